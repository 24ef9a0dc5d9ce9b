"""What of a document's text reaches OpenTimelineIO: the fields an edit needs, in shapes that its parser survives.

That parser is compiled and trusts its input: deep nesting, an old clip whose medium is no medium, references between
objects and the schema names of its own tests end the whole process. So Python's parser comes first, this sieve second.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from kinestitch.errors import DocumentError

KEY = "kinestitch"
"""The one metadata key under which everything of ours stands."""

MAX_DEPTH = 200
"""Levels of nesting; a timeline has about ten."""

_KEPT = frozenset(
    {"OTIO_SCHEMA", "name", "tracks", "children", "kind", "enabled", "source_range", "start_time", "duration"}
    | {"rate", "value", "in_offset", "out_offset", "transition_type", "available_range", "target_url"}
    | {"media_reference", "media_references", "active_media_reference_key"}
)
_SCHEMAS = frozenset(
    {"Timeline", "Stack", "Track", "Sequence", "Clip", "Gap", "Filler", "Transition", "RationalTime", "TimeRange"}
    | {"ExternalReference", "MissingReference", "SerializableCollection", "SerializeableCollection"}
)
_EFFECT = {"OTIO_SCHEMA": "Effect.1", "name": "", "effect_name": ""}


def sieved_text(path: Path) -> str:
    """The document as JSON with what is not needed left out, and each table of ours sealed as one text.

    Sealed, since OpenTimelineIO's parser misses one double in ten by its last digit; Python's reads them exactly.
    Raises DocumentError for anything that is not JSON in UTF-8.
    """
    try:
        tree = json.loads(path.read_bytes().decode("utf-8-sig"))
    except IsADirectoryError as error:
        raise DocumentError("Expected a document, got a folder.") from error
    except RecursionError as error:
        raise DocumentError(f"Expected at most {MAX_DEPTH} levels of nesting, got far more.") from error
    except ValueError as error:
        raise DocumentError(f"Expected JSON in UTF-8, got a damaged file: {error}.") from error
    return json.dumps(_sieved(tree, 0))


def opened(sealed: Any) -> Any:
    """A table of ours as it stood in the document; an empty one where there is none."""
    return json.loads(sealed or "{}")


def _sieved(node: Any, depth: int) -> Any:
    if depth > MAX_DEPTH:
        raise DocumentError(f"Expected at most {MAX_DEPTH} levels of nesting, got more.")
    if isinstance(node, list):
        return [_sieved(entry, depth + 1) for entry in node]
    if not isinstance(node, dict):
        return node
    schema = node.get("OTIO_SCHEMA")
    if schema is not None and not re.fullmatch(r"\w+\.[1-9][0-9]{0,3}", str(schema)):
        raise DocumentError(f"Expected schema names such as Clip.2, got {schema!r:.60}.")
    if schema is not None and re.match(r"(?!External)\w+Reference\.", schema):
        node, schema = {**node, "OTIO_SCHEMA": "MissingReference.1"}, "MissingReference.1"
    if schema is not None and schema.split(".")[0] not in _SCHEMAS:
        return {"OTIO_SCHEMA": "KinestitchUnread.1", "name": schema[:40]}
    # A table without a schema is one of media by name, whose keys are anybody's choice.
    kept = {name: _sieved(entry, depth + 1) for name, entry in node.items() if name in _KEPT or schema is None}
    metadata, effects = node.get("metadata"), node.get("effects")
    if isinstance(metadata, dict) and KEY in metadata:
        kept["metadata"] = {KEY: json.dumps(metadata[KEY])}
    if isinstance(effects, list) and effects:
        kept["effects"] = [_EFFECT] * len(effects)
    if schema == "Clip.1":
        kept["OTIO_SCHEMA"] = "Clip.2"
        kept["media_references"] = {"DEFAULT_MEDIA": kept.pop("media_reference", None)}
        kept["active_media_reference_key"] = "DEFAULT_MEDIA"
    return kept
