"""What the sources do by themselves, without the cut between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from solve_oracles import cast, line

from kinestitch.solve.placed import place_timeline
from kinestitch.solve.sources import Strength, own_strength, own_triples, own_velocities, velocity_between

SEEDS = st.integers(0, 2**16)


@given(st.integers(2, 40), st.integers(2, 40), st.integers(0, 3))
def test_velocities_are_those_between_each_sources_own_neighbours(first: int, middle: int, skip: int):
    clips = cast(3, frames=60)
    parts = [("a", 3, 3 + first), ("b", 0, middle), ("c", 20 - skip, 40)]
    placed = place_timeline(line(parts, clips), clips)
    start, stop = 1, placed.frames - 1
    into, out, (before, after) = own_velocities(placed, start, stop)
    triples = own_triples(placed, start, stop)
    fps = placed.timeline.fps
    np.testing.assert_allclose(into, velocity_between(triples[0], triples[1], fps), atol=1e-9)
    np.testing.assert_allclose(out, velocity_between(triples[1], triples[2], fps), atol=1e-9)
    speeds = [np.linalg.norm(np.diff(clips[key].translations[:, 0], axis=0), axis=-1) * fps for key in "abc"]
    inner = slice(1, first - 2)  # frames of the first segment whose neighbours are in it too
    np.testing.assert_allclose(np.linalg.norm(before[inner], axis=-1), speeds[0][4 : 4 + len(before[inner])], atol=1e-9)
    assert before.shape == after.shape == (stop - start, 3)


def test_the_cut_itself_is_not_in_the_strength():
    clips = cast(1, frames=80)
    clips["b"] = replace(clips["a"], name="b")
    whole = place_timeline(line([("a", 0, 40), ("b", 40, 80)], clips), clips)
    jump = place_timeline(
        line([("a", 0, 40), ("b", 40, 80)], clips | {"b": _turned(clips["b"])}), clips | {"b": _turned(clips["b"])}
    )
    one, other = (own_strength(placed, placed.seams[0]) for placed in (whole, jump))
    np.testing.assert_allclose(
        [one.acceleration, one.velocity, one.path], [other.acceleration, other.velocity, other.path], rtol=1e-9
    )


def _turned(motion):
    """Every joint but the root turned by a constant in its parent, which no velocity in its own axes shows."""
    from kinestitch.core.rotation import quat_about_axis, quat_multiply

    rotations = motion.rotations.copy()
    rotations[:, 1:] = quat_multiply(quat_about_axis(2, 0.8), rotations[:, 1:])
    return replace(motion, rotations=rotations)


def test_too_short_to_show_anything():
    clips = cast(2, frames=10)
    placed = place_timeline(line([("a", 0, 1), ("b", 4, 6)], clips), clips)
    assert own_strength(placed, placed.seams[0]) == Strength(0.0, 0.0, 0.0)
