"""Mappings as files that a person edits: TOML, or JSON of the same shape.

::

    source_family = "CMU"
    target_family = "Mixamo"

    [joints]                      # target = source
    "mixamorig:Hips" = "Hips"
    "mixamorig:Spine" = { from = "Hips", to = "LowerBack", share = 0.75 }
"""

from __future__ import annotations

import json
import math
import os
import tomllib
from pathlib import Path
from typing import Any

from kinestitch.core.atomic import replacing
from kinestitch.errors import DocumentError, UnsupportedFormatError
from kinestitch.rig.mapping import Mapping, Pair

SUFFIXES = (".toml", ".json")
_KEYS = {"source_family", "target_family", "missing", "joints"}


def save_mapping(mapping: Mapping, path: str | os.PathLike[str]) -> None:
    """Write a mapping to a TOML or JSON file.

    Raises UnsupportedFormatError for another suffix, OutputError where the file cannot be written.
    """
    suffix = _suffix(path)
    joints = {
        pair.target: {"from": pair.source, "to": pair.towards, "share": pair.share} if pair.towards else pair.source
        for pair in mapping.pairs
    }
    head = {"source_family": mapping.source_family, "target_family": mapping.target_family}
    if suffix == ".json":
        text = json.dumps({**head, "missing": list(mapping.missing), "joints": joints}, indent=2, ensure_ascii=False)
    else:
        lines = [f"{key} = {_quoted(value)}" for key, value in head.items()]
        lines += [f"missing = [{', '.join(map(_quoted, mapping.missing))}]", "", "[joints]  # target = source"]
        lines += [f"{_quoted(target)} = {_value(source)}" for target, source in joints.items()]
        text = "\n".join(lines)
    with replacing(path) as stream:
        stream.write((text + "\n").encode("utf-8"))


def _suffix(path: str | os.PathLike[str]) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise UnsupportedFormatError(f"Expected a mapping that ends in {', '.join(SUFFIXES)}, got {suffix!r}. ({path})")
    return suffix


def _quoted(text: str) -> str:
    """A TOML basic string; JSON's escapes are TOML's, but for DEL."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(source: str | dict[str, Any]) -> str:
    if isinstance(source, str):
        return _quoted(source)
    return f"{{ from = {_quoted(source['from'])}, to = {_quoted(source['to'])}, share = {source['share']!r} }}"


def load_mapping(path: str | os.PathLike[str]) -> Mapping:
    """Read a mapping from a TOML or JSON file; whether rigs have its joints is checked where it is used.

    Raises UnsupportedFormatError for another suffix, DocumentError for a file that is no mapping, FileNotFoundError.
    """
    suffix = _suffix(path)
    data = Path(path).read_bytes()
    try:
        text = data.decode("utf-8-sig")
        content = tomllib.loads(text) if suffix == ".toml" else json.loads(text)
    except (ValueError, RecursionError) as error:
        why = str(error).splitlines()[0]
        raise DocumentError(f"Expected {suffix[1:].upper()}, got: {why}. Mend the file. ({path})") from error
    return _mapping(content, path)


def _mapping(content: object, path: str | os.PathLike[str]) -> Mapping:
    if not isinstance(content, dict) or not isinstance(content.get("joints"), dict):
        raise DocumentError(f"Expected a table 'joints' of target = source, got none. ({path})")
    unknown = sorted(set(content) - _KEYS)
    if unknown:
        raise DocumentError(f"Expected the keys {', '.join(sorted(_KEYS))}, got {unknown[0]!r}. Remove it. ({path})")
    pairs = tuple(_pair(target, source, path) for target, source in content["joints"].items())
    missing = content.get("missing", [])
    source, target = (content.get(key, "") for key in ("source_family", "target_family"))
    if not isinstance(missing, list) or not all(isinstance(text, str) for text in [*missing, source, target]):
        raise DocumentError(f"Expected families as text and 'missing' as a list of it. ({path})")
    return Mapping(pairs, source, target, tuple(missing))


def _pair(target: str, source: object, path: str | os.PathLike[str]) -> Pair:
    if isinstance(source, str):
        return Pair(target, source)
    if isinstance(source, dict) and set(source) == {"from", "to", "share"}:
        share = source["share"]
        texts = isinstance(source["from"], str) and isinstance(source["to"], str)
        number = isinstance(share, (int, float)) and not isinstance(share, bool) and math.isfinite(share)
        if texts and number and 0 <= share <= 1:
            return Pair(target, source["from"], source["to"], float(share))
    raise DocumentError(
        f"Expected a joint's name, or from, to and a share in [0, 1], for {target!r}, got {source!r}. ({path})"
    )
