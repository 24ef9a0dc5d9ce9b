"""The verb ``cuts`` and the option ``--snap``."""

from __future__ import annotations

import json

import pytest

import kinestitch as ks
from kinestitch.files import read, write
from kinestitch.search.price import best_cuts, price_map


@pytest.fixture
def two(clip, kinestitch):
    clip("a.bvh", frames=50, seed=1)
    clip("b.bvh", frames=40, seed=2)
    return kinestitch


def test_a_table_and_how_to_make_the_cut(two):
    ran = two("cuts", "a.bvh", "b.bvh", "--top", 3)
    assert (ran.code, ran.err) == (0, "")
    best = best_cuts(price_map(read("a.bvh"), read("b.bvh")), 3, exact=True)
    assert len(ran.out.splitlines()) == 1 + len(best) + 2
    assert f"{best[0].price:.4g}" in ran.out
    told = ran.out.splitlines()[-1].split()
    assert told[:3] == ["kinestitch", "stitch", "a.bvh"]
    made = two(*told[1:-1], "out.bvh")
    assert (made.code, made.err) == (0, "")
    assert read("out.bvh").frames == best[0].out + 40 - best[0].into


def test_json(two):
    ran = two("cuts", "a.bvh@10:30", "b.bvh@:20", "--json", "--even", "--lambda", 10)
    told = json.loads(ran.out)
    assert (told["lambda"], told["fps"], told["weighted"], told["contacts"]) == (10.0, 30.0, False, False)
    prices = price_map(read("a.bvh"), read("b.bvh"), stiffness=10.0, weights="even")
    best = best_cuts(prices, 5, outs=(11, 30), intos=(0, 19), exact=True)
    assert [(cut["out"], cut["into"]) for cut in told["cuts"]] == [(cut.out, cut.into) for cut in best]
    assert told["cuts"][0]["price"] == pytest.approx(best[0].price)
    exact = [cut["exact_cost"] for cut in told["cuts"]]
    assert exact == sorted(exact)


def test_feet(kinestitch):
    for name in ("walk", "run"):
        write(ks.sample(name), f"{name}.bvh")
    ran = kinestitch("cuts", "walk.bvh", "run.bvh", "--top", 2, "--plot", "map.png")
    assert ran.out.splitlines()[0].split()[-1] == "feet"
    assert all(" → " in line for line in ran.out.splitlines()[1:3])
    blind = kinestitch("cuts", "walk.bvh", "run.bvh", "--top", 2, "--no-contacts")
    assert "feet" not in blind.out
    told = [
        json.loads(kinestitch("cuts", "walk.bvh", "run.bvh", "--json", *more).out) for more in ((), ["--no-contacts"])
    ]
    assert [one["contacts"] for one in told] == [True, False]
    assert told[0]["cuts"] != told[1]["cuts"]


def test_frames_of_another_rate_are_its_own(clip, kinestitch):
    clip("a.bvh", frames=50, seed=1)
    clip("fast.bvh", frames=80, fps=60.0, seed=2)
    told = json.loads(kinestitch("cuts", "a.bvh", "fast.bvh@40:60", "--json").out)
    assert all(40 <= cut["into"] < 60 for cut in told["cuts"])


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_the_map(two, suffix):
    assert two("cuts", "a.bvh", "b.bvh", "--plot", f"map.{suffix}").code == 0
    with open(f"map.{suffix}", "rb") as stream:  # noqa: PTH123
        assert stream.read(4) == {"png": b"\x89PNG", "svg": b"<?xm"}[suffix]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["a.bvh", "b.bvh", "--plot", "map.gif"], "ends in .png"),
        (["a.bvh", "b.bvh", "--smooth", "1", "--lambda", "1"], "got both"),
        (["a.bvh", "b.bvh", "--lambda", "0"], "λ > 0"),
        (["a.bvh@10:80", "b.bvh"], "within 0:50"),
        (["a.bvh@10:10", "b.bvh"], "got 10:10. Let its stop come after its start"),
        (["a.bvh", "edit.otio"], "got an edit"),
        (["a.bvh", "c.bvh"], "c.bvh"),
    ],
)
def test_refusals(two, words, said):
    assert said in two("cuts", *words).error


@pytest.mark.parametrize("frames", [1, 3])
def test_a_clip_too_short_to_cut(two, clip, frames):
    clip("tiny.bvh", frames=frames, seed=3)
    for words in (("tiny.bvh", "a.bvh"), ("a.bvh", "tiny.bvh")):
        error = two("cuts", *words).error
        assert f"at least 4 frames to look for cuts in, got {frames} frame" in error
        assert error.endswith("(tiny.bvh)")
    clip("small.bvh", frames=4, seed=3)
    assert two("cuts", "small.bvh", "a.bvh").code == 0


def test_snap_says_what_it_moved(two):
    plain = two("stitch", "a.bvh", "--replace", "20:30", "b.bvh@10:25", "-o", "plain.bvh")
    assert "moved:" not in plain.err
    ran = two("stitch", "a.bvh", "--replace", "20:30", "b.bvh@10:25", "--snap", 0.1, "-o", "out.bvh")
    assert ran.code == 0
    assert "note: seam 1 moved: a now ends before frame" in ran.err
    assert "note: all seams together now cost" in ran.err
    assert abs(read("out.bvh").frames - read("plain.bvh").frames) <= 4 * 3


def test_snap_that_keeps_the_length(two):
    words = ("stitch", "a.bvh", "--replace", "20:30", "b.bvh@10:25")
    two(*words, "-o", "plain.bvh")
    ran = two(*words, "--snap", 0.3, "--keep-length", "-o", "out.bvh")
    assert read("out.bvh").frames == read("plain.bvh").frames
    assert "moved:" in ran.err
    assert "it is as long as before." in ran.err
    assert "--snap with --keep-length" in two(*words, "--keep-length", "-o", "no.bvh").error
    for snap in ((), ("--snap", 0.3)):
        both = two(*words, *snap, "--align-steps", 0.3, "--keep-length", "-o", "no.bvh")
        assert "Leave out --keep-length, or take --snap instead of --align-steps." in both.error


def test_snap_goes_into_the_document(two):
    words = ("stitch", "a.bvh", "--replace", "20:30", "b.bvh@10:25", "--snap", 0.1)
    said = two(*words, "-o", "edit.otio").err
    assert "moved:" in said
    assert two("stitch", "edit.otio", "-o", "one.bvh").err == ""
    two(*words, "-o", "two.bvh")
    assert read("one.bvh").frames == read("two.bvh").frames
