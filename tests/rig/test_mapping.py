"""Mappings: spines are spread, doubt is told, files keep everything and damaged ones are refused in one line."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig_builders import renamed

import kinestitch as ks
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import DocumentError, OutputError, SkeletonMismatchError, UnsupportedFormatError
from kinestitch.rig.mapping import Mapping, Pair, check_mapping, find_mapping, unmatched
from kinestitch.rig.mapping_file import load_mapping, save_mapping


def spine_of(count: int, necks: int) -> Skeleton:
    """A body with so many joints in spine and neck."""
    names = ["Hips", *(f"Spine{n}" for n in range(count)), *(f"Neck{n or ''}" for n in range(necks)), "Head"]
    parents = list(range(-1, len(names) - 1))
    for side in ("Left", "Right"):
        for start, limb in ((count, ("Arm", "ForeArm", "Hand")), (0, ("UpLeg", "Leg", "Foot"))):
            for number, part in enumerate(limb):
                parents.append(start if number == 0 else len(names) - 1)
                names.append(side + part)
    return Skeleton(tuple(names), tuple(parents), np.ones((len(names), 3)))


def follows(mapping: Mapping) -> dict[str, tuple[str, str, float]]:
    return {pair.target: (pair.source, pair.towards, pair.share) for pair in mapping.pairs}


def test_equal_spines_match_joint_by_joint():
    found = find_mapping(spine_of(3, 1), spine_of(3, 1))
    assert found.certain
    assert all(pair.source == pair.target and not pair.towards for pair in found.pairs)
    assert found.unmapped(spine_of(3, 1)) == ()


def test_other_spines_are_spread_from_hips_to_chest_and_from_chest_to_head():
    found = follows(find_mapping(spine_of(2, 0), spine_of(4, 2)))
    assert found["Spine0"] == ("Hips", "Spine0", 0.5)
    assert found["Spine1"] == ("Spine0", "", 0.0)
    assert found["Spine2"] == ("Spine0", "Spine1", 0.5)
    assert found["Spine3"] == ("Spine1", "", 0.0)
    assert found["Neck"] == ("Spine1", "Head", pytest.approx(1 / 3, abs=1e-5))
    assert found["Head"] == ("Head", "", 0.0)


@given(st.integers(1, 6), st.integers(0, 3), st.integers(1, 6), st.integers(0, 3))
def test_the_chest_always_follows_the_chest(own, own_necks, other, other_necks):
    found = follows(find_mapping(spine_of(own, own_necks), spine_of(other, other_necks)))
    assert found[f"Spine{other - 1}"] == (f"Spine{own - 1}", "", 0.0)
    places = [found[f"Spine{n}"] for n in range(other)]
    order = ["Hips", *(f"Spine{n}" for n in range(own))]
    steps = [order.index(source) + share for source, _, share in places]
    assert steps == sorted(steps)
    assert all(0 <= share < 1 for _, _, share in found.values())


def test_joints_without_a_role_follow_their_namesakes():
    motion = ks.sample("idle")
    found = follows(find_mapping(motion.skeleton, motion.skeleton))
    assert found["mixamorig:HeadTop_End"] == ("mixamorig:HeadTop_End", "", 0.0)


def test_what_is_missing_is_told():
    body = spine_of(2, 1)
    armless = Skeleton(tuple(name.replace("LeftHand", "LeftHook") for name in body.names), body.parents, body.offsets)
    found = find_mapping(armless, body)
    assert not found.certain
    assert found.missing == ("left_hand of the source",)
    assert unmatched(found) == "left_hand of the source"
    worm = Skeleton(("Hips", "A"), (-1, 0), np.ones((2, 3)))
    assert unmatched(find_mapping(worm, armless)) == "any limb of the source; left_hand of the target"


def test_a_mapping_names_joints_that_are_there():
    body = spine_of(1, 0)
    check_mapping(Mapping((Pair("Head", "Hips"),)), body, body)
    for pairs, told in (
        ((Pair("Tail", "Hips"),), "joint of the target rig in the mapping, got 'Tail'"),
        ((Pair("Head", "Tail"),), "joint of the source rig in the mapping, got 'Tail'"),
        ((Pair("Head", "Hips", "Tail", 0.5),), "joint of the source rig in the mapping, got 'Tail'"),
        ((Pair("Head", "Hips"), Pair("Head", "Head")), "'Head' twice"),
    ):
        with pytest.raises(SkeletonMismatchError, match=told):
            check_mapping(Mapping(pairs), body, body)


names = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12)
pairs = st.builds(Pair, names, names) | st.builds(Pair, names, names, names, st.floats(0, 1))
mappings = st.builds(
    Mapping,
    st.lists(pairs, max_size=5, unique_by=lambda pair: pair.target).map(tuple),
    names,
    names,
    st.lists(names, max_size=3).map(tuple),
)


@given(mappings, st.sampled_from([".toml", ".json", ".TOML"]))
def test_files_keep_everything(tmp_path_factory, mapping, suffix):
    path = tmp_path_factory.mktemp("mapping") / f"map{suffix}"
    save_mapping(mapping, path)
    assert load_mapping(path) == mapping


def test_a_file_is_what_a_person_would_write(tmp_path):
    found = find_mapping(ks.sample("idle").skeleton, renamed(ks.sample("idle"), {"left_hand": "Paw_L"}).skeleton)
    save_mapping(found, tmp_path / "map.toml")
    text = (tmp_path / "map.toml").read_text(encoding="utf-8")
    assert '\n"mixamorig:Head" = "mixamorig:Head"\n' in text
    (tmp_path / "own.toml").write_text('[joints]\n"Paw_L" = "mixamorig:LeftHand"  # by hand\n', encoding="utf-8")
    assert load_mapping(tmp_path / "own.toml").pairs == (Pair("Paw_L", "mixamorig:LeftHand"),)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[joints", "Expected TOML, got"),
        ("hips = 1", "Expected a table 'joints'"),
        ("joints = 1", "Expected a table 'joints'"),
        ("[joints]\nHead = 1", "for 'Head', got 1"),
        ("[joints]\nHead = {from = 'a', to = 'b', share = 2}", "a share in \\[0, 1\\]"),
        ("[joints]\nHead = {from = 'a', to = 'b', share = nan}", "a share in \\[0, 1\\]"),
        ("[joints]\nHead = {from = 'a', to = 'b', share = true}", "a share in \\[0, 1\\]"),
        ("speed = 1\n[joints]", "got 'speed'"),
        ("missing = 'x'\n[joints]", "as a list"),
        ("source_family = 3\n[joints]", "Expected families as text"),
        ("\x00", "Expected TOML, got"),
    ],
)
def test_damaged_files_are_refused(tmp_path, text, told):
    path = tmp_path / "map.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DocumentError, match=told) as caught:
        load_mapping(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_other_files_are_refused(tmp_path):
    (tmp_path / "map.json").write_bytes(b"\xff\xfe{")
    with pytest.raises(DocumentError, match="Expected JSON"):
        load_mapping(tmp_path / "map.json")
    (tmp_path / "deep.json").write_text("[" * 100_000, encoding="utf-8")
    with pytest.raises(DocumentError, match="Expected JSON"):
        load_mapping(tmp_path / "deep.json")
    (tmp_path / "list.json").write_text(json.dumps([1]), encoding="utf-8")
    with pytest.raises(DocumentError, match="Expected a table"):
        load_mapping(tmp_path / "list.json")
    with pytest.raises(UnsupportedFormatError, match=r"\.toml, \.json, got '\.xml'"):
        load_mapping(tmp_path / "map.xml")
    with pytest.raises(UnsupportedFormatError):
        save_mapping(Mapping(()), tmp_path / "map")
    with pytest.raises(OutputError):
        save_mapping(Mapping(()), tmp_path / "none" / "map.toml")
    with pytest.raises(FileNotFoundError):
        load_mapping(tmp_path / "gone.toml")
