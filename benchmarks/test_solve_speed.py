"""The seam form beside the dense solve, the full banded solve and a crossfade: 65 joints, 1,000 frames, two seams."""

import subprocess
import sys
from time import perf_counter

import numpy as np
import pytest
from scipy.linalg import solveh_banded

from kinestitch.analysis.quality import solve_proper
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.solve.laplacian import normal_bands, row_stiffness, solve_full
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.rivals import crossfade
from kinestitch.solve.seam import visible_reach
from kinestitch.solve.stitch import solve_seam, solve_timeline, stitch
from kinestitch.testing import random_motion

JOINTS, FRAMES = 65, 1000
STIFFNESS = (81.0, 1296.0)


def two_seams(stiffness: float, frames: int = FRAMES) -> tuple[Timeline, dict]:
    """A replacement of 200 frames in the middle of a clip."""
    clips = {key: random_motion(seed, joints=JOINTS, frames=frames, fps=60.0) for seed, key in enumerate("ab")}
    middle = frames // 2
    segments = (
        Segment("a", FrameRange(0, middle - 100)),
        Segment("b", FrameRange(100, 300)),
        Segment("a", FrameRange(middle + 100, frames)),
    )
    infos = tuple(ClipInfo(key, frames, 60.0) for key in clips)
    return Timeline(infos, segments, (Seam(stiffness), Seam(stiffness)), 60.0), clips


@pytest.fixture(scope="module", params=STIFFNESS)
def case(request):
    timeline, clips = two_seams(request.param)
    rng = np.random.default_rng(0)
    return request.param, timeline, clips, rng.normal(size=(FRAMES, 3 * JOINTS)), rng.normal(size=(FRAMES, 3 * JOINTS))


def banded(stiffness, target):
    """SciPy's banded Cholesky solve alone, of all frames and channels; bands and right-hand side stand ready."""
    bands, rhs = normal_bands(row_stiffness(stiffness, FRAMES)), np.asfortranarray(target)
    return lambda: solveh_banded(bands, rhs, check_finite=False)


def test_solve_proper_against_full_banded(case, compare):
    stiffness, timeline, clips, target, _ = case
    run = solve_proper(solve_timeline(timeline, clips))
    compare(
        f"seam form, λ = {stiffness:g}", run, "SciPy solveh_banded, whole clip", banded(stiffness, target), "≤ 0.17"
    )


def test_full_banded_against_dense(case, compare):
    stiffness, _, _, target, delta = case
    second = np.diff(np.eye(FRAMES), 2, axis=0)
    matrix = np.eye(FRAMES) + stiffness * second.T @ second
    compare(
        f"full banded solve with its right-hand side, λ = {stiffness:g}",
        lambda: solve_full(target, delta, stiffness),
        "dense NumPy solve",
        lambda: np.linalg.solve(matrix, target),
        "< 1",
        repeats=5,
    )


def test_stitch_as_called(case, compare):
    stiffness, timeline, clips, target, _ = case
    what = f"stitch() of two seams as called, λ = {stiffness:g}"
    compare(
        what, lambda: stitch(timeline, clips), "SciPy solveh_banded, whole clip", banded(stiffness, target), "≤ 1.5"
    )


def test_stitch_against_crossfade(case, compare):
    stiffness, timeline, clips, _, _ = case
    reach = visible_reach(stiffness)
    compare(
        f"stitch() of two seams as called, λ = {stiffness:g}",
        lambda: stitch(timeline, clips),
        f"slerp crossfade over {reach} frames each side",
        lambda: crossfade(place_timeline(timeline, clips), reach),
        "none",
    )


def test_one_seam_of_a_long_timeline(compare, quick):
    long = 20_000 if quick else 1_000_000
    rows = np.arange(long) % FRAMES
    timeline, clips = two_seams(1296.0)
    tiled = {}
    for key, clip in clips.items():
        from dataclasses import replace

        tiled[key] = replace(clip, rotations=clip.rotations[rows], translations=clip.translations[rows])
    info = tuple(ClipInfo(key, long, 60.0) for key in tiled)
    middle = long // 2 + 400
    segments = (
        Segment("a", FrameRange(0, middle)),
        Segment("b", FrameRange(100, 300)),
        Segment("a", FrameRange(middle + 200, long)),
    )
    far = place_timeline(Timeline(info, segments, timeline.seams, 60.0), tiled)
    near = place_timeline(timeline, clips)
    what = f"re-solving one seam of {long:,} frames"
    compare(what, lambda: solve_seam(far, 0), "the same at 1,000 frames", lambda: solve_seam(near, 0), "≤ 2")


def run_python(code: str) -> float:
    start = perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return perf_counter() - start


def test_import_against_numpy(compare):
    compare(
        "import kinestitch, whole interpreter",
        lambda: run_python("import kinestitch"),
        "import numpy, whole interpreter",
        lambda: run_python("import numpy"),
        "≤ 1.4",
        repeats=7,
    )
    compare(
        "the front door's solver imported: kinestitch.stitch",
        lambda: run_python("import kinestitch; kinestitch.stitch"),
        "import numpy, whole interpreter",
        lambda: run_python("import numpy"),
        "none",
        repeats=7,
    )
