"""Kick: a front kick of the right leg out of the guard, knee first, and back into the guard."""

from __future__ import annotations

from kinestitch.samples import guard
from kinestitch.samples.build import Choreography, Reach
from kinestitch.samples.curves import keyed
from kinestitch.samples.feet import Footwork, planted

SECONDS = 2.5

_HIPS = (
    (0.0, *guard.HIPS),
    (0.24, -0.015, 0.893, 0.005),
    (0.5, 0.04, 0.9, 0.12),
    (0.7, 0.106, 0.925, 0.185),
    (0.86, 0.111, 0.94, 0.195),
    (1.0, 0.111, 0.945, 0.225),
    (1.16, 0.111, 0.935, 0.2),
    (1.36, 0.096, 0.918, 0.16),
    (1.58, 0.02, 0.893, 0.075),
    (1.8, -0.005, 0.89, 0.02),
    (2.15, *guard.HIPS),
    (2.5, *guard.HIPS),
)
_PELVIS = (
    (0.0, *guard.PELVIS),
    (0.26, -30, 7, 0),
    (0.64, -8, 4, -2),
    (0.84, 6, -8, -4),
    (1.0, 20, -22, -4),
    (1.16, 10, -10, -4),
    (1.4, -10, 2, -2),
    (1.66, -26, 7, 0),
    (2.1, *guard.PELVIS),
    (2.5, *guard.PELVIS),
)
_SPINE = (
    (0.0, *guard.SPINE),
    (0.3, -14, 12, 0),
    (0.7, -14, 12, 0),
    (0.88, -20, 16, 2),
    (1.02, -30, 6, 4),
    (1.2, -22, 14, 2),
    (1.5, -12, 14, 0),
    (1.75, -12, 12, 0),
    (2.1, *guard.SPINE),
    (2.5, *guard.SPINE),
)
_HEAD = (
    (0.0, *guard.HEAD),
    (0.8, 0, 4, 0),
    (1.02, 0, -4, 0),
    (1.5, 0, 8, 0),
    (2.1, *guard.HEAD),
)
_LEFT_WRIST = (
    (0.0, *guard.LEFT_WRIST),
    (0.5, 0.08, 0.03, 0.38, 22),
    (0.84, 0.09, 0.03, 0.32, 26),
    (1.02, 0.12, 0.0, 0.3, 30),
    (1.3, 0.09, 0.02, 0.34, 26),
    (1.8, *guard.LEFT_WRIST),
    (2.5, *guard.LEFT_WRIST),
)
_RIGHT_WRIST = (
    (0.0, *guard.RIGHT_WRIST),
    (0.45, 0.06, -0.02, 0.22, 24),
    (0.76, 0.16, -0.14, 0.22, 34),
    (1.0, 0.38, -0.45, 0.04, 30),
    (1.16, 0.34, -0.36, 0.08, 32),
    (1.45, 0.14, -0.1, 0.22, 28),
    (1.8, *guard.RIGHT_WRIST),
    (2.5, *guard.RIGHT_WRIST),
)
_KNEES = (
    (0.0, 0, 0),
    (0.6, 0, -8),
    (0.9, 0, 0),
    (1.2, 0, 0),
    (1.5, 0, -4),
    (1.8, 0, 0),
)


def choreography() -> Choreography:
    """The weight goes onto the left leg, the knee comes up, the foot snaps out chest-high at 1 s and folds again."""
    return Choreography(
        seconds=SECONDS,
        hips=keyed(
            _HIPS,
            smooth=0.05,
        ),
        pelvis=keyed(_PELVIS),
        spine=keyed(_SPINE),
        head=keyed(_HEAD, smooth=0.08),
        left_arm=Reach(
            keyed(
                _LEFT_WRIST,
                smooth=0.05,
            )
        ),
        right_arm=Reach(
            keyed(
                _RIGHT_WRIST,
                smooth=0.05,
            )
        ),
        left_foot=planted(*guard.LEFT_BALL, guard.LEFT_YAW, SECONDS),
        right_foot=_kicking(),
        knees=keyed(_KNEES),
        fists=75.0,
    )


def _kicking() -> Footwork:
    """Ankle of the right foot: up behind the knee, out along the line of the thigh, and back the way it came."""
    yaw = guard.RIGHT_YAW
    before = guard.standing(False, (-0.5, 0.0, yaw), (0.40, 0.0, yaw), (0.64, -52.0, yaw + 14))
    after = guard.standing(False, (1.56, -30.0, yaw), (1.68, 0.0, yaw), (4.0, 0.0, yaw))
    air = (
        (0.75, -0.100, 0.345, 0.060, -46.0, -12.0),
        (0.87, -0.035, 0.640, 0.445, -30.0, 0.0),
        (1.00, 0.000, 1.300, 0.985, 82.0, 0.0),
        (1.14, -0.025, 0.640, 0.505, -22.0, 0.0),
        (1.32, -0.085, 0.375, 0.150, -34.0, -14.0),
    )
    return Footwork((before, after), (air,))
