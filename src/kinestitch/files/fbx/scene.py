"""What an FBX node tree says about a scene: objects, who hangs on whom, properties with defaults, units and axes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError
from kinestitch.files.fbx.nodes import Document, Node, Property

Key = int | str  # 7.x objects carry numbers, older ones are known by their full name
Properties = Mapping[str, tuple[Property, ...]]

_RATES = {
    1: 120.0, 2: 100.0, 3: 60.0, 4: 50.0, 5: 48.0, 6: 30.0, 7: 30.0, 8: 30000 / 1001, 9: 30000 / 1001, 10: 25.0,
    11: 24.0, 12: 1000.0, 13: 24000 / 1001, 15: 96.0, 16: 72.0, 17: 60000 / 1001, 18: 120000 / 1001,
}  # fmt: skip
TIME_MODES = {
    120.0: 1,
    100.0: 2,
    60.0: 3,
    50.0: 4,
    48.0: 5,
    30.0: 6,
    30000 / 1001: 9,
    25.0: 10,
    24.0: 11,
    24000 / 1001: 13,
}
CUSTOM_TIME_MODE = 14
MAX_RATE = 100_000.0


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """One object that stands in the scene: a bone, a null, a mesh, a camera."""

    key: Key
    name: str
    kind: str
    properties: Properties

    @property
    def is_bone(self) -> bool:
        """Whether the file calls it part of a skeleton."""
        return self.kind in {"LimbNode", "Limb", "Root", "Effector"}

    def vector(self, name: str, default: float = 0.0) -> Array:
        """A property of three numbers (3,), finite."""
        values = [v for v in self.properties.get(name, ())[:3] if isinstance(v, int | float)]
        return (
            np.array(values, dtype=np.float64)
            if len(values) == 3 and np.isfinite(values).all()
            else np.full(3, default)
        )

    def integer(self, name: str, default: int = 0) -> int:
        """A property of one number."""
        return _integer(self.properties, name, default)


@dataclass(frozen=True, slots=True)
class Link:
    """One connection: `child` hangs on `parent`, or drives its property `name` where that is not empty."""

    child: Key
    parent: Key
    name: str = ""


@dataclass(frozen=True, eq=False)
class Scene:
    """The objects of a document, read when asked for."""

    document: Document

    @cached_property
    def objects(self) -> dict[Key, Node]:
        """Every object by its key; for the same key the first one counts."""
        found: dict[Key, Node] = {}
        home = self.document.child("Objects")
        nodes = home.children if home is not None else self.document.nodes
        for node in nodes:
            key = node.properties[0] if node.properties else None
            if isinstance(key, int | str):
                found.setdefault(key, node)
        return found

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """All object–object and object–property connections, in file order."""
        home = self.document.child("Connections")
        said = map(link_of, home.children) if home is not None else ()
        return (*(link for link in said if link is not None), *_old_links(self.document))

    @cached_property
    def children(self) -> dict[Key, list[Link]]:
        """Connections by the key of their parent."""
        found: dict[Key, list[Link]] = {}
        for link in self.links:
            found.setdefault(link.parent, []).append(link)
        return found

    @cached_property
    def driven(self) -> dict[Key, list[tuple[Key, str]]]:
        """Models and property names by the key of the object that drives them."""
        found: dict[Key, list[tuple[Key, str]]] = {}
        for link in self.links:
            if link.name and link.parent in self.models:
                found.setdefault(link.child, []).append((link.parent, link.name))
        return found

    @cached_property
    def templates(self) -> dict[str, Properties]:
        """Default properties by object type."""
        found: dict[str, Properties] = {}
        home = self.document.child("Definitions")
        for entry in home.all("ObjectType") if home is not None else ():
            template = entry.child("PropertyTemplate")
            if template is not None:
                found.setdefault(entry.text(), read_properties(template))
        return found

    @cached_property
    def models(self) -> dict[Key, Model]:
        """Every model by key, parents before children."""
        template = self.templates.get("Model", {})
        found = {}
        for key, node in self.objects.items():
            if node.name == "Model":
                properties = {**template, **_old_defaults(node), **read_properties(node)}
                found[key] = Model(key, object_name(node), _kind(node), properties)
        order: dict[Key, Model] = {}
        for start in found:
            path: dict[Key, Model] = {}
            at: Key | None = start
            while at is not None and at not in order:
                if at in path:
                    raise FormatError(f"Expected a tree of models, got a circle through {found[at].name!r}.")
                path[at] = found[at]
                at = self.parents.get(at)
            order.update(reversed(path.items()))
        return order

    @cached_property
    def parents(self) -> dict[Key, Key]:
        """Parent model of each model that has one."""
        models = {key for key, node in self.objects.items() if node.name == "Model"}
        parents: dict[Key, Key] = {}
        for link in self.links:
            if not link.name and link.child in models and link.parent in models and link.child != link.parent:
                parents.setdefault(link.child, link.parent)
        return parents

    @cached_property
    def settings(self) -> Properties:
        """The global settings, wherever the file's version keeps them."""
        found: dict[str, tuple[Property, ...]] = dict(self.templates.get("GlobalSettings", {}))
        objects, old = self.document.child("Objects"), self.document.child("Version5") or self.document
        for home in (objects, self.document):
            node = home.child("GlobalSettings") if home is not None else None
            found.update(read_properties(node) if node is not None else {})
        rate = old.child("Settings")
        rate = rate.child("FrameRate") if rate is not None else None
        if rate is not None and self.document.version < 7000:
            found["FrameRate"] = rate.properties
        return found

    @property
    def metres_per_unit(self) -> float:
        """Size of one unit of the file in metres; FBX counts in centimetres times UnitScaleFactor."""
        factor = _number(self.settings, "UnitScaleFactor", 1.0)
        return factor * 0.01 if np.isfinite(factor) and factor > 0 else 0.01

    @property
    def axes(self) -> Array:
        """(3, 3) matrix from the file's world to Y up, X right, Z to the viewer; a reflection if left-handed."""
        matrix = np.zeros((3, 3))
        for row, name, usual in ((0, "CoordAxis", 0), (1, "UpAxis", 1), (2, "FrontAxis", 2)):
            axis = _integer(self.settings, name, usual)
            sign = _integer(self.settings, name + "Sign", 1)
            if axis in (0, 1, 2):
                matrix[row, axis] = -1.0 if sign < 0 else 1.0
        return matrix if abs(np.linalg.det(matrix)) == 1 else np.eye(3)

    @property
    def fps(self) -> float:
        """The frame rate of the file's time line; 30 where it says none."""
        said = next(iter(self.settings.get("FrameRate", ())), None)
        if isinstance(said, str) and said.replace(".", "", 1).isdecimal() and 0 < float(said) <= MAX_RATE:
            return float(said)
        mode = _integer(self.settings, "TimeMode", 0)
        custom = _number(self.settings, "CustomFrameRate", 0.0)
        if mode == CUSTOM_TIME_MODE and np.isfinite(custom) and 0 < custom <= MAX_RATE:
            return custom
        return _RATES.get(mode, 30.0)


def link_of(node: Node) -> Link | None:
    """What one entry of the list of connections says; None for kinds that tie no objects together."""
    kind, ends = node.text(), node.properties[1:3]
    if node.name not in {"C", "Connect"} or len(ends) != 2 or kind not in {"OO", "OP"}:
        return None
    child, parent = ends
    if not isinstance(child, int | str) or not isinstance(parent, int | str):
        return None
    return Link(child, parent, node.text(3) if kind == "OP" else "")


def _old_links(document: Document) -> Iterator[Link]:
    """FBX 5 keeps models among the top nodes and has them list their children."""
    for node in document.nodes:
        children = node.child("Children") if node.name == "Model" else None
        for i in range(len(children.properties) if children is not None else 0):
            yield Link(children.text(i), node.text())  # type: ignore[union-attr]


def _kind(node: Node) -> str:
    inner = node.child("Type")
    return node.text(len(node.properties) - 1) if len(node.properties) > 1 or inner is None else inner.text()


def _old_defaults(node: Node) -> Properties:
    """FBX 5 keeps the default transform of a model as channels without keys."""
    found: dict[str, tuple[Property, ...]] = {}
    names = {"T": "Lcl Translation", "R": "Lcl Rotation", "S": "Lcl Scaling"}
    for transform in node.all("Channel"):
        for channel in transform.all("Channel"):
            values = [part.child("Default") for part in channel.all("Channel")]
            if channel.text() in names and len(values) == 3:
                found[names[channel.text()]] = tuple(value.number() if value is not None else 0.0 for value in values)
    return found


def read_properties(node: Node) -> Properties:
    """Values by property name out of a node's Properties70 or Properties60 block; empty where there is none."""
    found: dict[str, tuple[Property, ...]] = {}
    for block, entry, skip in (("Properties70", "P", 4), ("Properties60", "Property", 3)):
        home = node.child(block)
        for item in home.all(entry) if home is not None else ():
            found[item.text()] = item.properties[skip:]
    return found


def object_name(node: Node) -> str:
    """An object's own name, without its class (``Hips\\0\\1Model`` and ``Model::Hips`` are both ``Hips``)."""
    text = next((p for p in node.properties if isinstance(p, str)), "")
    name = text.split("\x00\x01", 1)[0] if "\x00\x01" in text else text.split("::", 1)[-1]
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def _number(properties: Properties, name: str, default: float) -> float:
    value = next(iter(properties.get(name, ())), default)
    return float(value) if isinstance(value, int | float) else default


def _integer(properties: Properties, name: str, default: int) -> int:
    number = _number(properties, name, float(default))
    return int(number) if np.isfinite(number) else default
