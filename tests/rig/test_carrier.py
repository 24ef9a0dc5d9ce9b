"""Which joint carries the travel: what moves by a millimetre does, what trembles by less than a tenth does not."""

from __future__ import annotations

import numpy as np
import pytest

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.carrier import carrier_joint

RIG = Skeleton(("Root", "Hips", "Spine"), (-1, 0, 1), [[0, 0, 0], [0, 1, 0], [0, 0.3, 0]])


def rooted(metres: float, radians: float) -> Motion:
    """A body whose root drifts and turns by so much over the clip, while its hips travel."""
    along = np.linspace(0, 1, 9)
    translations = np.broadcast_to(RIG.offsets, (9, 3, 3)).copy()
    translations[:, 0, 2] = metres * along
    translations[:, 1, 2] = along
    rotations = np.zeros((9, 3, 4))
    rotations[..., 3] = 1.0
    rotations[:, 0] = quat_about_axis(1, radians * along)
    return Motion(RIG, translations, rotations, 30.0)


@pytest.mark.parametrize(
    ("metres", "radians", "carrier"),
    [(0, 0, 1), (5e-5, 0, 1), (0, 1e-4, 1), (1e-3, 0, 0), (0, 2e-3, 0), (1, 1, 0)],
)
def test_a_root_that_stands_still_does_not_carry(metres: float, radians: float, carrier: int):
    assert carrier_joint(rooted(metres, radians)) == carrier
