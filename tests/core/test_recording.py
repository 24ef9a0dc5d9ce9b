"""A recording checks its parts when it is made."""

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.recording import Recording
from kinestitch.errors import InvalidMotionError

GOOD = Recording(np.zeros((4, 2, 3)), ("A", "B"), 50.0, np.zeros((8, 1)), ("EMG",), ("V",), 100.0, "trial")


def test_parts():
    assert (GOOD.frames, GOOD.samples, GOOD.duration) == (4, 8, 0.08)
    assert not GOOD.markers.flags.writeable
    assert not GOOD.analog.flags.writeable
    assert replace(GOOD, rate=10).duration == 0.4


def test_copies_what_others_could_change():
    mine = np.zeros((4, 2, 3))
    recording = replace(GOOD, markers=mine)
    mine[:] = 1
    assert not recording.markers.any()


def part_of(value):
    markers = np.zeros((4, 2, 3))
    markers[1, 1, 2] = value
    return markers


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rate": 0}, "Expected rate > 0, got 0.0"),
        ({"analog_rate": np.nan}, "Expected analog_rate > 0, got nan"),
        ({"markers": np.zeros((4, 3, 3))}, r"Expected markers of shape \(F, 2, 3\), got \(4, 3, 3\)"),
        ({"markers": np.zeros((2, 3))}, "Expected markers of shape"),
        ({"analog": np.zeros((8, 2))}, r"Expected analog of shape \(S, 1\)"),
        ({"analog_units": ()}, "Expected 1 analog units, got 0"),
        ({"marker_names": ("A", "A")}, "Expected unique marker names, got 'A'"),
        ({"markers": part_of(np.inf)}, "got infinity"),
        ({"analog": np.full((8, 1), -np.inf)}, "got infinity"),
        ({"markers": part_of(np.nan)}, "seen whole or not at all, got .* at frame 1, marker 'B'"),
    ],
)
def test_refused(changes, message):
    with pytest.raises(InvalidMotionError, match=message):
        replace(GOOD, **changes)


def test_a_marker_that_was_not_seen_is_nan():
    markers = np.zeros((4, 2, 3))
    markers[2, 0] = np.nan
    assert np.isnan(replace(GOOD, markers=markers).markers[2, 0]).all()
