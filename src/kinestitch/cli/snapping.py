"""Seams that are moved: to cheaper frames by ``--snap``; and a sentence for each that says so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from kinestitch.cli.inputs import Opened

if TYPE_CHECKING:
    from kinestitch.edit import Timeline


def snapped(opened: Opened, seconds: float, *, keep_length: bool = False) -> tuple[Opened, list[str]]:
    """The edit with its seams moved, and what moved; the clips are the same."""
    from kinestitch.search.snap import snap

    found = snap(opened.timeline, opened.clips, seconds, keep_length=keep_length)
    prices = found.before, found.after, found.separable
    notes = move_notes(opened.timeline, found.timeline, found.moves, prices)
    return replace(opened, timeline=found.timeline), notes


def move_notes(
    old: Timeline, new: Timeline, moves: Sequence[tuple[int, int]], prices: tuple[float, float, float]
) -> list[str]:
    """What moved and what that changes. prices : E* in rad² of all seams together, before and after, and the sum after
    as the search saw it
    """
    notes = []
    for seam, (out, into) in enumerate(moves):
        if (out, into) != (0, 0):
            left, right = new.segments[seam], new.segments[seam + 1]
            notes.append(
                f"seam {seam + 1} moved: {left.clip} now ends before frame {left.range.stop} ({out:+d}), "
                f"{right.clip} starts at {right.range.start} ({into:+d})."
            )
    if notes:
        change = new.frames - old.frames
        length = f"{abs(change)} frames {'longer' if change > 0 else 'shorter'}" if change else "as long as before"
        before, after, seen = prices
        off = f" ({100 * (after / seen - 1):+.1f} % off the sum of what the search saw)" if seen > 0 else ""
        notes.append(f"all seams together now cost {after:.4g} rad²{off}, before {before:.4g}; it is {length}.")
    return notes
