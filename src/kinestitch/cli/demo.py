"""The verb ``demo``: the main job on clips that need no download, and everything one can look at afterwards."""

from __future__ import annotations

import shlex
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinestitch.cli.console import console, progress
from kinestitch.cli.options import FILE
from kinestitch.errors import OutputError

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.edit import Timeline
    from kinestitch.solve.solved import Solved

CUT, PASTED = (84, 130), (30, 112)
"""Chosen so that the seams are cheap and the walk goes on the way it came."""

CLIPS = ("walk.bvh", "kick.bvh")
DOCUMENT = "walk_kick.otio"
RESULTS = ("walk_kick.bvh", "walk_kick.glb", DOCUMENT, "walk_kick_plot.png", "walk_kick_filmstrip.png")
JOINT = "RightUpLeg"


@click.command(short_help="Paste a kick into a walk, with nothing to download.")
@click.argument("folder", metavar="[DIR]", default="kinestitch-demo", type=FILE)
def demo(folder: str) -> None:
    """Paste a kick into a walk and write everything there is to see into DIR (kinestitch-demo).

    Both clips are made by code, so nothing is downloaded: walk.bvh and kick.bvh, the result as walk_kick.bvh and
    walk_kick.glb, the edit as walk_kick.otio, a plot of the kicking leg, and a filmstrip.

    \b
    Examples:
      kinestitch demo
      kinestitch demo /tmp/try
    """
    target = Path(folder)
    _make_folder(target)
    with progress(6) as step:
        from kinestitch.analysis.quality import report
        from kinestitch.analysis.skating import feet_report
        from kinestitch.edit import replace, save_document
        from kinestitch.edit.timeline import timeline
        from kinestitch.files import write
        from kinestitch.samples import sample
        from kinestitch.solve.stitch import solve_timeline

        step("making two clips")
        clips = {"walk": sample("walk"), "kick": sample("kick")}
        for name in CLIPS:
            write(clips[Path(name).stem], target / name)
        line = replace(timeline(clips, "walk"), *CUT, "kick", *PASTED)
        step("solving the seams")
        solved = solve_timeline(line, clips, foot_lock=line.foot_lock)
        numbers = {**report(solved), "feet": feet_report(solved)}
        step("writing the result")
        for suffix in (".bvh", ".glb"):
            write(solved.motion, target / f"walk_kick{suffix}")
        sources = {Path(name).stem: target / name for name in CLIPS}
        save_document(line, target / DOCUMENT, sources=sources)
        step("drawing")
        _draw(clips, line, solved, target)
    _tell(solved, numbers, target)


def _make_folder(target: Path) -> None:
    """Make the folder; files of the same names are replaced only where an earlier demo left them."""
    if target.exists() and not target.is_dir():
        raise OutputError(f"Expected a folder, got a file. Choose another name. ({target})")
    found = [name for name in (*CLIPS, *RESULTS) if (target / name).exists()]
    if found and not (target / DOCUMENT).exists():
        raise OutputError(f"Expected a folder without {found[0]}, which would be replaced. Choose another. ({target})")
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"Expected a folder that can be made, got: {error.strerror}. ({target})") from error


def _draw(clips: dict[str, Motion], line: Timeline, solved: Solved, target: Path) -> None:
    from kinestitch.analysis.plots import plot_joint
    from kinestitch.cli.pictures import find_joint, pasted_stretches
    from kinestitch.render.filmstrip import filmstrip

    seams = [seam.frame for seam in solved.seams]
    joint = find_joint(solved.motion, JOINT)
    plot_joint(solved.motion, joint, target / RESULTS[3], before=solved.cut, seams=seams, contacts=solved.contacts)
    filmstrip(
        [clips["walk"], clips["kick"], solved.motion],
        target / RESULTS[4],
        poses=15,
        labels=["walk", "kick", "walk with the kick pasted in"],
        marks=[(), (), seams],
        segments=[(), (), pasted_stretches(line)],
    )


def _tell(solved: Solved, numbers: dict[str, object], target: Path) -> None:
    from kinestitch.cli.seam_table import show_seams

    show_seams(solved, numbers, str(target / RESULTS[0]))
    out = console()
    for name in RESULTS[1:]:
        out.print(target / name)
    walk, kick = (str(target / name) for name in CLIPS)
    pasted = f"{kick}@{PASTED[0]}:{PASTED[1]}"
    words = ("stitch", walk, "--replace", f"{CUT[0]}:{CUT[1]}", pasted, "-o", str(target / "mine.bvh"))
    out.print("\nThe same by hand, and with your own clips:")
    out.print(f"  {shlex.join([*_program(), *words])}")


def _program() -> list[str]:
    """The words that start kinestitch in this shell."""
    if shutil.which("kinestitch"):
        return ["kinestitch"]
    started = Path(sys.argv[0])
    return [sys.argv[0]] if started.stem == "kinestitch" and started.exists() else [sys.executable, "-m", "kinestitch"]
