"""Stances of both sides of a seam: which become one, and which give way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.core.rotation import quat_about_axis, quat_conjugate, quat_multiply, quat_to_rotvec
from kinestitch.solve.contacts import runs
from kinestitch.solve.laplacian import second_difference
from kinestitch.solve.release import released, wanted_stances
from kinestitch.solve.seam import Cluster, SeamPlace
from kinestitch.solve.stances import FootPath, Setting, Stances, settled
from kinestitch.solve.swings import carry_over

FPS, LEG, BLEND = 60.0, 0.9, 25.0
HARDEST = 18.0 * LEG / FPS**2


def setting(
    count: int, *seams: int, bounded: tuple[bool, bool] = (False, False), held: tuple[int, int] = (0, 0), stiff=1296.0
) -> Setting:
    places = tuple(SeamPlace(k, frame, stiff) for k, frame in enumerate(seams))
    return Setting(Cluster(0, count, places, held), bounded, FPS, LEG, BLEND)


def standing(count: int, seam: int, gap: tuple[float, float, float], yaw: float = 0.0, roll: float = 0.0) -> FootPath:
    """A foot that stands at the origin until a seam and at `gap` m from it on, turned by `yaw` and rolled rad."""
    later = (np.arange(count) >= seam)[:, None]
    turn = quat_multiply(quat_about_axis(1, yaw), quat_about_axis(0, roll))
    return FootPath(np.where(later, gap, (0.0, 0.0, 0.0)), np.where(later, turn, [0.0, 0.0, 0.0, 1.0]))


def all_frames(count: int) -> np.ndarray:
    return np.ones(count, dtype=bool)


def test_near_stances_become_one_nearer_to_the_longer():
    path = standing(90, 30, (0.2, 0.0, 0.1), yaw=0.3)
    found = settled(path, all_frames(90), all_frames(90), setting(90, 30))
    expected = np.array([0.2, 0.0, 0.1]) * 60 / 90
    assert np.allclose(found.path.pivot, expected, atol=1e-12)
    assert np.allclose(found.path.turn @ quat_about_axis(1, 0.3 * 60 / 90), 1.0)


@pytest.mark.parametrize("bounded", [(True, False), (False, True)])
def test_a_stance_that_lasts_beyond_the_window_stays(bounded: tuple[bool, bool]):
    found = settled(standing(80, 40, (0.2, 0.0, 0.0)), all_frames(80), all_frames(80), setting(80, 40, bounded=bounded))
    assert np.allclose(found.path.pivot[:, 0], 0.0 if bounded[0] else 0.2)


@pytest.mark.parametrize(
    ("gap", "yaw"),
    [((0.4, 0.0, 0.0), 0.0), ((0.0, 0.2, 0.0), 0.0), ((0.1, 0.0, 0.0), 1.0)],
    ids=["far", "on a step", "turned"],
)
def test_stances_too_far_apart_stay_two(gap: tuple[float, float, float], yaw: float):
    path = standing(80, 40, gap, yaw)
    found = settled(path, all_frames(80), all_frames(80), setting(80, 40))
    assert np.array_equal(found.path.pivot, path.pivot)
    assert not found.links


def test_neither_becomes_one_with_what_is_cut_hard():
    found = settled(standing(80, 40, (0.1, 0.0, 0.0)), all_frames(80), all_frames(80), setting(80, 40, stiff=0.0))
    assert not found.links


@pytest.mark.parametrize(("before", "after"), [(True, True), (True, False), (False, True), (False, False)])
def test_what_stances_differ_by_besides_is_evened_out_where_the_heel_is_up(before: bool, after: bool):
    path = standing(80, 40, (0.0, 0.02, 0.0), roll=0.2)
    flat = np.where(np.arange(80) < 40, before, after)
    found = settled(path, all_frames(80), flat, setting(80, 40))
    steps = np.abs(np.diff(found.path.pivot[:, 1]))
    rolls = np.linalg.norm(
        quat_to_rotvec(quat_multiply(found.path.turn[1:], quat_conjugate(found.path.turn[:-1]))), axis=1
    )
    for change in (steps / 0.02, rolls / 0.2):
        assert change.sum() == pytest.approx(1.0)
        assert change[39] < 1e-9
        assert change.max() < 0.2
        share = 0.5 if before == after else float(after)
        assert change[:39].sum() == pytest.approx(share, abs=1e-9)
    values = np.where(np.arange(80) < 40, 0.0, 1.0)[:, None]
    assert np.abs(np.diff(found.evened(values)[:, 0])).max() < 0.2


@st.composite
def torn(draw: st.DrawFn) -> tuple[FootPath, np.ndarray, np.ndarray, np.ndarray, Setting]:
    """A foot that stands apart on both sides of a seam, now and then, and whose solved way goes from side to side; near
    enough to become one stance, or not, with pauses between, and now and then out of reach.
    """
    count, seam = draw(st.integers(60, 160)), draw(st.integers(25, 40))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    held = np.repeat(rng.random(count // 8 + 1) < 0.7, 8)[:count]
    far = np.repeat(rng.random(count // 6 + 1) < draw(st.sampled_from([0.0, 0.2])), 6)[:count]
    gap = np.array([draw(st.floats(0.0, 1.0)), 0.0, draw(st.floats(-0.3, 0.3))])
    share = 1 / (1 + np.exp(-(np.arange(count) - seam + 0.5) / draw(st.floats(2.0, 6.0))))
    return standing(count, seam, tuple(gap)), held, far, share[:, None] * gap, setting(count, seam)


@dataclass(frozen=True)
class Point:
    """A foot without a leg: it is thrown by the acceleration of its offset to the solved way."""

    offsets: np.ndarray

    def excess(self, stands: np.ndarray) -> np.ndarray:
        carried = carry_over(np.where(stands[:, None], self.offsets, 0.0), stands, BLEND)
        return np.linalg.norm(second_difference(carried), axis=1) / HARDEST


@settings(max_examples=40, deadline=None)
@given(torn())
def test_no_foot_is_thrown_harder_than_the_bound(case):
    """Nor does a stance begin or end out of reach, or last less than it takes to be one, but where the seam cuts it."""
    path, held, far, solved, how = case
    stances = settled(path, held, held, how)
    offsets = stances.path.pivot - solved
    stands = released(stances, Point(offsets), far, how)
    assert not (stands & ~held).any()
    hard = Point(offsets).excess(stands)
    for start, stop in runs(~stands):
        assert hard[max(0, start - 1) : stop + 1].max() <= 1 + 1e-12
    for start, stop in runs(stands):
        assert hard[start:stop].max() <= 1 + 1e-12
        seam = how.cluster.local_frames[0]
        at_seam = bool(stances.links) and start - how.pause <= seam <= stop + how.pause
        assert at_seam or stop - start >= 4 or start == 0 or stop == len(held)
        assert at_seam or not (far[start] or far[stop - 1])
    if far.all() or not held.any():
        assert not stands.any()


def test_a_stance_whose_other_half_is_out_of_reach_does_not_outlast_it_for_a_moment():
    """What was joined to nothing is a stance of its own, and has to be long enough for one."""
    held = (np.arange(80) >= 20) & (np.arange(80) < 42)
    stances = settled(standing(80, 40, (0.0, 0.0, 0.0)), held, held, setting(80, 40))
    assert len(stances.links) == 1
    stands = released(stances, Point(np.zeros((80, 3))), np.arange(80) < 40, setting(80, 40))
    assert not stands.any()


def test_the_way_between_two_joined_stances_counts():
    held = np.ones(80, dtype=bool)
    held[37:43] = False
    stances = settled(standing(80, 40, (0.0, 0.0, 0.0)), held, held, setting(80, 40))
    assert len(stances.links) == 1

    class Between:
        def excess(self, stands: np.ndarray) -> np.ndarray:
            return np.where((np.arange(80) == 40) & (np.flatnonzero(stands[43:])[:1] == 0), 9.0, 0.0)

    assert not released(stances, Between(), np.zeros(80, dtype=bool), setting(80, 40))[[36, 43]].any()


@settings(max_examples=20, deadline=None)
@given(torn())
def test_time_may_run_backwards(case):
    path, held, far, solved, how = case
    count = len(held)
    back = FootPath(path.pivot[::-1], path.turn[::-1])
    mirrored = setting(count, count - how.cluster.local_frames[0])
    forth = settled(path, held, held, how)
    there = settled(back, held[::-1], held[::-1], mirrored)
    ours = released(forth, Point(forth.path.pivot - solved), far, how)
    theirs = released(there, Point(there.path.pivot - solved[::-1]), far[::-1], mirrored)
    assert np.array_equal(ours, theirs[::-1])


def test_a_stance_that_asks_little_is_kept_whole():
    path = standing(80, 40, (0.02, 0.0, 0.0))
    stances = settled(path, all_frames(80), all_frames(80), setting(80, 40))
    stands = released(stances, Point(stances.path.pivot), np.zeros(80, dtype=bool), setting(80, 40))
    assert stands.all()


def test_a_stance_does_not_begin_or_end_out_of_reach():
    held = np.arange(100) >= 40
    path = FootPath(np.zeros((100, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (100, 1)))
    stances = settled(path, held, held, setting(100, 20))
    far = (np.arange(100) < 50) | (np.arange(100) == 70) | (np.arange(100) > 95)
    stands = released(stances, Point(np.zeros((100, 3))), far, setting(100, 20))
    assert runs(stands) == [(50, 96)]


def test_contacts_stay_apart_where_a_foot_then_stands_for_longer():
    """The shorter of two stances that became one lies so far off its clip that the foot cannot get there in time."""
    count, seam = 281, 138
    frames = np.arange(count)
    held = ((frames >= 37) & (frames < 76)) | (frames >= 104)
    placed = standing(count, seam, (0.29, 0.0, 0.0))
    share = 1 / (1 + np.exp(-(frames - seam + 0.5) / 4.0))
    solved = FootPath(share[:, None] * [0.29, 0.0, 0.0], placed.turn)
    how = setting(count, seam)

    def far(path: FootPath) -> np.ndarray:
        return (frames < 118) & (np.abs(path.pivot - placed.pivot).max(axis=1) > 0.1)

    def on(found: Stances) -> Point:
        return Point(found.path.pivot - solved.pivot)

    one = settled(placed, held, held, how)
    assert len(one.links) == 1
    together = released(one, on(one), far(one.path), how)
    stances, stands = wanted_stances(placed, on, (held, held), far, how)
    assert not stances.links
    assert stands.sum() > together.sum() + 0.1 * FPS
    little = standing(count, seam, (0.02, 0.0, 0.0))
    assert wanted_stances(little, lambda _: Point(np.zeros((count, 3))), (held, held), lambda _: frames < 0, how)[
        0
    ].links


def test_frames_beside_a_window_that_ends_have_no_offset():
    stands = np.zeros(20, dtype=bool)
    assert runs(setting(20, 10, bounded=(True, True), held=(0, 5)).known(stands)) == [(0, 2), (15, 20)]
    assert not setting(20, 10, held=(3, 3)).known(stands).any()
