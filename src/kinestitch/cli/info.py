"""The verb ``info``: what is in a file."""

from __future__ import annotations

import importlib
import json
import os
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import click

from kinestitch.cli.console import console, fact_table, progress
from kinestitch.cli.edits import EditFacts, edit_facts, show_edit_facts
from kinestitch.cli.failures import WRONG, explain, tell
from kinestitch.cli.inputs import is_document, read_clip
from kinestitch.cli.options import FILE
from kinestitch.cli.recordings import RecordingFacts, is_recording, recording_facts, show_recording

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.core.skeleton import Skeleton


@dataclass(frozen=True, slots=True)
class ClipFacts:
    """What is told of one file.

    duration : s from the first frame to the last; travel, path : m the hips move over the ground, from start to end
    and along the way; hip_height : m, measured along the bones of a straight leg
    """

    file: str
    format: str
    takes: tuple[str, ...]
    joints: int
    root: str
    hips: str
    fps: float
    frames: int
    duration: float
    travel: float
    path: float
    hip_height: float
    joint_names: tuple[str, ...]
    warnings: tuple[str, ...]


@click.command(no_args_is_help=True, short_help="Tell what is in clips and edits.")
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@click.option("--json", "as_json", is_flag=True, help="Print a JSON list with one object for each file.")
@click.option("--joints", is_flag=True, help="Print the tree of joints, too.")
@click.pass_context
def info(ctx: click.Context, files: tuple[str, ...], as_json: bool, joints: bool) -> None:
    """Tell what is in clips: joints, frame rate, length, travel, hip height, takes, oddities.

    One file gets a block, several a table; recordings (.c3d) and edits (.otio: segments, seams and the clips they
    name) get a block each. Lengths are in metres and seconds.

    \b
    Examples:
      kinestitch info walk.fbx
      kinestitch info *.bvh
      kinestitch info walk.fbx --joints
      kinestitch info walk.fbx kick.fbx --json
    """
    facts: list[ClipFacts] = []
    trees: list[Skeleton] = []
    others: list[RecordingFacts | EditFacts] = []
    with progress(len(files)) as step:
        for path in files:
            step(f"reading {path}")
            try:
                if is_recording(path):
                    others.append(recording_facts(path))
                    continue
                if is_document(path):
                    others.append(edit_facts(path))
                    continue
                told, motion = clip_facts(path)
            except Exception as error:
                if len(files) == 1:
                    raise
                tell("error", explain(error))
                continue
            facts.append(told)
            trees.append(motion.skeleton)
    if as_json:
        everything = [asdict(told) for told in facts] + [asdict(other) for other in others]
        click.echo(json.dumps(everything, indent=2))
    else:
        _show(facts, trees if joints else [])
        for other in others:
            if isinstance(other, EditFacts):
                show_edit_facts(other)
            else:
                show_recording(other)
    if len(facts) + len(others) < len(files):
        ctx.exit(WRONG)


def clip_facts(path: str) -> tuple[ClipFacts, Motion]:
    """Read a clip and measure it; raises what reading raises."""
    import numpy as np

    from kinestitch.core.kinematics import world_pose
    from kinestitch.files import format_of
    from kinestitch.rig.hips import hip_height, hips_joint

    oddities: list[str] = []
    motion = read_clip(path, oddities.append)
    skeleton = motion.skeleton
    hips = hips_joint(skeleton)
    ground = world_pose(motion, [hips]).positions[:, hips, ::2]
    told = ClipFacts(
        file=path,
        format=format_of(path).name,
        takes=_takes(path),
        joints=skeleton.joint_count,
        root=skeleton.names[0],
        hips=skeleton.names[hips],
        fps=motion.fps,
        frames=motion.frames,
        duration=motion.duration,
        travel=float(np.linalg.norm(ground[-1] - ground[0])),
        path=float(np.linalg.norm(np.diff(ground, axis=0), axis=1).sum()),
        hip_height=hip_height(skeleton),
        joint_names=skeleton.names,
        warnings=tuple(oddities),
    )
    return told, motion


def _takes(path: str) -> tuple[str, ...]:
    """Names of a file's takes, in formats that have several."""
    from kinestitch.files import format_of

    module = importlib.import_module(f"kinestitch.files.{format_of(path).module}")
    listed: tuple[str, ...] = tuple(module.list_takes(path)) if hasattr(module, "list_takes") else ()
    return listed


def _show(facts: list[ClipFacts], trees: list[Skeleton]) -> None:
    out = console()
    if len(facts) == 1:
        _show_block(facts[0])
    elif facts:
        _show_table(facts)
    for told, skeleton in zip(facts, trees, strict=False):
        from rich.tree import Tree

        if len(facts) > 1:
            out.print(told.file)
        branches = [Tree(skeleton.names[0])]
        for joint in range(1, skeleton.joint_count):
            branches.append(branches[skeleton.parents[joint]].add(skeleton.names[joint]))
        out.print(branches[0])


def _show_block(told: ClipFacts) -> None:
    table = fact_table()
    rows = [
        ("file", told.file),
        ("format", told.format),
        ("joints", f"{told.joints}, root {told.root}" + ("" if told.hips == told.root else f", hips {told.hips}")),
        ("frame rate", f"{told.fps:g} fps"),
        ("frames", f"{told.frames}, numbered 0 to {told.frames - 1}"),
        ("duration", f"{told.duration:.3f} s"),
        ("travel", f"{told.travel:.2f} m from start to end, {told.path:.2f} m along the way"),
        ("hip height", f"{told.hip_height:.3f} m"),
        ("takes", ", ".join(told.takes)),
        *(("warning", oddity) for oddity in told.warnings),
    ]
    for name, value in rows:
        if value:
            table.add_row(name, value)
    console().print(table)


def _show_table(facts: list[ClipFacts]) -> None:
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("file", overflow="fold", ratio=1)
    table.add_column("format")
    for title in ("joints", "fps", "frames", "seconds", "travel m", "hips m", "warnings"):
        table.add_column(title, justify="right")
    for told in facts:
        table.add_row(
            os.fspath(told.file),
            told.format,
            str(told.joints),
            f"{told.fps:g}",
            str(told.frames),
            f"{told.duration:.2f}",
            f"{told.travel:.2f}",
            f"{told.hip_height:.2f}",
            str(len(told.warnings) or ""),
        )
    console().print(table)
    for told in facts:
        for oddity in told.warnings:
            tell("warning", oddity if told.file in oddity else f"{oddity} ({told.file})")
