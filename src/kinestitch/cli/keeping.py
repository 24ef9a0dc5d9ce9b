"""An output in the input's own format keeps the input's character: its mesh, skin, materials and the rest."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinestitch.errors import FormatError, KinestitchWarning

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion

preset_option = click.option(
    "--preset",
    type=click.Choice(["unity", "unreal", "blender", "maya"]),
    help="Axes, units and root of an FBX file OUT, as this program likes them; the skeleton alone.",
)


def write_clip(
    motion: Motion,
    target: str,
    source: str,
    *,
    skeleton_only: bool,
    take: str | None = None,
    name: str | None = None,
    preset: str | None = None,
) -> None:
    """Write a motion that came from `source`, into a copy of that file where the formats allow it.

    skeleton_only : write the skeleton and its motion alone
    take : the one that was read from `source`, None for the one that reading takes
    name : what the clip was called that was read from `source`, where the motion is called otherwise
    preset : of the output's format, which is written as a skeleton then; one line says what it sets

    One KinestitchWarning tells of a mesh that the output does not carry, unless that was asked for.
    """
    from kinestitch.files import can_keep, format_of, has_character, write

    why = f"the output is {format_of(target).name}. Choose an output of the input's format to keep it."
    if preset is not None:
        why = "a preset sets axes and units, which a mesh has of its own."
    elif not skeleton_only and format_of(source) is format_of(target) and can_keep(target):
        options: dict[str, Any] = {} if take is None else {"take": take}
        try:
            write(motion if name is None else replace(motion, name=name), target, like=source, **options)
            return
        except FormatError as error:
            why = str(error)
    if preset is None:
        write(motion, target)
    else:
        write(motion, target, preset=preset)
        _tell_preset(preset)
    if not skeleton_only and has_character(source):
        warnings.warn(KinestitchWarning(f"The mesh of {Path(source).name} is left out: {why}"), stacklevel=2)


def _tell_preset(name: str) -> None:
    from kinestitch.cli.failures import tell
    from kinestitch.files.fbx import PRESETS

    tell("preset", f"{name}: {PRESETS[name].says}.")
