"""Documents that are damaged: a DocumentError with the path, never anything else, never a crash."""

import json
import random
import warnings

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from kinestitch.edit.document import load_document, save_document
from kinestitch.edit.operations import replace
from kinestitch.edit.timeline import ClipInfo, Seam, timeline
from kinestitch.errors import DocumentError, KinestitchWarning

LINE = replace(
    timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 101, 60.0)], "walk"),
    40,
    60,
    "kick",
    seam=Seam(smoothing=0.2),
)
EDGES = (None, True, -1, 0, 0.5, 10**40, 2**63, -(2**63), 1e308, float("nan"), float("inf"), "", "walk", [], {}, [[]])
SCHEMAS = ("Timeline.1", "Stack.1", "Track.1", "Clip.1", "Clip.2", "Gap.1", "Transition.1", "Marker.1", "Test.1")
SCHEMAS += ("RationalTime.1", "TimeRange.1", "ExternalReference.1", "UnknownSchema.1", "SerializableObjectRef.1")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "x.otio"


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    path = tmp_path_factory.mktemp("sound") / "x.otio"
    save_document(LINE, path, sources={"walk": path.parent / "walk.bvh"})
    return path.read_text()


def refused(path, content, words=None):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(DocumentError, match=words) as caught:
        load_document(path)
    assert str(caught.value).endswith(f"({path})")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "JSON"),
        (b"\x89PNG\r\n\x1a\n\x00\xff", "JSON in UTF-8"),
        (b"HIERARCHY\nROOT Hips\n", "JSON"),
        (b"null", "timeline"),
        (b"[]", "timeline"),
        (b'{"a": 1}', "timeline"),
        (b'{"OTIO_SCHEMA": "Clip.1"}', None),
        (b'{"OTIO_SCHEMA": "Strange.7"}', "timeline"),
        (b'{"OTIO_SCHEMA": "Timeline.99", "tracks": null}', "refuses"),
        (b'{"OTIO_SCHEMA": "Timeline.1"}', "refuses"),
        (b'{"OTIO_SCHEMA": "Timeline.1", "tracks": null}', "timeline"),
        (b'{"OTIO_SCHEMA": "Timeline.1", "tracks": {"OTIO_SCHEMA": "Stack.1", "children": []}}', "one video track"),
        (b"[" * 100_000, "nesting"),
        (b"[" * 900 + b"]" * 900, "nesting"),
        (b'{"a":' * 201 + b"1" + b"}" * 201, "nesting"),
    ],
)
def test_files_that_are_no_documents(path, content, words):
    refused(path, content, words)


def test_folder_and_missing_file(path):
    path.mkdir()
    with pytest.raises(DocumentError, match="folder"):
        load_document(path)
    with pytest.raises(FileNotFoundError):
        load_document(path / "none.otio")


def test_truncated_anywhere(path, sound):
    for length in range(0, len(sound) - 3, 61):
        refused(path, sound[:length])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"schema": 1', '"schema": -1', "schema version from 0 to 1, got -1"),
        ('"schema": 1', '"schema": true', "schema version"),
        ('"schema": 1', '"other": 1', "schema version from 0 to 1, got None"),
        ('"frames": 120', '"frames": 0', "at least 1 frame, got 0"),
        ('"frames": 120', '"frames": 100', "0:100 of clip 'walk'"),
        ('"frames": 120', '"frames": 1' + "0" * 40, None),
        ('"frames": 120', '"frame": 120', "a clip's frames to be a whole number, got nothing"),
        ('"clip": "kick"', '"clip": "jump"', "one of the document's clips, got 'jump'"),
        ('"clip": "kick"', '"clip": ["kick"]', "segment's clip to be text"),
        ('"key": "kick"', '"key": "walk"', "'walk' twice"),
        ('"smoothing": 0.2', '"smoothing": -0.2', "smoothing ≥ 0"),
        ('"smoothing": 0.2', '"smoothing": NaN', "smoothing ≥ 0"),
        ('"smoothing": 0.2', '"smoothing": 1, "stiffness": 1', "both"),
        ('"smoothing": 0.2', '"smoothing": 1, "automatic": true', "automatic seam without"),
        ('"smoothing": 0.2', '"automatic": 1', "True or False, got 1"),
        ('"schema": 1', '"schema": 1, "foot_lock": "no"', "True or False, got 'no'"),
        ('"value": 60.0', '"value": NaN', "time range"),
        ('"value": 60.0', '"value": -1.0', "time range"),
        ('"value": 60.0', '"value": 1e300', "frame number"),
        ('"value": 60.0', '"value": Infinity', "time range"),
        ('"rate": 30.0', '"rate": 0.0', "time range"),
    ],
)
def test_wrong_values(path, sound, old, new, words):
    assert old in sound
    refused(path, sound.replace(old, new), words)


@pytest.mark.parametrize(
    "item",
    [
        {"OTIO_SCHEMA": "UnknownSchema.1"},
        {"OTIO_SCHEMA": "Test.1", "name": "x"},
        {"OTIO_SCHEMA": "SerializableObjectRef.1", "id": "track"},
        {"OTIO_SCHEMA": "Clip.1", "media_references": {}},
        {"OTIO_SCHEMA": "Clip.1", "media_reference": {}},
        {"OTIO_SCHEMA": "Clip.1", "media_reference": 3},
        {"OTIO_SCHEMA": "Clip.01"},
        {"OTIO_SCHEMA": "Clip.99999999999"},
        {"OTIO_SCHEMA": ["Clip.1"]},
        {"OTIO_SCHEMA": "Clip.2", "media_references": {"DEFAULT_MEDIA": None}},
        {"OTIO_SCHEMA": "Gap.1", "source_range": {"OTIO_SCHEMA": "TimeRange.1"}},
        {},
        None,
        3,
    ],
)
def test_objects_that_a_compiled_parser_does_not_survive(path, item):
    track = {"OTIO_SCHEMA": "Track.1", "OTIO_REF_ID": "track", "kind": "Video", "children": [item]}
    stack = {"OTIO_SCHEMA": "Stack.1", "children": [track]}
    refused(path, json.dumps({"OTIO_SCHEMA": "Timeline.1", "tracks": stack}))


def places(node, found):
    children = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in children:
        found.append((node, key))
        places(child, found)
    return found


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=300)
@given(st.integers(0, 2**32))
def test_random_damage(path, sound, seed):
    rng = random.Random(seed)
    data = json.loads(sound)
    for _ in range(rng.randint(1, 3)):
        node, key = rng.choice(places(data, []))
        if isinstance(node, dict) and rng.random() < 0.3:
            del node[key]
        elif rng.random() < 0.3:
            _, other = rng.choice(places(data, []))
            if isinstance(node, dict) and isinstance(other, str):
                node[other] = node.pop(key)
        else:
            node[key] = rng.choice(SCHEMAS if key == "OTIO_SCHEMA" else EDGES)
    path.write_text(json.dumps(data))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        try:
            load_document(path)
        except DocumentError:
            return


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.data())
def test_random_bytes(path, sound, data):
    content = bytearray(sound.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        try:
            load_document(path)
        except DocumentError:
            return
