"""Jump: crouch with the arms back, throw them up, fly, land softly and stand up."""

from __future__ import annotations

from kinestitch.samples.airborne import beside, hops
from kinestitch.samples.build import Choreography, Swing
from kinestitch.samples.curves import Curve, keyed
from kinestitch.samples.feet import Footwork, Stance

SECONDS = 2.5
OFF, ON = 0.96, 1.49
REACH = 0.65

_PELVIS = (
    (0.0, 0, 2, 0),
    (0.25, 0, 8, 0),
    (0.62, 0, 38, 0),
    (0.8, 0, 30, 0),
    (0.98, 0, 3, 0),
    (1.16, 0, 4, 0),
    (1.44, 0, 14, 0),
    (1.7, 0, 38, 0),
    (1.95, 0, 24, 0),
    (2.28, 0, 4, 0),
    (2.5, 0, 2, 0),
)
_SPINE = (
    (0.0, 0, 1, 0),
    (0.6, 0, 18, 0),
    (0.8, 0, 10, 0),
    (1.0, 0, -10, 0),
    (1.2, 0, 2, 0),
    (1.45, 0, 12, 0),
    (1.72, 0, 22, 0),
    (2.2, 0, 4, 0),
    (2.5, 0, 1, 0),
)
_HEAD = (
    (0.0, 0, 2, 0),
    (0.6, 0, 16, 0),
    (0.98, 0, -14, 0),
    (1.3, 0, 10, 0),
    (1.7, 0, 20, 0),
    (2.2, 0, 4, 0),
    (2.5, 0, 2, 0),
)
_KNEES = (
    (0.0, 0, 0),
    (0.6, 6, 6),
    (1.0, 0, 0),
    (1.7, 7, 7),
    (2.4, 0, 0),
)
_FORWARDS = (
    (0.0, 0, 0.0),
    (0.25, 0, -0.01),
    (0.6, 0, -0.07),
    (0.8, 0, 0.0),
    (OFF, 0, 0.135),
    (1.225, 0, 0.36),
    (ON, 0, 0.575),
    (1.62, 0, 0.608),
    (1.8, 0, 0.59),
    (2.2, 0, 0.645),
    (2.5, 0, REACH),
)
_ARM = (
    (0.0, 3, 9, 10, 16),
    (0.22, 25, 10, 10, 24),
    (0.54, -56, 16, 0, 14),
    (0.68, -26, 15, 0, 20),
    (0.82, 50, 15, 4, 26),
    (0.96, 126, 16, 10, 26),
    (1.1, 152, 18, 12, 20),
    (1.3, 118, 24, 14, 26),
    (1.55, 56, 26, 14, 34),
    (1.75, 22, 20, 12, 34),
    (2.05, -8, 13, 10, 20),
    (2.3, 5, 10, 10, 18),
    (2.5, 3, 9, 10, 16),
)


def choreography() -> Choreography:
    """Off the floor from 0.96 s to 1.49 s, 0.65 m forwards; the flight is a parabola under gravity."""
    height = hops(
        [(OFF, ON, 1.010, 0.985)],
        [
            [(0.0, 0.955), (0.22, 0.925), (0.46, 0.720), (0.64, 0.600), (0.80, 0.685)],
            [(1.60, 0.760), (1.74, 0.690), (1.98, 0.790), (2.25, 0.935), (2.5, 0.952)],
        ],
    )
    return Choreography(
        seconds=SECONDS,
        hips=beside(_forwards(), height),
        pelvis=keyed(_PELVIS),
        spine=keyed(_SPINE),
        head=keyed(
            _HEAD,
            smooth=0.06,
        ),
        left_arm=Swing(_arm()),
        right_arm=Swing(_arm()),
        left_foot=_foot(1.0),
        right_foot=_foot(-1.0),
        knees=keyed(_KNEES),
        fists=30.0,
    )


def _forwards() -> Curve:
    """Sideways and forward path of the hips (F, 2): even speed through the air."""
    return keyed(
        _FORWARDS,
        smooth=0.035,
    )


def _arm() -> Curve:
    """Back in the crouch, thrown overhead at take-off, forwards and down on landing."""
    return keyed(
        _ARM,
        smooth=0.045,
    )


def _foot(side: float) -> Footwork:
    x, yaw = side * 0.11, side * 7.0
    before = Stance(x, 0.125, ((-0.5, 0.0, yaw), (0.74, 0.0, yaw), (OFF, -58.0, yaw)))
    after = Stance(side * 0.13, 0.125 + REACH, ((ON, -36.0, yaw), (1.59, 0.0, yaw), (3.0, 0.0, yaw)))
    air = (
        (1.02, side * 0.107, 0.280, 0.125, -72.0, yaw),
        (1.09, side * 0.105, 0.430, 0.130, -74.0, yaw),
        (1.24, side * 0.112, 0.575, 0.280, -52.0, yaw),
        (1.36, side * 0.122, 0.425, 0.460, -40.0, yaw),
        (1.44, side * 0.128, 0.252, 0.612, -34.0, yaw),
    )
    return Footwork((before, after), (air,))
