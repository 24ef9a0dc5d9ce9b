"""What other programs like to be given: axes, units and a root, by the name of the program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from kinestitch.core.kinematics import rest_pose, with_joint_axes
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, matrix_to_quat, quat_conjugate, quat_multiply, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError
from kinestitch.files.fbx.axes import from_y_up_metres
from kinestitch.files.fbx.build import Y_UP

_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
_BELOW = 0.1
"""Share of the body's height by which it may rest below a joint that still counts as standing on the ground."""


@dataclass(frozen=True, slots=True)
class Preset:
    """How a file of a skeleton alone is told.

    z_up : Z up and −Y to the front instead of Y up and +Z to the front; right-handed both
    unit : metres per unit
    root : the topmost joint stands on the ground with its axes along the file's; a still one is added above hips
    says : all that in words, for people
    """

    says: str
    z_up: bool = False
    unit: float = 0.01
    root: bool = False

    @property
    def axes(self) -> Array:
        """(3, 3) matrix from the file's world to Y up, X right, Z to the viewer."""
        return _Z_UP if self.z_up else np.eye(3)

    @property
    def settings(self) -> tuple[tuple[str, int, int], ...]:
        """Name, number and sign of the file's axes, as its global settings have them."""
        return (("Up", 2, 1), ("Front", 1, -1), ("Coord", 0, 1), ("OriginalUp", 2, 1)) if self.z_up else Y_UP


PLAIN = Preset("Y up, +Z to the front, centimetres; the joints as they are")
PRESETS: Mapping[str, Preset] = MappingProxyType(
    {
        "unity": Preset(f"{PLAIN.says}. Unity's Convert Units makes metres of it"),
        "unreal": Preset(
            "Z up, -Y to the front, centimetres; the topmost joint is a root on the ground with the world's axes "
            "(added, and still, where the rig begins at the hips)",
            z_up=True,
            root=True,
        ),
        "blender": Preset(
            "Z up, -Y to the front, metres; the joints as they are, so that the armature comes in unturned at scale 1",
            z_up=True,
            unit=1.0,
        ),
        "maya": Preset(PLAIN.says),
    }
)


def preset_named(name: str | None) -> Preset:
    """The preset of that name, the plain one for None; raises ParameterError with the names there are."""
    if name is None:
        return PLAIN
    if name not in PRESETS:
        raise ParameterError(f"Expected a preset out of {', '.join(PRESETS)}, got {name!r}.")
    return PRESETS[name]


def in_file(motion: Motion, preset: Preset) -> Motion:
    """The motion in the preset's axes and units, under its root; skeleton too."""
    if preset.root:
        motion = _rooted(motion, matrix_to_quat(preset.axes))
    skeleton = motion.skeleton
    offsets, rest = from_y_up_metres(skeleton.offsets[None], skeleton.rest[None], preset.axes, preset.unit)
    moved, turned = from_y_up_metres(motion.translations, motion.rotations, preset.axes, preset.unit)
    told = replace(skeleton, offsets=offsets[0], rest=rest[0])
    return replace(motion, skeleton=told, translations=moved, rotations=turned)


def _rooted(motion: Motion, axes: Array) -> Motion:
    """A topmost joint on the ground that rests with these axes (4,): the one there is, or a still one above it."""
    skeleton = motion.skeleton
    positions, rotations = rest_pose(skeleton)
    height = positions[:, 1]
    if height[0] - height.min() <= _BELOW * np.ptp(height):
        return with_joint_axes(motion, np.concatenate([axes[None], rotations[1:]]))
    name = "root"
    while name in {other.lower() for other in skeleton.names}:
        name = f"_{name}"
    back = quat_conjugate(axes)
    above = Skeleton(
        (name, *skeleton.names),
        (-1, *(parent + 1 for parent in skeleton.parents)),
        _led(np.zeros(3), quat_rotate(back, skeleton.offsets[:1]), skeleton.offsets[1:]),
        _led(axes, quat_multiply(back, skeleton.rest[:1]), skeleton.rest[1:]),
        _led(np.full(3, np.nan), skeleton.tips),
    )
    still = np.broadcast_to(np.zeros(3), (motion.frames, 1, 3)), np.broadcast_to(axes, (motion.frames, 1, 4))
    moved, turned = motion.translations, motion.rotations
    return replace(
        motion,
        skeleton=above,
        translations=np.concatenate([still[0], quat_rotate(back, moved[:, :1]), moved[:, 1:]], axis=1),
        rotations=np.concatenate([still[1], quat_multiply(back, turned[:, :1]), turned[:, 1:]], axis=1),
    )


def _led(first: Array, *rest: Array) -> Array:
    return np.concatenate([first[None], *rest])
