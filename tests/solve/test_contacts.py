"""When feet stand: against the truth of the samples, and for plausibility on real clips."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch import files
from kinestitch.core.kinematics import local_from_world, turn_about_up, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.rig.hips import hip_height
from kinestitch.samples import SAMPLE_NAMES, sample, sample_contacts
from kinestitch.solve.contacts import SLOW, Contacts, Leg, find_contacts, legs_of, runs
from kinestitch.testing import random_motion


def truth(name: str, fps: float, *joints: int) -> np.ndarray:
    held = sample_contacts(name, fps=fps)
    names = sample(name, fps=fps).skeleton.names
    return np.any([held[names[joint]] for joint in joints], axis=0)


def widened(mask: np.ndarray, frames: int) -> np.ndarray:
    out = mask.copy()
    for k in range(1, frames + 1):
        out[k:] |= mask[:-k]
        out[:-k] |= mask[k:]
    return out


@pytest.mark.parametrize("fps", [30, 60, 120])
@pytest.mark.parametrize("name", SAMPLE_NAMES)
def test_finds_the_stances_of_the_samples(name: str, fps: int):
    """Every frame in which a foot is held is found. What is found besides lies within 50 ms of it: the truth ends with
    the first motion, a detector that bears noise cannot.
    """
    motion = sample(name, fps=fps)
    found = find_contacts(motion)
    for leg in legs_of(motion.skeleton):
        held, ours = truth(name, fps, leg.foot, leg.toe), found.of(leg.foot, leg.toe)
        assert (ours & held).sum() >= 0.95 * held.sum()
        assert (ours & widened(held, round(0.05 * fps))).sum() >= 0.95 * ours.sum()


@pytest.mark.parametrize("name", ["idle", "kick", "jump", "light_punch", "heavy_punch"])
def test_finds_toes_frame_by_frame(name: str):
    motion = sample(name)
    found = find_contacts(motion)
    toes = [leg.toe for leg in legs_of(motion.skeleton)]
    held = np.concatenate([truth(name, 60, toe) for toe in toes])
    ours = np.concatenate([found.of(toe) for toe in toes])
    assert (ours & held).sum() >= 0.95 * max(ours.sum(), held.sum())


@pytest.mark.parametrize("name", SAMPLE_NAMES)
def test_what_stands_is_slow(name: str):
    motion = sample(name)
    found = find_contacts(motion)
    places = world_pose(motion).positions[:, found.joints]
    speed = np.linalg.norm(np.diff(places, axis=0), axis=-1) * motion.fps
    assert speed[found.held[1:] & found.held[:-1]].max() < 2 * SLOW[1] * hip_height(motion.skeleton)


def test_does_not_depend_on_where_the_clip_lies_nor_how_high():
    motion = sample("walk")
    turned = turn_about_up(motion, 1.1, (3.0, -0.7, 2.0))
    assert np.array_equal(find_contacts(turned).held, find_contacts(motion).held)


def test_feet_that_walk_on_the_spot_do_not_stand():
    walk = sample("walk")
    translations = walk.translations.copy()
    translations[:, 0, 2] = translations[0, 0, 2]
    assert find_contacts(replace(walk, translations=translations)).held.mean() < 0.02


def test_noise_does_not_make_it_flicker():
    motion = sample("idle")
    noise = np.random.default_rng(0).normal(scale=3e-4, size=(motion.frames, 3))
    translations = motion.translations.copy()
    translations[:, 0] += noise
    held = find_contacts(replace(motion, translations=translations)).held
    assert all(len(runs(column)) <= 2 for column in held.T)
    assert held.mean() > 0.95


def test_a_clip_of_one_frame_stands():
    idle = sample("idle")
    one = replace(idle, translations=idle.translations[:1], rotations=idle.rotations[:1])
    assert find_contacts(one).held.all()


def test_runs_are_the_stretches_of_a_mask():
    assert runs(np.array([True, True, False, True])) == [(0, 2), (3, 4)]
    assert runs(np.zeros(3, dtype=bool)) == []


def test_refusals():
    with pytest.raises(SkeletonMismatchError, match="two feet"):
        find_contacts(random_motion(0))
    with pytest.raises(ParameterError, match="low"):
        find_contacts(sample("idle"), low=(0.2, 0.1))
    with pytest.raises(ParameterError, match="shape"):
        Contacts((1, 2), np.zeros((4, 3), dtype=bool))


def test_contacts_cannot_be_changed():
    found = find_contacts(sample("idle"))
    with pytest.raises(ValueError, match="read-only"):
        found.held[0, 0] = False


RIG = Skeleton(
    ("Hips", *(f"{side}{part}" for side in ("Left", "Right") for part in ("UpLeg", "Leg", "Foot", "ToeBase"))),
    (-1, 0, 1, 2, 3, 0, 5, 6, 7),
    [[0, 0.9, 0], *(2 * [[0.1, 0, 0], [0, -0.4, 0], [0, -0.4, 0], [0, -0.07, 0.12]])],
)


def stepping(
    seed: int, fps: float, noise: float = 0.0, size: float = 1.0, floor: float = 0.0
) -> tuple[Motion, np.ndarray]:
    """Feet that stand at known times (F, 2) and in between go their way in arcs, at a pace that begins and ends at
    once; `noise` m on every joint in every frame. Nothing but the feet is posed.
    """
    rng = np.random.default_rng(seed)
    count = round(8 * fps)
    times = np.arange(count) / fps
    places, held = np.zeros((count, 2, 3)), np.zeros((count, 2), dtype=bool)
    for foot in range(2):
        t, place = -rng.uniform(0.0, 0.5), np.array([0.2 * foot, 0.0, 0.0])
        while t < times[-1]:
            down, swing = rng.uniform(0.25, 0.9), rng.uniform(0.3, 0.5)
            here = (times >= t) & (times < t + down)
            places[here, foot], held[here, foot] = place, True
            step = rng.uniform(0.4, 0.9) * np.array([rng.normal(scale=0.2), 0.0, 1.0])
            away = (times >= t + down) & (times < t + down + swing)
            share = (times[away] - t - down) / swing
            places[away, foot] = place + share[:, None] * step
            places[away, foot, 1] = 0.12 * np.sin(np.pi * share)
            t, place = t + down + swing, place + step
    positions = np.zeros((count, RIG.joint_count, 3))
    positions[:, 0] = [0.0, 0.9, 0.0]
    for foot, (ankle, toe) in enumerate(((3, 4), (7, 8))):
        positions[:, ankle] = places[:, foot] + [0.0, 0.08, 0.0]
        positions[:, toe] = places[:, foot] + [0.0, 0.01, 0.12]
    positions = size * positions + rng.normal(scale=max(noise, 1e-12), size=positions.shape) + [0.0, floor, 0.0]
    skeleton = replace(RIG, offsets=size * RIG.offsets)
    identity = np.broadcast_to(skeleton.rest, (count, RIG.joint_count, 4))
    translations, _ = local_from_world(skeleton, positions, identity)
    return Motion(skeleton, translations, identity, fps), held


def both(motion: Motion) -> np.ndarray:
    found = find_contacts(motion)
    return np.stack([found.of(leg.foot, leg.toe) for leg in legs_of(motion.skeleton)], axis=1)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([30.0, 60.0, 120.0]), st.sampled_from([0.0, 1e-4, 3e-4]))
def test_known_stances_are_found_and_nothing_else(seed: int, fps: float, noise: float):
    motion, truth = stepping(seed, fps, noise)
    found = both(motion)
    assert (found & truth).sum() >= 0.95 * truth.sum()
    assert (found & truth).sum() >= 0.95 * found.sum()


def test_a_leg_has_three_joints_or_four():
    assert Leg(4, 5, 6, 7).joints == (4, 5, 6, 7)
    assert Leg(4, 5, 6, None).joints == (4, 5, 6)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.01, 100.0), st.floats(-50.0, 50.0))
def test_size_and_height_of_the_floor_do_not_matter(seed: int, size: float, floor: float):
    plain, other = stepping(seed, 60.0)[0], stepping(seed, 60.0, size=size, floor=floor)[0]
    assert (both(plain) == both(other)).mean() > 0.999


def test_speed_between_both_bounds_neither_begins_a_contact_nor_ends_one():
    """Hysteresis: a foot that drifts at a speed between the bounds stands if it stood before, and not otherwise."""
    motion, _ = stepping(0, 60.0)
    middle = (SLOW[0] + SLOW[1]) / 2 * hip_height(motion.skeleton) / 60
    translations = np.repeat(motion.translations[:1], 240, axis=0)
    way = np.cumsum(np.where(np.arange(240) < 120, 0.0, middle))
    stood = replace(motion, rotations=motion.rotations[:240], translations=translations.copy())
    moved = translations.copy()
    moved[:, 0, 2] += way
    drifts = replace(stood, translations=moved)
    assert both(drifts).all()
    never = replace(
        stood,
        translations=translations + middle * np.arange(240)[:, None, None] * (np.arange(9) == 0)[:, None] * [0, 0, 1],
    )
    assert not both(never).any()


CLIPS = {
    "bandai/dataset-1_walk_normal_001.bvh": (0.40, 0.65, 5),
    "mixamo_xbot_60fps/Walking (1).fbx": (0.35, 0.65, 2),
    "mixamo_xbot_60fps/Running.fbx": (0.05, 0.35, 1),
    "mixamo_xbot_30fps/Idle.fbx": (0.95, 1.0, 1),
    "cmu/02_01.bvh": (0.30, 0.75, 2),
}
"""Clip: least and greatest share of the frames in which a foot stands, and least number of its stances."""


@pytest.mark.parametrize("place", CLIPS)
def test_real_clips_stand_about_as_long_as_people_do(place: str):
    folder = os.environ.get("KINESTITCH_DATA")
    if not folder or not (Path(folder) / place).exists():
        pytest.skip("KINESTITCH_DATA does not hold this clip")
    motion = files.read(Path(folder) / place)
    found = find_contacts(motion)
    least, most, stances = CLIPS[place]
    for leg in legs_of(motion.skeleton):
        column = found.of(leg.foot, leg.toe)
        assert least <= column.mean() <= most
        assert len(runs(column)) >= stances
