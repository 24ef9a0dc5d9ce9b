"""Every file in the folder of real clips is read or refused in one clear line; the table is told at the end."""

import os
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from kinestitch import files
from kinestitch.core.motion import Motion
from kinestitch.errors import FormatError, KinestitchWarning, UnsupportedFormatError
from kinestitch.testing import check_motion

DATA = os.environ.get("KINESTITCH_DATA")
SECONDS = 10.0
"""Of the processor's time, for one file."""
LIBRARIES = {"usd": "pxr.Usd", "c3d": "ezc3d"}
"""What the extras install."""

pytestmark = pytest.mark.skipif(not DATA, reason="KINESTITCH_DATA, the folder of real clips, is not set")


def names():
    """Paths of the files inside the folder; the two that tell of the others are no clips."""
    folder = Path(DATA or ".")
    every = sorted(path for path in folder.rglob("*") if path.is_file()) if DATA else []
    return [str(path.relative_to(folder)) for path in every if path.suffix != ".md"]


def told():
    """Frames and joints (None where the table says nothing) of files, by name."""
    table = (Path(DATA) / "MANIFEST.md").read_text(encoding="utf-8") if DATA else ""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return {r[0]: tuple(int(c) if c.isdecimal() else None for c in r[5:7]) for r in rows if len(r) == 8}


TOLD = told()


def load(path):
    """The file's motion or recording, and how many warnings there were; warnings of others are errors."""
    entry = files.format_of(path)
    if entry.extra:
        pytest.importorskip(LIBRARIES[entry.extra], reason=f"the extra {entry.extra} is not installed")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        clip = (files.read_recording if entry.records else files.read)(path)
    assert all(issubclass(w.category, KinestitchWarning) for w in caught), [str(w.message) for w in caught]
    return clip, len(caught)


def account(clip, warned):
    """What was read, in words."""
    if isinstance(clip, Motion):
        check_motion(clip)
        what = f"{clip.frames} frames, {clip.skeleton.joint_count} joints, {clip.fps:g} fps"
    else:
        seen = np.isfinite(clip.markers).all(axis=-1).mean() if clip.markers.size else 1.0
        what = f"{clip.frames} frames, {len(clip.marker_names)} markers ({seen:.0%} seen), {clip.rate:g} fps"
        what += f", {len(clip.analog_names)} channels, {clip.analog_rate:g} Hz" if clip.analog_names else ""
    return what + (f", {warned} warning(s)" if warned else "")


def refusal(error, path):
    """The line that refuses a file, without its path."""
    message = str(error)
    assert message.endswith(f" ({path})")
    assert message.count(str(path)) == 1
    assert "\n" not in message
    assert "xpected " in message
    return message.removesuffix(f" ({path})")


@pytest.mark.parametrize("name", names())
def test_real_file(name, tell_file, capfd):
    path = Path(DATA) / name
    frames, joints = TOLD.get(name, (None, None))
    capfd.readouterr()
    begun = time.process_time()
    try:
        clip, warned = load(path)
    except UnsupportedFormatError as error:
        row = f"refused: {refusal(error, path)}"
    except FormatError as error:
        row = f"refused: {refusal(error, path)}"
        if frames is not None:
            pytest.fail(f"a sound clip was {row}")
    else:
        took = time.process_time() - begun
        row = f"{account(clip, warned)}, {1000 * took:.0f} ms"
        assert frames in (None, clip.frames)
        assert joints is None or joints == clip.skeleton.joint_count
    assert time.process_time() - begun < SECONDS
    assert capfd.readouterr() == ("", ""), "something was printed"
    tell_file.append(f"{name}: {row}")
