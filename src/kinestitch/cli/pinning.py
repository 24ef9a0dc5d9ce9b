"""The options ``--pin``, ``--waypoint`` and ``--return``: where the body has to be in single frames of the result."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import click

from kinestitch.cli.failures import tell
from kinestitch.cli.inputs import Opened
from kinestitch.cli.options import NOT_NEGATIVE
from kinestitch.errors import ParameterError

if TYPE_CHECKING:
    from kinestitch.edit import Pin, Timeline

Command = TypeVar("Command", bound=Callable[..., Any])


class PinType(click.ParamType):
    """A pin as it is written, by the parser of this name."""

    name = "pin"

    def __init__(self, parser: str) -> None:
        self.parser = parser

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Pin:
        from kinestitch import edit

        if isinstance(value, edit.Pin):
            return value
        try:
            pin: Pin = getattr(edit, self.parser)(value)
        except ParameterError as error:
            self.fail(str(error), param, ctx)
        return pin


def pin_options(command: Command) -> Command:
    """``--pin``, ``--waypoint`` and ``--return`` as the parameters pin, waypoint and come_back."""
    for option in (
        click.option(
            "--return",
            "come_back",
            type=NOT_NEGATIVE,
            metavar="SECONDS",
            help="Be back on ORIGINAL's own path this long after the last seam.",
        ),
        click.option(
            "--waypoint",
            type=PinType("parse_waypoint"),
            multiple=True,
            metavar="N=X,Z[:W]",
            help="Bend the path through X,Z (m) at frame N of the result.",
        ),
        click.option(
            "--pin",
            type=PinType("parse_pin"),
            multiple=True,
            metavar="WHAT@N=VALUES[:W]",
            help="root@N=X,Y,Z: in frame N of the result the body stands over X,Z (m), Y higher than it would. "
            "heading@N=DEGREES: 0 faces +Z, 90 +X. JOINT@N=X,Y,Z: a joint's place in the world (m). JOINT@N=X,Y,Z,W: "
            "its local rotation. With a weight :W it goes W/(W+1) of the way, without one all of it.",
        ),
    ):
        command = option(command)
    return command


def tell_unsolved(timeline: Timeline) -> None:
    """What can be told of an edit's seams and pins before it is solved; raises ParameterError for seams that cannot be
    solved at all.
    """
    from kinestitch.edit import away_again
    from kinestitch.solve.seam import stiffness_at

    for seam in timeline.seams:
        stiffness_at(seam, timeline.fps)
    if away := away_again(timeline.pins):
        tell("warning", away)
    if timeline.pins:
        tell("note", "whether pins can be met, and what they do to the steps, is told when the edit is solved.")


def with_pins(opened: Opened, pins: Sequence[Pin], seconds: float | None) -> Opened:
    """The edit with more pins, and with a way back to ORIGINAL's path where `seconds` are given.

    Raises ParameterError for a joint that ORIGINAL's rig does not have, and what the edits of pins raise.
    """
    from kinestitch.edit import add_pin, come_back
    from kinestitch.solve.pins import joint_called

    line = opened.timeline
    skeleton = next(iter(opened.clips.values())).skeleton
    for pin in pins:
        if pin.joint is not None:
            joint_called(skeleton, pin)
        line = add_pin(line, pin)
    if seconds is not None:
        line = come_back(line, seconds)
    return replace(opened, timeline=line)
