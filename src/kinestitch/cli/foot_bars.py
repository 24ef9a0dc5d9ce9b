"""When feet stand around a seam, as bars of text."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kinestitch.core.rotation import Array
    from kinestitch.solve.solved import Solved

SPAN, SLOTS = 0.5, 10
"""Seconds on each side of a seam that a bar shows, and in how many characters."""

STANDS, GIVEN_UP, OFF = "█", "░", "·"


def legend(solved: Solved) -> str:
    """What the marks of a result's bars mean; feet that are not locked are as in their clips and give nothing up."""
    where = f"Feet {SPAN:g} s before and after: {STANDS} stands"
    return f"{where}." if solved.contacts is None else f"{where}, {GIVEN_UP} stood in its clip and steps instead."


def foot_bars(solved: Solved) -> Iterator[str]:
    """For each seam the left and the right foot's bar; nothing for a rig without feet, or where none ever stands."""
    import numpy as np

    from kinestitch.errors import SkeletonMismatchError
    from kinestitch.solve.contacts import legs_of
    from kinestitch.solve.footlock import placed_contacts

    try:
        own = placed_contacts(solved.placed)
    except SkeletonMismatchError:
        return
    kept = own if solved.contacts is None else solved.contacts
    if not own.held.any():
        return
    legs = legs_of(solved.motion.skeleton)
    feet = [np.stack([contacts.of(leg.foot, leg.toe) for contacts in (kept, own)]) for leg in legs]
    for seam in solved.seams:
        bars = (
            f"{side} {_bar(shares, seam.frame, solved.motion.fps)}" for side, shares in zip("LR", feet, strict=True)
        )
        yield "   ".join(bars)


def _bar(stands: NDArray, frame: int, fps: float) -> str:
    """stands : (2, F) frames in which the foot stands, and in which it does in its clip."""
    import numpy as np

    edges = frame + np.floor(np.arange(-SLOTS, SLOTS + 1) * SPAN * fps / SLOTS + 0.5).astype(int)
    marks = [_mark(stands[:, max(a, 0) : max(b, 0)].astype(float)) for a, b in pairwise(edges)]
    return "".join(marks[:SLOTS]) + "|" + "".join(marks[SLOTS:])


def _mark(shares: Array) -> str:
    if not shares.shape[1]:
        return " "
    kept, own = shares.mean(axis=1)
    return STANDS if kept >= 0.5 else GIVEN_UP if own >= 0.5 else OFF
