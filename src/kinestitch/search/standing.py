"""Which feet stand at every place of a clip, as columns beside its features, so that stances count in a cost.

A foot stands at a place by s(k): 1 inside a stance, ½ where one begins or ends, 0 in the air. A seam between two places
pays for each foot that stands on one side only, and for a body that has no foot on the ground, whose course in the air
nothing could change. All of it is a squared distance of three columns, the last one mirrored for the second clip:

    √(2(α − β)) · c · [s_left, s_right, ±½(1 − s_left)(1 − s_right)]                                  (Eq. 23)
"""

from __future__ import annotations

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.errors import SkeletonMismatchError
from kinestitch.search.features import seam_factors
from kinestitch.solve.contacts import Mask, find_contacts, legs_of

CONTACT = 1.0
"""rad; c of Eq. 23: a foot that stands on one side only costs what this gap of one joint of mean weight costs."""


def standing_feet(motion: Motion) -> Mask | None:
    """The frames (F, 2) in which the left and the right foot stands, on ankle or toe.

    None on a rig without feet, and where neither ever stands, as on a treadmill: such a clip says nothing about feet.
    """
    try:
        legs = legs_of(motion.skeleton)
    except SkeletonMismatchError:
        return None
    contacts = find_contacts(motion)
    held = np.stack([contacts.of(leg.foot, leg.toe) for leg in legs], axis=1)
    return held if held.any() else None


def both_standing(first: Motion, second: Motion) -> tuple[Mask, Mask] | None:
    """The standing feet of two clips; None unless both are known."""
    held = standing_feet(first), standing_feet(second)
    return None if held[0] is None or held[1] is None else (held[0], held[1])


def standing_columns(first: Mask, second: Mask, stiffness: float) -> tuple[Array, Array]:
    """Columns (F + 1, 3) of the first clip's places and of the second's: their squared distance is the cost of feet
    (Eq. 23).

    first, second : (F, 2), as of :func:`standing_feet`
    """
    size = CONTACT * np.sqrt(seam_factors(stiffness)[0])
    return size * _places(first, 0.5), size * _places(second, -0.5)


def _places(held: Mask, air: float) -> Array:
    padded = np.concatenate([held[:1], held, held[-1:]]).astype(np.float64)
    stands = (padded[:-1] + padded[1:]) / 2
    return np.concatenate([stands, air * (1 - stands).prod(axis=1, keepdims=True)], axis=1)
