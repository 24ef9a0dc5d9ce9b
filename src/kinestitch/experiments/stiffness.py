"""Experiment 9: what λ means: reach, overshoot, the step that remains, deviation, and the law of the fourth power."""

from __future__ import annotations

import numpy as np

from kinestitch.analysis.quality import deviation, rotation_step
from kinestitch.core.resample import resample
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.page import Finding, Picture, Section, Table, panels, picture, rows_of
from kinestitch.solve.seam import Cluster, SeamPlace, seam_curves, visible_reach
from kinestitch.solve.stitch import solve_timeline

LAMBDAS = (1.0, 10.0, 81.0, 1e2, 1e3, 1296.0, 1e4)
RATES = (24.0, 30.0, 60.0, 120.0)
LONG = 2000  # frames: far beyond every window


def gap_response(stiffness: float) -> np.ndarray:
    """Correction (n,) for a position gap of 1 at the middle of a long clip."""
    curves = seam_curves(Cluster(0, LONG, (SeamPlace(0, LONG // 2, stiffness),)))
    return np.asarray(curves.sum(axis=1))


def measured_law(stiffness: float) -> tuple[float, float, float]:
    """Reach in frames (last one above 5 % of the peak), overshoot as a share of the gap, step that remains as a
    share.
    """
    right = gap_response(stiffness)[LONG // 2 :]
    above = np.flatnonzero(np.abs(right) >= 0.05 * np.abs(right).max())
    reach = above.max() + 1
    remaining = 1 - 2 * abs(float(right[0]))
    return float(reach), float(right.max()), remaining


def _cut_at(data: DataSet, fps: float) -> tuple[float, float]:
    """Deviation (max, rad) and speed of the steepest step (rad/s) of one cut at another rate, default smoothing
    time.
    """
    left, right = data.find("Walking", "Kicking") if data.real else data.find("walk", "kick")
    clips = {key: resample(data.clips[key], fps) for key in (left, right)}
    infos = tuple(ClipInfo(key, clip.frames, fps) for key, clip in clips.items())
    out, into = round(0.5 * fps), round(0.4 * fps)
    segments = (Segment(left, FrameRange(0, out)), Segment(right, FrameRange(into, clips[right].frames)))
    solved = solve_timeline(Timeline(infos, segments, (Seam(),), fps), clips)
    (seam,) = solved.seams
    _, largest = deviation(solved.motion, solved.cut, seam.frame, visible_reach(seam.stiffness))
    return largest, rotation_step(solved.motion, seam.frame) * fps


def _times(spread: float) -> str:
    return f"the largest deviation differs by a factor of {spread:.2f} over {len(RATES)} rates"


def _laws(laws: dict[float, tuple[float, float, float]]) -> Picture:
    drawing, axes = panels(1, 3, size=(9.0, 3.0))
    roots = np.array(LAMBDAS) ** 0.25
    shown = (
        ("reach (frames)", [law[0] for law in laws.values()], 4.2 * roots),
        ("overshoot (% of the gap)", [100 * law[1] for law in laws.values()], np.full(len(roots), 3.3)),
        ("step that remains (%)", [100 * law[2] for law in laws.values()], 100 / (2 * np.sqrt(2) * roots)),
    )
    for axis, (name, values, closed) in zip(axes, shown, strict=True):
        axis.semilogx(LAMBDAS, values, "o", color="#0072B2", label="measured")
        axis.semilogx(LAMBDAS, closed, color="#D55E00", linewidth=1, label="closed form")
        axis.set_title(name, loc="left")
        axis.set_xlabel("λ")
    axes[0].legend(frameon=False)
    return picture(drawing, "Measured against closed form.", own=True)


def run(data: DataSet) -> Section:
    """Measured against closed form, and one cut at four frame rates."""
    laws = {value: measured_law(value) for value in LAMBDAS}
    rows = []
    for value, (reach, overshoot, remaining) in laws.items():
        root = value**0.25
        rows.append((f"{value:g}", reach, 4.2 * root, 100 * overshoot, 100 * remaining, 100 / (2 * np.sqrt(2) * root)))
    cuts = [_cut_at(data, fps) for fps in RATES]
    rates = [(f"{f:g}", (0.1 * f) ** 4, *np.degrees(cut).tolist()) for f, cut in zip(RATES, cuts, strict=True)]
    spread = max(cut[0] for cut in cuts) / min(cut[0] for cut in cuts)
    worst = max(abs(law[0] / (4.2 * value**0.25) - 1) for value, law in laws.items() if value >= 81)
    return Section(
        "λ is a time to the fourth power",
        "A position gap falls below 5 % of its peak after about 4.2 λ^¼ frames, so λ = (τ · fps)⁴ means the same at "
        "every rate.",
        (
            Finding("reach ≈ 4.2 λ^¼", "measured", f"worst relative error {worst:.1%} for λ ≥ 81 (frames are whole)"),
            Finding("λ scales with fps⁴", "measured", _times(spread)),
        ),
        (_laws(laws),),
        (
            Table(
                "Measured and closed form.",
                ("λ", "reach", "4.2 λ^¼", "overshoot %", "step %", "closed %"),
                rows_of(rows),
            ),
            Table("One cut, τ = 0.1 s.", ("fps", "λ", "largest deviation °", "steepest step °/s"), rows_of(rates)),
        ),
        numbers={"rate_law_deviation_ratio": round(float(spread), 3)},
    )
