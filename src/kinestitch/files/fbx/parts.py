"""New objects and connections, gathered with keys of their own before they become part of a document."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field

from kinestitch.files.fbx.build import node
from kinestitch.files.fbx.nodes import Node
from kinestitch.files.fbx.scene import Key

_CLASSES = {
    "AnimationStack": "AnimStack",
    "AnimationLayer": "AnimLayer",
    "AnimationCurve": "AnimCurve",
    "AnimationCurveNode": "AnimCurveNode",
}


@dataclass(slots=True)
class Parts:
    """Objects and connections as they are gathered.

    taken : keys that are in use already
    """

    taken: Container[Key] = frozenset()
    objects: list[Node] = field(default_factory=list)
    links: list[Node] = field(default_factory=list)
    last: int = 1_000_000

    def key(self) -> int:
        """A key that nothing else has."""
        self.last += 1
        while self.last in self.taken:
            self.last += 1
        return self.last

    def add(self, name: str, title: str, kind: str, children: Sequence[Node]) -> int:
        """Gather an object and return its key."""
        key = self.key()
        label = f"{title}\x00\x01{_CLASSES.get(name, name)}"
        self.objects.append(node(name, "LSS", key, label, kind, children=children))
        return key

    def link(self, child: Key, parent: Key, name: str = "") -> None:
        """Hang `child` on `parent`, or have it drive the property `name` of it."""
        if name:
            self.links.append(node("C", "SLLS", "OP", child, parent, name))
        else:
            self.links.append(node("C", "SLL", "OO", child, parent))
