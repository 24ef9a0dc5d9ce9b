"""Kinds of options: ranges, clips with a range, and commands that remember the order of their options."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from kinestitch.errors import ParameterError

_ORDER = "kinestitch.order"


class OrderedCommand(click.Command):
    """A command that remembers in which order options of different names were given.

    sections : heading → names of its options, as the help shows them; what is in none comes last
    """

    def __init__(self, *words: Any, sections: Mapping[str, Sequence[str]] | None = None, **settings: Any) -> None:
        super().__init__(*words, **settings)
        self.sections = dict(sections or {})

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        known = {parameter.name: parameter for parameter in self.get_params(ctx) if isinstance(parameter, click.Option)}
        named = {name for names in self.sections.values() for name in names}
        rest = [name for name in known if name not in named]
        for heading, names in {**self.sections, "Options": rest}.items():
            rows = [row for name in names if (row := known[name].get_help_record(ctx)) is not None]
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        order = self.make_parser(ctx).parse_args(args=list(args))[2]
        ctx.meta[_ORDER] = [parameter.name for parameter in order]
        return super().parse_args(ctx, args)


def in_order(ctx: click.Context, names: tuple[str, ...]) -> list[tuple[str, Any]]:
    """(name, value) of every use of these repeatable options, as they stood on the command line."""
    values = {name: iter(ctx.params[name]) for name in names}
    return [(name, next(values[name])) for name in ctx.meta[_ORDER] if name in values]


class RangeType(click.ParamType):
    """Frames ``60:110`` as (60, 110); either end may be left out."""

    name = "range"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int | None, int | None]:
        from kinestitch.edit import parse_range

        try:
            return value if isinstance(value, tuple) else parse_range(value)
        except ParameterError as error:
            self.fail(str(error), param, ctx)


class ClipType(click.ParamType):
    """A clip and maybe a range of it, ``PATH@20:75``, as (path, 20, 75); only a trailing ``@a:b`` counts."""

    name = "clip"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, int | None, int | None]:
        from kinestitch.edit import parse_source

        if isinstance(value, tuple):
            return value
        if value.startswith("-") and not Path(parse_source(value)[0]).exists():
            self.fail(f"Expected PATH@START:STOP such as kick.fbx@20:75, got the option {value!r}.", param, ctx)
        try:
            source = parse_source(value)
        except ParameterError as error:
            self.fail(str(error), param, ctx)
        clip = clip_before_range(source[0])
        if clip:
            told = value[len(clip) + 1 :]
            self.fail(f"Expected a range START:STOP behind {clip}@, such as 20:75, got {told!r}.", param, ctx)
        return source

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        return [CompletionItem(incomplete, type="file")]


def clip_before_range(text: str) -> str:
    """``kick.fbx`` of ``kick.fbx@…``, whatever stands behind the @; empty where that is no clip, or all is one."""
    clip = text.rpartition("@")[0]
    return clip if _is_clip(clip) and not _is_clip(text) and not Path(text).exists() else ""


def _is_clip(path: str) -> bool:
    """Whether a path ends as a clip's does."""
    from kinestitch.files import FORMATS

    return Path(path).suffix.lower() in {suffix for entry in FORMATS for suffix in entry.suffixes}


class NotNegative(click.ParamType):
    """A finite number ≥ 0."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and number >= 0):
            self.fail(f"Expected a number ≥ 0, got {value!r}.", param, ctx)
        return number


class SizeType(click.ParamType):
    """Pixels ``960x540`` as (960, 540)."""

    name = "size"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        width, _, height = value.lower().replace("×", "x").partition("x")
        if not (width.isascii() and width.isdigit() and height.isascii() and height.isdigit()):
            self.fail(f"Expected WIDTHxHEIGHT such as 960x540, got {value!r}.", param, ctx)
        return int(width[:6]), int(height[:6])


class PasteType(click.Tuple):
    """A place and the clip that goes there; the Tab key completes the clip's file name."""

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        return [CompletionItem(incomplete, type="file")]


RANGE, CLIP, NOT_NEGATIVE, SIZE, FILE = RangeType(), ClipType(), NotNegative(), SizeType(), click.Path()
OVER, BEFORE = PasteType([RANGE, CLIP]), PasteType([click.INT, CLIP])
