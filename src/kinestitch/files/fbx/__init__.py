"""FBX: our own codec of the node tree, the evaluation of its scenes, and a writer of skeletons."""

from kinestitch.files.fbx.read import list_takes, read_fbx
from kinestitch.files.fbx.write import write_fbx

__all__ = ["list_takes", "read_fbx", "write_fbx"]
