"""The verb ``retarget``: a clip on the rig of another file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from kinestitch.cli.console import console, counted, progress
from kinestitch.cli.inputs import is_document, read_clip
from kinestitch.cli.keeping import write_clip
from kinestitch.cli.options import FILE
from kinestitch.cli.outputs import check_output, check_suffix, refuse_suffix
from kinestitch.errors import ParameterError, UnsupportedFormatError

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.rig.mapping import Mapping


@click.command(no_args_is_help=True, short_help="Put a clip on the rig of another file.")
@click.argument("source", metavar="IN", type=FILE)
@click.option(
    "--to", "onto", required=True, metavar="TARGET", type=FILE, help="A file with the rig, best one that moves."
)
@click.option("-o", "--output", metavar="OUT", type=FILE, help="The clip on the other rig.")
@click.option("--mapping", metavar="FILE", type=FILE, help="Which joints follow which, as --save-mapping wrote it.")
@click.option("--save-mapping", metavar="FILE", type=FILE, help="Write the mapping to a .toml or .json file.")
@click.option("--foot-ik/--no-foot-ik", default=True, help="Bend the legs so that feet stand where IN's do.")
@click.option("--take", metavar="NAME", help="Which take of an FBX or glTF file IN; info lists them.")
@click.option("--skeleton-only", is_flag=True, help="Leave out the mesh and all else that OUT keeps of TARGET.")
def retarget(
    source: str, onto: str, output: str | None, mapping: str | None, save_mapping: str | None, **more: Any
) -> None:
    """Put the clip IN on the rig of TARGET. In TARGET's format OUT keeps TARGET's character.

    Joints are matched by their names. Where these are not known, save a mapping, edit it, and pass it.

    \b
    Examples:
      kinestitch retarget walk.bvh --to hero.fbx -o hero_walk.fbx
      kinestitch retarget walk.bvh --to hero.fbx --save-mapping hero.toml
      kinestitch retarget walk.bvh --to hero.fbx --mapping hero.toml -o hero_walk.fbx
    """
    _check(source, onto, output, mapping, save_mapping)
    with progress(4) as step:
        step(f"reading {source}")
        motion = read_clip(source, **({} if more["take"] is None else {"take": more["take"]}))
        step(f"reading {onto}")
        target = read_clip(onto)
        pairs = _mapping(motion, target, mapping, save_mapping)
        if output is None:
            return
        from kinestitch.rig.retarget import retarget as put

        step("retargeting")
        result = put(motion, target.skeleton, pairs if mapping else None, foot_ik=more["foot_ik"], example=target)
        step(f"writing {output}")
        write_clip(result, output, onto, skeleton_only=more["skeleton_only"], name=target.name)
    joints = counted(result.skeleton.joint_count, "joint")
    console().print(f"{output}: {counted(result.frames, 'frame')}, {result.fps:g} fps, {joints}")


def _check(source: str, onto: str, output: str | None, mapping: str | None, save_mapping: str | None) -> None:
    """Refuse before anything is read what could not be written or means nothing."""
    for path in (source, onto):
        if is_document(path):
            raise UnsupportedFormatError(f"Expected a clip, got an edit. Use kinestitch stitch first. ({path})")
    if output is None and save_mapping is None:
        raise ParameterError("Expected an output, got none. Add -o OUT, or --save-mapping FILE.")
    inputs = [source, onto, *([mapping] if mapping else [])]
    if output is not None:
        check_suffix(output)
        check_output(output, inputs)
    if save_mapping is not None:
        refuse_suffix(save_mapping, [".toml", ".json"])
        check_output(save_mapping, inputs, also=[output] if output else [])


def _mapping(motion: Motion, target: Motion, path: str | None, save: str | None) -> Mapping:
    """The mapping of a file, or the one that names tell; saved where that is wished, certain or not."""
    from kinestitch.rig.mapping import find_mapping, unmatched
    from kinestitch.rig.mapping_file import load_mapping, save_mapping

    found = load_mapping(path) if path else find_mapping(motion.skeleton, target.skeleton)
    if save:
        save_mapping(found, save)
        doubt = "" if found.certain else f"; names do not tell {unmatched(found)}"
        console().print(f"{save}: {len(found.pairs)} of {target.skeleton.joint_count} joints follow one{doubt}")
    return found
