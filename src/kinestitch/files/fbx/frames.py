"""The frames of a take: from its first to its last key, both included, at the rate of the file or of the keys."""

from __future__ import annotations

import numpy as np

from kinestitch.errors import FormatError
from kinestitch.files.fbx.animation import Take
from kinestitch.files.fbx.curves import TICKS, Ticks
from kinestitch.files.fbx.scene import Key
from kinestitch.files.rates import SNAP, snap_rate

_FREE_POSES = 2_000_000  # joint poses that a file of few keys may ask for
_POSES_PER_KEY = 100


def frame_ticks(take: Take | None, models: list[Key], fps: float) -> tuple[Ticks, float]:
    """Times (F,) in ticks of every frame and their rate, of the curves that move `models`; one frame where none does.

    fps : the rate that the file's settings name. Keys that stand evenly at another rate win over it.
    Raises FormatError where far-apart keys claim more frames than the file could fill.
    """
    wanted = set(models)
    moving = (
        [curve.times for (key, _), curve in take.curves() if key in wanted and len(curve.times) > 1] if take else []
    )
    if not moving:
        return np.zeros(1, dtype=np.int64), fps
    start, stop = min(int(times[0]) for times in moving), max(int(times[-1]) for times in moving)
    fps = _rate_of_keys(max(moving, key=len), fps)
    count = int((stop - start) * fps / TICKS + 0.01) + 1
    keys = sum(len(times) for times in moving)
    if count * len(models) > _FREE_POSES + _POSES_PER_KEY * keys:
        raise FormatError(
            f"Expected a clip, got {keys} keys spread over {count} frames. Shorten the take and export it again."
        )
    return start + np.rint(np.arange(count) * (TICKS / fps)).astype(np.int64), fps


def _rate_of_keys(times: Ticks, fps: float) -> float:
    gaps = np.diff(times)
    usual = float(np.median(gaps))
    frames = usual * fps / TICKS
    on_grid = round(frames) >= 1 and abs(frames - round(frames)) < SNAP * frames
    even = np.mean(np.abs(gaps - usual) < 2e-3 * usual) >= 0.9
    if on_grid or not even or len(gaps) < 4 or not 0.02 < frames < 2:
        return fps
    return snap_rate(TICKS / usual)
