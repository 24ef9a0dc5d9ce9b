"""The solve: every seam's window re-solved, everything else left as it was.

    minimise  ‖R − R_tar‖² + λ ‖L R − δ_tar‖²                                                       (Eq. 4)

R_tar is the hard cut, δ_tar the second differences of each source among its own neighbours, R the rotation vectors of
all joints in a chart; the ground path is solved on its displacements, height and other translations as positions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import Timeline
from kinestitch.errors import ParameterError
from kinestitch.solve.adaptive import with_automatic
from kinestitch.solve.chart import Chart, check_chart
from kinestitch.solve.placed import Placed, place_timeline, target_window
from kinestitch.solve.seam import clusters
from kinestitch.solve.solved import METHODS, Method, Solved, SolvedWindow, as_motion
from kinestitch.solve.window import solve_window

if TYPE_CHECKING:
    from kinestitch.solve.contacts import Contacts


def stitch(
    timeline: Timeline, clips: Mapping[str, Motion], *, chart: Chart = "centred", method: Method = "laplacian"
) -> Motion:
    """The timeline as one motion whose seams are solved.

    clips : a motion for every key the timeline uses; chart : ``centred`` or ``principal`` (as published)
    method : ``laplacian``, or ``cut`` for the hard cut with the root placed

    Frames further than a seam's window (Eq. 8) from every seam are exactly those of their sources, rigidly placed, and
    what pins of the timeline ask for is met after that.

    Raises MissingClipError, SkeletonMismatchError, RangeError, ParameterError (also for pins that cannot be met).
    """
    _check(chart, method)
    placed = with_automatic(place_timeline(timeline, clips))
    if method == "laplacian":
        return _pinned(solve_placed(placed, chart=chart), placed)[0]
    return _pinned(as_motion(placed, *target_window(placed, 0, placed.frames)), placed)[0]


def solve_placed(placed: Placed, *, chart: Chart = "centred") -> Motion:
    """The seams of a timeline that stands placed solved, every one with the λ that it has there; its pins are not."""
    rotations, translations = target_window(placed, 0, placed.frames)
    _solve_into(placed, rotations, translations, chart)
    return as_motion(placed, rotations, translations)


def solve_timeline(
    timeline: Timeline,
    clips: Mapping[str, Motion],
    *,
    chart: Chart = "centred",
    method: Method = "laplacian",
    foot_lock: bool = False,
) -> Solved:
    """Like :func:`stitch`, with the hard cut and the seams beside the result, for those who measure.

    foot_lock : hold the feet near the seams where they stand in the clips; a rig without feet is left as it is
    """
    _check(chart, method)
    placed = with_automatic(place_timeline(timeline, clips))
    rotations, translations = target_window(placed, 0, placed.frames)
    cut = as_motion(placed, rotations.copy(), translations.copy())
    if method == "cut":
        return _with_pins(Solved(cut, cut, placed, placed.seams, chart, method))
    _solve_into(placed, rotations, translations, chart)
    solved = Solved(as_motion(placed, rotations, translations), cut, placed, placed.seams, chart, method)
    return _with_pins(_with_locked_feet(solved) if foot_lock else solved)


def _with_pins(solved: Solved) -> Solved:
    """The pins met; feet that were locked stand where their path has been taken."""
    if not solved.placed.timeline.pins:
        return solved
    motion, contacts = _pinned(solved.motion, solved.placed, solved.contacts)
    return replace(solved, motion=motion, contacts=contacts, unpinned=solved.motion)


def _pinned(motion: Motion, placed: Placed, contacts: Contacts | None = None) -> tuple[Motion, Contacts | None]:
    if not placed.timeline.pins:
        return motion, contacts
    from kinestitch.solve.pins import pinned

    return pinned(motion, placed, contacts)


def _with_locked_feet(solved: Solved) -> Solved:
    from kinestitch.errors import SkeletonMismatchError
    from kinestitch.solve.footlock import locked

    try:
        found = locked(solved)
    except SkeletonMismatchError:
        return solved
    return replace(solved, motion=found.motion, unlocked=solved.motion, contacts=found.contacts)


def solve_seam(placed: Placed, index: int, *, chart: Chart = "centred") -> SolvedWindow:
    """Only the window around seam `index` of the timeline, at a cost that does not depend on the length of the clip.

    Raises ParameterError if the timeline has no such seam or nothing to solve there.
    """
    check_chart(chart)
    for cluster in clusters(placed.seams, placed.frames, placed.firm):
        if any(seam.index == index for seam in cluster.seams):
            rotations, translations = target_window(placed, cluster.start, cluster.stop)
            solve_window(placed, cluster, rotations, translations, chart)
            return SolvedWindow(cluster.start, cluster.stop, rotations, translations)
    raise ParameterError(
        "Expected a seam between segments that has something to solve "
        f"(0 to {len(placed.timeline.seams) - 1}), got {index}."
    )


def _check(chart: str, method: str) -> None:
    check_chart(chart)
    if method not in METHODS:
        raise ParameterError(f"Expected a method out of {', '.join(METHODS)}, got {method!r}.")


def _solve_into(placed: Placed, rotations: Array, translations: Array, chart: Chart) -> None:
    for cluster in clusters(placed.seams, placed.frames, placed.firm):
        here = slice(cluster.start, cluster.stop)
        solve_window(placed, cluster, rotations[here], translations[here], chart)
