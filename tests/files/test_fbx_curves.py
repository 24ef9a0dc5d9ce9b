"""FBX curves by hand: tangents of every kind, and what comes before the first and after the last key."""

import numpy as np
import pytest

from kinestitch.files.fbx.curves import TICKS, Curve, make_curve, sample
from kinestitch.files.fbx.extrapolation import Beyond
from kinestitch.files.fbx.tangents import cubic_slopes, secants

CUBIC, AUTO, TCB, USER, SPLIT, EVEN, CLAMP, PROGRESSIVE = 8, 0x100, 0x200, 0x400, 0x800, 0x2000, 0x1000, 0x4000
TIMES = np.array([0.0, 1.0, 3.0, 4.0])
VALUES = np.array([0.0, 2.0, 4.0, 3.0])


def slopes(*flags, data=None, values=VALUES):
    told = np.zeros((4, 3)) if data is None else np.array(data, dtype=float)
    return cubic_slopes(TIMES, values, np.array(flags) | CUBIC, told, np.full((4, 2), 1 / 3))


def test_slopes_that_the_file_tells_are_kept():
    told = np.arange(12.0).reshape(4, 3)
    np.testing.assert_array_equal(slopes(*[USER] * 4, data=told), told[:, :2])


def test_automatic_keys_follow_their_neighbours():
    even = slopes(*[AUTO | EVEN] * 4)
    np.testing.assert_allclose(even[:, 0], [2, 4 / 3, 1 / 3, -1])
    np.testing.assert_allclose(even[:3, 1], [4 / 3, 1 / 3, -1])
    # keys that heed the spacing take the mean of that and of the secants weighted the other way round
    plain = slopes(*[AUTO] * 4)
    np.testing.assert_allclose(plain[1:3, 0], [(4 / 3 + 5 / 3) / 2, (1 / 3 - 1 / 3) / 2], atol=1e-12)


def test_clamped_keys_are_level_beside_an_equal_one_and_progressive_ones_do_not_overshoot():
    level = slopes(*[AUTO | EVEN | CLAMP] * 4, values=np.array([0.0, 2, 2, 3]))
    np.testing.assert_allclose(level[:, 0], [2, 0, 0, 1])
    held = slopes(*[AUTO | EVEN | PROGRESSIVE] * 4, values=np.array([0.0, 0.1, 4, 5]))
    np.testing.assert_allclose(held[:, 0], [0, 0.3, 5 - 10.3 / 3, 0], atol=0.15)
    assert held[0, 0] == held[2, 1] == 0


def test_bias_leans_and_a_split_key_leans_two_ways():
    bias = slopes(0, AUTO | EVEN * 0, 0, 0, data=[[0, 0, 0], [100, 0, 0], [0, 0, 0], [0, 0, 0]])
    assert bias[1, 0] == bias[0, 1] == 1  # wholly towards the key after
    split = slopes(0, AUTO | SPLIT, 0, 0, data=[[0, 100, 0], [100, 0, 0], [0, 0, 0], [0, 0, 0]])
    assert (split[0, 1], split[1, 0]) == (2, 1)
    steep = slopes(0, AUTO, 0, 0, data=[[0, 0, 0], [600, 0, 0], [0, 0, 0], [0, 0, 0]])
    assert steep[1, 0] == pytest.approx(1.5 + 6 * (1 - 1.5) - 40)


def test_tension_continuity_and_bias():
    assert slopes(0, TCB, 0, 0)[1, 0] == slopes(0, TCB, 0, 0)[0, 1] == 1.5
    tense = slopes(0, TCB, 0, 0, data=[[0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, 0]])
    assert tense[1, 0] == tense[0, 1] == 0
    broken = slopes(0, TCB, 0, 0, data=[[0, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 0]])
    assert (broken[0, 1], broken[1, 0]) == (1, 2)
    np.testing.assert_array_equal(secants(TIMES, VALUES), [[0, 2, 1, -1], [2, 1, -1, 0]])


def curve(kind="", count=-1, flags=4):
    beyond = (Beyond(kind, count), Beyond(kind, count))
    times = np.array([0, 1, 2]) * TICKS
    return Curve(times, np.array([1.0, 3.0, 2.0]), np.full(3, flags), np.zeros((3, 3)), np.full((3, 2), 1 / 3), beyond)


@pytest.mark.parametrize(
    ("kind", "count", "expected"),
    [
        ("", -1, [1, 1, 1, 1, 3, 2, 2, 2, 2]),
        ("R", -1, [3, 1, 3, 1, 3, 2, 3, 1, 3]),
        ("A", -1, [1, 0, 2, 1, 3, 2, 4, 3, 5]),
        ("M", -1, [3, 2, 3, 1, 3, 2, 3, 1, 3]),
        ("R", 1, [1, 1, 3, 1, 3, 2, 3, 2, 2]),
        ("A", 0, [1, 1, 1, 1, 3, 2, 2, 2, 2]),
        ("K", -1, [-5, -3, -1, 1, 3, 2, 1, 0, -1]),
        ("?", -1, [1, 1, 1, 1, 3, 2, 2, 2, 2]),
    ],
)
def test_beyond_the_ends(kind, count, expected):
    seconds = np.array([-3, -2, -1, 0, 1, 2, 3, 4, 5]) * TICKS
    shown = sample(curve(kind, count), seconds)
    # where a cycle meets the next one either of both ends may be shown
    meeting = np.isin(seconds // TICKS, (-2, 4)) if kind in {"R", "A"} else np.zeros(9, dtype=bool)
    np.testing.assert_allclose(shown[~meeting], np.array(expected, dtype=float)[~meeting])


def test_steps_change_on_the_key_even_where_a_frame_is_rounded():
    stepped = curve(flags=2)
    np.testing.assert_array_equal(
        sample(stepped, np.array([0, TICKS // 2, TICKS - 1, TICKS, TICKS + 1])), [1, 1, 3, 3, 3]
    )
    after = curve(flags=0x102)
    np.testing.assert_array_equal(sample(after, np.array([1, TICKS // 2, TICKS + 1, 2 * TICKS - 1])), [1, 3, 3, 2])


def test_keys_out_of_order_are_sorted_and_the_last_of_equals_counts():
    times = np.array([2, 0, 1, 1]) * TICKS
    made = make_curve(times, np.array([2.0, 0, 9, 1]), np.full(4, 4), np.zeros((4, 3)), np.zeros((4, 2)))
    np.testing.assert_array_equal(made.times, np.array([0, 1, 2]) * TICKS)
    np.testing.assert_array_equal(made.values, [0, 1, 2])


def test_weighted_handles_keep_to_the_curve():
    times = np.array([0, 1]) * TICKS
    flags, data = np.full(2, CUBIC | USER), np.zeros((2, 3))
    weighted = Curve(times, np.array([0.0, 1.0]), flags, data, np.array([[0.9, 0.9], [0, 0]]))
    mirrored = sample(weighted, np.linspace(0, TICKS, 21).astype(np.int64))
    np.testing.assert_allclose(mirrored + mirrored[::-1], 1, atol=1e-9)
    assert mirrored[5] < 0.06
