"""What a rig is: joint names, their parents, and the pose that all rotations are compared with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinestitch.core.rotation import Array, quat_identity
from kinestitch.errors import InvalidMotionError


def frozen(values: ArrayLike) -> Array:
    """The values as a read-only float64 array; copied only where somebody else could still write to them.

    A broadcast view stays one: only what it repeats is copied.
    """
    array = np.asarray(values, dtype=np.float64)
    if isinstance(values, (list, tuple)) and array.base is None:
        array.setflags(write=False)
    elif _writeable(array):
        once = tuple(slice(0, 1) if step == 0 else slice(None) for step in array.strides)
        own = array[once].copy()
        own.setflags(write=False)
        array = own if own.shape == array.shape else np.broadcast_to(own, array.shape)
    return array


def _writeable(array: object) -> bool:
    """Whether the array, or any it is a view of, can be written to."""
    while isinstance(array, np.ndarray):
        if array.flags.writeable:
            return True
        array = array.base
    try:
        return array is not None and not memoryview(array).readonly  # type: ignore[arg-type]
    except TypeError:
        return True


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A tree of J joints in topological order (every parent stands before its children).

    names : J unique joint names
    parents : J indices, -1 for the one root, ``parents[j] < j``
    offsets : (J, 3) m, rest translation of each joint in its parent's frame
    rest : (J, 4) rest rotation parent_from_joint, xyzw; identity when left out
    tips : (J, 3) m, the end of a leaf joint in its own frame (a BVH End Site), NaN where there is none

    Raises InvalidMotionError if shapes disagree, names repeat, or the parents are no tree.

    >>> Skeleton(("Hips", "Spine"), (-1, 0), [[0, 1, 0], [0, 0.2, 0]]).index("Spine")
    1
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Array
    rest: Array = None  # type: ignore[assignment]
    tips: Array = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        count = len(self.names)
        object.__setattr__(self, "names", tuple(str(name) for name in self.names))
        object.__setattr__(self, "parents", tuple(int(parent) for parent in self.parents))
        object.__setattr__(self, "offsets", frozen(self.offsets))
        object.__setattr__(self, "rest", frozen(quat_identity((count,)) if self.rest is None else self.rest))
        object.__setattr__(self, "tips", frozen(np.full((count, 3), np.nan) if self.tips is None else self.tips))
        self._check(count)

    def _check(self, count: int) -> None:
        if count == 0:
            raise InvalidMotionError("Expected a skeleton of at least one joint, got none.")
        if len(set(self.names)) != count:
            twice = next(name for name in self.names if self.names.count(name) > 1)
            raise InvalidMotionError(f"Expected unique joint names, got {twice!r} more than once. Rename one of them.")
        if len(self.parents) != count:
            raise InvalidMotionError(f"Expected {count} parents (one per joint name), got {len(self.parents)}.")
        for joint, parent in enumerate(self.parents):
            if not (parent == -1 if joint == 0 else 0 <= parent < joint):
                raise InvalidMotionError(
                    f"Expected parent of joint {joint} ({self.names[joint]!r}) in [0, {joint}) "
                    f"(-1 for joint 0), got {parent}."
                )
        for label, array, width in (("offsets", self.offsets, 3), ("rest", self.rest, 4), ("tips", self.tips, 3)):
            if array.shape != (count, width):
                raise InvalidMotionError(f"Expected {label} of shape ({count}, {width}), got {array.shape}.")
        if not np.isfinite(self.offsets).all():
            raise InvalidMotionError("Expected finite offsets, got NaN or infinity.")
        if not (np.abs(np.einsum("ji,ji->j", self.rest, self.rest) - 1) < 1e-6).all():
            raise InvalidMotionError("Expected rest rotations of unit norm.")

    @property
    def joint_count(self) -> int:
        """Number of joints J."""
        return len(self.names)

    @cached_property
    def parent_array(self) -> NDArray[np.intp]:
        """The parents as an index array (J,)."""
        return np.array(self.parents, dtype=np.intp)

    def index(self, name: str) -> int:
        """Index of the joint called `name`; raises InvalidMotionError with the nearest names."""
        try:
            return self.names.index(name)
        except ValueError:
            import difflib

            near = difflib.get_close_matches(name, self.names, n=3, cutoff=0.4) or self.names[:3]
            raise InvalidMotionError(f"Expected the name of a joint, got {name!r}. Try {', '.join(near)}.") from None

    def children(self, joint: int) -> tuple[int, ...]:
        """Indices of the joints whose parent is `joint`."""
        return tuple(j for j, parent in enumerate(self.parents) if parent == joint)

    def chain(self, joint: int) -> tuple[int, ...]:
        """Indices from the root down to `joint`, both included."""
        path = [joint]
        while self.parents[path[-1]] >= 0:
            path.append(self.parents[path[-1]])
        return tuple(reversed(path))

    def __eq__(self, other: object) -> bool:
        """Equal by value: names, parents, and every number of the rest pose."""
        if self is other:
            return True
        if not isinstance(other, Skeleton):
            return NotImplemented
        return (
            self.names == other.names
            and self.parents == other.parents
            and np.array_equal(self.offsets, other.offsets)
            and np.array_equal(self.rest, other.rest)
            and np.array_equal(self.tips, other.tips, equal_nan=True)
        )

    def __hash__(self) -> int:
        return hash((self.names, self.parents))


def first_difference(a: Sequence[str], b: Sequence[str]) -> int | None:
    """Index of the first place where two lists of names differ, or None if they are the same."""
    for i, (left, right) in enumerate(zip(a, b, strict=False)):
        if left != right:
            return i
    return None if len(a) == len(b) else min(len(a), len(b))
