"""Run: four strides at 3 m/s, with both feet off the floor between steps."""

from __future__ import annotations

from kinestitch.samples.build import Choreography, Swing
from kinestitch.samples.curves import Curve, cycle, summed
from kinestitch.samples.gait import Gait
from kinestitch.samples.travel import forwards

SECONDS = 8 / 3
PERIOD = 2 / 3
SPEED = 3.0

GAIT = Gait(
    period=PERIOD,
    speed=SPEED,
    roll=((0.0, 9.0), (0.08, 0.0), (0.17, 0.0), (0.37, -64.0)),
    swing=(
        (0.49, 0.370, -0.540, -88.0),
        (0.62, 0.420, -0.240, -62.0),
        (0.76, 0.260, 0.180, -12.0),
        (0.90, 0.175, 0.325, 9.0),
    ),
    ahead=0.360,
    apart=0.040,
    toes_out=4.0,
)


def choreography() -> Choreography:
    """The left foot lands at 0; the body sinks until mid-stance, is thrown up, and is highest between steps."""
    return Choreography(
        seconds=SECONDS,
        hips=summed(
            forwards(SPEED),
            cycle(PERIOD, (0.0, 0.012, 0.20), (0.903, 0.0, 0.0, 0.036, 0.86), (0.0, 0.0, 0.0, 0.006, 0.75)),
        ),
        pelvis=cycle(PERIOD, (0.0, -7.0, 0.0), (9.0, 0.0, 0.0, 2.0, 0.4), (0.0, 4.0, 0.20)),
        spine=cycle(PERIOD, (0.0, 20.0, 0.0), (4.0, 0.0, 0.0, 2.0, 0.4), (0.0, -4.0, 0.20)),
        head=cycle(PERIOD, (0.0, 2.0, 0.0), (4.0, 0.0, 0.0, 1.5, 0.4), (0.0,)),
        left_arm=Swing(_arm(0.5)),
        right_arm=Swing(_arm(0.0)),
        left_foot=GAIT.footwork(1.0, 0.0, SECONDS),
        right_foot=GAIT.footwork(-1.0, PERIOD / 2, SECONDS),
        fists=55.0,
    )


def _arm(forward: float) -> Curve:
    """Elbows at a right angle; the hand comes up towards the chin in front and past the hip behind."""
    return cycle(
        PERIOD, (-8.0, 42.0, forward), (14.0, 4.0, forward + 0.5), (24.0, 10.0, forward), (88.0, 16.0, forward + 0.04)
    )
