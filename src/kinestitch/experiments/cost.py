"""Experiment 8: what a solve costs as clips grow, for the dense, the full banded and the seam form."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.experiments.page import Finding, Section, Table, panels, picture, rows_of
from kinestitch.solve.laplacian import row_stiffness, solve_full
from kinestitch.solve.seam import SeamPlace, clusters, correction

CHANNELS, STIFFNESS = 195, 1296.0
PUBLISHED = (1000, 0.1)
"""The paper's figure: about 0.1 s for 1,000 frames."""


def dense(frames: int) -> Callable[[], object]:
    """The normal equations as full matrices."""
    target = _target(frames)
    rows = row_stiffness(STIFFNESS, frames)
    second = np.zeros((frames, frames))
    inner = np.arange(1, frames - 1)
    for shift, value in ((-1, 1.0), (0, -2.0), (1, 1.0)):
        second[inner, inner + shift] = value
    return lambda: np.linalg.solve(np.eye(frames) + second.T @ (rows[:, None] * second), target)


def banded(frames: int) -> Callable[[], object]:
    """The same system with its five bands, every channel of every frame."""
    target = _target(frames)
    return lambda: solve_full(target, np.zeros_like(target), STIFFNESS)


def seam_form(frames: int) -> Callable[[], object]:
    """Two curves and one thin product, on the seam's window only."""
    offsets = _target(2)
    (cluster,) = clusters([SeamPlace(0, frames // 2, STIFFNESS)], frames)
    return lambda: correction(cluster, offsets)


FORMS = {"dense": (dense, 2_000), "full banded": (banded, 100_000), "seam form": (seam_form, 1_000_000)}


def _target(frames: int) -> Array:
    return np.random.default_rng(0).normal(size=(frames, CHANNELS))


def least_seconds(call: Callable[[], object]) -> float:
    """Least time of a few runs, fewer where one run is long."""
    call()
    times: list[float] = []
    while len(times) < 3 or (sum(times) < 0.1 and len(times) < 50):
        start = perf_counter()
        call()
        times.append(perf_counter() - start)
        if times[-1] > 1:
            break
    return min(times)


def measure(sizes: tuple[int, ...]) -> dict[str, list[tuple[int, float]]]:
    """Seconds by form and number of frames; each form up to the size it can bear."""
    return {
        name: [(frames, least_seconds(make(frames))) for frames in sizes if frames <= most]
        for name, (make, most) in FORMS.items()
    }


def slope(points: list[tuple[int, float]]) -> float:
    """Exponent of the cost: slope of the log-log fit over the larger half of the sizes."""
    large = points[len(points) // 2 :] if len(points) > 3 else points
    frames, seconds = np.log(np.array(large).T)
    return float(np.polyfit(frames, seconds, 1)[0])


def run(*, sizes: tuple[int, ...] = (100, 300, 1_000, 2_000, 10_000, 100_000, 1_000_000)) -> Section:
    """Time the three forms in one run and tell ratios and exponents."""
    found = measure(sizes)
    drawing, (axis,) = panels(size=(8.0, 3.8))
    for (name, points), colour in zip(found.items(), ("#D55E00", "#0072B2", "#009E73"), strict=True):
        axis.loglog(*zip(*points, strict=True), marker="o", color=colour, label=f"{name} (slope {slope(points):.2f})")
    axis.axhline(PUBLISHED[1], color="#9A9A9A", linestyle=":", label="published: 0.1 s at 1,000 frames")
    axis.set_xlabel("frames")
    axis.set_ylabel("seconds")
    axis.legend(frameon=False)
    here = {name: dict(points).get(PUBLISHED[0]) for name, points in found.items()}
    rows = []
    for name, points in found.items():
        seconds = here[name]
        share = float(seconds / here["full banded"]) if seconds and here["full banded"] else float("nan")
        rows.append((name, points[-1][0], slope(points), share))
    table = Table(
        f"{CHANNELS} channels, λ = {STIFFNESS:g}; time at 1,000 frames as a share of the full banded solve's.",
        ("form", "largest size", "slope", "share at 1,000 frames"),
        rows_of(rows),
    )
    full = here["full banded"]
    finding = Finding(
        "1,000 frames are solved in about 0.1 s.",
        "reproduced" if full is not None and full <= PUBLISHED[1] else "not reproduced",
        f"the full banded solve needs {full / PUBLISHED[1]:.2f} of that time on this machine"
        if full
        else "not measured",
    )
    return Section(
        "Cost",
        "Solve time against the number of frames. The seam form does not depend on the clip's length.",
        (finding,),
        (picture(drawing, "Time by frames; log-log.", own=True),),
        (table,),
        numbers={
            "cost_slope": {name: round(slope(points), 3) for name, points in found.items()},
            "cost_share_of_full_banded_at_1000": {row[0]: round(float(row[3]), 4) for row in rows},
        },
    )
