"""The fighter's stance that kick and punches start from and return to: left foot and left hand in front."""

from __future__ import annotations

from kinestitch.samples.feet import Stance

LEFT_BALL = (0.095, 0.330)
RIGHT_BALL = (-0.135, -0.075)
LEFT_YAW = -4.0
RIGHT_YAW = -38.0
"""Where the balls of the feet stand, x and z in m, and how far the feet turn in degrees."""

HIPS = (0.0, 0.905, 0.030)
PELVIS = (-24.0, 5.0, 0.0)
SPINE = (-12.0, 9.0, 0.0)
HEAD = (0.0, 6.0, 0.0)

LEFT_WRIST = (0.075, 0.035, 0.390, 22.0)
RIGHT_WRIST = (0.050, -0.010, 0.215, 24.0)
"""The fists: the left one before the face, the right one at the chin; see :class:`kinestitch.samples.build.Reach`."""


def standing(left: bool, *roll: tuple[float, float, float]) -> Stance:
    """A stance of one foot on its place in the guard, with the rows of its roll."""
    x, z = LEFT_BALL if left else RIGHT_BALL
    return Stance(x, z, roll)
