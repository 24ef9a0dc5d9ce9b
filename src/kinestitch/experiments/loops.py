"""Loops of real clips: how many keep the gates, as cut, with the gap spread evenly, and solved.

Run as ``python -m kinestitch.experiments.loops FOLDER -o docs/loops.md``. FOLDER holds one folder of clips per data
set. What stands in the document before its section of figures stays.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinestitch.analysis.cycle import GATES, LoopQuality, feet_of, gate_text, loop_quality, with_feet_locked
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_conjugate, quat_multiply, quat_normalize, quat_to_rotvec, rotvec_to_quat
from kinestitch.experiments.seams import DATA_SETS, read_clips
from kinestitch.experiments.tables import table_options, write_page
from kinestitch.rig.carrier import with_local_carrier, with_world_carrier
from kinestitch.search.cycle import Cycle, best_cycle, whole_cycle
from kinestitch.solve.loop import Looped, around_seam, solve_loop
from kinestitch.solve.root import GROUND

HEADING = "## On real clips"
_REPEATS = re.compile(r"(?i)walk|run|dash|idle|strafe")
METHODS = ("cut", "spread", "solved", "solved, feet")


@dataclass(frozen=True, slots=True)
class Row:
    """One clip's cycle in numbers, by method. share : of the clip's frames that the cycle keeps"""

    name: str
    share: float
    numbers: Mapping[str, LoopQuality]


def spread_evenly(motion: Motion, looped: Looped) -> Looped:
    """The rival: what the clip's frame after the last misses of the first one's pose, shared out over all frames alike.

    Half of it goes before the middle and half of it after, for every joint's rotation and translation. The turn and the
    way over the ground stay.
    """
    carrier = looped.carrier
    cut, own = (with_world_carrier(m, carrier) for m in (looped.cut, around_seam(motion, looped.span)))
    gap = quat_to_rotvec(quat_multiply(quat_conjugate(own.rotations[3]), cut.rotations[-1]))
    moved = cut.translations[-1] - own.translations[3]
    moved[carrier, GROUND] = 0.0
    share = (np.arange(cut.frames) / (cut.frames - 1) - 0.5)[:, None, None]
    share[-1] = -0.5  # the next cycle's first frame
    rotations = quat_normalize(quat_multiply(cut.rotations, rotvec_to_quat(share * gap)))
    spread = replace(cut, rotations=rotations, translations=cut.translations + share * moved)
    return replace(looped, motion=with_local_carrier(spread, carrier))


def measured(name: str, motion: Motion, choose: Callable[[Motion], Cycle]) -> Row:
    """A clip's cycle by every method."""
    cycle = choose(motion)
    looped = solve_loop(motion, cycle.start, cycle.stop)
    contacts = feet_of(motion, looped)
    made = (looped, spread_evenly(motion, looped), looped, with_feet_locked(motion, looped))
    numbers = {
        method: loop_quality(each, contacts, before=method == "cut") for method, each in zip(METHODS, made, strict=True)
    }
    return Row(name, cycle.frames / motion.frames, numbers)


def repeats(name: str) -> bool:
    """Whether a clip's name says that it shows something that repeats: a gait or an idle stance."""
    return _REPEATS.search(name) is not None


def kept(rows: Sequence[Row], method: str, gate: str | None = None) -> int:
    """How many cycles keep a gate, or all of them."""
    found = [row.numbers[method] for row in rows]
    return sum(not quality.missed if gate is None else quality.keeps(gate) for quality in found)


def tables(data: Mapping[str, Mapping[str, Motion]]) -> list[str]:
    """The section of figures, line by line."""
    best = {name: [measured(key, clip, best_cycle) for key, clip in clips.items()] for name, clips in data.items()}
    whole = {name: [measured(key, clip, whole_cycle) for key, clip in clips.items()] for name, clips in data.items()}
    lines = [*_INTRODUCTION.splitlines(), "", "### Clips that keep all six gates", ""]
    lines += ["| clips | frames | number | " + " | ".join(METHODS) + " |", "|---|---|---|" + "---|" * len(METHODS)]
    for frames, found in (("best", best), ("all", whole)):
        for name, rows in found.items():
            for kind, chosen in _groups(rows):
                cells = " | ".join(str(kept(chosen, method)) for method in METHODS)
                lines.append(f"| {name}, {kind} | {frames} | {len(chosen)} | {cells} |")
    lines += ["", "### Each gate, best frames, all clips", ""]
    shown = ("cut", "spread", "solved, feet")
    heads = [f"{name}: {method}" for name in best for method in shown]
    lines += ["| gate | at most | " + " | ".join(heads) + " |", "|---|---|" + "---|" * len(heads)]
    for gate, bound in GATES.items():
        cells = " | ".join(f"{kept(rows, method, gate)} of {len(rows)}" for rows in best.values() for method in shown)
        lines.append(f"| `{gate}` | {bound:g} | {cells} |")
    lines += ["", "### Gaits and idle stances, best frames: median / largest", ""]
    lines += ["| measure | " + " | ".join(heads) + " |", "|---|" + "---|" * len(heads)]
    for gate in GATES:
        cells = " | ".join(_spread(_groups(rows)[0][1], method, gate) for rows in best.values() for method in shown)
        lines.append(f"| `{gate}` | {cells} |")
    return [*lines, "", *_shares(best)]


def _groups(rows: Sequence[Row]) -> tuple[tuple[str, list[Row]], ...]:
    gaits = [row for row in rows if repeats(row.name)]
    return ("gaits and idle", gaits), ("other", [row for row in rows if not repeats(row.name)])


def _spread(rows: Sequence[Row], method: str, gate: str) -> str:
    values = np.array([getattr(row.numbers[method], gate) for row in rows])
    return f"{gate_text(gate, float(np.median(values)))} / {gate_text(gate, values.max())}"


def _shares(best: Mapping[str, Sequence[Row]]) -> list[str]:
    out = []
    for name, rows in best.items():
        share = np.array([row.share for row in rows])
        out.append(f"The best frames of {name} are {100 * np.median(share):.0f} % of a clip in the median.")
    return out


_INTRODUCTION = f"""{HEADING}

Made by `python -m kinestitch.experiments.loops`; no figure of this section is typed in. *Cut*: the frames as they are.
*Spread*: what the clip's frame after the last one misses of the first pose is shared out evenly over the cycle.
*Solved*: as above, with the default smoothing time. *Feet*: `kinestitch loop` without an option. *Best* are the frames
that it chooses, *all* those of `--whole`. Gaits and idle stances are the clips with walk, run, dash, strafe or idle in
their names; the others do not repeat by themselves, and some end far from where they began."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure every data set of a folder and write the section."""
    chosen = table_options(__doc__, seams=None).parse_args(arguments)
    lines = tables({name: read_clips(chosen.folder / name) for name in DATA_SETS})
    old = chosen.output.read_text(encoding="utf-8") if chosen.output.exists() else ""
    text = old.partition(HEADING)[0] + "\n".join(lines) + "\n"
    write_page(chosen.output, text)


if __name__ == "__main__":
    main()
