"""The options that change when things happen: segments at another speed, steps that meet at the seams, cheaper cuts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from kinestitch.cli.inputs import Opened
from kinestitch.cli.options import NOT_NEGATIVE
from kinestitch.cli.snapping import move_notes, snapped

if TYPE_CHECKING:
    from kinestitch.search.phase import Steps


class SpeedType(click.ParamType):
    """A segment and its speed, ``2=0.5``, as (2, 0.5)."""

    name = "speed"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, float]:
        if isinstance(value, tuple):
            return value
        number, sign, factor = value.partition("=")
        try:
            found = int(number), float(factor)
        except ValueError:
            found = 0, math.nan
        if not (sign and found[0] >= 1 and math.isfinite(found[1])):
            self.fail(f"Expected N=FACTOR such as 2=0.5, the second segment at half its speed, got {value!r}.")
        return found


def time_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options ``--keep-length``, ``--speed``, ``--align-steps`` and ``--warp`` of a command."""
    for option in (
        click.option(
            "--warp",
            type=click.FloatRange(0.0, 0.5, min_open=True),
            metavar="BOUND",
            help="Bend time near each seam, by this share of its speed at most, so that the steps meet.",
        ),
        click.option(
            "--align-steps",
            type=NOT_NEGATIVE,
            metavar="SECONDS",
            help="Move each seam between steps to where they meet, this far at most.",
        ),
        click.option(
            "--speed",
            type=SpeedType(),
            multiple=True,
            metavar="N=FACTOR",
            help="Play segment N of the result, counted from 1, at this speed.",
        ),
        click.option(
            "--keep-length", is_flag=True, help="With --snap alone, only moves that leave the result as long as it was."
        ),
    ):
        command = option(command)
    return command


def in_time(opened: Opened, wishes: dict[str, Any], step: Callable[[str], None]) -> tuple[Opened, list[str]]:
    """The edit with its segments' speeds, its seams moved and time bent around them; and a sentence for each change.

    wishes : the command's options, of which ``speed``, ``align_steps``, ``snap``, ``keep_length`` and ``warp`` count,
    in this order
    """
    if wishes["keep_length"] and wishes["align_steps"] is not None:
        raise click.UsageError(
            "Expected --keep-length without --align-steps, whose moves change the length, got both. Leave out "
            "--keep-length, or take --snap instead of --align-steps."
        )
    if wishes["keep_length"] and wishes["snap"] is None:
        raise click.UsageError("Expected --snap with --keep-length, which says how far seams may move.")
    opened, notes = _paced(opened, wishes["speed"])
    if not opened.timeline.seams and (wishes["align_steps"] is not None or wishes["warp"] is not None):
        return opened, [*notes, "no seam at which steps could meet: the result is one stretch of one clip."]
    if wishes["align_steps"] is not None:
        step("looking for steps")
        opened, told = _aligned(opened, wishes)
        notes += told
    elif wishes["snap"] is not None:
        step("looking for cheaper cuts")
        opened, told = snapped(opened, wishes["snap"], keep_length=wishes["keep_length"])
        notes += told
    if wishes["warp"] is not None:
        step("bending time")
        opened, told = _warped(opened, wishes["warp"])
        notes += told
    return opened, notes


def _paced(opened: Opened, speeds: tuple[tuple[int, float], ...]) -> tuple[Opened, list[str]]:
    from kinestitch.edit import set_speed
    from kinestitch.errors import RangeError

    line, notes = opened.timeline, []
    for number, speed in speeds:
        count = len(line.segments)
        if number > count:
            raise RangeError(f"Expected one of the result's {count} segments, counted from 1, got --speed {number}.")
        before = line.segments[number - 1]
        line = set_speed(line, number - 1, speed)
        after = line.segments[number - 1]
        notes.append(
            f"segment {number} ({before.clip} {before.range}) plays at {speed:g} × speed: "
            f"{len(after)} frames, before {len(before)}."
        )
    return replace(opened, timeline=line), notes


def _aligned(opened: Opened, wishes: dict[str, Any]) -> tuple[Opened, list[str]]:
    from kinestitch.search.align import TOLERANCE, align_phase

    seconds, warp = wishes["align_steps"], wishes["warp"]
    found = align_phase(opened.timeline, opened.clips, seconds, snap=wishes["snap"])
    notes = move_notes(opened.timeline, found.timeline, found.moves, (found.before, found.after, found.separable))
    opened = replace(opened, timeline=found.timeline)
    if warp is not None:  # what bending makes of the seams is told there
        return opened, notes
    notes += _without_steps(opened, found.gaps_after)
    for seam, (move, before, gap) in enumerate(zip(found.moves, found.gaps_before, found.gaps_after, strict=True)):
        if abs(gap) > TOLERANCE + 1e-9:  # never of NaN
            why = f"no nearer place lies within {seconds:g} s"
            if _is_hard(opened, seam):
                why = "hard cuts stay"
            elif not math.isfinite(before):
                why = "where it was cut one side makes none, so that it was only snapped"
            notes.append(f"the steps at seam {seam + 1} still differ by {_degrees(gap)} of a stride's 360°; {why}.")
        elif move == (0, 0) and math.isfinite(gap):
            notes.append(f"the steps at seam {seam + 1} meet already, to {_degrees(gap)} of a stride's 360°; it stays.")
    return opened, notes


def _warped(opened: Opened, bound: float) -> tuple[Opened, list[str]]:
    from kinestitch.search.warp import warp_steps

    found = warp_steps(opened.timeline, opened.clips, bound)
    notes = _without_steps(opened, found.gaps_before)
    for seam, (speeds, before, after) in enumerate(
        zip(found.speeds, found.gaps_before, found.gaps_after, strict=True), start=1
    ):
        if speeds != (1.0, 1.0):
            rest = "" if abs(after) < 1e-3 else f"; {_degrees(after)} stay, as far as the bound and the clips allow"
            notes.append(
                f"time bent at seam {seam}: {speeds[0]:.4g} × speed before it, {speeds[1]:.4g} × after it, "
                f"to bridge {_degrees(before)} of a stride{rest}."
            )
        elif abs(before) < 1e-3:  # never of NaN
            notes.append(f"the steps at seam {seam} meet already; time stays as it is.")
        elif math.isfinite(before):
            why = "hard cuts stay" if _is_hard(opened, seam - 1) else "the clips leave no frames to bend time with"
            notes.append(f"the steps at seam {seam} still differ by {_degrees(before)} of a stride's 360°; {why}.")
    return replace(opened, timeline=found.timeline), notes


def _without_steps(opened: Opened, gaps: tuple[float, ...]) -> list[str]:
    """A sentence for each seam at which a side makes no steps, and what that side is."""
    from kinestitch.search.phase import find_steps

    steps, line, notes = find_steps(opened.timeline, opened.clips), opened.timeline, []
    for seam, gap in enumerate(gaps):
        if math.isfinite(gap):
            continue
        left, right = line.segments[seam], line.segments[seam + 1]
        said = []
        for segment, place in ((left, left.range.stop), (right, right.range.start)):
            source = line.clip(segment.clip).source
            if source in steps.missing:
                said.append(f"{source} {steps.missing[source]}")
            elif not math.isfinite(_phase_at(opened, segment.clip, place, steps)):
                said.append(f"{segment.clip} makes no steps around frame {place}")
        notes.append(f"no steps to align at seam {seam + 1}: {', '.join(dict.fromkeys(said))}.")
    return notes


def _is_hard(opened: Opened, seam: int) -> bool:
    return opened.timeline.seams[seam].lambda_at(opened.timeline.fps) == 0


def _phase_at(opened: Opened, clip: str, place: int, steps: Steps) -> float:
    from kinestitch.search.align import place_phases

    return float(place_phases(opened.timeline, clip, (place, place), steps)[0])


def _degrees(angle: float) -> str:
    return f"{abs(math.degrees(angle)):.3g}°"
