"""Time other programs' importers from inside. Runs in .venv-bpy or .venv-ufbx, as a child of test_importer_speed.py.

    python time_importers.py PROGRAM ROUNDS FILE ...

PROGRAM is bpy or ufbx. Prints one JSON object: least seconds of ROUNDS for each importer and file, after one warm-up.
"""

import ctypes
import gc
import json
import os
import sys
from pathlib import Path
from time import perf_counter


def with_bpy(path):
    """Importers by name; each fills an empty scene."""
    import bpy

    version = f"Blender {bpy.app.version_string}"
    if path.endswith(".bvh"):
        return {version: (empty_scene, lambda: bpy.ops.import_anim.bvh(filepath=path))}
    calls = {f"{version}, wm.fbx_import": (empty_scene, lambda: bpy.ops.wm.fbx_import(filepath=path))}
    if "io_scene_fbx" in bpy.context.preferences.addons:
        calls[f"{version}, import_scene.fbx"] = (empty_scene, lambda: bpy.ops.import_scene.fbx(filepath=path))
    return calls


def empty_scene():
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)


def with_ufbx(path):
    """The scene alone, and the local transforms of all nodes on all frames of its keys' rate."""
    from importlib.metadata import version

    import ufbx

    gc.disable()  # the collector stumbles over what ufbx 0.0.5 hands out

    def load():
        return ufbx.load_file(path)

    def load_and_pose():
        scene = load()
        rate = scene.settings.frames_per_second
        frames = round((scene.anim.time_end - scene.anim.time_begin) * rate) + 1
        poses = []
        for frame in range(frames):
            posed = scene.evaluate(scene.anim, scene.anim.time_begin + frame / rate)
            for index in range(len(posed.nodes)):
                node = posed.nodes[index]
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(node))  # ufbx 0.0.5 forgets to hand out a reference
                local = node.local_transform
                poses.append((tuple(local.translation), tuple(local.rotation)))
        return scene, poses

    name = f"ufbx {version('ufbx')} for Python"
    return {f"{name}, no poses": (nothing, load), f"{name}, every frame posed": (nothing, load_and_pose)}


def nothing():
    """No preparation."""


def least(prepare, call, rounds):
    times = []
    for _ in range(rounds + 1):
        prepare()
        begun = perf_counter()
        kept = call()
        times.append(perf_counter() - begun)
        del kept
    return min(times[1:])


def main(program, rounds, paths):
    importers = {"bpy": with_bpy, "ufbx": with_ufbx}[program]
    kept = os.dup(1)
    os.dup2(2, 1)  # importers print to the standard output
    found = {
        path: {name: least(*calls, rounds) for name, calls in importers(str(Path(path).absolute())).items()}
        for path in paths
    }
    os.write(kept, json.dumps(found).encode())
    os._exit(0)  # ufbx 0.0.5 may crash while the interpreter takes its objects down


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3:])
