"""Experiment 5: how continuous rotation axes are within clips and at boundaries, and how often a branch is crossed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinestitch.analysis.continuity import (
    THRESHOLD,
    Continuity,
    angles,
    axis_continuity,
    clip_steps,
    continuity,
    end_to_start,
    random_boundaries,
)
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.page import Finding, Section, Table, panels, picture, rows_of

PUBLISHED_SHARE = 0.776
"""The paper's share of boundary values above 0.5."""

_BINS = np.linspace(-1, 1, 101)


def measure(data: DataSet, *, pairs: int = 2000, seed: int = 0) -> dict[str, Continuity]:
    """Within clips, from every end to every start, and between random frames of different clips."""
    rng = np.random.default_rng(seed)
    return {
        "within clips": continuity([clip_steps(motion) for motion in data.clips.values()]),
        "end to start": continuity([end_to_start(data.clips)]),
        "random frames": continuity([random_boundaries(data.clips, pairs, rng)]),
    }


def _drawings(sets: Sequence[DataSet]) -> list:
    pictures = []
    for data in sets:
        within = np.concatenate([axis_continuity(motion) for motion in data.clips.values()])
        between = end_to_start(data.clips).values
        theta = np.degrees(np.concatenate([angles(motion).ravel() for motion in data.clips.values()]))
        drawing, (linear, log, turn) = panels(1, 3, size=(10.0, 2.9))
        for axis, scale in ((linear, "linear"), (log, "log")):
            axis.hist(within, _BINS, color="#0072B2", alpha=0.8, label="within clips", density=True)
            axis.hist(between, _BINS, color="#D55E00", alpha=0.6, label="at boundaries", density=True)
            axis.set_yscale(scale)
            axis.set_xlabel("$u_t \\cdot u_{t+1}$")
            axis.set_title(f"{data.name}, {scale}", loc="left")
        linear.legend(frameon=False)
        turn.hist(theta, np.linspace(0, 180, 91), color="#009E73", density=True)
        turn.set_xlabel("θ from the rest pose (°)")
        turn.set_title("distribution of θ", loc="left")
        pictures.append(picture(drawing, f"{data.name}: products of neighbouring axes, and θ.", own=not data.real))
    return pictures


def run(sets: Sequence[DataSet], *, seed: int = 0) -> Section:
    """All data sets beside each other."""
    found = {data.name: measure(data, seed=seed) for data in sets}
    rows = [
        (name, where, n.values, n.share_above_half, n.share_aligned, n.share_flipped, n.crossings, n.joint_steps)
        for name, kinds in found.items()
        for where, n in kinds.items()
    ]
    first = sets[0].name
    share = found[first]["end to start"].share_above_half
    shares = {name: round(kinds["end to start"].share_above_half, 4) for name, kinds in found.items()}
    crossings = {name: kinds["within clips"].crossings for name, kinds in found.items()}
    near = abs(share - PUBLISHED_SHARE) < 0.05
    finding = Finding(
        f"At boundaries about {PUBLISHED_SHARE:.1%} of axis products lie above 0.5.",
        "reproduced" if near else "reproduced with limits",
        ", ".join(f"{value:.1%} on {name}" for name, value in shares.items()),
    )
    within = Finding(
        "Within clips the axes are continuous.",
        "reproduced" if crossings[first] <= 1 else "reproduced with limits",
        f"{found[first]['within clips'].share_aligned:.1%} above 0.99 on {first}; branch crossings inside clips: "
        + ", ".join(f"{value} on {name}" for name, value in crossings.items()),
    )
    return Section(
        "Continuity of axes, within clips and at boundaries",
        f"Products of neighbouring rotation axes in the principal chart, where both angles exceed {THRESHOLD:g} rad. A "
        "branch crossing is a jump of the vector by more than π, which is what makes a limb spin.",
        (finding, within),
        tuple(_drawings(sets)),
        (
            Table(
                "Shares of products, and branch crossings among joint-steps.",
                ("data", "where", "products", "> 0.5", "> 0.99", "< −0.9", "crossings", "joint-steps"),
                rows_of(rows),
            ),
        ),
        numbers={"boundary_share_above_0.5": shares, "branch_crossings_within": crossings},
    )
