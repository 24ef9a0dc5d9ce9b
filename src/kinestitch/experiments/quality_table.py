"""Experiment 10: every method on the same cuts, every measure, medians with bootstrap intervals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinestitch.analysis.feet import foot_joints, skating_share, standing_heights, weighted_skate
from kinestitch.analysis.quality import angular_velocity_step, deviation, dynamics_kept, root_step, rotation_step
from kinestitch.analysis.smoothness import added_acceleration, area_under_jerk, jerk, peak_jerk
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import Seam
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.page import Finding, Section, Table
from kinestitch.experiments.seams import random_cut
from kinestitch.experiments.trade_off import near_seam
from kinestitch.solve.placed import Placed
from kinestitch.solve.rivals import crossfade, dead_blend, hermite, inertialize
from kinestitch.solve.seam import SeamPlace
from kinestitch.solve.solved import Solved
from kinestitch.solve.stitch import solve_timeline

SECONDS = 0.2
"""s, width of the rivals on each side, half of it the half-life of inertialization; the solver keeps its default."""

WINDOW = 0.75
"""s on each side of a seam that everything is measured in."""

METHODS: Mapping[str, Callable[[Solved], Motion]] = {
    "hard cut": lambda solved: solved.cut,
    "crossfade": lambda solved: crossfade(solved.placed, _frames(solved.placed, SECONDS)),
    "inertialize": lambda solved: inertialize(solved.placed, SECONDS / 2),
    "dead blend": lambda solved: dead_blend(solved.placed, _frames(solved.placed, 2 * SECONDS)),
    "hermite": lambda solved: hermite(solved.placed, _frames(solved.placed, 2 * SECONDS)),
    "laplacian": lambda solved: solved.motion,
}
MEASURES = (
    "rotation step °",
    "velocity step °/s",
    "added acceleration",
    "dynamics kept",
    "deviation °",
    "root step cm",
    "skate mm/frame",
    "skating share",
)


def _frames(placed: Placed, seconds: float) -> int:
    return max(1, round(seconds * placed.timeline.fps))


def measure(solved: Solved) -> dict[str, tuple[list[float], Motion]]:
    """For each method the values of ``MEASURES`` at a timeline's only seam, and the window they were taken in."""
    (seam,) = solved.seams
    reach = _frames(solved.placed, WINDOW)
    ground = standing_heights(solved.cut, foot_joints(solved.cut.skeleton))
    return {name: _values(make(solved), solved, seam, reach, ground) for name, make in METHODS.items()}


def _window(motion: Motion, seam: SeamPlace, reach: int) -> Motion:
    near = slice(max(0, seam.frame - reach), seam.frame + reach)
    return replace(motion, rotations=motion.rotations[near], translations=motion.translations[near])


def _values(motion: Motion, solved: Solved, seam: SeamPlace, reach: int, ground: Array) -> tuple[list[float], Motion]:
    window = _window(motion, seam, reach)
    return [
        float(np.degrees(rotation_step(motion, seam.frame))),
        float(np.degrees(angular_velocity_step(motion, seam.frame))),
        added_acceleration(motion, solved.placed, seam, reach).peak,
        dynamics_kept(motion, solved.placed, seam),
        float(np.degrees(deviation(motion, solved.cut, seam.frame, reach)[0])),
        100 * root_step(motion, seam.frame),
        1000 * float(weighted_skate(window, ground=ground).mean()),
        skating_share(window, ground=ground),
    ], window


def bootstrap(values: Array, rng: np.random.Generator, *, rounds: int = 500) -> tuple[float, float]:
    """95 % interval of the median by resampling the seams."""
    picks = rng.integers(0, len(values), size=(rounds, len(values)))
    low, high = np.percentile(np.median(values[picks], axis=1), (2.5, 97.5))
    return float(low), float(high)


def table(data: DataSet, seams: int, seed: int) -> tuple[Table, dict[str, dict[str, float]]]:
    """One data set's table and its medians by method and measure."""
    rng = np.random.default_rng(seed)
    found: dict[str, list[list[float]]] = {name: [] for name in METHODS}
    windows: dict[str, list[Motion]] = {name: [] for name in METHODS}
    for _ in range(seams):
        solved = solve_timeline(near_seam(random_cut(dict(data.clips), rng, Seam())), data.clips)
        for name, (values, window) in measure(solved).items():
            found[name].append(values)
            windows[name].append(window)
    full = max(window.frames for window in windows["hard cut"])
    rest = float(np.mean([jerk(motion).mean() for motion in data.clips.values() if motion.frames >= 4]))
    rows, medians = [], {}
    for name, lists in found.items():
        array = np.array(lists)
        whole = [window for window in windows[name] if window.frames == full]
        cells = [_cell(column, rng) for column in array.T]
        jerks = (peak_jerk(whole), area_under_jerk(whole, rest)) if whole else (float("nan"), float("nan"))
        rows.append((name, *cells, *(f"{value:.3g}" for value in jerks)))
        medians[name] = dict(zip(MEASURES, np.median(array, axis=0).tolist(), strict=True))
    fps = next(iter(data.clips.values())).fps
    head = ("method", *MEASURES, "PJ", "AUJ")
    caption = (
        f"{data.name}, {seams} cuts at {fps:g} fps: median [95 % interval of the median] / 95th percentile. PJ, AUJ "
        f"in m/frame³."
    )
    return Table(caption, head, tuple(rows)), medians


def _cell(values: Array, rng: np.random.Generator) -> str:
    low, high = bootstrap(values, rng)
    return f"{np.median(values):.3g} [{low:.3g}, {high:.3g}] / {np.percentile(values, 95):.3g}"


def run(sets: Sequence[DataSet], *, seams: int = 200, seed: int = 0) -> Section:
    """All methods, all measures, all data sets; where a rival is better, the finding says so."""
    tables, numbers = [], {}
    for data in sets:
        made, medians = table(data, seams, seed)
        tables.append(made)
        numbers[data.name] = {name: {k: float(f"{v:.4g}") for k, v in row.items()} for name, row in medians.items()}
    return Section(
        "Quality of seams, every method on the same cuts",
        f"Rivals at their customary widths ({SECONDS:g} s on each side), the solver at its default smoothing time; "
        f"feet by "
        "MANN's weighted skate (H = 2.5 cm) and by the share of sliding frames at 20 fps.",
        tuple(_finding(name, medians) for name, medians in numbers.items()),
        tables=tuple(tables),
        numbers={"quality_medians": numbers},
    )


def _finding(name: str, medians: Mapping[str, Mapping[str, float]]) -> Finding:
    ours = medians["laplacian"]
    rivals = {key: row for key, row in medians.items() if key not in {"laplacian", "hard cut"}}
    added = min(rivals, key=lambda key: rivals[key]["added acceleration"])
    better = [
        f"{key} has less {measure} ({row[measure]:.3g} against {ours[measure]:.3g})"
        for measure in ("added acceleration", "deviation °", "skate mm/frame")
        for key, row in rivals.items()
        if row[measure] < ours[measure]
    ]
    return Finding(
        f"Seams are smooth and keep their clips' dynamics ({name}).",
        "measured",
        f"added acceleration {ours['added acceleration']:.3g} of the sources' own against "
        f"{rivals[added]['added acceleration']:.3g} "
        f"for the best rival ({added}); dynamics kept {ours['dynamics kept']:.3f} against "
        f"{rivals[added]['dynamics kept']:.3f}; "
        + ("; ".join(better) if better else "no rival is better on these measures"),
    )
