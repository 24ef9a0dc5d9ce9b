"""The verbs that change a whole clip, mirror, in-place, extract-root and bake-root, and what all such verbs share."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinestitch.cli.console import console, counted, progress
from kinestitch.cli.inputs import is_document, read_clip
from kinestitch.cli.keeping import write_clip
from kinestitch.cli.options import FILE, NOT_NEGATIVE
from kinestitch.cli.outputs import check_output, check_suffix
from kinestitch.errors import KinestitchWarning, UnsupportedFormatError

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion

_COMMON = (
    click.argument("source", metavar="IN", type=FILE),
    click.option("-o", "--output", required=True, metavar="OUT", type=FILE, help="The new clip."),
    click.option("--take", metavar="NAME", help="Which take of an FBX or glTF file; info lists them."),
    click.option("--skeleton-only", is_flag=True, help="Leave out the mesh and all else that OUT keeps of IN."),
)


def clip_verb(name: str, short_help: str) -> Callable[[Callable[..., None]], click.Command]:
    """A command with the arguments that all of these verbs share."""

    def decorate(function: Callable[..., None]) -> click.Command:
        for add in reversed(_COMMON):
            function = add(function)
        return click.command(name, no_args_is_help=True, short_help=short_help)(function)

    return decorate


def change_clip(
    common: dict[str, Any], how: Callable[[Motion], Motion], then: Callable[[], None] = lambda: None
) -> None:
    """Read IN, change it, and write OUT; the numbers are printed. then : called once OUT is written"""
    source, output, take = common["source"], common["output"], common["take"]
    if is_document(source):
        raise UnsupportedFormatError(f"Expected a clip, got an edit. Use kinestitch stitch first. ({source})")
    check_suffix(output)
    check_output(output, [source])
    with progress(3) as step:
        step(f"reading {source}")
        motion = read_clip(source, **({} if take is None else {"take": take}))
        step("changing")
        result = how(motion)
        step(f"writing {output}")
        alone = common["skeleton_only"] or _left_alone(motion, result, source)
        write_clip(result, output, source, skeleton_only=alone, take=take)
        then()
    joints = counted(result.skeleton.joint_count, "joint")
    console().print(
        f"{output}: {counted(result.frames, 'frame')}, {result.fps:g} fps, {result.duration:.2f} s, {joints}"
    )


def _left_alone(motion: Motion, result: Motion, source: str) -> bool:
    """Whether the rig has got or lost a joint, so that IN's character does not fit it; a warning says so."""
    from kinestitch.files import has_character

    other = result.skeleton.names != motion.skeleton.names
    if other and has_character(source):
        warnings.warn(
            KinestitchWarning(f"The mesh of {Path(source).name} is left out: it has not the same joints."), stacklevel=2
        )
    return other


@clip_verb("mirror", "Exchange left and right.")
def mirror(**common: Any) -> None:
    """Write the clip IN as a mirror shows it: left becomes right.

    \b
    Example:
      kinestitch mirror punch_right.fbx -o punch_left.fbx
    """
    from kinestitch.core.mirror import mirror as mirrored

    change_clip(common, mirrored)


@clip_verb("in-place", "Take the travel out of a clip.")
@click.option("--turning/--no-turning", default=True, help="Keep the body's turns, or face one way throughout.")
def in_place(*, turning: bool, **common: Any) -> None:
    """Hold the body over the place where it starts; height stays.

    \b
    Example:
      kinestitch in-place walk.fbx -o walk_in_place.fbx
    """
    from kinestitch.rig.root_motion import in_place as held

    change_clip(common, lambda motion: held(motion, turning=turning))


@clip_verb("extract-root", "Give the travel to a root joint on the ground.")
@click.option("--turning/--no-turning", default=True, help="The root turns with the body, or keeps its direction.")
@click.option("--smooth", type=NOT_NEGATIVE, default=0.0, metavar="S", help="Average the root's way over S seconds.")
@click.option("--name", default="root", metavar="NAME", help="Of the root joint, where the rig gets a new one.")
def extract_root(*, turning: bool, smooth: float, name: str, **common: Any) -> None:
    """Give the travel to a root joint on the ground below the hips; a rig whose root is the hips gets a new one.
    No other joint moves in the world.

    \b
    Example:
      kinestitch extract-root walk.fbx -o walk_root.fbx --smooth 0.5
    """
    from kinestitch.rig.root_motion import extract_root as extracted

    change_clip(common, lambda motion: extracted(motion, turning=turning, smooth=smooth, name=name))


@clip_verb("bake-root", "Give a root joint's travel to the hips.")
@click.option("--remove", is_flag=True, help="Take the root joint away as well.")
def bake_root(*, remove: bool, **common: Any) -> None:
    """Give what the joints above the hips do to the hips: the inverse of extract-root.

    \b
    Example:
      kinestitch bake-root walk_root.fbx -o walk.fbx --remove
    """
    from kinestitch.rig.root_motion import bake_root as baked

    change_clip(common, lambda motion: baked(motion, remove=remove))
