"""The option ``--snap``: seams moved to cheaper frames, and a sentence for each that says so."""

from __future__ import annotations

from dataclasses import replace

from kinestitch.cli.inputs import Opened


def snapped(opened: Opened, seconds: float) -> tuple[Opened, list[str]]:
    """The edit with its seams moved, and what moved; the clips are the same."""
    from kinestitch.search.snap import snap

    found = snap(opened.timeline, opened.clips, seconds)
    old, new = opened.timeline, found.timeline
    notes = []
    for seam, (out, into) in enumerate(found.moves):
        if (out, into) != (0, 0):
            left, right = new.segments[seam], new.segments[seam + 1]
            notes.append(
                f"seam {seam + 1} moved: {left.clip} now ends before frame {left.range.stop} ({out:+d}), "
                f"{right.clip} starts at {right.range.start} ({into:+d})."
            )
    if notes:
        change = new.frames - old.frames
        length = f"{abs(change)} frames {'longer' if change > 0 else 'shorter'}" if change else "as long as before"
        notes.append(f"all seams together now cost {found.after:.4g} rad², before {found.before:.4g}; it is {length}.")
    return replace(opened, timeline=new), notes
