"""Walk: three strides at 1.26 m/s."""

from __future__ import annotations

from kinestitch.samples.build import Choreography, Swing
from kinestitch.samples.curves import Curve, cycle, summed
from kinestitch.samples.gait import Gait
from kinestitch.samples.travel import forwards

SECONDS = 10 / 3
PERIOD = 10 / 9
SPEED = 1.26

GAIT = Gait(
    period=PERIOD,
    speed=SPEED,
    roll=((0.0, 20.0), (0.10, 0.0), (0.36, 0.0), (0.62, -62.0)),
    swing=((0.72, 0.215, -0.255, -50.0), (0.83, 0.140, 0.075, -9.0), (0.92, 0.105, 0.262, 14.0)),
    ahead=0.470,
    apart=0.055,
    toes_out=6.0,
)


def choreography() -> Choreography:
    """The left heel strikes at 0; the pelvis is lowest just after each strike and highest over the standing leg."""
    return Choreography(
        seconds=SECONDS,
        hips=summed(
            forwards(SPEED),
            cycle(PERIOD, (0.0, 0.020, 0.30), (0.932, 0.0, 0.0, 0.022, 0.55), (0.0, 0.0, 0.0, 0.008, 0.20)),
        ),
        pelvis=cycle(PERIOD, (0.0, -6.0, 0.0), (3.0, 0.0, 0.0, 1.0, 0.1), (0.0, 3.5, 0.17)),
        spine=cycle(PERIOD, (0.0, 12.0, 0.02), (1.0, 0.0, 0.0, -1.0, 0.15), (0.0, -4.5, 0.19)),
        head=cycle(PERIOD, (0.0, 1.0, 0.05), (1.0, 0.0, 0.0, 1.0, 0.2), (0.0, 0.5, 0.2)),
        left_arm=Swing(_arm(0.5)),
        right_arm=Swing(_arm(0.0)),
        left_foot=GAIT.footwork(1.0, 0.0, SECONDS),
        right_foot=GAIT.footwork(-1.0, PERIOD / 2, SECONDS),
    )


def _arm(forward: float) -> Curve:
    """Forward swing peaks at the share `forward` of the cycle; the elbow bends most a moment later."""
    return cycle(
        PERIOD, (3.0, 23.0, forward), (7.0, 1.5, forward + 0.25), (12.0, 4.0, forward), (24.0, 12.0, forward + 0.06)
    )
