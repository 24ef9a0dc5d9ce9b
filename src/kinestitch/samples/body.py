"""The body of all samples: a person of 1.75 m with Mixamo's joint names, in T-pose, facing +Z."""

from __future__ import annotations

from functools import cache

import numpy as np

from kinestitch.core.skeleton import Skeleton

PREFIX = "mixamorig:"
HEIGHT = 1.75
THIGH = 0.245 * HEIGHT
SHANK = 0.246 * HEIGHT
ANKLE = 0.039 * HEIGHT
UPPER_ARM = 0.186 * HEIGHT
FOREARM = 0.146 * HEIGHT
"""Segment lengths in m: Winter, Biomechanics and Motor Control of Human Movement, as shares of body height."""

HIP_DROP = 0.045
BALL = (0.0, 0.022 - ANKLE, 0.136)
"""The ball of the foot (joint ToeBase) as seen from the ankle, m, foot flat."""
HEEL = (0.0, -ANKLE, -0.050)
"""The back edge of the heel as seen from the ankle, m, foot flat; no joint stands there."""

_SHOULDER = 0.818 * HEIGHT
_HIPS = THIGH + SHANK + ANKLE + HIP_DROP
_SPINE = (0.100, 0.120, 0.130)
_CHEST = _HIPS + sum(_SPINE)

_MIDDLE = (
    ("Hips", "", (0.0, _HIPS, 0.0)),
    ("Spine", "Hips", (0.0, _SPINE[0], 0.0)),
    ("Spine1", "Spine", (0.0, _SPINE[1], 0.0)),
    ("Spine2", "Spine1", (0.0, _SPINE[2], 0.0)),
    ("Neck", "Spine2", (0.0, 0.160, 0.0)),
    ("Head", "Neck", (0.0, 0.092, 0.012)),
    ("HeadTop_End", "Head", (0.0, HEIGHT - _CHEST - 0.252, 0.0)),
)
_ARM = (
    ("Shoulder", "Spine2", (0.040, _SHOULDER - _CHEST, 0.0)),
    ("Arm", "Shoulder", (0.150, 0.0, 0.0)),
    ("ForeArm", "Arm", (UPPER_ARM, 0.0, 0.0)),
    ("Hand", "ForeArm", (FOREARM, 0.0, 0.0)),
    ("HandMiddle1", "Hand", (0.095, 0.0, 0.0)),
    ("HandMiddle2", "HandMiddle1", (0.040, 0.0, 0.0)),
    ("HandMiddle3", "HandMiddle2", (0.030, 0.0, 0.0)),
    ("HandMiddle4", "HandMiddle3", (0.024, 0.0, 0.0)),
)
_LEG = (
    ("UpLeg", "Hips", (0.091, -HIP_DROP, 0.0)),
    ("Leg", "UpLeg", (0.0, -THIGH, 0.0)),
    ("Foot", "Leg", (0.0, -SHANK, 0.0)),
    ("ToeBase", "Foot", BALL),
    ("Toe_End", "ToeBase", (0.0, -0.008, 0.070)),
)


@cache
def humanoid() -> Skeleton:
    """The skeleton that all samples share: 33 joints, metres, Y up, facing +Z, every rest rotation the identity.

    Segment lengths are Winter's shares of body height (thigh 0.245, shank 0.246, ankle 0.039, upper arm 0.186, forearm
    0.146, shoulder height 0.818): D. A. Winter, Biomechanics and Motor Control of Human Movement, after Drillis and
    Contini.
    """
    rows = [(name, parent, offset) for name, parent, offset in _MIDDLE]
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        for name, parent, (x, y, z) in _ARM:
            rows.append((side + name, parent if parent == "Spine2" else side + parent, (sign * x, y, z)))
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        for name, parent, (x, y, z) in _LEG:
            rows.append((side + name, parent if parent == "Hips" else side + parent, (sign * x, y, z)))
    place = {name: index for index, (name, _, _) in enumerate(rows)}
    return Skeleton(
        tuple(PREFIX + name for name, _, _ in rows),
        tuple(place.get(parent, -1) for _, parent, _ in rows),
        np.array([offset for _, _, offset in rows]),
    )


def joint(name: str) -> int:
    """Index of a joint of :func:`humanoid` by its name without the prefix."""
    return humanoid().index(PREFIX + name)
