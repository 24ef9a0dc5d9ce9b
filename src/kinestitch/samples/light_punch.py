"""Light punch: a quick jab of the left hand, the feet where they are, the shoulders turning a little."""

from __future__ import annotations

from kinestitch.samples import guard
from kinestitch.samples.build import Choreography, Reach
from kinestitch.samples.curves import keyed
from kinestitch.samples.feet import Footwork, planted

SECONDS = 2.0

_HIPS = (
    (0.0, *guard.HIPS),
    (0.3, 0.0, 0.898, 0.015),
    (0.52, 0.0, 0.895, 0.018),
    (0.72, 0.012, 0.896, 0.075),
    (0.95, 0.008, 0.899, 0.05),
    (1.35, *guard.HIPS),
    (2.0, *guard.HIPS),
)
_PELVIS = (
    (0.0, *guard.PELVIS),
    (0.5, -21, 5, 0),
    (0.72, -31, 6, 0),
    (1.0, -26, 5, 0),
    (1.35, *guard.PELVIS),
    (2.0, *guard.PELVIS),
)
_SPINE = (
    (0.0, *guard.SPINE),
    (0.52, -8, 10, 0),
    (0.71, -24, 11, -2),
    (0.95, -14, 10, 0),
    (1.4, *guard.SPINE),
    (2.0, *guard.SPINE),
)
_HEAD = (
    (0.0, *guard.HEAD),
    (0.72, -2, 8, 0),
    (1.2, *guard.HEAD),
)
_LEFT_WRIST = (
    (0.0, *guard.LEFT_WRIST),
    (0.35, 0.078, 0.02, 0.385, 22),
    (0.56, 0.08, 0.015, 0.345, 24),
    (0.7, -0.01, 0.03, 0.71, 50),
    (0.76, -0.005, 0.03, 0.68, 48),
    (0.94, 0.07, 0.035, 0.37, 26),
    (1.3, *guard.LEFT_WRIST),
    (2.0, *guard.LEFT_WRIST),
)
_RIGHT_WRIST = (
    (0.0, *guard.RIGHT_WRIST),
    (0.72, 0.035, 0.005, 0.205, 18),
    (1.2, *guard.RIGHT_WRIST),
    (2.0, *guard.RIGHT_WRIST),
)


def choreography() -> Choreography:
    """Hardly any wind-up; the fist is out at 0.7 s, back in the guard a quarter of a second later."""
    return Choreography(
        seconds=SECONDS,
        hips=keyed(
            _HIPS,
            smooth=0.05,
        ),
        pelvis=keyed(_PELVIS),
        spine=keyed(
            _SPINE,
            smooth=0.035,
        ),
        head=keyed(_HEAD, smooth=0.08),
        left_arm=Reach(
            keyed(
                _LEFT_WRIST,
                smooth=0.024,
            )
        ),
        right_arm=Reach(
            keyed(
                _RIGHT_WRIST,
                smooth=0.06,
            )
        ),
        left_foot=planted(*guard.LEFT_BALL, guard.LEFT_YAW, SECONDS),
        right_foot=Footwork((guard.standing(False, *_rear_heel()),)),
        fists=75.0,
    )


def _rear_heel() -> tuple[tuple[float, float, float], ...]:
    """The rear heel comes up a little with the push."""
    yaw = guard.RIGHT_YAW
    return ((-1.0, 0.0, yaw), (0.50, 0.0, yaw), (0.72, -14.0, yaw), (1.15, 0.0, yaw), (4.0, 0.0, yaw))
