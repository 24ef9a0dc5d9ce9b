"""Asks Blender to blend both sources of a seam by its non-linear animation; our side of ``blender_side``."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_continuous, quat_multiply, quat_normalize
from kinestitch.edit.timeline import Timeline
from kinestitch.errors import KinestitchError
from kinestitch.experiments import blender_side
from kinestitch.solve.placed import Placed, target_window
from kinestitch.solve.rivals.blends import own_poses
from kinestitch.solve.rivals.gap import rooms
from kinestitch.solve.solved import as_motion

VARIABLE = "KINESTITCH_BLENDER"
DEFAULT = Path(".venv-bpy/bin/python")
WIDTHS = (2, 5, 10, 20, 30, 60)
"""Frames on each side of a seam."""

Mode = Literal["matched", "keyed", "fade", "combine"]
MODES: Mapping[Mode, tuple[str, bool]] = {
    "matched": ("replace", True),
    "keyed": ("replace", False),
    "fade": ("fade", False),
    "combine": ("combine", False),
}
"""What Blender is told, and whether the signs of the right source's quaternions are chosen for the shorter way."""


class NoBlenderError(KinestitchError):
    """There is no Python with Blender in it, or Blender could not do what was asked."""


@dataclass(frozen=True, eq=False, slots=True)
class Blended:
    """Blender's results by timeline, width and mode, as motions; and which Blender it was.

    turned : per timeline, joints whose quaternions as keyed point to different sides at the seam
    auto : how much of an overlap Blender's automatic blending lets the left strip fade out and the right one fade in
    """

    version: str
    motions: Mapping[tuple[Timeline, int, Mode], Motion]
    turned: Mapping[Timeline, int]
    auto: tuple[float, float]


def blender_python() -> Path:
    """The Python that can ``import bpy``: the environment variable's, or ``.venv-bpy`` in the current folder.

    Raises NoBlenderError, saying what to set, where there is none.
    """
    chosen = Path(os.environ.get(VARIABLE) or DEFAULT)
    if not chosen.is_file():
        raise NoBlenderError(
            f"Expected a Python that can import bpy, got none. Run `make setup-blender` or set {VARIABLE}. ({chosen})"
        )
    return chosen


def blend(wanted: Mapping[Mode, Sequence[Placed]], widths: Sequence[int] = WIDTHS) -> Blended:
    """Let Blender join the sources of timelines of one seam each, at every width, in one process.

    wanted : by mode, the timelines to be joined so

    The overlap is centred on the seam as :func:`kinestitch.solve.rivals.crossfade` has it, with the same weights; both
    sources run on under each other, and one that ends holds its last pose.

    Raises NoBlenderError where Blender is missing or fails.
    """
    python = blender_python()
    skeleton = next(iter(wanted.values()))[0].skeleton
    request = {"parents": np.array(skeleton.parents), "offsets": skeleton.offsets}
    jobs: list[dict[str, object]] = []
    keys: list[tuple[Placed, int, Mode]] = []
    turned: dict[Timeline, int] = {}
    rows = {one.timeline: _rows(one, max(widths)) for some in wanted.values() for one in some}
    numbers = {line: number for number, line in enumerate(rows)}
    for mode, some in wanted.items():
        told, matched = MODES[mode]
        for one in some:
            left, right, signs = rows[one.timeline]
            turned[one.timeline] = int((signs < 0).sum())
            if matched:
                right = np.concatenate([right[..., :4] * signs[:, None], right[..., 4:]], axis=-1)
            pair = f"{numbers[one.timeline]}_{matched:d}"
            request[f"left_{pair}"], request[f"right_{pair}"] = left, right
            for width in widths:
                jobs.append({"pair": pair, "reach": _reach(one, width), "mode": told})
                keys.append((one, width, mode))
    answer = _ask(python, {**request, "jobs": np.array(json.dumps(jobs))})
    motions = {
        (one.timeline, width, mode): _motion(one, _reach(one, width), answer[f"job_{number}"])
        for number, (one, width, mode) in enumerate(keys)
    }
    out, into = answer["auto"]
    return Blended(str(answer["version"]), motions, turned, (float(out), float(into)))


def _ask(python: Path, request: Mapping[str, Array]) -> dict[str, Array]:
    with tempfile.TemporaryDirectory() as folder:
        asked, answered = Path(folder) / "request.npz", Path(folder) / "answer.npz"
        np.savez(asked, **request)  # type: ignore[arg-type, unused-ignore]
        command = [str(python), str(Path(blender_side.__file__)), str(asked), str(answered)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise NoBlenderError(f"Expected an answer from Blender, got {error}. ({python})") from error
        if done.returncode != 0 or not answered.exists():
            last = (done.stderr.strip().splitlines() or ["nothing"])[-1]
            raise NoBlenderError(f"Expected an answer from Blender, got {last!r}. Set {VARIABLE}. ({python})")
        with np.load(answered) as found:
            return dict(found)


def _reach(placed: Placed, width: int) -> int:
    ((_, before, after),) = rooms(placed)
    return max(1, min(width, before, after))


def _rows(placed: Placed, widest: int) -> tuple[Array, Array, Array]:
    """Both sources around the seam, (n, J, 7) each, n = 2 R + 2, every source's quaternions continuous from w ≥ 0 at
    its first frame on; and the signs (J,) that turn the right ones to the left ones' side at the seam.
    """
    (seam,) = placed.seams
    reach = _reach(placed, widest)
    frames = np.arange(-reach - 1, reach + 1)
    sides = []
    for index in (seam.index, seam.index + 1):
        segment = placed.timeline.segments[index]
        at = segment.range.stop if index == seam.index else segment.range.start
        source = placed.sources[segment.clip]
        rotations, translations = own_poses(placed, index, np.arange(source.frames))
        keyed = quat_continuous(quat_multiply(quat_conjugate(placed.skeleton.rest), rotations))
        keyed *= np.where(keyed[0, :, 3:] < 0, -1.0, 1.0)
        rows = np.concatenate([keyed[..., [3, 0, 1, 2]], translations - placed.skeleton.offsets], axis=-1)
        sides.append(rows[np.clip(at + frames, 0, source.frames - 1)])
    left, right = sides
    here = slice(reach, reach + 2)
    products = np.einsum("fji,fji->j", left[here, :, :4], right[here, :, :4])
    return left, right, np.where(products < 0, -1.0, 1.0)


def _motion(placed: Placed, reach: int, rows: Array) -> Motion:
    """Blender's rows of frames [m − reach − 1, m + reach] put into the hard cut, the outer two left out."""
    (seam,) = placed.seams
    rotations, translations = target_window(placed, 0, placed.frames)
    here = slice(seam.frame - reach, seam.frame + reach)
    basis = quat_normalize(rows[1:-1][..., [1, 2, 3, 0]])
    rotations[here] = quat_multiply(placed.skeleton.rest, basis)
    translations[here] = placed.skeleton.offsets + rows[1:-1, :, 4:]
    return as_motion(placed, rotations, translations)
