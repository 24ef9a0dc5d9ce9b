"""A clip: one skeleton, its joints' local translations and rotations frame by frame, and a frame rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton, frozen
from kinestitch.errors import InvalidMotionError

_UNIT_TOLERANCE = 1e-6
_BLOCK = 8192  # quaternions looked at a time, so that temporaries stay in the processor's cache


def _all_unit(quaternions: Array) -> bool:
    ones = np.ones(4)
    for start in range(0, len(quaternions), _BLOCK):
        block = quaternions[start : start + _BLOCK]
        square = (block * block) @ ones
        if not (square.min() > 1 - _UNIT_TOLERANCE and square.max() < 1 + _UNIT_TOLERANCE):
            return False
    return True


@dataclass(frozen=True, eq=False, slots=True)
class Motion:
    """F frames of a skeleton of J joints; the only value that crosses every door.

    skeleton : the rig
    translations : (F, J, 3) m, each joint in its parent's frame (the root in the world); broadcast views are welcome
    rotations : (F, J, 4) parent_from_joint, xyzw, unit norm
    fps : frames a second, > 0; frame k stands at time k / fps
    name : what a person calls the clip

    The world is right-handed with Y up. Arrays are read-only; use ``dataclasses.replace`` to change a field.
    Raises InvalidMotionError for wrong shapes, NaN or infinity, quaternions off unit norm, F = 0 or fps ≤ 0.
    """

    skeleton: Skeleton
    translations: Array
    rotations: Array
    fps: float
    name: str = ""

    def __post_init__(self) -> None:
        self._take_arrays()
        self._check_rotations()
        self._check_translations()

    def _take_arrays(self) -> None:
        object.__setattr__(self, "translations", frozen(self.translations))
        object.__setattr__(self, "rotations", frozen(self.rotations))
        object.__setattr__(self, "fps", float(self.fps))
        joints = self.skeleton.joint_count
        shape = self.rotations.shape
        if self.rotations.ndim != 3 or shape[1:] != (joints, 4) or shape[0] < 1:
            raise InvalidMotionError(f"Expected rotations of shape (F ≥ 1, {joints}, 4), got {shape}.")
        if self.translations.shape != (shape[0], joints, 3):
            raise InvalidMotionError(
                f"Expected translations of shape ({shape[0]}, {joints}, 3), got {self.translations.shape}."
            )
        if not (np.isfinite(self.fps) and self.fps > 0):
            raise InvalidMotionError(f"Expected fps > 0, got {self.fps}.")

    def _check_rotations(self) -> None:
        if not _all_unit(self.rotations.reshape(-1, 4)):
            square = np.einsum("fji,fji->fj", self.rotations, self.rotations)
            frame, joint = np.argwhere(~(np.abs(square - 1.0) < _UNIT_TOLERANCE))[0]
            raise InvalidMotionError(
                f"Expected unit quaternions, got norm² {square[frame, joint]:.6g} "
                f"at frame {frame}, joint {self.skeleton.names[joint]!r}."
            )

    def _check_translations(self) -> None:
        if not np.isfinite(self.translations).all():
            frame, joint = np.argwhere(~np.isfinite(self.translations).all(axis=-1))[0]
            raise InvalidMotionError(
                f"Expected finite translations, got {self.translations[frame, joint]} "
                f"at frame {frame}, joint {self.skeleton.names[joint]!r}."
            )

    @property
    def frames(self) -> int:
        """Number of frames F."""
        return self.rotations.shape[0]

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last: (F − 1) / fps."""
        return (self.frames - 1) / self.fps


def motion_of_units(skeleton: Skeleton, translations: Array, rotations: Array, fps: float, name: str) -> Motion:
    """A motion whose rotations are products and exponentials of those of other motions, and so of unit norm: they are
    not looked at again.

    Raises InvalidMotionError as :class:`Motion` does for all else.
    """
    motion = object.__new__(Motion)
    values = {"translations": translations, "rotations": rotations, "skeleton": skeleton, "fps": fps, "name": name}
    for field, value in values.items():
        object.__setattr__(motion, field, value)
    motion._take_arrays()
    motion._check_translations()
    return motion
