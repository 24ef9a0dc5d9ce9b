"""What a curve is worth before its first and after its last key: held, repeated, mirrored, or carried on straight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.files.fbx.nodes import Node

REPEAT, RELATIVE, MIRROR, SLOPE = "R", "A", "M", "K"


@dataclass(frozen=True, slots=True)
class Beyond:
    """One side of a curve: how it goes on (anything unknown is held), and how often at most (below 0: for ever)."""

    kind: str = ""
    count: int = -1


HELD = (Beyond(), Beyond())


def read_beyond(node: Node) -> tuple[Beyond, Beyond]:
    """Both sides of a curve, from the object (7.x) or the channel (before) that holds its keys."""
    return _side(node.child("Pre-Extrapolation")), _side(node.child("Post-Extrapolation"))


def _side(node: Node | None) -> Beyond:
    kind = node.child("Type") if node is not None else None
    if node is None or kind is None:
        return Beyond()
    count = node.child("Repetition")
    return Beyond(kind.text() or chr(min(max(kind.integer(), 0), 127)), count.integer() if count is not None else -1)


def folded(
    ticks: NDArray[np.int64], ends: tuple[int, int], rise: float, beyond: tuple[Beyond, Beyond]
) -> tuple[NDArray[np.int64], Array]:
    """Times (N,) within the keys that show what is to be seen at `ticks` (N,), and what to add there (N,).

    ends : times of the first and the last key; rise : last value minus first
    """
    first, last = ends
    span = last - first
    inside, added = np.clip(ticks, first, last), np.zeros(len(ticks))
    for before, side, past in ((True, beyond[0], first - ticks), (False, beyond[1], ticks - last)):
        out = past > 0
        if side.kind not in {REPEAT, RELATIVE, MIRROR} or not out.any():
            continue
        rounds = past[out] // span + 1
        phase = past[out] % span
        if side.count >= 0:
            over = rounds > side.count
            rounds, phase = np.where(over, side.count, rounds), np.where(over, span if side.count else 0, phase)
        back = (rounds % 2 == 1) if side.kind == MIRROR else np.zeros(len(rounds), dtype=bool)
        forward = (back if before else ~back) if side.count != 0 else np.full(len(rounds), before)
        inside[out] = np.where(forward, first + phase, last - phase)
        if side.kind == RELATIVE:
            added[out] = rounds * (-rise if before else rise)
    return inside, added
