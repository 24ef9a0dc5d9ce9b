"""One take of a file told anew: its curves, its length and its rate; every other take stays as it stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError
from kinestitch.files.fbx.animation import LOCAL, Take
from kinestitch.files.fbx.build import curve_keys, properties, takes, time_mode
from kinestitch.files.fbx.graft import Entry, Graft, with_children, with_properties, with_values
from kinestitch.files.fbx.nodes import Node
from kinestitch.files.fbx.scene import Key, Link
from kinestitch.files.fbx.unpose import Said

Ticks = NDArray[np.int64]
_SHORT = {"Lcl Translation": "T", "Lcl Rotation": "R", "Lcl Scaling": "S"}
_TINY = 1e-7  # of a unit or a degree, beside single precision
_SPANS = ("LocalStart", "LocalStop", "ReferenceStart", "ReferenceStop")


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Where a take is written: its stack and its layers, the base first."""

    stack: Key
    layers: tuple[Key, ...]


def sheet_of(graft: Graft, take: Take | None, places: tuple[Take, ...], title: str) -> Sheet:
    """The stack and the layers of a take, made where the file has none of them.

    Raises FormatError where the base layer is muted.
    """
    scene = graft.scene
    stacks = [key for key, entry in scene.objects.items() if entry.name == "AnimationStack"]
    if take is None:
        stack: Key = graft.parts.add("AnimationStack", title, "", [properties()])
        layers: list[Key] = []
    else:
        if next(iter(take.layers[0].properties.get("Mute", ())), 0) if take.layers else 0:
            raise FormatError(f"Expected a base layer that is heard, got a muted one in take {take.name!r}. Unmute it.")
        stack = stacks[next(i for i, place in enumerate(places) if place is take)]
        links = scene.children.get(stack, [])
        layers = [link.child for link in links if _is_a(graft, link.child, "AnimationLayer")]
    if not layers:
        layers = [graft.parts.add("AnimationLayer", "BaseLayer", "", [])]
        graft.parts.link(layers[0], stack)
    return Sheet(stack, tuple(layers))


def tell(graft: Graft, sheet: Sheet, take: Take | None, said: dict[Key, Said], ticks: Ticks) -> None:
    """Put what the models have to say into the base layer, and take the other layers off them.

    The first joint keeps every key, so that a still clip keeps its length. Everything else that stands still gets one
    key, or none where it has no curve and its default says the same.
    """
    told = {target for layer in (take.layers if take is not None else ()) for target in layer.tracks}
    moving = {target for target, curve in (take.curves() if take is not None else ()) if len(curve.times) > 1}
    first = next(key for key, values in said.items() if values.translation is not None)
    for key, values in said.items():
        model = graft.scene.models[key]
        for name, still, path in zip(LOCAL, values.still, (values.translation, values.rotation, None), strict=True):
            usual = model.vector(name, 1.0 if name == LOCAL[2] else 0.0)
            if path is None:
                if (key, name) in moving:
                    _track(graft, sheet, (key, name), ticks, still[None], whole=False)
            elif key == first or (key, name) in told or np.abs(path - usual).max() > _TINY:
                _track(graft, sheet, (key, name), ticks, path, whole=key == first)


def _track(graft: Graft, sheet: Sheet, target: tuple[Key, str], ticks: Ticks, values: Array, *, whole: bool) -> None:
    """The three curves of one property of one model, values (F, 3) or (1, 3)."""
    key, name = target
    groups = [
        (layer, link.child)
        for layer in sheet.layers
        for link in graft.scene.children.get(layer, [])
        if target in graft.scene.driven.get(link.child, []) and _is_a(graft, link.child, "AnimationCurveNode")
    ]
    own = next((there for layer, there in groups if layer == sheet.layers[0] and _alone(graft, there)), None)
    for layer, there in groups:
        if there != own:
            _release(graft, layer, there, target)
    group: Key
    if own is not None:
        group = own
    else:
        defaults: list[Entry] = [
            (f"d|{axis}", "Number", "", "A", [float(values[0, i])]) for i, axis in enumerate("XYZ")
        ]
        group = graft.parts.add("AnimationCurveNode", _SHORT[name], "", [properties(*defaults)])
        graft.parts.link(group, sheet.layers[0])
        graft.parts.link(group, key, name)
    for i, axis in enumerate("XYZ"):
        path = values[:, i]
        still = np.ptp(path) <= _TINY * 1e-2 * (1 + np.abs(path).max())
        count = len(path) if whole or not still else 1
        _keys(graft, group, f"d|{axis}", ticks[:count], path[:count])


def _is_a(graft: Graft, key: Key, kind: str) -> bool:
    return key in graft.scene.objects and graft.scene.objects[key].name == kind


def _alone(graft: Graft, group: Key) -> bool:
    """Whether a curve node hangs on one layer and drives one property."""
    links = graft.above.get(group, [])
    return len(links) == 2 and sum(bool(link.name) for link in links) == 1


def _release(graft: Graft, layer: Key, group: Key, target: tuple[Key, str]) -> None:
    """Have a curve node drive the target no more; one that drives nothing else goes, with its curves."""
    if _alone(graft, group):
        graft.dropped.add(group)
        for link in graft.scene.children.get(group, []):
            if len(graft.above[link.child]) == 1 and _is_a(graft, link.child, "AnimationCurve"):
                graft.dropped.add(link.child)
        return
    if any(not link.name and link.parent != layer for link in graft.above[group]):
        name = graft.scene.models[target[0]].name
        raise FormatError(f"Expected takes of their own curves, got shared ones that move {name!r}. Export it again.")
    graft.unlinked.add(Link(group, *target))


def _keys(graft: Graft, group: Key, name: str, ticks: Ticks, values: Array) -> None:
    """One curve: put in the place of the one there is, else added."""
    scene = graft.scene
    there = [
        link.child
        for link in scene.children.get(group, [])
        if link.name == name and _is_a(graft, link.child, "AnimationCurve")
    ]
    own = next((curve for curve in there if len(graft.above[curve]) == 1), None)
    graft.unlinked.update(Link(curve, group, name) for curve in there if curve != own)
    if own is not None:
        old = scene.objects[own]
        version = old.child("KeyVer")
        keys = curve_keys(ticks, values, version.integer(0, 4008) if version is not None else 4008)
        graft.replaced[own] = with_children(old, keys)
    else:
        graft.parts.link(graft.parts.add("AnimationCurve", "", "", curve_keys(ticks, values)), group, name)


def stretch(graft: Graft, sheet: Sheet, take: Take | None, ticks: Ticks, fps: float, title: str) -> None:
    """Tell the take's new length wherever the file says it, and the rate where it is another."""
    start, stop = int(ticks[0]), int(ticks[-1])
    spans: list[Entry] = [(name, "KTime", "Time", "", [stop if "Stop" in name else start]) for name in _SPANS]
    if take is None:
        graft.parts.objects = [
            with_properties(entry, *spans) if entry.name == "AnimationStack" else entry for entry in graft.parts.objects
        ]
    else:
        graft.replaced[sheet.stack] = with_properties(graft.scene.objects[sheet.stack], *spans)
    _stretch_settings(graft, start, stop, fps)
    _stretch_listing(graft, take, start, stop, title)


def _stretch_settings(graft: Graft, start: int, stop: int, fps: float) -> None:
    entries: list[Entry] = [
        ("TimeSpanStart", "KTime", "Time", "", [start]),
        ("TimeSpanStop", "KTime", "Time", "", [stop]),
    ]
    if abs(graft.scene.fps - fps) > 1e-7 * fps:
        mode, custom = time_mode(fps)
        entries += [
            ("TimeMode", "enum", "", "", [mode]),
            ("CustomFrameRate", "double", "Number", "", [custom]),
        ]
    home = graft.scene.document.child("GlobalSettings") or Node("GlobalSettings")
    graft.tops["GlobalSettings"] = with_properties(home, *entries)


def _stretch_listing(graft: Graft, take: Take | None, start: int, stop: int, title: str) -> None:
    home = graft.scene.document.child("Takes")
    if home is None:
        return
    if take is None:
        entry = next(takes(title, stop).all("Take"))
        graft.tops["Takes"] = with_children(home, [*home.children, entry])
        return
    children = [
        with_children(entry, [_span(child, start, stop) for child in entry.children])
        if entry.name == "Take" and entry.text() == take.name
        else entry
        for entry in home.children
    ]
    graft.tops["Takes"] = with_children(home, children)


def _span(entry: Node, start: int, stop: int) -> Node:
    return with_values(entry, [start, stop]) if entry.name in {"LocalTime", "ReferenceTime"} else entry
