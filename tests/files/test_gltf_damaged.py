"""Damaged glTF files: a sound motion or a KinestitchError of one line, soon and without huge allocations."""

import json
import struct
import time
import tracemalloc
import warnings

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.errors import FormatError, KinestitchError, KinestitchWarning
from kinestitch.files.glb import parse_glb, serialise_glb
from kinestitch.files.gltf import read_gltf, write_gltf
from kinestitch.testing import check_motion, random_motion


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    path = tmp_path_factory.mktemp("damaged") / "clip.glb"
    write_gltf(random_motion(3, joints=4, frames=9), path)
    return path, path.read_bytes()


def attempt(path, data):
    path.write_bytes(data)
    begin = time.perf_counter()
    message = ""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        warnings.simplefilter("error", RuntimeWarning)
        try:
            check_motion(read_gltf(path))
            result = "read"
        except KinestitchError as error:
            result = "refused"
            message = str(error)
    assert "\n" not in message
    assert time.perf_counter() - begin < 5
    return result


def test_cut_off_anywhere(clip):
    path, data = clip
    for length in range(0, len(data), 11):
        assert attempt(path, data[:length]) == "refused"


@settings(max_examples=400, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 255), st.integers(1, 4))
def test_changed_bytes(clip, place, value, count):
    path, data = clip
    damaged = bytearray(data)
    for k in range(count):
        damaged[(place * (k + 1)) % len(data)] = (value + 37 * k) % 256
    attempt(path, bytes(damaged))


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=300))
def test_rubbish(clip, data):
    path, _ = clip
    assert attempt(path, data) == "refused"
    attempt(path, b"glTF" + struct.pack("<II", 2, 12 + len(data)) + data)
    attempt(path, b"{" + data)


def places(value, path=()):
    """Every place in a JSON document."""
    yield path
    if isinstance(value, dict):
        for key, below in value.items():
            yield from places(below, (*path, key))
    elif isinstance(value, list):
        for index, below in enumerate(value[:6]):
            yield from places(below, (*path, index))


RUBBISH = [
    None,
    True,
    -1,
    0,
    1,
    3,
    10**6,
    2**31,
    2**70,
    -0.5,
    1e30,
    "",
    "x",
    "VEC3",
    [],
    [[]],
    [0],
    [0, 1, 2, 3],
    {},
    {"a": 1},
]


@settings(max_examples=600, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([*RUBBISH, "delete"]), st.integers(0, 10**6), st.sampled_from(RUBBISH))
def test_changed_document(clip, first, value, second, other):
    path, data = clip
    container = parse_glb(data)
    document = json.loads(json.dumps(container.document))
    for number, new in ((first, value), (second, other)) if second % 2 else ((first, value),):
        options = [place for place in places(document) if place]
        *above, key = options[number % len(options)]
        holder = document
        for step in above:
            holder = holder[step]
        if new == "delete":
            del holder[key]
        else:
            holder[key] = json.loads(json.dumps(new))
    attempt(path, b"".join(serialise_glb(document, [(k, [c]) for k, c in container.chunks])))


def changed(data, change):
    container = parse_glb(data)
    document = json.loads(json.dumps(container.document))
    change(document)
    return b"".join(serialise_glb(document, [(k, [c]) for k, c in container.chunks]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["accessors"][2].update(count=10**9), "The file may be cut short"),
        (
            lambda d: d["accessors"][2].pop("bufferView") and d["accessors"][2].update(count=10**9),
            "to have a bufferView",
        ),
        (lambda d: d["bufferViews"][2].update(byteLength=10**9), "The file may be cut short"),
        (lambda d: d["nodes"][3].update(children=[0]), "tree of nodes|one parent"),
        (lambda d: d["nodes"][0].update(children=[0]), "cycle"),
        (lambda d: d["asset"].update(version="1.0"), "glTF 2.0, got version '1.0'"),
        (lambda d: d["animations"][0]["samplers"][0].update(interpolation="WAVY"), "LINEAR, STEP or CUBICSPLINE"),
        (
            lambda d: d["animations"][0]["samplers"][0].update(interpolation="CUBICSPLINE"),
            "27 values for 9 keys, got 9",
        ),
        (lambda d: d.update(nodes={}), "list of objects as 'nodes'"),
        (lambda d: d["nodes"][1].update(rotation=[0, 0, "x", 1]), "finite numbers as 'rotation'"),
        (lambda d: d["bufferViews"][2].update(extensions={"EXT_meshopt_compression": {}}), "meshopt"),
    ],
)
def test_what_is_said(clip, change, message):
    path, data = clip
    path.write_bytes(changed(data, change))
    with pytest.raises(FormatError, match=message) as caught:
        read_gltf(path)
    assert str(caught.value).endswith(f"({path})")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "got an empty one"),
        (b"Kaydara FBX", "Expected a GLB file or JSON, got bytes that begin with b'Kaydara '"),
        (b"glTF\x01\0\0\0\x14\0\0\0aaaaaaaa", "Expected GLB version 2, got 1"),
        (b'{"a":' * 100_000, "nested too deeply"),
        (b'{"asset": NaN}', "NaN is no JSON number"),
        (b"{]", "Expected a JSON document"),
        (b"{}", "Expected an object as 'asset'"),
    ],
)
def test_no_gltf(clip, data, message):
    path, _ = clip
    path.write_bytes(data)
    with pytest.raises(FormatError, match=message):
        read_gltf(path)


def test_keys_far_apart_take_no_memory(clip):
    path, data = clip
    container = parse_glb(data)
    times = container.document["bufferViews"][container.document["accessors"][1]["bufferView"]]
    binary = bytearray(container.binary)
    struct.pack_into("<f", binary, times["byteOffset"] + times["byteLength"] - 4, 1e11)
    path.write_bytes(b"".join(serialise_glb(container.document, [(0x004E4942, [bytes(binary)])])))
    tracemalloc.start()
    with pytest.raises(FormatError, match="keys that follow each other"):
        read_gltf(path)
    assert tracemalloc.get_traced_memory()[1] < 20e6
    tracemalloc.stop()


def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_gltf(tmp_path / "none.glb")
