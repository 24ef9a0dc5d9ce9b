"""Idle: standing at ease, breathing, the weight going from one leg to the other and back."""

from __future__ import annotations

from kinestitch.samples.build import Choreography, Swing
from kinestitch.samples.curves import cycle, keyed, summed
from kinestitch.samples.feet import planted

SECONDS = 4.0
BREATH = 2.0

_HEAD = (
    (0.0, 0.0, 2.0, 0.0),
    (0.9, 12.0, 1.0, -1.5),
    (1.7, 13.0, 1.0, -1.5),
    (2.6, -9.0, 3.0, 1.5),
    (3.2, -9.0, 3.0, 1.5),
    (4.0, 0.0, 2.0, 0.0),
)


def choreography() -> Choreography:
    """Two breaths; the weight lies on the left leg first and on the right one after the middle, then comes back."""
    return Choreography(
        seconds=SECONDS,
        hips=summed(
            cycle(SECONDS, (0.0, 0.045, 0.20), (0.955, 0.0, 0.0, -0.003, 0.40), (0.004, 0.004, 0.1, 0.003, 0.3)),
            cycle(BREATH, (0.0,), (0.0, 0.0015, 0.4), (0.0,)),
        ),
        pelvis=cycle(SECONDS, (0.0, -3.0, 0.22), (2.0, 0.6, 0.3), (0.0, 4.6, 0.22)),
        spine=summed(
            cycle(SECONDS, (0.0, 2.5, 0.26), (0.5, 0.5, 0.6), (0.0, -5.6, 0.24)),
            cycle(BREATH, (0.0,), (0.0, -1.8, 0.4), (0.0,)),
        ),
        head=keyed(
            _HEAD,
            smooth=0.10,
        ),
        left_arm=Swing(
            summed(
                cycle(SECONDS, (0.0, 3.0, 0.34), (9.0, 1.5, 0.75), (14.0, 3.0, 0.4), (13.0, 3.0, 0.42)),
                cycle(BREATH, (0.0, 0.8, 0.5), (0.0, 1.2, 0.45), (0.0,), (0.0, 1.5, 0.5)),
            )
        ),
        right_arm=Swing(
            summed(
                cycle(SECONDS, (0.0, 3.0, 0.84), (9.0, 1.5, 0.25), (14.0, 3.0, 0.9), (13.0, 3.0, 0.92)),
                cycle(BREATH, (0.0, 0.8, 0.5), (0.0, 1.2, 0.45), (0.0,), (0.0, 1.5, 0.5)),
            )
        ),
        left_foot=planted(0.105, 0.150, 9.0, SECONDS),
        right_foot=planted(-0.105, 0.125, -11.0, SECONDS),
    )
