"""Experiments 3 and 4: actions of another kind pasted into a walk, and where the body goes meanwhile."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch import files
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit import append, insert
from kinestitch.edit.timeline import timeline
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.page import Finding, Picture, Section, Table, panels, picture, rows_of
from kinestitch.render.filmstrip import filmstrip_figure
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.seam import seam_reach
from kinestitch.solve.solved import Solved
from kinestitch.solve.stitch import solve_timeline

WALK, ACTIONS = ("Walking", "walk"), (("Jumping", "jump"), ("Kicking", "kick"))
RUN, JACKS = ("Running", "run"), ("Jumping Jacks", "jumping_jacks")


JUMP_ON_THE_SPOT = "mixamo_ybot_60fps/Jumping.fbx"
"""The first rig's own jumps climb or fall by a metre; this one lands where it left, on a rig of other bone lengths."""


def with_jump(data: DataSet) -> DataSet:
    """The data set with one more clip, a jump on the spot, where the folder has it."""
    extra = None if data.place is None else data.place / JUMP_ON_THE_SPOT
    if extra is None or not extra.is_file() or data.name != "mixamo":
        return data
    return replace(data, clips={"Jumping": files.read(extra), **data.clips})


def _pick(data: DataSet, *wishes: tuple[str, str]) -> tuple[str, ...]:
    return data.find(*(real if data.real else made for real, made in wishes))


def joined(data: DataSet, *wishes: tuple[str, str]) -> Solved:
    """Whole clips one after the other."""
    data = with_jump(data)
    keys = _pick(data, *wishes)
    line = timeline({key: data.clips[key] for key in dict.fromkeys(keys)}, keys[0])
    for key in keys[1:]:
        line = append(line, key)
    return solve_timeline(line, data.clips)


def inserted(data: DataSet) -> Solved:
    """A walk with a jump and a kick inserted."""
    data = with_jump(data)
    walk, jump, kick = _pick(data, WALK, *ACTIONS)
    line = timeline({key: data.clips[key] for key in dict.fromkeys((walk, jump, kick))}, walk)
    frames = data.clips[walk].frames
    line = insert(line, 2 * frames // 3, kick)
    line = insert(line, frames // 3, jump)
    return solve_timeline(line, data.clips)


def _filmstrip(solved: Solved, rows: list[Motion], labels: list[str], caption: str, own: bool) -> Picture:
    starts = solved.placed.starts
    marks: list[tuple[int, ...]] = [() for _ in rows]
    tints: list[tuple] = [() for _ in rows]
    marks[-1] = tuple(seam.frame for seam in solved.seams)
    base = solved.placed.timeline.segments[0].clip
    tints[-1] = tuple(
        (starts[i], starts[i + 1], segment.clip)
        for i, segment in enumerate(solved.placed.timeline.segments)
        if segment.clip != base
    )
    drawing = filmstrip_figure(rows, labels=labels, marks=marks, segments=tints, poses=13)
    return picture(drawing, caption, own=own)


def cross_category(data: DataSet) -> Section:
    """Walking into jumping jacks; a walk with a jump and a kick inserted, as base, inserted and integrated rows."""
    jacks, mixed = joined(data, WALK, JACKS), inserted(data)
    data = with_jump(data)
    walk, jump, kick = _pick(data, WALK, *ACTIONS)
    own = not data.real
    clips = [data.clips[key] for key in (walk, jump, kick)]
    return Section(
        "Across categories",
        "Actions of another kind pasted into a walk. Upper rows: the sources. Last row: the result, seams dashed, "
        "pasted frames tinted.",
        (),
        (
            _filmstrip(
                jacks, [data.clips[walk], jacks.motion], [walk, "walk, then jumping jacks"], "Walk to jacks.", own
            ),
            _filmstrip(
                mixed, [*clips, mixed.motion], [walk, jump, kick, "integrated"], "A jump and a kick inserted.", own
            ),
        ),
    )


def ground_path(motion: Motion) -> Array:
    """The hips' position (F, 3) m in the world."""
    joint = hips_joint(motion.skeleton)
    return world_pose(motion, [joint]).positions[:, joint]


def absolute_path(solved: Solved) -> Array:
    """The path (F, 3) m where every clip keeps its own place in the world, cut hard."""
    parts = []
    for segment in solved.placed.timeline.segments:
        source = solved.placed.sources[segment.clip]
        parts.append(source.translations[segment.range.start : segment.range.stop, solved.placed.carrier])
    return np.concatenate(parts)


def _drawn(name: str, solved: Solved, path: Array, other: Array, own: bool) -> Picture:
    drawing, (above, speed) = panels(1, 2, size=(9.0, 3.2))
    above.plot(path[:, 0], path[:, 2], color="#0072B2", label="relative (ours)")
    above.plot(other[:, 0], other[:, 2], color="#D55E00", linewidth=0.9, linestyle="--", label="absolute")
    above.set_aspect("equal", adjustable="datalim")
    above.set_xlabel("x (m)")
    above.set_ylabel("z (m)")
    above.legend(frameon=False)
    above.set_title(name, loc="left")
    speed.plot(np.linalg.norm(np.diff(path, axis=0), axis=1) * solved.motion.fps, color="#0072B2")
    for seam in solved.seams:
        speed.axvline(seam.frame - 0.5, color="#CC79A7", linestyle="--", linewidth=1)
    speed.set_xlabel("frame")
    speed.set_ylabel("speed of the hips (m/s)")
    return picture(drawing, f"{name}: from above, and speed.", own=own)


def _steps(solved: Solved, path: Array, other: Array) -> tuple[float, float, float, float, float]:
    """At the seams (cm), the clips' own largest (cm), their ratio, the largest with absolute places (cm), error (m)."""
    step, jump = (np.linalg.norm(np.diff(p, axis=0), axis=1) for p in (path, other))
    sources = [solved.placed.sources[segment.clip] for segment in solved.placed.timeline.segments]
    moves = [np.diff(source.translations[:, solved.placed.carrier], axis=0) for source in sources]
    own = max(float(np.linalg.norm(move, axis=1).max()) for move in moves)
    worst = max(float(step[seam.frame - 1]) for seam in solved.seams)
    return 100 * worst, 100 * own, worst / own, 100 * float(jump.max()), _rigid_error(solved)


def root_path(data: DataSet) -> Section:
    """Path from above and speed over time, relative and absolute; a run and a walk into actions with real travel."""
    rows: list[tuple] = []
    pictures = []
    for name, wishes in (
        ("walk → jump → walk", (WALK, ACTIONS[0], WALK)),
        ("run → kick → run", (RUN, ACTIONS[1], RUN)),
    ):
        solved = joined(data, *wishes)
        path, other = ground_path(solved.motion), absolute_path(solved)
        rows.append((name, *_steps(solved, path, other)))
        pictures.append(_drawn(name, solved, path, other, not data.real))
    largest = max(row[3] for row in rows)
    finding = Finding(
        "The root continues by relative displacement.",
        "reproduced" if largest <= 1.1 else "reproduced with limits",
        f"the step at a seam is at most {largest:.2f} of the clips' own largest; with absolute positions the hips jump "
        f"by up to {max(row[4] for row in rows):.0f} cm",
    )
    head = ("edit", "at the seam cm", "clips' largest cm", "ratio", "absolute: largest cm", "away from seams m")
    return Section(
        "Root translation",
        "The pasted segment is turned and moved so that it goes on from where the body is; its ground path is solved "
        "on displacements. Away from the seam the path is exactly the rigidly placed one.",
        (finding,),
        tuple(pictures),
        (Table("Steps of the hips.", head, rows_of(rows)),),
        numbers={"root_step_ratio": round(float(largest), 3)},
    )


def _rigid_error(solved: Solved) -> float:
    """Largest distance in m from the rigidly placed path, outside all windows; 0 where there is no such frame."""
    away = np.ones(solved.placed.frames, dtype=bool)
    for seam in solved.seams:
        reach = seam_reach(seam.stiffness)
        away[max(0, seam.frame - reach) : seam.frame + reach] = False
    gap = np.linalg.norm(ground_path(solved.motion) - ground_path(solved.cut), axis=1)
    return float(gap[away].max()) if away.any() else 0.0
