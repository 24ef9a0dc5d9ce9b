"""Documents of ours: exact round trips, paths, versions."""

import json
import os
import subprocess
import sys
import warnings
from collections import Counter

import opentimelineio as otio
import pytest
from edit_strategies import timelines
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from kinestitch.edit import schema
from kinestitch.edit.document import load_document, save_document
from kinestitch.edit.operations import append, replace
from kinestitch.edit.timeline import ClipInfo, Seam, timeline
from kinestitch.errors import DocumentError, KinestitchWarning, MissingClipError, OutputError, ParameterError

CLIPS = [ClipInfo("walk", 120, 30.0), ClipInfo("kick", 101, 60.0), ClipInfo("spare", 9, 30.0)]
LINE = append(
    replace(timeline(CLIPS, "walk"), 40, 60, "kick", 20, 75, seam=Seam(stiffness=81.5)), "walk", 3, 30,
    seam=Seam(smoothing=0.25),
)  # fmt: skip


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "edit.otio"
    save_document(LINE, path, sources={"walk": tmp_path / "walk.bvh", "spare": "https://example.org/spare.glb"})
    return path


def changed(path, change):
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))
    return path


def own(data):
    return data["metadata"]["kinestitch"]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(timelines(most_frames=2**50), st.data())
def test_round_trip_is_exact(tmp_path, line, data):
    names = st.text(st.characters(exclude_characters="/\0", exclude_categories=["Cs"]), min_size=1, max_size=9)
    names = names.filter(lambda name: name not in {".", ".."} and "\\" not in name)
    chosen = data.draw(st.sets(st.sampled_from([info.key for info in line.clips if info.source == info.key])))
    sources = {key: f"{tmp_path}{os.sep}{data.draw(names)}" for key in sorted(chosen)}
    save_document(line, tmp_path / "edit.otio", sources=sources)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        document = load_document(tmp_path / "edit.otio")
    assert document.timeline == line
    assert hash(document.timeline) == hash(line)
    assert document.sources == sources


def test_what_another_program_sees(saved):
    line = otio.adapters.read_from_file(str(saved))
    (track,) = line.video_tracks()
    assert [clip.name for clip in track] == ["walk", "kick", "walk", "walk"]
    kick = track[1]
    assert kick.source_range == otio.opentime.TimeRange(
        otio.opentime.RationalTime(10, 30), otio.opentime.RationalTime(28, 30)
    )
    assert kick.media_reference.available_range.duration == otio.opentime.RationalTime(101, 60)
    assert isinstance(kick.media_reference, otio.schema.MissingReference)
    assert track[0].media_reference.target_url == "walk.bvh"
    assert set(line.metadata) == set(track.metadata) == set(kick.metadata) == {"kinestitch"}
    assert line.duration().value == LINE.frames


def test_sources_move_with_the_folder(tmp_path):
    (tmp_path / "a" / "clips").mkdir(parents=True)
    (tmp_path / "a" / "edits").mkdir()
    name = "Happy Walk #2 100%@3.bvh"
    save_document(LINE, tmp_path / "a" / "edits" / "x.otio", sources={"walk": f"clips/{name}"}, base=tmp_path / "a")
    assert load_document(tmp_path / "a" / "edits" / "x.otio").sources == {"walk": str(tmp_path / "a" / "clips" / name)}
    (tmp_path / "a").rename(tmp_path / "b")
    assert load_document(tmp_path / "b" / "edits" / "x.otio").sources == {"walk": str(tmp_path / "b" / "clips" / name)}


def test_relative_paths_count_from_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save_document(LINE, "x.otio", sources={"walk": "walk.bvh", "kick": (tmp_path / "k.bvh").as_uri()})
    expected = {"walk": str(tmp_path / "walk.bvh"), "kick": str(tmp_path / "k.bvh")}
    assert load_document("x.otio").sources == expected


def test_linked_folders_and_odd_file_names(tmp_path):
    (tmp_path / "real" / "deep").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "real" / "deep")
    odd = os.fsdecode(b"caf\xe9.bvh")
    save_document(LINE, tmp_path / "link" / "x.otio", sources={"walk": tmp_path / odd})
    assert load_document(tmp_path / "link" / "x.otio").sources["walk"] == str(tmp_path / odd)
    assert load_document(tmp_path / "real" / "deep" / "x.otio").sources["walk"] == str(tmp_path / odd)


def test_saving_refuses_and_leaves_no_trace(tmp_path):
    with pytest.raises(MissingClipError, match="'jump'"):
        save_document(LINE, tmp_path / "x.otio", sources={"jump": "jump.bvh"})
    with pytest.raises(OutputError):
        save_document(LINE, tmp_path / "none" / "x.otio")
    with pytest.raises(ParameterError, match="another key"):
        save_document(timeline([ClipInfo("\udce9", 3, 30.0)], "\udce9"), tmp_path / "x.otio")
    assert list(tmp_path.iterdir()) == []


def test_saving_twice_replaces(saved):
    save_document(timeline(CLIPS, "spare"), saved)
    assert load_document(saved).timeline == timeline(CLIPS, "spare")


def test_relinked_in_another_program(saved):
    line = otio.adapters.read_from_file(str(saved))
    line.video_tracks()[0][1].media_reference = otio.schema.ExternalReference("better%20kick.bvh")
    otio.adapters.write_to_file(line, str(saved))
    document = load_document(saved)
    assert document.timeline == LINE
    assert document.sources["kick"] == str(saved.parent / "better kick.bvh")
    assert document.sources["spare"] == "https://example.org/spare.glb"


def test_seams_travel_with_segments_another_program_moved(saved):
    line = otio.adapters.read_from_file(str(saved))
    track = line.video_tracks()[0]
    del track[2]
    otio.adapters.write_to_file(line, str(saved))
    document = load_document(saved)
    assert document.timeline.seams == (LINE.seams[0], LINE.seams[2])
    assert document.timeline.segments == (*LINE.segments[:2], LINE.segments[3])


def test_unknown_settings_are_counted_and_kept_out(saved):
    def change(data):
        own(data)["colour"] = "red"
        own(data)["clips"][0]["actor"] = "Ann"
        for clip in data["tracks"]["children"][0]["children"][1:]:
            clip["metadata"]["kinestitch"]["seam"]["bouncy"] = True

    changed(saved, change)
    with pytest.warns(KinestitchWarning, match="3 × unknown setting 'bouncy'.*'colour'") as caught:
        document = load_document(saved)
    assert len(caught) == 1
    assert "'actor'" in str(caught[0].message)
    assert document.timeline == LINE


@pytest.mark.parametrize(
    ("seam", "told"),
    [(Seam(), {}), (Seam(automatic=True), {"automatic": True}), (Seam(stiffness=0.0), {"stiffness": 0.0})],
)
def test_a_seam_tells_only_what_is_not_the_default(seam, told):
    assert schema.seam_data(seam) == told
    assert schema.seam_from(told, Counter()) == seam


def test_newer_version_names_its_writer(saved):
    def change(data):
        own(data)["schema"] = schema.SCHEMA + 1
        own(data)["written_by"] = "kinestitch 9.1"

    with pytest.raises(
        DocumentError, match=r"got 2, written by kinestitch 9\.1\. Update kinestitch\. \(.*edit\.otio\)"
    ):
        load_document(changed(saved, change))


def test_every_old_version_has_an_upgrade():
    assert sorted(schema.UPGRADES) == list(range(schema.SCHEMA))


def version_0():
    def clip(key, start, length):
        def time(value):
            return {"OTIO_SCHEMA": "RationalTime.1", "rate": 30, "value": value}

        shown = {"OTIO_SCHEMA": "TimeRange.1", "start_time": time(start), "duration": time(length)}
        media = {"OTIO_SCHEMA": "ExternalReference.1", "target_url": f"{key}.bvh"}
        settings = {"kinestitch": {"key": key}}
        return {
            "OTIO_SCHEMA": "Clip.1", "name": key, "source_range": shown, "media_reference": media, "metadata": settings,
        }  # fmt: skip

    settings = {
        "schema": 0, "rate": 30, "clips": {"walk": [120, 30], "kick": [50, 30]},
        "seams": [{"lambda": 81}, {"seconds": 0.2}],
    }  # fmt: skip
    children = [clip("walk", 0, 60), clip("kick", 10, 30), clip("walk", 80, 40)]
    track = {"OTIO_SCHEMA": "Track.1", "kind": "Video", "children": children}
    stack = {"OTIO_SCHEMA": "Stack.1", "children": [track]}
    return {"OTIO_SCHEMA": "Timeline.1", "name": "old", "tracks": stack, "metadata": {"kinestitch": settings}}


def test_version_0_is_upgraded(tmp_path):
    path = tmp_path / "old.otio"
    path.write_text(json.dumps(version_0()))
    document = load_document(path)
    line = timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 50, 30.0)], "walk")
    line = replace(line, 60, 80, "kick", 10, 40)
    assert document.timeline.segments == line.segments
    assert document.timeline.seams == (Seam(stiffness=81.0), Seam(smoothing=0.2))
    assert set(document.timeline.clips) == set(line.clips)
    assert document.sources == {key: str(tmp_path / f"{key}.bvh") for key in ("walk", "kick")}
    save_document(document.timeline, path, sources=document.sources)
    assert load_document(path) == document


@pytest.mark.parametrize("change", [
    lambda data: own(data).pop("clips"),
    lambda data: own(data).pop("rate"),
    lambda data: own(data)["seams"].pop(),
    lambda data: own(data).update(clips=[1]),
    lambda data: data["tracks"]["children"][0]["children"][1].pop("metadata"),
])  # fmt: skip
def test_incomplete_version_0(tmp_path, change):
    path = tmp_path / "old.otio"
    path.write_text(json.dumps(version_0()))
    with pytest.raises(DocumentError, match="complete document of schema version 0"):
        load_document(changed(path, change))


def test_opentimelineio_is_imported_late():
    code = (
        "import sys, kinestitch.edit; print([m for m in ('opentimelineio', 'scipy', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
