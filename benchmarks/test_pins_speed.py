"""Pins on a long clip beside the full banded solve of the same clip: 65 joints, 10,000 frames."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solveh_banded

from kinestitch.core.rotation import quat_normalize
from kinestitch.edit.pins import Pin
from kinestitch.edit.timeline import timeline
from kinestitch.rig.carrier import world_of
from kinestitch.solve.laplacian import normal_bands, row_stiffness
from kinestitch.solve.pinned import path_rows, pinned_correction, pinned_path
from kinestitch.solve.pins import pinned
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.stitch import stitch
from kinestitch.testing import random_motion

JOINTS, FPS, STIFFNESS = 65, 60.0, 1296.0
RIVAL = "SciPy solveh_banded, whole clip"


@pytest.fixture(scope="module")
def case(quick):
    frames = 1000 if quick else 10_000
    clips = {"a": random_motion(0, joints=JOINTS, frames=frames, fps=FPS)}
    rhs = np.asfortranarray(np.random.default_rng(0).normal(size=(frames, 3 * JOINTS)))
    bands = normal_bands(row_stiffness(STIFFNESS, frames))
    return clips, stitch(timeline(clips, "a"), clips), lambda: solveh_banded(bands, rhs, check_finite=False)


def pins_of(kind, frames, motion):
    rng = np.random.default_rng(1)
    places = world_of(motion, 30)[0]
    for frame in np.linspace(frames // 20, frames - 1, 20).astype(int):
        here = motion.translations[frame, 0]
        if kind == "rotation":
            for joint in range(10, 20):
                yield Pin("rotation", int(frame), tuple(quat_normalize(rng.normal(size=4))), f"Joint{joint}")
        elif kind == "position":
            yield Pin("position", int(frame), tuple(places[frame] + rng.normal(scale=0.03, size=3)), "Joint30")
        elif kind == "root":
            yield Pin("root", int(frame), (here[0] + 0.1, 0.0, here[2]))
        else:
            yield Pin("waypoint", int(frame), (here[0] + 0.05, here[2] + 0.05))


@pytest.mark.filterwarnings("ignore:Steps before:kinestitch.errors.KinestitchWarning")  # a random path bends unevenly
@pytest.mark.parametrize(
    ("kind", "what"),
    [
        ("rotation", "200 pins of 10 joints' rotations"),
        ("position", "20 pins of a joint's position"),
        ("root", "20 root pins"),
        ("waypoint", "a path bent through 20 waypoints"),
    ],
)
def test_pins_against_the_full_solve(case, compare, kind, what):
    clips, motion, rival = case
    line = replace(timeline(clips, "a"), pins=tuple(pins_of(kind, motion.frames, motion)))
    placed = place_timeline(line, clips)
    aim = {"rotation": "≤ 2", "root": "≤ 2"}.get(kind, "none")
    compare(f"{what}, 10,000 frames, as called", lambda: pinned(motion, placed), RIVAL, rival, aim, repeats=3)


def test_the_solves_alone_against_the_full_solve(case, compare):
    _, motion, rival = case
    frames = np.linspace(motion.frames // 20, motion.frames - 1, 20).astype(int)
    gaps, exact = np.ones((20, 3)), np.full(20, np.inf)
    rows = row_stiffness(STIFFNESS, motion.frames)
    compare(
        "20 pins of one joint, solve alone", lambda: pinned_correction(rows, frames, gaps, exact), RIVAL, rival, "≤ 0.1"
    )
    path = path_rows(np.full(frames[-1], STIFFNESS), started=False)
    what = "20 pins of a path, solve alone"
    compare(what, lambda: pinned_path(path, frames, gaps[:, :2], exact), RIVAL, rival, "≤ 1", repeats=10)
