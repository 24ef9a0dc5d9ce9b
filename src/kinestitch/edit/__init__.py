"""What the user wants: timelines of clip ranges, the edits that change them, their documents and their history."""

from kinestitch.edit.document import Document, load_document, save_document
from kinestitch.edit.history import History, commit, preview, redo, undo
from kinestitch.edit.operations import (
    add_clip,
    append,
    delete,
    insert,
    move,
    replace,
    set_seam,
    split,
    trim,
)
from kinestitch.edit.pinning import add_pin, come_back, remove_pin
from kinestitch.edit.pins import Pin, away_again, parse_pin, parse_waypoint
from kinestitch.edit.retiming import Retiming
from kinestitch.edit.script import Edit, apply_edits, parse_range, parse_source
from kinestitch.edit.speed import set_speed
from kinestitch.edit.timeline import DEFAULT_SEAM, DEFAULT_SMOOTHING, ClipInfo, FrameRange, Seam, Segment, Timeline

__all__ = [
    "DEFAULT_SEAM",
    "DEFAULT_SMOOTHING",
    "ClipInfo",
    "Document",
    "Edit",
    "FrameRange",
    "History",
    "Pin",
    "Retiming",
    "Seam",
    "Segment",
    "Timeline",
    "add_clip",
    "add_pin",
    "append",
    "apply_edits",
    "away_again",
    "come_back",
    "commit",
    "delete",
    "insert",
    "load_document",
    "move",
    "parse_pin",
    "parse_range",
    "parse_source",
    "parse_waypoint",
    "preview",
    "redo",
    "remove_pin",
    "replace",
    "save_document",
    "set_seam",
    "set_speed",
    "split",
    "trim",
    "undo",
]
