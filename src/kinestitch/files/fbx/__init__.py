"""FBX: our own codec of the node tree, the evaluation of its scenes, and writers of skeletons and kept characters."""

from kinestitch.files.fbx.keep import has_character_fbx
from kinestitch.files.fbx.presets import PRESETS
from kinestitch.files.fbx.read import list_takes, read_fbx
from kinestitch.files.fbx.write import write_fbx

__all__ = ["PRESETS", "has_character_fbx", "list_takes", "read_fbx", "write_fbx"]
