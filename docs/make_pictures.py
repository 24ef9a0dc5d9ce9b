"""Draw the documents' pictures from the samples: ``python docs/make_pictures.py [FOLDER]``."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import kinestitch as ks
from kinestitch.analysis.plots import plot_costs, plot_joint, save_figure
from kinestitch.cli.demo import CUT, PASTED
from kinestitch.core.kinematics import world_pose
from kinestitch.core.retime import time_map
from kinestitch.core.rotation import quat_conjugate, quat_multiply, quat_to_rotvec
from kinestitch.edit import DEFAULT_SMOOTHING, Pin, Timeline, add_pin
from kinestitch.experiments.adaptive import study
from kinestitch.render.filmstrip import filmstrip
from kinestitch.render.paint import Stretch
from kinestitch.render.video import Film, film, pictures
from kinestitch.samples import SAMPLE_NAMES
from kinestitch.search.align import align_phase
from kinestitch.search.cycle import best_cycle, whole_cycle
from kinestitch.search.price import best_cuts, price_map
from kinestitch.search.warp import warp_steps
from kinestitch.solve.adaptive import with_automatic
from kinestitch.solve.contacts import find_contacts, legs_of, runs
from kinestitch.solve.footlock import locked, placed_contacts
from kinestitch.solve.loop import solve_loop
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.rivals import crossfade
from kinestitch.solve.seam import Cluster, SeamPlace, seam_curves, visible_reach

SPANS = (81.0, 1296.0, 10_000.0)
COLOURS = ("#0072B2", "#D55E00", "#009E73")


def pasted_kick() -> tuple[Timeline, dict[str, ks.Motion]]:
    """The demo's edit: a kick in place of some steps of a walk."""
    clips = {name: ks.sample(name) for name in ("walk", "kick")}
    return ks.replace(ks.timeline(clips, "walk"), *CUT, "kick", *PASTED), clips


def hero(folder: Path) -> None:
    """Walk, kick, and the walk with the kick pasted in."""
    line, clips = pasted_kick()
    motion = ks.solve_timeline(line, clips, foot_lock=True).motion
    first, second = line.starts[1:3]
    filmstrip(
        [clips["walk"], clips["kick"], motion],
        folder / "walk_kick.png",
        poses=15,
        labels=["walk", "kick", "walk with the kick pasted in"],
        marks=[(), (), (first, second)],
        segments=[(), (), [(first, second, "kick")]],
    )


def joint_curve(folder: Path) -> None:
    """The kicking leg before and after."""
    line, clips = pasted_kick()
    solved = ks.solve_timeline(line, clips)
    seams = [seam.frame for seam in solved.seams]
    plot_joint(solved.motion, "mixamorig:RightUpLeg", folder / "joint.png", before=solved.cut, seams=seams)


def all_samples(folder: Path) -> None:
    """The eight clips that are made by code."""
    filmstrip([ks.sample(name) for name in SAMPLE_NAMES], folder / "samples.png", labels=list(SAMPLE_NAMES))


def moving(folder: Path) -> None:
    """One picture of the demo's video, just after the first seam."""
    from matplotlib.image import imsave

    line, clips = pasted_kick()
    solved = ks.solve_timeline(line, clips, foot_lock=True)
    first, second = line.starts[1:3]
    standing = placed_contacts(solved.placed)
    made = film(
        [solved.cut, crossfade(solved.placed, 12), solved.motion],
        labels=["hard cut", "crossfade 0.4 s", "walk_kick"],
        seams=[first, second],
        segments=[[Stretch(first, second, f"kick {PASTED[0]}–{PASTED[1] - 1}")]] * 3,
        contacts=[standing, standing, solved.contacts or standing],
    )
    for frame, picture in enumerate(pictures(made)):
        if frame == first + 4:
            imsave(folder / "video.png", picture)
            return


def sheet(made: Film, frames: Sequence[int], columns: int) -> np.ndarray:
    """Pictures of a film that shows every frame, `columns` in a row: (height, width, 4) RGBA."""
    kept = [picture.copy() for number, picture in enumerate(pictures(made)) if number in frames]
    kept += [np.full_like(kept[0], 255)] * (-len(kept) % columns)
    return np.concatenate([np.concatenate(kept[i : i + columns], axis=1) for i in range(0, len(kept), columns)])


def around_a_seam(folder: Path) -> None:
    """Stills of the demo's first seam: the left foot stands through it."""
    from matplotlib.image import imsave

    line, clips = pasted_kick()
    solved = ks.solve_timeline(line, clips, foot_lock=True)
    seam = line.starts[1]
    look = {"style": "skeleton", "view": 60.0, "size": (230, 360), "seams": [seam], "labels": [""]}
    made = film(solved.motion, contacts=[solved.contacts], **look)
    imsave(folder / "stills.png", sheet(made, range(seam - 10, seam + 14, 4), 6))


def curves(folder: Path) -> None:
    """How a gap of 1 at a seam is shared out in time, for three λ."""
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    axes = figure.subplots()
    axes.spines[["top", "right"]].set_visible(False)
    for stiffness, colour in zip(SPANS, COLOURS, strict=True):
        share = seam_curves(Cluster(0, 1000, (SeamPlace(0, 500, stiffness),))).sum(axis=1)
        for frames, label in ((np.arange(-80, 0), f"λ = {stiffness:,g}"), (np.arange(80), None)):
            axes.plot(frames + 0.5, share[frames + 500], color=colour, marker=".", markersize=3, label=label)
        for side in (-visible_reach(stiffness), visible_reach(stiffness)):
            axes.axvline(side, color=colour, linewidth=0.8, linestyle=":")
    axes.set_xlabel("frames from the seam (dotted: visible reach, beyond it less than 5 % is left)")
    axes.set_ylabel("correction for a gap of 1")
    axes.legend(frameon=False)
    save_figure(figure, folder / "curves.png")


def cuts(folder: Path) -> None:
    """What every cut from the walk into the kick costs, and the five best."""
    prices = price_map(ks.sample("walk"), ks.sample("kick"))
    places = [(cut.out, cut.into) for cut in best_cuts(prices, 5, exact=True)]
    plot_costs(prices.costs, folder / "cuts.png", cuts=places, names=("walk", "kick"), standing=prices.standing)


def feet(folder: Path) -> None:
    """How fast the toes move over the ground before and after locking, and when they stand."""
    line, clips = pasted_kick()
    solved = ks.solve_timeline(line, clips)
    after = locked(solved)
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    for axes, leg, side in zip(panels, legs_of(solved.motion.skeleton), ("left", "right"), strict=True):
        axes.spines[["top", "right"]].set_visible(False)
        for motion, label, colour in ((solved.motion, "solved", "#999999"), (after.motion, "locked", COLOURS[0])):
            places = world_pose(motion).positions[:, leg.toe][:, (0, 2)]
            speed = np.linalg.norm(np.diff(places, axis=0), axis=-1) * motion.fps
            axes.plot(np.arange(1, motion.frames), speed, color=colour, label=label)
        for start, stop in runs(after.contacts.of(leg.foot, leg.toe)):
            axes.plot([start, stop - 1], [-0.15, -0.15], color=COLOURS[2], linewidth=4, solid_capstyle="butt")
        for seam in solved.seams:
            axes.axvline(seam.frame - 0.5, color="#882255", linewidth=0.8, linestyle="--")
        axes.set_ylabel(f"{side} toe (m/s)")
        axes.set_ylim(-0.3, 3.0)
    panels[0].legend(frameon=False, loc="upper right", ncols=2)
    panels[1].set_xlabel("frame (dashed: seams; green: the foot stands)")
    save_figure(figure, folder / "feet.png")


def steps(folder: Path) -> None:
    """When the feet stand around a walk that becomes a run, as cut and aligned; and how fast clips play when warped."""
    clips = {name: ks.sample(name) for name in ("walk", "run")}

    def cut(out: int, into: int) -> Timeline:
        return ks.append(ks.delete(ks.timeline(clips, "walk"), out, clips["walk"].frames), "run", into)

    figure = Figure(figsize=(8.0, 4.6), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True, height_ratios=(2, 2, 3))
    lines = {"as cut": cut(110, 40), "steps aligned": align_phase(cut(110, 40), clips, 0.3).timeline}
    for axes, (label, line) in zip(panels, lines.items(), strict=False):
        motion = ks.solve_timeline(line, clips, foot_lock=True).motion
        found = find_contacts(motion)
        for row, leg in enumerate(legs_of(motion.skeleton)):
            for start, stop in runs(found.of(leg.foot, leg.toe)):
                times = (np.array([start, stop - 1]) - line.starts[1]) / line.fps
                axes.plot(times, [row, row], color=COLOURS[row], linewidth=8, solid_capstyle="butt")
        axes.set(ylim=(-0.6, 1.6), yticks=(0, 1), yticklabels=("left", "right"), title=label)
    _plot_speeds(panels[2], warp_steps(cut(90, 50), clips, 0.2).timeline)
    for axes in panels:
        axes.spines[["top", "right"]].set_visible(False)
        axes.axvline(0.0, color="#882255", linewidth=0.8, linestyle="--")
    panels[2].set(xlim=(-1.4, 1.4), xlabel="s from the seam (bars: a foot stands)", ylabel="speed")
    panels[2].set_title("another cut, time bent within 0.2")
    panels[2].legend(frameon=False)
    save_figure(figure, folder / "steps.png")


def _plot_speeds(axes: Axes, line: Timeline) -> None:
    for segment, start, colour in zip(line.segments, line.starts, COLOURS[::2], strict=False):
        info = line.clip(segment.clip)
        times = np.arange(segment.range.start, segment.range.stop) / line.fps
        speed = np.diff(times if info.retiming is None else time_map(info.retiming.knots, times)) * line.fps
        axes.plot((np.arange(len(speed)) + 0.5 + start - line.starts[1]) / line.fps, speed, color=colour)
        axes.plot([], [], color=colour, label=info.source)


def auto(folder: Path) -> None:
    """How long each part of the body may take at the demo's two seams, and both rules on random cuts of the samples."""
    line, clips = pasted_kick()
    line = replace(line, seams=(ks.Seam(automatic=True),) * len(line.seams))
    placed = with_automatic(place_timeline(line, clips))
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    bars, curves = figure.subplots(1, 2)
    rows = np.arange(len(placed.groups))
    for number, (seam, colour) in enumerate(zip(placed.seams, COLOURS, strict=False)):
        times = [group.stiffness[number] ** 0.25 / line.fps for group in placed.groups]
        bars.barh(rows + 0.36 * number - 0.18, times, height=0.34, color=colour, label=f"seam at frame {seam.frame}")
    bars.axvline(DEFAULT_SMOOTHING, color="#666666", linewidth=0.9, linestyle="--")
    bars.set_yticks(rows, [group.name.replace("_", " ") for group in placed.groups])
    bars.invert_yaxis()
    bars.set_xlabel("smoothing time (s); dashed: the default of a fixed one")
    found = study({name: ks.sample(name, fps=30.0) for name in SAMPLE_NAMES}, "samples", seams=60).curves
    shown = {"fixed": "one time for all seams", "auto, whole body": "--auto, body as one", "auto, by parts": "--auto"}
    for (rule, label), colour in zip(shown.items(), ("#999999", COLOURS[1], COLOURS[0]), strict=True):
        added, moved = found[rule].percentile("added", 95.0), found[rule].values["deviation"].mean(axis=1)
        curves.loglog(added, moved, color=colour, marker="o", markersize=4, label=label)
    curves.set_xlabel("added acceleration, 95th percentile")
    curves.set_ylabel("mean deviation (°)")
    for axis, ticks in ((curves.xaxis, (0.1, 1.0, 10.0)), (curves.yaxis, (0.5, 1.0, 2.0, 4.0))):
        axis.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.set_ticks([], minor=True)
    for axes in (bars, curves):
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False)
    save_figure(figure, folder / "auto.png")


def loops(folder: Path) -> None:
    """A thigh over three cycles of a walk that is cut in the middle of a stride, and of its best frames."""
    walk = ks.sample("walk")
    clip = replace(walk, rotations=walk.rotations[11:160], translations=walk.translations[11:160])
    joint = clip.skeleton.index("mixamorig:LeftUpLeg")
    figure = Figure(figsize=(8.0, 4.4), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    for axes, cycle, label in zip(
        panels, (whole_cycle(clip), best_cycle(clip)), ("all frames", "best frames"), strict=True
    ):
        axes.spines[["top", "right"]].set_visible(False)
        looped = solve_loop(clip, cycle.start, cycle.stop)
        for motion, name, colour in ((looped.cut, "as they are", "#999999"), (looped.motion, "solved", COLOURS[0])):
            turned = quat_to_rotvec(
                quat_multiply(quat_conjugate(clip.skeleton.rest[joint]), motion.rotations[:-1, joint])
            )
            axes.plot(np.degrees(np.tile(turned[:, 0], 3)), color=colour, label=name)
        for copy in (1, 2):
            axes.axvline(copy * cycle.frames - 0.5, color="#882255", linewidth=0.8, linestyle="--")
        axes.set_ylabel(f"{label} {cycle.start}:{cycle.stop}\nleft thigh, about x (°)")
    panels[0].set_ylim(-42, 24)
    panels[0].legend(frameon=False, loc="upper right", ncols=2)
    panels[1].set_xlabel("frame (dashed: where a cycle ends and the next begins)")
    save_figure(figure, folder / "loops.png")


WAYPOINTS = (Pin("waypoint", 100, (0.8, 1.7)), Pin("waypoint", 200, (0.0, 3.3)))
HAND = Pin("position", 130, (0.35, 1.6, 2.95), "LeftHand")


def waypoints(folder: Path) -> None:
    """A walk's path from above, straight and bent, with the feet that stand."""
    clips = {"walk": ks.sample("walk")}
    line = ks.timeline(clips, "walk")
    bent = line
    for pin in WAYPOINTS:
        bent = add_pin(bent, pin)
    figure = Figure(figsize=(8.0, 2.9), layout="constrained")
    axes = figure.subplots()
    axes.spines[["top", "right"]].set_visible(False)
    for edit, label, colour in ((line, "as it was", "#999999"), (bent, "through two waypoints", COLOURS[0])):
        solved = ks.solve_timeline(edit, clips, foot_lock=True)
        places = world_pose(solved.motion).positions
        axes.plot(places[:, 0, 2], places[:, 0, 0], color=colour, label=label)
        for leg in legs_of(solved.motion.skeleton):
            for start, stop in runs(solved.contacts.of(leg.foot, leg.toe)):
                for frame in range(start, stop):
                    foot = places[frame, [leg.foot, leg.toe]]
                    axes.plot(foot[:, 2], foot[:, 0], color=colour, linewidth=4, alpha=0.12, solid_capstyle="round")
    for pin in WAYPOINTS:
        axes.plot(pin.target[1], pin.target[0], "o", color=COLOURS[1], markersize=7)
        axes.annotate(f"frame {pin.frame}", pin.target[::-1], xytext=(8, 4), textcoords="offset points")
    axes.set_aspect("equal")
    axes.margins(y=0.2)
    axes.set_xlabel("z (m), from above")
    axes.set_ylabel("x (m)")
    axes.legend(frameon=False, loc="upper right")
    save_figure(figure, folder / "waypoints.png")


def hand(folder: Path) -> None:
    """A hand that has to be somewhere in one frame."""
    clips = {"walk": ks.sample("walk")}
    line = ks.timeline(clips, "walk")
    filmstrip(
        [clips["walk"], ks.stitch(add_pin(line, HAND), clips)],
        folder / "hand.png",
        poses=list(range(100, 161, 5)),
        labels=["walk", f"the left hand pinned in frame {HAND.frame}"],
        marks=[(), (HAND.frame,)],
    )


def main() -> None:
    """Draw them all."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    seams = (hero, joint_curve, all_samples, moving, around_a_seam, curves, cuts, feet, steps, auto, loops)
    for draw in (*seams, waypoints, hand):
        draw(folder)


if __name__ == "__main__":
    main()
