"""Experiment 0: the idea in two pictures, drawn from the samples."""

from __future__ import annotations

import numpy as np

from kinestitch.analysis.plots import joint_curve
from kinestitch.core.rotation import quat_continuous, quat_mean
from kinestitch.edit import replace
from kinestitch.edit.timeline import timeline
from kinestitch.experiments.page import Picture, Section, panels, picture
from kinestitch.render.filmstrip import filmstrip_figure
from kinestitch.samples import sample
from kinestitch.solve.solved import Solved
from kinestitch.solve.stitch import solve_timeline

JOINT = "mixamorig:RightUpLeg"
_COLOURS = ("#0072B2", "#009E73", "#D55E00", "#555555")


def example() -> Solved:
    """A kick in place of some steps of a walk."""
    clips = {name: sample(name) for name in ("walk", "kick")}
    return solve_timeline(replace(timeline(clips, "walk"), 84, 130, "kick", 30, 112), clips)


def _strip(solved: Solved) -> Picture:
    first, second = (seam.frame for seam in solved.seams)
    drawing = filmstrip_figure(
        [solved.placed.sources["walk"], solved.placed.sources["kick"], solved.motion],
        labels=["original", "reference", "stitched"],
        marks=[(), (), (first, second)],
        segments=[(), (), [(first, second, "pasted")]],
        poses=13,
    )
    return picture(drawing, "Original, reference, and the reference's frames pasted into the original.", own=True)


def _curves(solved: Solved) -> Picture:
    joint = solved.motion.skeleton.index(JOINT)
    base = quat_mean(solved.motion.rotations[:, joint])
    drawing, (quats, vectors) = panels(2, 1, size=(8.0, 4.6))
    for motion, alpha, width in ((solved.cut, 0.4, 0.9), (solved.motion, 1.0, 1.6)):
        q = quat_continuous(motion.rotations[:, joint])
        for i, letter in enumerate("xyzw"):
            label = letter if motion is solved.motion else None
            quats.plot(q[:, i], color=_COLOURS[i], alpha=alpha, linewidth=width, label=label)
        r = np.degrees(joint_curve(motion, joint, base))
        for i, letter in enumerate("xyz"):
            label = letter if motion is solved.motion else None
            vectors.plot(r[:, i], color=_COLOURS[i], alpha=alpha, linewidth=width, label=label)
    for axis, name in ((quats, "quaternion"), (vectors, "rotation vector (°)")):
        axis.set_ylabel(name)
        axis.legend(frameon=False, ncols=4, loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0)
        for seam in solved.seams:
            axis.axvline(seam.frame - 0.5, color="#CC79A7", linestyle="--", linewidth=1)
    vectors.set_xlabel("frame")
    return picture(drawing, f"{JOINT}: thin the hard cut, thick the result; seams dashed.", own=True)


def run() -> Section:
    """What goes in, what comes out, and the same joint as quaternion and as rotation vector."""
    solved = example()
    return Section(
        "Overview",
        "Each joint's quaternions become rotation vectors θu; their temporal Laplacian is kept while positions are "
        "made to "
        "meet; the vectors become quaternions again.",
        pictures=(_strip(solved), _curves(solved)),
    )
