"""The verb ``convert``: one format to another, maybe at another frame rate."""

from __future__ import annotations

from typing import Any

import click

from kinestitch.cli.console import console, counted, progress
from kinestitch.cli.inputs import is_document, read_clip
from kinestitch.cli.keeping import preset_option, write_clip
from kinestitch.cli.options import FILE
from kinestitch.cli.outputs import check_output, check_suffix
from kinestitch.errors import ParameterError, UnsupportedFormatError


@click.command(no_args_is_help=True, short_help="Convert a clip to another format.")
@click.argument("source", metavar="IN", type=FILE)
@click.argument("target", metavar="OUT", type=FILE)
@click.option("--fps", type=float, metavar="N", help="Resample to this frame rate; the duration stays.")
@click.option("--take", metavar="NAME", help="Which take of an FBX or glTF file; info lists them.")
@click.option(
    "--unit", metavar="U", help="What the numbers of a BVH file IN count: m, cm, mm, inch, asf, or metres, as 0.0254."
)
@click.option(
    "--skeleton-only", is_flag=True, help="Leave out the mesh and all else that OUT keeps of IN in the same format."
)
@preset_option
def convert(
    source: str,
    target: str,
    *,
    fps: float | None,
    take: str | None,
    unit: str | None,
    skeleton_only: bool,
    preset: str | None,
) -> None:
    """Read the clip IN and write it as OUT; the suffixes say which formats. In the same format OUT keeps IN's
    character.

    \b
    Examples:
      kinestitch convert walk.fbx walk.bvh
      kinestitch convert capture.bvh capture.glb --fps 60 --unit inch
      kinestitch convert skinned.fbx walk.glb --take mixamo.com
      kinestitch convert walk.bvh walk.fbx --preset unreal
    """
    if is_document(source):
        raise UnsupportedFormatError(f"Expected a clip, got an edit. Use kinestitch stitch instead. ({source})")
    check_suffix(target)
    check_output(target, [source])
    options: dict[str, Any] = {}
    if take is not None:
        options["take"] = take
    if unit is not None:
        options["unit"] = _metres(unit)
    with progress(3) as step:
        from kinestitch.core.resample import resample

        step(f"reading {source}")
        motion = read_clip(source, **options)
        if fps is not None:
            step("resampling")
            motion = resample(motion, fps)
        step(f"writing {target}")
        write_clip(motion, target, source, skeleton_only=skeleton_only or unit is not None, take=take, preset=preset)
    size = f"{counted(motion.frames, 'frame')}, {motion.fps:g} fps, {motion.duration:.2f} s"
    console().print(f"{target}: {size}, {counted(motion.skeleton.joint_count, 'joint')}")


def _metres(unit: str) -> str | float:
    """A unit by name, or in metres."""
    try:
        number = float(unit)
    except ValueError:
        return unit
    if not 0 < number < float("inf"):
        raise ParameterError(f"Expected a unit > 0 m, got {unit}.")
    return number
