"""The joints of SMPL, SMPL-H and SMPL-X: names, parents and an average body, which pose files leave out.

AMASS files hold angles and shape numbers, no joints; where the joints of a body are comes from the body models, whose
licence does not let them be part of this package. The places below are of an average adult, typed from what humanoid
descriptions of these models publish (rest joints of the neutral mean shapes), made symmetric and rounded to
millimetres; eyes and jaw are placed by anatomy. They are right to about a centimetre for the mean body, and say
nothing of a person's own size: shape numbers (betas) are not used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton

Place = tuple[float, float, float]

BODY = (
    *("pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2", "left_ankle", "right_ankle"),
    *("spine3", "left_foot", "right_foot", "neck", "left_collar", "right_collar", "head", "left_shoulder"),
    *("right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist"),
)
"""The 22 joints that all three models begin with."""

_FINGERS = tuple(f"{finger}{part}" for finger in ("index", "middle", "pinky", "ring", "thumb") for part in (1, 2, 3))
_HANDS = tuple(f"{side}_{finger}" for side in ("left", "right") for finger in _FINGERS)

_ABOVE = {"hip": "pelvis", "knee": "hip", "ankle": "knee", "foot": "ankle", "collar": "spine3", "shoulder": "collar"}
_ABOVE |= {"elbow": "shoulder", "wrist": "elbow", "hand": "wrist", "spine1": "pelvis", "spine2": "spine1"}
_ABOVE |= {"spine3": "spine2", "neck": "spine3", "head": "neck", "jaw": "head", "eye_smplhf": "head"}
_ABOVE |= {finger: "wrist" if finger.endswith("1") else f"{finger[:-1]}{int(finger[-1]) - 1}" for finger in _FINGERS}

_SMPL: dict[str, Place] = {
    "hip": (0.069, -0.091, -0.006),
    "knee": (0.036, -0.379, -0.007),
    "ankle": (-0.015, -0.398, -0.043),
    "foot": (0.026, -0.052, 0.121),
    "spine1": (0.0, 0.109, -0.027),
    "spine2": (0.0, 0.135, 0.001),
    "spine3": (0.0, 0.053, 0.025),
    "neck": (0.0, 0.214, -0.043),
    "head": (0.0, 0.065, 0.051),
    "collar": (0.080, 0.120, -0.036),
    "shoulder": (0.094, 0.032, -0.009),
    "elbow": (0.257, -0.013, -0.024),
    "wrist": (0.252, 0.008, -0.003),
    "hand": (0.084, -0.007, -0.013),
    "index1": (0.101, -0.010, 0.020),
    "index2": (0.032, 0.002, 0.003),
    "index3": (0.022, -0.002, 0.0),
    "middle1": (0.108, -0.008, -0.004),
    "middle2": (0.031, 0.001, -0.004),
    "middle3": (0.024, -0.002, -0.004),
    "pinky1": (0.083, -0.016, -0.044),
    "pinky2": (0.016, -0.001, -0.012),
    "pinky3": (0.016, -0.002, -0.011),
    "ring1": (0.096, -0.011, -0.027),
    "ring2": (0.028, 0.002, -0.005),
    "ring3": (0.023, -0.002, -0.007),
    "thumb1": (0.040, -0.020, 0.026),
    "thumb2": (0.017, 0.001, 0.025),
    "thumb3": (0.020, -0.005, 0.016),
}
"""Left side and middle: each joint from the one above it, m, in the T-pose (x to the left, y up, z to the front)."""

_SMPLX = _SMPL | {
    "hip": (0.061, -0.098, -0.024),
    "knee": (0.049, -0.371, -0.013),
    "ankle": (-0.029, -0.407, -0.026),
    "foot": (0.043, -0.058, 0.119),
    "spine1": (0.0, 0.110, -0.028),
    "spine2": (0.0, 0.132, -0.006),
    "spine3": (0.0, 0.052, 0.028),
    "neck": (0.0, 0.165, -0.032),
    "head": (0.0, 0.160, 0.021),
    "collar": (0.047, 0.085, -0.010),
    "shoulder": (0.111, 0.056, -0.014),
    "elbow": (0.263, -0.054, -0.034),
    "jaw": (0.0, -0.010, 0.015),
    "eye_smplhf": (0.032, 0.055, 0.055),
}


@dataclass(frozen=True, slots=True)
class Layout:
    """One model's joints, in the order of its pose vectors.

    pelvis : where the pelvis of the mean body is, m, from the model's own origin
    """

    name: str
    names: tuple[str, ...]
    pelvis: Place
    places: dict[str, Place]

    @property
    def parents(self) -> tuple[int, ...]:
        """Index of the joint above each, -1 for the pelvis."""
        return (-1, *(self.names.index(_above(name)) for name in self.names[1:]))

    @property
    def offsets(self) -> Array:
        """Each joint from the one above it (J, 3) m, zero for the pelvis."""
        return np.array([(0.0, 0.0, 0.0), *(self._offset(name) for name in self.names[1:])])

    def _offset(self, name: str) -> Place:
        x, y, z = self.places[_sided(name)[1]]
        return (-x if name.startswith("right_") else x, y, z)


def _sided(name: str) -> tuple[str, str]:
    side, _, rest = name.partition("_")
    return (f"{side}_", rest) if side in ("left", "right") else ("", name)


def _above(name: str) -> str:
    side, joint = _sided(name)
    above = _ABOVE[joint]
    return above if above in BODY else side + above


LAYOUTS = (
    Layout("SMPL", (*BODY, "left_hand", "right_hand"), (-0.002, -0.223, 0.028), _SMPL),
    Layout("SMPL-H", BODY + _HANDS, (-0.002, -0.223, 0.028), _SMPL),
    Layout("SMPL-X", (*BODY, "jaw", "left_eye_smplhf", "right_eye_smplhf", *_HANDS), (0.003, -0.351, 0.012), _SMPLX),
    Layout("SMPL body", BODY, (-0.002, -0.223, 0.028), _SMPL),
)
"""By length of their pose vectors: 72, 156, 165 and 66."""


def skeleton_of(layout: Layout, joints: Array | None = None) -> tuple[Skeleton, Array]:
    """The skeleton, standing on the ground, and the pelvis (3,) m from the model's origin.

    joints : (J, 3) m, rest positions of this very body from the model's origin; None takes the mean body
    """
    parents = layout.parents
    if joints is None:
        offsets, pelvis = layout.offsets, np.array(layout.pelvis)
    else:
        above = np.array(parents)
        offsets, pelvis = joints - joints[np.maximum(above, 0)], joints[0]
    places = np.zeros_like(offsets)
    for joint, parent in enumerate(parents[1:], start=1):
        places[joint] = places[parent] + offsets[joint]
    offsets = offsets.copy()
    offsets[0] = (0.0, -places[:, 1].min(), 0.0)
    return Skeleton(layout.names, parents, offsets), pelvis
