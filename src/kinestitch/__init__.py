"""Cut motion-capture clips together; the seams solve themselves.

>>> import kinestitch as ks
>>> clips = {"walk": ks.sample("walk"), "kick": ks.sample("kick")}
>>> line = ks.replace(ks.timeline(clips, "walk"), 40, 60, "kick", 10, 50)
>>> ks.stitch(line, clips).frames == clips["walk"].frames + 20
True

These names are the front door. Each loads what it needs when it is first used, so that importing the package costs
next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kinestitch.analysis.quality import report
    from kinestitch.core.motion import Motion
    from kinestitch.core.skeleton import Skeleton
    from kinestitch.edit.operations import append, delete, insert, replace
    from kinestitch.edit.timeline import Seam, Timeline, timeline
    from kinestitch.files import read, write
    from kinestitch.rig.retarget import retarget
    from kinestitch.samples import sample
    from kinestitch.solve.stitch import solve_timeline, stitch

__version__ = "0.1.0"

__all__ = [
    "Motion",
    "Seam",
    "Skeleton",
    "Timeline",
    "append",
    "delete",
    "insert",
    "read",
    "replace",
    "report",
    "retarget",
    "sample",
    "solve_timeline",
    "stitch",
    "timeline",
    "write",
]

_ROOMS = {
    "Motion": "core.motion",
    "Seam": "edit.timeline",
    "Skeleton": "core.skeleton",
    "Timeline": "edit.timeline",
    "append": "edit.operations",
    "delete": "edit.operations",
    "insert": "edit.operations",
    "read": "files",
    "replace": "edit.operations",
    "report": "analysis.quality",
    "retarget": "rig.retarget",
    "sample": "samples",
    "solve_timeline": "solve.stitch",
    "stitch": "solve.stitch",
    "timeline": "edit.timeline",
    "write": "files",
}


def __getattr__(name: str) -> object:
    if name not in _ROOMS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_ROOMS[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
