"""What a skeleton and a motion promise at construction: everything else is refused, and nothing changes afterwards."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from kinestitch.core.motion import Motion, motion_of_units
from kinestitch.core.rotation import quat_identity
from kinestitch.core.skeleton import Skeleton, first_difference
from kinestitch.errors import InvalidMotionError
from kinestitch.testing import check_motion, random_motion

NAMES = ("Hips", "Spine", "LeftLeg")
PARENTS = (-1, 0, 0)
OFFSETS = np.array([[0, 1.0, 0], [0, 0.2, 0], [0.1, -0.1, 0]])
RIG = Skeleton(NAMES, PARENTS, OFFSETS)


def arrays(frames: int = 4) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((frames, 3, 3)), quat_identity((frames, 3))


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"names": (), "parents": (), "offsets": np.zeros((0, 3))}, "at least one joint"),
        ({"names": ("Hips", "Spine", "Spine")}, "'Spine' more than once"),
        ({"names": ("Hips", "Spine")}, "2 parents"),
        ({"parents": (-1, 0)}, "3 parents"),
        ({"parents": (0, 0, 0)}, "joint 0 .*'Hips'"),
        ({"parents": (-1, -1, 0)}, "joint 1 .*'Spine'"),
        ({"parents": (-1, 1, 0)}, r"\[0, 1\)"),
        ({"parents": (-1, 2, 0)}, "got 2"),
        ({"parents": (-1, 0, -2)}, "got -2"),
        ({"offsets": OFFSETS[:2]}, r"offsets of shape \(3, 3\), got \(2, 3\)"),
        ({"offsets": np.full((3, 3), np.nan)}, "finite offsets"),
        ({"offsets": np.full((3, 3), np.inf)}, "finite offsets"),
        ({"rest": np.zeros((3, 3))}, "rest of shape"),
        ({"rest": np.zeros((3, 4))}, "unit norm"),
        ({"rest": np.full((3, 4), np.nan)}, "unit norm"),
        ({"rest": 1.001 * quat_identity((3,))}, "unit norm"),
        ({"tips": np.zeros((2, 3))}, "tips of shape"),
    ],
)
def test_skeletons_refused(fields: dict, words: str):
    with pytest.raises(InvalidMotionError, match=words):
        Skeleton(**{"names": NAMES, "parents": PARENTS, "offsets": OFFSETS} | fields)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t, q: (t[:0], q[:0], 30), r"rotations of shape \(F ≥ 1, 3, 4\)"),
        (lambda t, q: (t, q[:, :2], 30), r"rotations of shape"),
        (lambda t, q: (t, q[..., :3], 30), r"rotations of shape"),
        (lambda t, q: (t, q[0], 30), r"rotations of shape"),
        (lambda t, q: (t[:3], q, 30), r"translations of shape \(4, 3, 3\), got \(3, 3, 3\)"),
        (lambda t, q: (t[0], q, 30), "translations of shape"),
        (lambda t, q: (t, q, 0), "fps > 0"),
        (lambda t, q: (t, q, -30), "fps > 0"),
        (lambda t, q: (t, q, np.nan), "fps > 0"),
        (lambda t, q: (t, q, np.inf), "fps > 0"),
        (lambda t, q: (t, q * 1.001, 30), r"norm² 1.002 at frame 0, joint 'Hips'"),
        (lambda t, q: (t, q * 0.0, 30), "unit quaternions"),
    ],
)
def test_motions_refused(change, words: str):
    with pytest.raises(InvalidMotionError, match=words):
        Motion(RIG, *change(*arrays()))


def test_a_motion_made_from_units_is_one_as_any_other():
    made = motion_of_units(RIG, *arrays(), 30, "clip")
    check_motion(made)
    assert (made.fps, made.name, made.frames) == (30.0, "clip", 4)
    assert dataclasses.replace(made, name="again").rotations is made.rotations
    with pytest.raises(InvalidMotionError, match="rotations of shape"):
        motion_of_units(RIG, arrays()[0], arrays()[1][:, :2], 30, "clip")
    with pytest.raises(InvalidMotionError, match="fps > 0"):
        motion_of_units(RIG, *arrays(), 0, "clip")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("what", ["translations", "rotations"])
def test_one_bad_number_is_found_and_named(bad: float, what: str):
    translations, rotations = arrays()
    (translations if what == "translations" else rotations)[2, 1, 1] = bad
    for make in (Motion, motion_of_units) if what == "translations" else (Motion,):
        with pytest.raises(InvalidMotionError, match="at frame 2, joint 'Spine'"):
            make(RIG, translations, rotations, 30, "clip")


def test_arrays_are_read_only():
    motion = random_motion(1)
    check_motion(motion)
    rig = motion.skeleton
    for array in (motion.translations, motion.rotations, rig.offsets, rig.rest, rig.tips):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    for value, field in ((motion, "fps"), (motion, "translations"), (rig, "names")):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(value, field, None)


def writable(translations: np.ndarray) -> np.ndarray:
    return translations


def view(translations: np.ndarray) -> np.ndarray:
    return translations[:]


def read_only_view(translations: np.ndarray) -> np.ndarray:
    seen = translations[:]
    seen.setflags(write=False)
    return seen


def repeated(translations: np.ndarray) -> np.ndarray:
    return np.broadcast_to(translations[:1], translations.shape)


class Exposed:
    """Something of another library that hands out its own memory."""

    def __init__(self, values: np.ndarray) -> None:
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return self.values


def memory(translations: np.ndarray) -> np.ndarray:
    return np.frombuffer(memoryview(translations), dtype=np.float64).reshape(translations.shape)


@pytest.mark.parametrize("handed", [writable, view, read_only_view, repeated, Exposed, memory])
def test_a_callers_later_write_does_not_reach_the_motion(handed):
    translations, rotations = arrays()
    offsets = OFFSETS.copy()
    motion = Motion(Skeleton(NAMES, PARENTS, handed(offsets)), handed(translations), handed(rotations), 30)
    translations[:] = 7.0
    rotations[:] = 7.0
    offsets[:] = 7.0
    assert not motion.translations.any()
    np.testing.assert_array_equal(motion.rotations, quat_identity((4, 3)))
    assert translations.flags.writeable
    if handed is not repeated:
        np.testing.assert_array_equal(motion.skeleton.offsets, OFFSETS)


def test_repeated_translations_stay_a_view():
    still = np.broadcast_to(OFFSETS, (100_000, 3, 3))
    motion = Motion(RIG, still, np.broadcast_to(quat_identity(), (100_000, 3, 4)), 30)
    assert motion.translations.strides[0] == motion.rotations.strides[0] == 0
    check_motion(motion)


def test_what_nobody_can_write_to_is_not_copied():
    translations, rotations = arrays()
    for array in (translations, rotations):
        array.setflags(write=False)
    motion = Motion(RIG, translations, rotations, 30)
    assert motion.translations is translations
    part = Motion(RIG, motion.translations[1:3], motion.rotations[1:3], 30)
    assert np.shares_memory(part.rotations, rotations)


def test_lists_and_whole_numbers_are_welcome():
    rig = Skeleton(["a", "b"], [-1, 0], [[0, 0, 0], [0, 1, 0]])
    motion = Motion(rig, [[[0, 0, 0], [0, 1, 0]]], [[[0, 0, 0, 1], [0, 0, 0, -1]]], 30)
    assert motion.translations.dtype == motion.rotations.dtype == np.float64
    assert (rig.names, rig.parents) == (("a", "b"), (-1, 0))
    assert (motion.frames, motion.duration, motion.fps) == (1, 0.0, 30.0)


def test_skeletons_are_equal_by_value():
    same = Skeleton(NAMES, PARENTS, OFFSETS.copy())
    assert same == RIG
    assert hash(same) == hash(RIG)
    assert Skeleton(NAMES, PARENTS, OFFSETS + 1e-9) != RIG
    assert Skeleton(NAMES, PARENTS, OFFSETS, -quat_identity((3,))) != RIG
    assert Skeleton(NAMES, PARENTS, OFFSETS, tips=OFFSETS) != RIG
    assert RIG != "Hips"


def test_tree_questions():
    assert RIG.joint_count == 3
    assert RIG.index("LeftLeg") == 2
    assert RIG.children(0) == (1, 2)
    assert RIG.children(1) == ()
    assert RIG.chain(2) == (0, 2)
    np.testing.assert_array_equal(RIG.parent_array, PARENTS)
    with pytest.raises(InvalidMotionError, match=r"got 'LeftLeh'\. Try LeftLeg"):
        RIG.index("LeftLeh")


@pytest.mark.parametrize(
    ("a", "b", "place"), [("abc", "abc", None), ("abc", "axc", 1), ("ab", "abc", 2), ("", "a", 0), ("", "", None)]
)
def test_first_difference(a: str, b: str, place: int | None):
    assert first_difference(a, b) == place
