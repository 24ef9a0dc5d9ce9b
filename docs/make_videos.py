"""Make videos of stitched samples, and stills around their seams: ``python docs/make_videos.py [FOLDER]``.

Each shows the hard cut, the solve, and the solve with its feet locked, as bare skeletons on the ground; feet are green
while they stand in their clip. A walk whose path is bent is shown alone, a looped one beside its hard cut. The stills
show the last figure, every second frame.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from make_pictures import pasted_kick, sheet
from matplotlib.image import imsave

import kinestitch as ks
from kinestitch.cli.pictures import pasted_stretches
from kinestitch.edit import Pin, add_pin
from kinestitch.edit.timeline import Timeline
from kinestitch.render.paint import Stretch
from kinestitch.render.video import film, video
from kinestitch.search.replacement import Limits, best_replacement
from kinestitch.search.snap import snap
from kinestitch.solve.contacts import Contacts
from kinestitch.solve.footlock import placed_contacts
from kinestitch.solve.loop import repeated, solve_loop
from kinestitch.solve.loop_feet import lock_loop, loop_contacts

SPEED, STILL, VIEW = 0.5, (384, 480), 60.0
AROUND, EVERY, COLUMNS = 14, 2, 5
"""Frames on each side of a seam that have stills, how far apart those are, and how many stand in a row."""

SPAN, COPIES = (20, 82), 3
"""Frames of the walk that are looped, of which 66.7 make a stride, and the times that they are shown on end."""

Edit = tuple[Timeline, Mapping[str, ks.Motion]]


def clips(*names: str) -> dict[str, ks.Motion]:
    """Samples by name."""
    return {name: ks.sample(name) for name in names}


def run_jump_run() -> Edit:
    """The cheapest jump of more than a second in the middle of a run."""
    found = clips("run", "jump")
    limits = Limits(start=(50, 90), stop=(60, 120), pasted=(70, 150))
    best = best_replacement(found["run"], found["jump"], limits)
    line = ks.timeline(found, "run")
    return ks.replace(line, best.start, best.stop, "jump", best.clip_start, best.clip_stop), found


def walk_punch() -> Edit:
    """A walk that ends in a punch, the cut snapped, its path bent through two places."""
    found = clips("walk", "heavy_punch")
    line = ks.append(ks.delete(ks.timeline(found, "walk"), 130, 201), "heavy_punch", 20)
    line = snap(line, found, 0.2).timeline
    for pin in (Pin("waypoint", 60, (0.35, 1.15)), Pin("waypoint", line.starts[1], (1.1, 2.2))):
        line = add_pin(line, pin)
    return line, found


EDITS: Mapping[str, Callable[[], Edit]] = {
    "walk_kick_walk": pasted_kick,
    "run_jump_run": run_jump_run,
    "walk_punch": walk_punch,
}


Shown = tuple[str, ks.Motion, Contacts]
"""A figure's label, its motion, and when its feet stand."""


def stitched(name: str, edit: Callable[[], Edit], folder: Path) -> None:
    """An edit: its hard cut, the solve, and the solve with its feet locked."""
    line, found = edit()
    loose, locked = (ks.solve_timeline(line, found, foot_lock=lock) for lock in (False, True))
    standing = placed_contacts(loose.placed)
    shown = [
        ("hard cut", loose.cut, standing),
        ("solved", loose.motion, standing),
        ("solved, feet locked", locked.motion, locked.contacts),
    ]
    if line.pins:  # a path of its own wants a camera of its own
        shown = shown[2:]
    save(folder / name, shown, [seam.frame for seam in loose.seams], pasted_stretches(line))


def looped_walk(folder: Path) -> None:
    """A stride but for its last frames, so that there is something to solve, three times on end: cut, and looped."""
    walk = ks.sample("walk")
    cycle = solve_loop(walk, *SPAN)
    found, length = loop_contacts(walk, cycle), len(cycle.span)
    standing = Contacts(found.joints, np.concatenate([found.held] * COPIES + [found.held[:1]]))
    shown = [
        ("hard cut", repeated(cycle.cut, COPIES), standing),
        ("looped", repeated(cycle.motion, COPIES), standing),
        ("looped, feet locked", repeated(lock_loop(walk, cycle).motion, COPIES), standing),
    ]
    save(folder / "looped_walk", shown, [length * copy for copy in range(1, COPIES)], ())


def save(path: Path, shown: Sequence[Shown], seams: Sequence[int], pasted: Sequence[Stretch]) -> None:
    """PATH.mp4 of all figures, and PATH_N.png of the last one for the seam before each frame N."""
    look = {"style": "skeleton", "view": VIEW, "seams": seams}
    labels, motions, contacts = (list(column) for column in zip(*shown, strict=True))
    segments, size = len(shown) * [pasted], (480 * max(len(shown), 2), 540)
    target = path.with_name(f"{path.name}.mp4")
    video(motions, target, labels=labels, segments=segments, contacts=contacts, speed=SPEED, size=size, **look)
    alone = film(motions[-1], labels=[path.name], segments=[pasted], contacts=contacts[-1:], size=STILL, **look)
    for seam in seams:
        frames = range(max(0, seam - AROUND), seam + AROUND + 1, EVERY)
        imsave(path.with_name(f"{path.name}_{seam}.png"), sheet(alone, frames, COLUMNS))
    print(target)


def main() -> None:
    """Make them all."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("videos")
    folder.mkdir(parents=True, exist_ok=True)
    for name, edit in EDITS.items():
        stitched(name, edit, folder)
    looped_walk(folder)


if __name__ == "__main__":
    main()
