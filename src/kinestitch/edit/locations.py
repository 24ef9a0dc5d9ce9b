"""Where a document's clips lie: paths relative to the document, written as URLs so that other programs find them."""

from __future__ import annotations

import os
import re
from pathlib import Path
from urllib.parse import quote, unquote_to_bytes

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):")
"""At least two letters: ``C:`` is a drive."""


def to_url(source: str | os.PathLike[str], folder: Path, base: Path) -> str:
    """The URL of a clip as seen from a document's folder: relative where both are on one drive.

    source : a path (a relative one counts from `base`), or a URL with ``://``, which stays as it is
    """
    text = os.fspath(source)
    if "://" in text and _SCHEME.match(text) and not text.lower().startswith("file:"):
        return text
    path = base / from_url(text, base) if text.lower().startswith("file://") else base / text
    # Symbolic links in the folders are followed, since `..` counts from the real folder; a linked clip keeps its name.
    real = Path(os.path.realpath(path.parent)) / path.name
    try:
        relative = os.path.relpath(real, os.path.realpath(folder))
    except ValueError:
        return real.as_uri()
    return quote(os.fsencode(Path(relative).as_posix()), safe="/")


def from_url(url: str, folder: Path) -> str:
    """The absolute path a document's URL means, counted from the document's folder; other URLs than files stay."""
    scheme = _SCHEME.match(url)
    if scheme is None:
        text = os.fsdecode(unquote_to_bytes(url))
        return os.path.normpath(Path(os.path.realpath(folder)) / text)
    if scheme[1].lower() != "file":
        return url
    text = os.fsdecode(unquote_to_bytes(re.sub(r"^file:(//[^/]*)?", "", url, flags=re.IGNORECASE)))
    return os.path.normpath(re.sub(r"^/([A-Za-z]:)", r"\1", text))
