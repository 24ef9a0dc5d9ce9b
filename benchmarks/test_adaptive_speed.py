"""What choosing λ costs beside the solve itself: the samples' walk with the kick pasted in, two seams, five parts."""

from dataclasses import replace

import pytest

import kinestitch as ks
from kinestitch.solve.adaptive import with_automatic
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.stitch import solve_timeline


@pytest.fixture(scope="module")
def case():
    clips = {name: ks.sample(name) for name in ("walk", "kick")}
    plain = ks.replace(ks.timeline(clips, "walk"), 84, 130, "kick", 30, 112, seam=ks.Seam())
    return plain, replace(plain, seams=(ks.Seam(automatic=True),) * 2), clips


def test_automatic_seams_against_plain_ones(case, compare):
    plain, automatic, clips = case
    compare(
        "solve_timeline of two automatic seams",
        lambda: solve_timeline(automatic, clips),
        "the same with a smoothing time of 0.1 s",
        lambda: solve_timeline(plain, clips),
        "≤ 5",
        repeats=20,
    )


def test_choosing_against_solving(case, compare):
    plain, automatic, clips = case
    placed = place_timeline(automatic, clips)
    compare(
        "choosing λ for two seams and five parts",
        lambda: with_automatic(placed),
        "solve_timeline with a smoothing time of 0.1 s",
        lambda: solve_timeline(plain, clips),
        "none",
        repeats=20,
    )
