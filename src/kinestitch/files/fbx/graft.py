"""Changes to a parsed document: objects replaced, added and taken out; whatever is not named stays as it stood."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from kinestitch.files.fbx.build import node
from kinestitch.files.fbx.build import properties as block_of
from kinestitch.files.fbx.nodes import Document, Node, Property
from kinestitch.files.fbx.parts import Parts
from kinestitch.files.fbx.scene import Key, Link, Scene, link_of

Entry = tuple[str, str, str, str, Sequence[float | str]]


@dataclass(eq=False)
class Graft:
    """What shall become different in the document of `scene`, gathered before it is made.

    parts : new objects and connections
    replaced : objects that take the place of those with their key
    dropped : keys of objects that go, with all their connections
    unlinked : connections that go
    tops : top nodes that take the place of those with their name
    """

    scene: Scene
    parts: Parts = field(init=False)
    replaced: dict[Key, Node] = field(default_factory=dict)
    dropped: set[Key] = field(default_factory=set)
    unlinked: set[Link] = field(default_factory=set)
    tops: dict[str, Node] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.parts = Parts(self.scene.objects.keys())

    @cached_property
    def above(self) -> dict[Key, list[Link]]:
        """Connections by the key of their child."""
        found: dict[Key, list[Link]] = {}
        for link in self.scene.links:
            found.setdefault(link.child, []).append(link)
        return found

    def document(self) -> Document:
        """The document with every change made."""
        old = self.scene.document
        made = {"Objects": self._objects(), "Connections": self._connections(), **self._definitions(), **self.tops}
        nodes = [made.pop(entry.name, entry) for entry in old.nodes]
        return replace(old, nodes=(*nodes, *made.values()))

    def _objects(self) -> Node:
        home = self.scene.document.child("Objects") or node("Objects")
        gone = {id(self.scene.objects[key]) for key in self.dropped}
        swapped = {id(self.scene.objects[key]): entry for key, entry in self.replaced.items()}
        kept = [swapped.get(id(entry), entry) for entry in home.children if id(entry) not in gone]
        return with_children(home, [*kept, *self.parts.objects])

    def _connections(self) -> Node:
        home = self.scene.document.child("Connections") or node("Connections")
        return with_children(home, [*(entry for entry in home.children if self._stays(entry)), *self.parts.links])

    def _stays(self, entry: Node) -> bool:
        link = link_of(entry)
        return link is None or not (link in self.unlinked or {link.child, link.parent} & self.dropped)

    def _definitions(self) -> dict[str, Node]:
        """The counts of objects by type, where they change and the file keeps any."""
        home = self.scene.document.child("Definitions")
        more = Counter(entry.name for entry in self.parts.objects)
        more.subtract(self.scene.objects[key].name for key in self.dropped)
        if home is None or not any(more.values()):
            return {}
        total = len(self.parts.objects) - len(self.dropped)
        known = {
            id(entry): total if entry.name == "Count" else more.pop(entry.text(), 0)
            for entry in home.children
            if entry.name in {"Count", "ObjectType"}
        }
        children = [_counted(entry, known.get(id(entry), 0)) for entry in home.children]
        fresh = [node("ObjectType", "S", name, children=[node("Count", "I", n)]) for name, n in more.items() if n > 0]
        return {"Definitions": with_children(home, [*children, *fresh])}


def _counted(entry: Node, added: int) -> Node:
    """A count, or a type with a count in it, that is higher by so much."""
    if not added:
        return entry
    if entry.name == "Count":
        return with_values(entry, [entry.integer() + added])
    return with_children(entry, [_counted(c, added) if c.name == "Count" else c for c in entry.children])


def with_children(entry: Node, children: Iterable[Node]) -> Node:
    """The node with other children."""
    return replace(entry, children=tuple(children), terminated=True)


def with_values(entry: Node, values: Sequence[Property], first: int = 0) -> Node:
    """The node with other properties from the one of that number on; their types stay. Itself where nothing changes."""
    if list(entry.properties[first:]) == list(values):
        return entry
    return replace(entry, properties=(*entry.properties[:first], *values))


def with_properties(entry: Node, *entries: Entry) -> Node:
    """The node with these in its Properties70 block; those with the same value as before stay as they stood."""
    block = entry.child("Properties70")
    items = list(block.children) if block is not None else []
    for wanted in block_of(*entries).children:
        place = next((i for i, item in enumerate(items) if item.text() == wanted.text()), len(items))
        old = items[place] if place < len(items) else wanted
        same_types = old.codes[4:] == wanted.codes[4:]
        items[place : place + 1] = [with_values(old, wanted.properties[4:], 4) if same_types else wanted]
    made = with_children(block if block is not None else node("Properties70"), items)
    if block is None:
        return with_children(entry, [*entry.children, made])
    return with_children(entry, [made if child is block else child for child in entry.children])
