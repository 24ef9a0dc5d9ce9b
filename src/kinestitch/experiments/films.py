"""Experiment 11: videos of stitches, hard cut, crossfade and ours side by side; two of them on a skinned character."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from kinestitch.errors import MissingExtraError
from kinestitch.experiments import effect, path
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.page import Finding, Section, Video
from kinestitch.solve.rivals import crossfade
from kinestitch.solve.solved import Solved

WIDTH = 0.2
"""s on each side that the crossfade takes."""

STITCHES: Mapping[str, Callable[[DataSet], Solved]] = {
    "punch replaced by a punch": effect.punch_for_punch,
    "walk, then jumping jacks": lambda data: path.joined(data, path.WALK, path.JACKS),
    "walk with a jump and a kick": path.inserted,
    "run, kick, run": lambda data: path.joined(data, path.RUN, path.ACTIONS[1], path.RUN),
}
SKINNED = ("mixamo_skinned/Michelle.glb", "mixamo_skinned/Xbot.glb")


def side_by_side(solved: Solved, caption: str, folder: Path) -> Video:
    """Hard cut, crossfade and the solved motion as one MP4 with the seams marked."""
    from kinestitch.render.video import video

    blended = crossfade(solved.placed, max(1, round(WIDTH * solved.motion.fps)))
    seams = [seam.frame for seam in solved.seams]
    target = folder / "film.mp4"
    motions = [solved.cut, blended, solved.motion]
    video(motions, target, labels=["hard cut", "crossfade", "kinestitch"], seams=[seams] * 3, fps=30, size=(1080, 420))
    return Video(caption, target.read_bytes())


def skinned(solved: Solved, character: Path, caption: str, folder: Path) -> Video:
    """The hard cut and the solved motion on a character with its skin, retargeted to its rig where that differs."""
    from kinestitch.files.gltf_mesh import read_mesh
    from kinestitch.render.skinned import Character
    from kinestitch.render.video import video
    from kinestitch.rig.retarget import retarget

    body = Character(read_mesh(character))
    motions = [retarget(motion, body.mesh.skeleton) for motion in (solved.cut, solved.motion)]
    target = folder / "skin.mp4"
    seams = [seam.frame for seam in solved.seams]
    video(
        motions,
        target,
        labels=["hard cut", "kinestitch"],
        seams=[seams] * 2,
        fps=15,
        size=(720, 420),
        bodies=[body, body],
    )
    return Video(caption, target.read_bytes())


def run(data: DataSet, folder: Path | None) -> Section:
    """All videos, or a word on what is missing."""
    videos: list[Video] = []
    findings: list[Finding] = []
    with tempfile.TemporaryDirectory() as scratch:
        try:
            solved = {name: make(data) for name, make in STITCHES.items()}
            videos += [
                side_by_side(made, f"{name}: hard cut, crossfade, ours.", Path(scratch))
                for name, made in solved.items()
            ]
            for character, name in zip(SKINNED, list(STITCHES)[1:3], strict=True):
                if folder is not None and (folder / character).is_file():
                    caption = f"{name}, on a skinned character."
                    videos.append(skinned(solved[name], folder / character, caption, Path(scratch)))
        except MissingExtraError as error:
            findings.append(Finding("Videos of the stitches.", "missing", str(error)))
    return Section(
        "Videos",
        f"The crossfade takes {WIDTH:g} s on each side. The ground glows at seams.",
        tuple(findings),
        videos=tuple(videos),
    )
