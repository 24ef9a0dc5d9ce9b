"""Cut motion-capture clips together; the seams solve themselves.

>>> import kinestitch as ks
>>> walk, kick = ks.sample("walk"), ks.sample("kick")
>>> timeline = ks.replace(ks.timeline({"walk": walk, "kick": kick}, "walk"), 40, 60, "kick", 10, 50)
>>> ks.stitch(timeline, {"walk": walk, "kick": kick}).frames == walk.frames + 20
True
"""

from __future__ import annotations

__version__ = "0.1.0"
