"""Eight clips made by code, so that demo, docs and tests run with nothing to download."""

from __future__ import annotations

import importlib
import math
from functools import cache
from typing import TYPE_CHECKING

from kinestitch.errors import ParameterError

if TYPE_CHECKING:
    from numpy import bool_
    from numpy.typing import NDArray

    from kinestitch.core.motion import Motion
    from kinestitch.core.skeleton import Skeleton
    from kinestitch.samples.build import Choreography

SAMPLE_NAMES = ("walk", "run", "jump", "jumping_jacks", "kick", "light_punch", "heavy_punch", "idle")


def humanoid() -> Skeleton:
    """The skeleton that all samples share; see :func:`kinestitch.samples.body.humanoid`."""
    from kinestitch.samples import body

    return body.humanoid()


@cache
def _choreography(name: str) -> Choreography:
    if name not in SAMPLE_NAMES:
        raise ParameterError(f"Expected a sample out of {', '.join(SAMPLE_NAMES)}, got {name!r}.")
    plan: Choreography = importlib.import_module(f"kinestitch.samples.{name}").choreography()
    return plan


def sample(name: str, *, fps: float = 60.0) -> Motion:
    """A clip by name: a person of 1.75 m who starts near the origin and faces +Z; the same numbers every time.

    fps : frames a second; the movement and its duration stay the same, to the frame

    Raises ParameterError for an unknown name or fps ≤ 0.
    """
    from kinestitch.samples.build import perform

    return perform(_choreography(name), _checked(fps), name)


def sample_contacts(name: str, *, fps: float = 60.0) -> dict[str, NDArray[bool_]]:
    """The truth about the feet of a sample: for each foot joint the frames (F,) in which the clip holds it still.

    ``…Foot`` is held while the whole sole stands, ``…ToeBase`` while the sole or the ball of the foot does. Raises as
    :func:`sample`.
    """
    from kinestitch.samples.body import PREFIX
    from kinestitch.samples.build import frame_times

    plan = _choreography(name)
    times = frame_times(plan.seconds, _checked(fps))
    held = {}
    for side, foot in (("Left", plan.left_foot), ("Right", plan.right_foot)):
        held[f"{PREFIX}{side}Foot"], held[f"{PREFIX}{side}ToeBase"] = foot.contacts(times)
    return held


def _checked(fps: float) -> float:
    if not (math.isfinite(fps) and fps > 0):
        raise ParameterError(f"Expected fps > 0, got {fps}.")
    return float(fps)
