"""The clips an experiment runs on: folders of real ones, or the generated samples where there are none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from kinestitch import files
from kinestitch.core.motion import Motion
from kinestitch.samples import SAMPLE_NAMES, sample

FOLDERS = {"mixamo": "mixamo_xbot_60fps", "bandai": "bandai", "cmu": "cmu"}
_SHORTEST = 16  # frames


@dataclass(frozen=True, eq=False, slots=True)
class DataSet:
    """Clips of one skeleton and rate by name; `real` unless they are the generated samples.

    place : the folder that holds the folders of all data sets, None for the samples
    """

    name: str
    clips: Mapping[str, Motion]
    real: bool
    place: Path | None = None

    def find(self, *names: str) -> tuple[str, ...]:
        """The first clip for each wish whose name matches it best: exact, then beginning, then anywhere, then the
        longest.
        """
        return tuple(self._find(name) for name in names)

    def _find(self, wish: str) -> str:
        wish = wish.lower()
        for test in (str.__eq__, str.startswith, str.__contains__):
            for name in self.clips:
                if test(name.lower(), wish):
                    return name
        return max(self.clips, key=lambda name: self.clips[name].frames)


def read_folder(folder: Path) -> dict[str, Motion]:
    """All BVH and FBX clips of a folder that share the skeleton's joints and the rate of the commonest kind, by
    stem.
    """
    groups: dict[tuple[tuple[str, ...], float], dict[str, Motion]] = {}
    for path in sorted(p for p in folder.iterdir() if p.suffix.lower() in {".bvh", ".fbx"}):
        motion = files.read(path)
        if motion.frames >= _SHORTEST:
            groups.setdefault((motion.skeleton.names, round(motion.fps)), {})[path.stem] = motion
    return max(groups.values(), key=len) if groups else {}


@cache
def load(folder: Path | None, name: str) -> DataSet:
    """A data set by its short name (``mixamo``, ``bandai``, ``cmu``); the samples where the folder has none of its
    clips.
    """
    place = None if folder is None else folder / FOLDERS[name]
    if place is not None and place.is_dir():
        clips = read_folder(place)
        if clips:
            return DataSet(name, clips, real=True, place=folder)
    return DataSet("samples", {key: sample(key) for key in SAMPLE_NAMES}, real=False)
