"""The codec of the FBX node tree: same bytes out as in, and no claim of a damaged file is believed."""

import contextlib
import struct
from dataclasses import replace

import numpy as np
import pytest

from kinestitch.errors import FormatError
from kinestitch.files.fbx.binary import MAGIC, parse_binary, serialise
from kinestitch.files.fbx.nodes import Document, Node, PackedArray
from kinestitch.files.fbx.write import motion_document
from kinestitch.testing import random_motion


def every_type():
    arrays = tuple(PackedArray.of(np.arange(count) % 2, code) for code in "bcilfd" for count in (0, 3, 1000))
    leaf = Node("Leaf", ("naïve \x00\x01Model", b"\x00\xff", 7, -5, 1 << 40, -1, 1.5, 0.1), "SRCYLIFD")
    bytewise = Node("Byte", (-3,), "B")
    packed = Node("Packed", arrays, "".join(array.code for array in arrays))
    block = Node("EmptyBlock", terminated=True)
    odd = Node("Odd\udcff", ("\udcfe",), "S", (leaf,), terminated=False)
    return (Node("Top", (), "", (leaf, bytewise, packed, block, odd), terminated=True), leaf)


@pytest.mark.parametrize("version", [7100, 7400, 7500, 7700])
def test_a_tree_of_every_type_survives(version):
    data = serialise(Document(version, every_type()))
    again = parse_binary(data)
    assert again.version == version
    assert serialise(again) == data
    top = again.nodes[0]
    assert [child.name for child in top.children] == ["Leaf", "Byte", "Packed", "EmptyBlock", "Odd\udcff"]
    assert top.children[0].properties == every_type()[1].properties
    assert [array.values().tolist() for array in top.children[2].properties][-1] == (np.arange(1000) % 2).tolist()


@pytest.mark.parametrize("version", [7400, 7700])
def test_a_changed_tree_gets_a_footer_that_fits(version):
    parsed = parse_binary(serialise(Document(version, every_type())))
    for extra in range(20):
        grown = replace(parsed, nodes=(*parsed.nodes, Node("x" * extra, (1,), "I")))
        data = serialise(grown)
        assert struct.unpack("<I", data[-140:-136])[0] == version
        assert len(data) % 16 == 0
        assert parse_binary(data).nodes[-1].properties == (1,)


def test_a_big_endian_file_is_read():
    body = b"Number" + b"L" + struct.pack(">q", 5) + b"d" + struct.pack(">IIIdd", 2, 0, 16, 1.5, -2.0)
    head = struct.pack(">IIIB", 27 + 13 + len(body), 2, len(body) - 6, 6)
    data = MAGIC + b"\x01" + struct.pack(">I", 6100) + head + body + bytes(13)
    number = parse_binary(data).nodes[0]
    assert number.properties[0] == 5
    assert number.properties[1].values().tolist() == [1.5, -2.0]
    with pytest.raises(FormatError, match="little-endian"):
        serialise(parse_binary(data))


def record(values, codes_count, *, end=None, children=b""):
    name = b"Node"
    size = 13 + len(name) + len(values) + len(children)
    return (
        struct.pack("<IIIB", 27 + size if end is None else end, codes_count, len(values), len(name))
        + name
        + values
        + children
    )


def document(*parts):
    return MAGIC + b"\x00" + struct.pack("<I", 7400) + b"".join(parts) + bytes(13)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"Kaydara FBX Binary  ",
        MAGIC + b"\x00" + struct.pack("<I", 7400),
        MAGIC + b"\x00" + struct.pack("<I", 12345),
        document(record(b"Z", 1)),
        document(record(b"", 1)),
        document(record(b"", 2**32 - 1)),
        document(record(b"I\x00", 1)),
        document(record(b"S\xff\xff\xff\xff", 1)),
        document(record(b"I\x00\x00\x00\x00\x00", 1)),
        document(record(b"d" + struct.pack("<III", 2**32 - 1, 0, 8) + bytes(8), 1)),
        document(record(b"d" + struct.pack("<III", 1, 7, 8) + bytes(8), 1)),
        document(record(b"", 0, end=2**32 - 1)),
        document(record(b"", 0, end=3)),
        document(record(b"", 0, children=b"\x01" * 20)),
    ],
    ids=range(15),
)
def test_damage_is_refused(data):
    with pytest.raises(FormatError):
        parse_binary(data)


@pytest.mark.parametrize(
    ("count", "payload"),
    [(2**32 - 1, b"x\x9c\x03\x00\x00\x00\x00\x01"), (100, b"not zlib"), (2, b"x\x9c\x03\x00\x00\x00\x00\x01")],
)
def test_arrays_that_hold_something_else_are_refused(count, payload):
    with pytest.raises(FormatError):
        PackedArray("d", count, 1, payload).values()


def test_deep_nesting_is_refused():
    node = Node("Deep")
    for _ in range(200):
        node = Node("Deep", children=(node,), terminated=True)
    with pytest.raises(FormatError, match="deep"):
        parse_binary(serialise(Document(7400, (node,))))


def test_every_cut_and_every_flipped_byte_is_answered_in_one_kind_of_error():
    data = serialise(motion_document(random_motion(1, joints=2, frames=3), "take"))
    for stop in range(0, len(data) - 200, 97):
        with pytest.raises(FormatError):
            parse_binary(data[:stop])
    rng = np.random.default_rng(0)
    for at in rng.integers(0, len(data), 400):
        damaged = bytearray(data)
        damaged[at] ^= 1 << int(rng.integers(8))
        with contextlib.suppress(FormatError):
            parse_binary(bytes(damaged))
