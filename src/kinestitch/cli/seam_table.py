"""The report of a stitch: as a table for a person, as JSON for a program."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

from kinestitch.cli.console import console, counted

if TYPE_CHECKING:
    from kinestitch.edit import Timeline
    from kinestitch.solve.solved import Solved


def as_json(numbers: dict[str, Any]) -> str:
    """One JSON object; what is not finite becomes null, since JSON has no NaN."""
    return json.dumps(_finite(numbers), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def show_seams(solved: Solved, numbers: dict[str, Any], output: str) -> None:
    """Print what was written and how every seam came out."""
    from rich.table import Table

    out = console()
    timeline = solved.placed.timeline
    seams = numbers["seams"]
    is_solved = numbers["method"] == "laplacian"
    if seams:
        table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
        for title in (
            "seam",
            "between",
            *(("smooth s",) if is_solved else ()),
            "rotation step °",
            "velocity step °/s",
            "moved by °",
            "hips step cm",
        ):
            table.add_column(title, justify="left" if title == "between" else "right", overflow="fold")
        for place, seam in zip(solved.seams, seams, strict=True):
            left, right = timeline.segments[place.index], timeline.segments[place.index + 1]
            table.add_row(
                str(seam["frame"]),
                f"{left.clip} {left.range.stop - 1} → {right.clip} {right.range.start}",
                *((_smoothing(seam, numbers["fps"]),) if is_solved else ()),
                _change(seam, "rotation_step_deg", "{:.1f}"),
                _change(seam, "angular_velocity_step_deg_s", "{:.0f}"),
                f"{seam['deviation_max_deg']:.1f}",
                _change(seam, "root_step_m", "{:.1f}", 100.0),
            )
        out.print(table)
        out.print("Before → after: largest joint between the two frames at each seam; moved by: largest, off the cut.")
        _show_feet(solved)
    tail = f", {counted(len(seams), 'seam')}"
    if seams and is_solved:
        tail += f" solved in {numbers['solve_ms']:.2f} ms"
    out.print(f"{output}: {_size(numbers['frames'], numbers['fps'])}, {counted(numbers['joints'], 'joint')}{tail}")


def _show_feet(solved: Solved) -> None:
    """Print when the feet stand around each seam."""
    from kinestitch.cli.foot_bars import foot_bars, legend

    bars = list(foot_bars(solved))
    for seam, bar in zip(solved.seams, bars, strict=False):
        console().print(f"{seam.frame:>4}  {bar}")
    if bars:
        console().print(legend(solved))


def show_edit(timeline: Timeline, output: str) -> None:
    """Print what an edit document holds."""
    out = console()
    for start, segment in zip(timeline.starts, timeline.segments, strict=False):
        out.print(f"{start:>7}  {segment}")
    out.print(
        f"{output}: {_size(timeline.frames, timeline.fps)}, {counted(len(timeline.seams), 'seam')}, not solved yet"
    )


def _size(frames: int, fps: float) -> str:
    return f"{counted(frames, 'frame')}, {fps:g} fps, {(frames - 1) / fps:.2f} s"


def _smoothing(seam: dict[str, Any], fps: float) -> str:
    """A smoothing time in s, or the shortest and longest of the body's parts."""
    longest = seam["lambda"] ** 0.25 / fps
    shortest = min((part["smoothing_s"] for part in seam.get("groups", {}).values()), default=longest)
    return f"{longest:.3g}" if shortest == longest else f"{shortest:.2g}–{longest:.2g}"


def _change(seam: dict[str, Any], name: str, form: str, scale: float = 1.0) -> str:
    before, after = (seam[f"{name}_{when}"] * scale for when in ("before", "after"))
    return f"{form.format(before)} → {form.format(after)}"
