"""Heavy punch: a right cross with all the weight: wind-up on the rear leg, a step, then hips, shoulders, fist."""

from __future__ import annotations

from kinestitch.samples import guard
from kinestitch.samples.build import Choreography, Reach
from kinestitch.samples.curves import keyed
from kinestitch.samples.feet import Footwork, Stance

SECONDS = 2.5
STEP = 0.200
"""How far the left foot steps forwards into the punch, and comes back afterwards, in m."""

_HIPS = (
    (0.0, *guard.HIPS),
    (0.3, -0.02, 0.89, 0.005),
    (0.66, -0.045, 0.862, -0.045),
    (0.84, 0.0, 0.866, 0.07),
    (1.0, 0.035, 0.868, 0.19),
    (1.14, 0.045, 0.862, 0.215),
    (1.42, 0.03, 0.876, 0.15),
    (1.8, 0.0, 0.895, 0.04),
    (2.15, *guard.HIPS),
    (2.5, *guard.HIPS),
)
_PELVIS = (
    (0.0, *guard.PELVIS),
    (0.3, -30, 6, 0),
    (0.68, -52, 6, 2),
    (0.82, -24, 8, 0),
    (0.97, 24, 10, -2),
    (1.14, 33, 11, -2),
    (1.45, 6, 8, 0),
    (1.85, -22, 5, 0),
    (2.15, *guard.PELVIS),
    (2.5, *guard.PELVIS),
)
_SPINE = (
    (0.0, *guard.SPINE),
    (0.34, -16, 10, 0),
    (0.74, -36, 8, 4),
    (0.86, -22, 10, 2),
    (1.0, 24, 14, -5),
    (1.16, 32, 17, -6),
    (1.5, 4, 12, -2),
    (1.9, -12, 9, 0),
    (2.15, *guard.SPINE),
    (2.5, *guard.SPINE),
)
_HEAD = (
    (0.0, *guard.HEAD),
    (0.72, -4, 6, 0),
    (1.05, 6, 9, -2),
    (1.6, *guard.HEAD),
)
_LEFT_WRIST = (
    (0.0, *guard.LEFT_WRIST),
    (0.4, 0.08, 0.03, 0.41, 24),
    (0.7, 0.07, 0.035, 0.47, 26),
    (0.9, 0.09, 0.01, 0.27, 24),
    (1.04, 0.085, -0.01, 0.165, 22),
    (1.25, 0.085, -0.01, 0.18, 22),
    (1.75, 0.08, 0.025, 0.35, 22),
    (2.1, *guard.LEFT_WRIST),
    (2.5, *guard.LEFT_WRIST),
)
_RIGHT_WRIST = (
    (0.0, *guard.RIGHT_WRIST),
    (0.3, 0.08, -0.02, 0.19, 28),
    (0.74, 0.21, -0.06, -0.01, 48),
    (0.84, 0.19, -0.035, 0.1, 60),
    (0.98, -0.03, 0.02, 0.74, 62),
    (1.05, -0.075, 0.0, 0.73, 58),
    (1.2, -0.12, -0.11, 0.56, 50),
    (1.45, 0.01, -0.08, 0.36, 36),
    (1.8, 0.05, -0.02, 0.23, 26),
    (2.1, *guard.RIGHT_WRIST),
    (2.5, *guard.RIGHT_WRIST),
)
_KNEES = (
    (0.0, 0, 0),
    (0.66, 0, 4),
    (1.05, 0, 2),
    (1.6, 0, 0),
)


def choreography() -> Choreography:
    """The fist is drawn back until 0.72 s, lands at 0.98 s, follows through across the body and returns slowly."""
    return Choreography(
        seconds=SECONDS,
        hips=keyed(
            _HIPS,
            smooth=0.05,
        ),
        pelvis=keyed(
            _PELVIS,
            smooth=0.035,
        ),
        spine=keyed(
            _SPINE,
            smooth=0.035,
        ),
        head=keyed(_HEAD, smooth=0.08),
        left_arm=Reach(
            keyed(
                _LEFT_WRIST,
                smooth=0.045,
            )
        ),
        right_arm=Reach(
            keyed(
                _RIGHT_WRIST,
                smooth=0.024,
            )
        ),
        left_foot=_leading(),
        right_foot=Footwork((guard.standing(False, *_pivot()),)),
        knees=keyed(_KNEES),
        fists=75.0,
    )


def _leading() -> Footwork:
    """The left foot steps forwards low and lands heel first as the hips begin to turn; later it steps back."""
    x, z = guard.LEFT_BALL
    yaw = guard.LEFT_YAW
    first = Stance(x, z, ((-1.0, 0.0, yaw), (0.46, 0.0, yaw), (0.58, -16.0, yaw)))
    second = Stance(x, z + STEP, ((0.80, 6.0, yaw), (0.87, 0.0, yaw), (1.50, 0.0, yaw), (1.62, -14.0, yaw)))
    third = Stance(x, z, ((1.90, -12.0, yaw), (1.98, 0.0, yaw), (4.0, 0.0, yaw)))
    ankle = z - 0.136
    forth = ((0.69, x, 0.125, ankle + 0.55 * STEP, -4.0, yaw),)
    back = ((1.76, x, 0.125, ankle + 0.50 * STEP, -12.0, yaw),)
    return Footwork((first, second, third), (forth, back))


def _pivot() -> tuple[tuple[float, float, float], ...]:
    """The right foot turns on its ball with the hips, the heel swinging out and up."""
    yaw = guard.RIGHT_YAW
    return (
        (-1.0, 0.0, yaw),
        (0.72, 0.0, yaw),
        (1.04, -46.0, 4.0),
        (1.24, -46.0, 4.0),
        (1.86, 0.0, yaw),
        (4.0, 0.0, yaw),
    )
