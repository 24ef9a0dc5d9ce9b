"""Documents of other programs: made here with OpenTimelineIO itself, without any setting of ours."""

import opentimelineio as otio
import pytest

from kinestitch.edit.document import load_document, save_document
from kinestitch.edit.timeline import DEFAULT_SEAM, ClipInfo, FrameRange, Segment
from kinestitch.errors import DocumentError, FormatError, KinestitchWarning


def span(start, length, rate):
    return otio.opentime.TimeRange(otio.opentime.RationalTime(start, rate), otio.opentime.RationalTime(length, rate))


def clip(name, url, shown=None, available=None):
    media = otio.schema.ExternalReference(url, available) if url else otio.schema.MissingReference()
    return otio.schema.Clip(name, media, shown)


def document(tmp_path, *items, others=(), kind="Video"):
    line = otio.schema.Timeline("cut")
    track = otio.schema.Track("V1", kind=kind)
    line.tracks.append(track)
    track.extend(items)
    line.tracks.extend(others)
    path = tmp_path / "cut.otio"
    otio.adapters.write_to_file(line, str(path))
    return path


def test_plain_cut(tmp_path):
    path = document(
        tmp_path,
        clip("walk", "walk.bvh", span(0, 60, 30), span(0, 120, 30)),
        clip("kick", "../k/kick%201.bvh", span(20, 55, 60), span(0, 101, 60)),
        clip("walk again", "walk.bvh", span(80, 40, 30), span(0, 120, 30)),
    )
    loaded = load_document(path)
    line = loaded.timeline
    assert line.fps == 30.0
    assert line.clips == (ClipInfo("walk", 120, 30.0), ClipInfo("kick", 101, 60.0))
    assert [str(segment) for segment in line.segments] == ["walk@0:60", "kick@10:38", "walk@80:120"]
    assert line.seams == (DEFAULT_SEAM, DEFAULT_SEAM)
    assert loaded.sources == {"walk": str(tmp_path / "walk.bvh"), "kick": str(tmp_path.parent / "k" / "kick 1.bvh")}
    save_document(line, path, sources=loaded.sources)
    assert load_document(path) == loaded


def test_time_codes_are_taken_off(tmp_path):
    hour = 3600 * 24
    path = document(tmp_path, clip("a", "a.fbx", span(hour + 10, 20, 24), span(hour, 100, 24)))
    assert load_document(path).timeline.segments == (Segment("a", FrameRange(10, 30)),)


def test_whole_clips_and_same_names_of_different_files(tmp_path):
    path = document(tmp_path, clip("a", "x/a.fbx", None, span(0, 100, 24)), clip("a", "y/a.fbx", None, span(0, 50, 24)))
    loaded = load_document(path)
    assert [str(segment) for segment in loaded.timeline.segments] == ["a@0:100", "a 2@0:50"]
    assert loaded.sources == {"a": str(tmp_path / "x" / "a.fbx"), "a 2": str(tmp_path / "y" / "a.fbx")}


def test_file_urls_and_web_urls(tmp_path):
    path = document(
        tmp_path,
        clip("a", "file:///clips/a%20b.fbx", None, span(0, 9, 24)),
        clip("b", "file://localhost/clips/b.fbx", None, span(0, 9, 24)),
        clip("c", "https://example.org/c%20d.glb", None, span(0, 9, 24)),
        clip("", "/clips/no name.bvh", None, span(0, 9, 24)),
    )
    assert load_document(path).sources == {
        "a": "/clips/a b.fbx",
        "b": "/clips/b.fbx",
        "c": "https://example.org/c%20d.glb",
        "no name": "/clips/no name.bvh",
    }


def test_files_of_unknown_length_are_asked_for(tmp_path):
    path = document(tmp_path, clip("a", "a.bvh", span(5, 10, 30)), clip("b", "b.bvh"))
    with pytest.raises(DocumentError, match=r"clip 'a' to say how long its file is"):
        load_document(path)
    asked = []

    def probe(source):
        asked.append(source)
        return 100, 60.0

    line = load_document(path, probe=probe).timeline
    assert asked == [str(tmp_path / "a.bvh"), str(tmp_path / "b.bvh")]
    assert [str(segment) for segment in line.segments] == ["a@5:15", "b@0:50"]
    assert load_document(document(tmp_path, clip("b", "b.bvh")), probe=probe).timeline.fps == 60.0

    def damaged(source):
        raise FormatError(f"Expected a hierarchy, got nothing. ({source})")

    with pytest.raises(DocumentError, match="hierarchy"):
        load_document(path, probe=damaged)


def test_what_has_no_meaning_here_is_counted_in_one_warning(tmp_path):
    dark = clip("dark", "d.bvh", None, span(0, 9, 30))
    dark.enabled = False
    slow = clip("a", "a.bvh", None, span(0, 9, 30))
    slow.effects.append(otio.schema.LinearTimeWarp(time_scalar=0.5))
    time = otio.opentime.RationalTime(3, 30)
    sound = otio.schema.Track("A1", kind="Audio")
    sound.append(clip("sound", "s.wav", None, span(0, 9, 30)))
    path = document(
        tmp_path, otio.schema.Gap(source_range=span(0, 30, 30)), slow,
        otio.schema.Transition(transition_type="SMPTE_Dissolve", in_offset=time, out_offset=time),
        clip("b", "b.bvh", None, span(0, 9, 30)), dark, otio.schema.Gap(source_range=span(0, 0, 30)),
        others=[sound, otio.schema.Track("V2"), otio.schema.Track("A2", kind="Audio")],
    )  # fmt: skip
    expected = "1 × audio track, 1 × disabled clip, 1 × effect, 1 × gap, 1 × transition"
    with pytest.warns(KinestitchWarning, match=expected) as caught:
        line = load_document(path).timeline
    assert len(caught) == 1
    assert [str(segment) for segment in line.segments] == ["a@0:9", "b@0:9"]


@pytest.mark.parametrize("nested", [otio.schema.Stack("layers"), otio.schema.Track("inner")])
def test_nested_compositions_are_refused(tmp_path, nested):
    with pytest.raises(DocumentError, match=r"nested .*Flatten it first"):
        load_document(document(tmp_path, clip("a", "a.bvh", None, span(0, 9, 30)), nested))
    with pytest.raises(DocumentError, match=r"nested Stack|one video track"):
        load_document(document(tmp_path, clip("a", "a.bvh", None, span(0, 9, 30)), others=[nested_copy(nested)]))


def nested_copy(nested):
    copy = nested.deepcopy()
    copy.append(clip("b", "b.bvh", None, span(0, 9, 30)))
    return copy


def test_several_or_no_video_tracks_are_refused(tmp_path):
    second = otio.schema.Track("V2")
    second.append(clip("b", "b.bvh", None, span(0, 9, 30)))
    first = clip("a", "a.bvh", None, span(0, 9, 30))
    with pytest.raises(DocumentError, match="one video track with clips, got 2"):
        load_document(document(tmp_path, first, others=[second]))
    with pytest.raises(DocumentError, match="one video track with clips, got 0"):
        load_document(document(tmp_path, clip("a", "a.wav", None, span(0, 9, 30)), kind="Audio"))
    with pytest.raises(DocumentError, match="at least one clip"):
        load_document(document(tmp_path, otio.schema.Gap(source_range=span(0, 30, 30))))


def test_ranges_outside_the_file_are_refused(tmp_path):
    path = document(tmp_path, clip("a", "a.bvh", span(5, 10, 30), span(0, 12, 30)))
    with pytest.raises(DocumentError, match=r"0:12 of clip 'a' at 30 fps, got 5:15 .*cut\.otio"):
        load_document(path)


def test_tracks_that_state_their_whole_length_are_fine_and_trimmed_ones_refused(tmp_path):
    path = document(tmp_path, clip("a", "a.bvh", None, span(0, 90, 30)))
    line = otio.adapters.read_from_file(str(path))
    for shown, fine in ((span(0, 90, 30), True), (span(0, 180, 60), True), (span(0, 80, 30), False)):
        line.tracks[0].source_range = shown
        otio.adapters.write_to_file(line, str(path))
        if fine:
            assert load_document(path).timeline.frames == 90
        else:
            with pytest.raises(DocumentError, match="whole track"):
                load_document(path)


def test_a_collection_of_one_timeline(tmp_path):
    path = document(tmp_path, clip("a", "a.bvh", None, span(0, 9, 30)))
    line = otio.adapters.read_from_file(str(path))
    otio.adapters.write_to_file(otio.schema.SerializableCollection("bin", [line]), str(path))
    assert load_document(path).timeline.frames == 9


def test_rounding_at_the_end_of_a_clip_of_another_rate(tmp_path):
    path = document(
        tmp_path, clip("a", "a.bvh", span(0, 10, 30), span(0, 10, 30)),
        clip("b", "b.bvh", span(0, 10, 24), span(0, 10, 24)),
    )  # fmt: skip
    assert [str(segment) for segment in load_document(path).timeline.segments] == ["a@0:10", "b@0:12"]


def test_media_that_are_no_files(tmp_path):
    image = otio.schema.ImageSequenceReference("file:///shots", "a.", ".exr", available_range=span(0, 9, 30))
    item = otio.schema.Clip("a", image)
    item.metadata["other"] = {"kinestitch": 3}
    item.markers.append(otio.schema.Marker("m", span(0, 1, 30)))
    loaded = load_document(document(tmp_path, item))
    assert loaded.timeline.clips == (ClipInfo("a", 9, 30.0),)
    assert loaded.sources == {}
