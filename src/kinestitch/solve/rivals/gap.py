"""The gap between both sources at a seam as a pose offset and its velocity: what blend-outs start from."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from kinestitch.core.rotation import Array, quat_conjugate, quat_log, quat_multiply, rotvec_to_quat
from kinestitch.errors import ParameterError
from kinestitch.solve.placed import Placed
from kinestitch.solve.seam import SeamPlace


@dataclass(frozen=True, eq=False, slots=True)
class Gap:
    """How far the left source is from the right one, ``a = exp(x) b``, at a seam's frames m−1 and m.

    turn : (2, J, 3) rad, x in the parent's frame; shift : (2, J, 3) m, a − b
    """

    turn: Array
    shift: Array

    @property
    def start(self) -> tuple[Array, Array]:
        """Offset at frame m−1 and its change in one frame, rotation beside translation: (J, 6) each."""
        both = np.concatenate([self.turn, self.shift], axis=-1)
        return both[0], both[1] - both[0]

    @property
    def middle(self) -> tuple[Array, Array]:
        """The same at m − ½, half way between the two frames."""
        both = np.concatenate([self.turn, self.shift], axis=-1)
        return both.mean(axis=0), both[1] - both[0]


def gap_between(rotations: Array, translations: Array) -> Gap:
    """The gap of poses (4, J, 4) and (4, J, 3): a(m−1), a(m), b(m−1), b(m), the carrier in the world.

    Both turns lie on one branch, the one whose quaternions have Σ w ≥ 0.
    """
    relative = quat_multiply(rotations[:2], quat_conjugate(rotations[2:]))
    apart = np.einsum("ji,ji->j", relative[0], relative[1]) < 0
    relative[1] *= np.where(apart, -1.0, 1.0)[:, None]
    relative *= np.where(relative[..., 3].sum(axis=0) < 0, -1.0, 1.0)[:, None]
    return Gap(quat_log(relative), translations[:2] - translations[2:])


def add_offset(rotations: Array, translations: Array, offset: Array) -> tuple[Array, Array]:
    """Poses (..., J, 4) and (..., J, 3) with an offset (..., J, 6) on them: ``exp(x) q`` and ``p + x``."""
    return quat_multiply(rotvec_to_quat(offset[..., :3]), rotations), translations + offset[..., 3:]


def spans(placed: Placed) -> Iterator[tuple[SeamPlace, int]]:
    """Every place where something has to be solved, and the frame up to which its right side runs."""
    ends = [*(seam.frame for seam in placed.seams), placed.frames][1:]
    yield from zip(placed.seams, ends, strict=True)


def rooms(placed: Placed) -> Iterator[tuple[SeamPlace, int, int]]:
    """Every such place with the frames that it may change before and after it, half way to its neighbours."""
    frames = [0, *(seam.frame for seam in placed.seams), placed.frames]
    sides = list(pairwise(frames))
    for number, seam in enumerate(placed.seams):
        before, after = (stop - start for start, stop in sides[number : number + 2])
        first, last = number == 0, number == len(placed.seams) - 1
        yield seam, before if first else before // 2, after if last else after // 2


def check_width(width: float) -> None:
    """Raise ParameterError unless a window has at least one frame."""
    if not width >= 1:
        raise ParameterError(f"Expected a width of at least 1 frame, got {width}.")


def check_halflife(halflife: float) -> None:
    """Raise ParameterError unless a half-life in seconds is positive and finite."""
    if not (math.isfinite(halflife) and halflife > 0):
        raise ParameterError(f"Expected a half-life in seconds > 0, got {halflife}.")
