"""What a document holds that is ours alone: its version, how old versions become new, and the seams and clips as data.

Everything here is plain dicts and lists, as JSON has them; ``document`` puts it under the metadata key ``kinestitch``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from kinestitch.edit.pins import Pin
from kinestitch.edit.retiming import Retiming
from kinestitch.edit.timeline import ClipInfo, Seam
from kinestitch.errors import DocumentError

SCHEMA = 1
"""Version of the layout below; raise it, with an entry in UPGRADES, when a field changes its meaning."""


@dataclass(slots=True)
class Own:
    """What is ours in one document.

    timeline : ``schema``, ``written_by``, ``fps``, ``clips`` (list of ``key``, ``frames``, ``fps`` and maybe ``url``; a
        retimed one has a ``retiming`` with its source's key, ``clip``, and ``knots``), ``foot_lock`` where it is false
    segments : for each segment ``clip``, the key, ``seam``, the settings of the seam in front of it, and maybe
        ``pins``, whose frames are those of the clip at the timeline's rate
    """

    timeline: dict[str, Any]
    segments: list[dict[str, Any]]
    ignored: Counter[str] = field(default_factory=Counter)


def _from_0(own: Own) -> Own:
    """Before 1 the seams stood in one list, so that they lost their places when another program moved a segment."""
    old = own.timeline
    names = {"lambda": "stiffness", "seconds": "smoothing"}
    clips = [{"key": key, "frames": frames, "fps": fps} for key, (frames, fps) in old["clips"].items()]
    segments = [{"clip": segment["key"]} for segment in own.segments]
    for segment, seam in zip(segments[1:], old["seams"], strict=True):
        segment["seam"] = {names.get(name, name): value for name, value in seam.items()}
    known = {"rate", "clips", "seams"}
    rest = {name: value for name, value in old.items() if name not in known}
    return Own({**rest, "schema": 1, "fps": old["rate"], "clips": clips}, segments, own.ignored)


UPGRADES: dict[int, Callable[[Own], Own]] = {0: _from_0}
"""From a version to the next one."""


def upgraded(own: Own) -> Own:
    """The same in today's layout; raises DocumentError for a version from the future or none at all."""
    version = own.timeline.get("schema")
    if type(version) is not int or version < 0:
        raise DocumentError(f"Expected a schema version from 0 to {SCHEMA}, got {version!r}.")
    if version > SCHEMA:
        writer = own.timeline.get("written_by", "a newer kinestitch")
        raise DocumentError(
            f"Expected a schema version up to {SCHEMA}, got {version}, written by {writer}. Update kinestitch."
        )
    while version < SCHEMA:
        try:
            own = UPGRADES[version](own)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise DocumentError(f"Expected a complete document of schema version {version}, got {error!r}.") from error
        version += 1
    return own


def seam_data(seam: Seam) -> dict[str, Any]:
    """A seam's settings that are not left to the default."""
    settings = {entry.name: getattr(seam, entry.name) for entry in fields(seam)}
    return {name: value for name, value in settings.items() if value is not None and value is not False}


def seam_from(data: object, ignored: Counter[str]) -> Seam:
    """A seam from its settings; fields nobody knows are counted and left out."""
    names = {entry.name for entry in fields(Seam)}
    return Seam(**known_fields(checked(data, dict, "a seam"), names, ignored))


def pin_data(pin: Pin, shift: int) -> dict[str, Any]:
    """A pin's settings that are not left to the default, its frame moved by `shift`."""
    data: dict[str, Any] = {"kind": pin.kind, "frame": pin.frame + shift, "target": list(pin.target)}
    if not pin.exact:
        data["weight"] = pin.weight
    optional = {"joint": pin.joint, "smoothing": pin.smoothing}
    return data | {name: value for name, value in optional.items() if value is not None}


def pin_from(data: object, ignored: Counter[str]) -> Pin:
    """A pin from its settings; fields nobody knows are counted and left out."""
    entries = known_fields(checked(data, dict, "a pin"), {entry.name for entry in fields(Pin)}, ignored)
    kind = checked(entries.pop("kind", None), str, "a pin's kind")
    frame = checked(entries.pop("frame", None), int, "a pin's frame")
    numbers = checked(entries.pop("target", None), list, "a pin's target")
    if "joint" in entries:
        checked(entries["joint"], str, "a pin's joint")
    for name in {"weight", "smoothing"} & set(entries):
        entries[name] = number(entries[name], f"a pin's {name}")
    return Pin(kind, frame, tuple(number(value, "a pin's target") for value in numbers), **entries)


def clip_data(info: ClipInfo, url: str | None) -> dict[str, Any]:
    """What is known of a clip."""
    data: dict[str, Any] = {"key": info.key, "frames": info.frames, "fps": info.fps}
    if info.retiming is not None:
        data["retiming"] = {"clip": info.retiming.clip, "knots": [list(knot) for knot in info.retiming.knots]}
    return data if url is None else {**data, "url": url}


def clip_from(data: object, ignored: Counter[str]) -> tuple[ClipInfo, str | None]:
    """A clip and its URL, if it has one."""
    entries = known_fields(checked(data, dict, "a clip"), {"key", "frames", "fps", "url", "retiming"}, ignored)
    url = entries.get("url")
    info = ClipInfo(
        checked(entries.get("key"), str, "a clip's key"),
        checked(entries.get("frames"), int, "a clip's frames"),
        number(entries.get("fps"), "a clip's fps"),
        _retiming_from(entries["retiming"], ignored) if "retiming" in entries else None,
    )
    return info, None if url is None else checked(url, str, "a clip's url")


def _retiming_from(data: object, ignored: Counter[str]) -> Retiming:
    entries = known_fields(checked(data, dict, "a retiming"), {"clip", "knots"}, ignored)
    knots = tuple(_knot_from(knot) for knot in checked(entries.get("knots"), list, "a retiming's knots"))
    return Retiming(checked(entries.get("clip"), str, "a retiming's clip"), knots)


def _knot_from(data: object) -> tuple[float, float]:
    pair = checked(data, list, "a knot")
    if len(pair) != 2:
        raise DocumentError(f"Expected a knot of two times, got {len(pair)} values.")
    return number(pair[0], "a knot's time"), number(pair[1], "a knot's time")


def known_fields(data: Mapping[str, Any], names: set[str], ignored: Counter[str]) -> dict[str, Any]:
    """Those fields that this version knows; the others are counted."""
    ignored.update(f"unknown setting {name!r}" for name in data if name not in names)
    return {name: value for name, value in data.items() if name in names}


def checked(value: Any, kind: type, what: str) -> Any:
    """The value, if it is of this kind; raises DocumentError otherwise."""
    if not isinstance(value, kind) or isinstance(value, bool):
        told = "nothing" if value is None else f"{value!r:.60}"
        kinds = {dict: "a table", list: "a list", str: "text", int: "a whole number"}
        raise DocumentError(f"Expected {what} to be {kinds[kind]}, got {told}.")
    return value


def number(value: Any, what: str) -> float:
    """The value, if it is a number; raises DocumentError otherwise."""
    return float(value) if isinstance(value, float) else float(checked(value, int, what))
