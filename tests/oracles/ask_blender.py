"""Ask Blender what motion files say. Runs in .venv-bpy; one process serves a whole list.

    python ask_blender.py REQUESTS.json

REQUESTS.json is a list of {"path", "out", "fps", "frames", "unit" (metres, for BVH; default 1), "take" (optional)};
the suffix chooses the importer (.fbx, .bvh, .glb, .gltf, .usd, .usda, .usdc). Of several animations in one file Blender
shows `take`, else the one it made active.
For each, `out` becomes an .npz of names (N,), parents (N,), positions (F, N, 3) in metres and rotations (F, N, 3, 3),
both in the world with Y up, of the heads and axes of all bones, and armature (4, 4), where the first one stands in
Blender's own world; or of one text `error`. Blender turns bone axes to its liking, so compare rotations relative to
those of frame 0. Frame k is evaluated k / fps seconds after the first key.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

Y_UP = Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))


def load(path, fps, unit):
    """Import into an empty scene whose time line runs at `fps`: the importer of glTF counts in its frames, the one of
    BVH sets one key a frame.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = round(fps), round(fps) / fps
    suffix = Path(path).suffix.lower()
    if suffix == ".fbx":
        bpy.ops.wm.fbx_import(filepath=path)
    elif suffix == ".bvh":
        bpy.ops.import_anim.bvh(filepath=path, axis_forward="-Z", axis_up="Y", frame_start=1, global_scale=unit)
    elif suffix in {".glb", ".gltf"}:
        bpy.ops.import_scene.gltf(filepath=path)
    elif suffix in {".usd", ".usda", ".usdc"}:
        bpy.ops.wm.usd_import(filepath=path)
    else:
        raise ValueError(f"no importer for {suffix}")
    return scene


def show_take(name):
    """Have every armature play the action of this name, as an animator would choose it."""
    action = bpy.data.actions[name]
    for thing in bpy.context.scene.objects:
        if thing.type == "ARMATURE":
            thing.animation_data.action = action
            thing.animation_data.action_slot = action.slots[0]


def first_key(name=None):
    """Frame of the first key of any curve, or of those of one action."""
    starts = [action.frame_range[0] for action in bpy.data.actions if name in (None, action.name)]
    return min(starts, default=float(bpy.context.scene.frame_start))


def ask(request):
    scene = load(request["path"], request["fps"], request.get("unit", 1.0))
    armatures = [thing for thing in scene.objects if thing.type == "ARMATURE"]
    bones = [(thing, bone) for thing in armatures for bone in thing.pose.bones]
    index = {(thing.name, bone.name): i for i, (thing, bone) in enumerate(bones)}
    rate = scene.render.fps / scene.render.fps_base
    if "take" in request:
        show_take(request["take"])
    start = first_key(request.get("take"))
    positions = np.empty((request["frames"], len(bones), 3))
    rotations = np.empty((request["frames"], len(bones), 3, 3))
    for frame in range(request["frames"]):
        at = start + frame * rate / request["fps"]
        whole = int(np.floor(at + 1e-4))
        scene.frame_set(whole, subframe=max(0.0, at - whole))
        for i, (thing, bone) in enumerate(bones):
            matrix = Y_UP @ thing.matrix_world @ bone.matrix
            positions[frame, i] = matrix.translation
            rotations[frame, i] = matrix.to_3x3().normalized()
    parents = [index[thing.name, bone.parent.name] if bone.parent else -1 for thing, bone in bones]
    return {
        "names": np.array([bone.name for _, bone in bones]),
        "parents": np.array(parents),
        "positions": positions,
        "rotations": rotations,
        "fps": np.array(rate),
        "armature": np.array(armatures[0].matrix_world if armatures else Matrix()),
    }


for entry in json.loads(Path(sys.argv[1]).read_text()):
    try:
        answer = ask(entry)
    except Exception as error:  # the tests decide what a refusal means
        answer = {"error": np.array(f"{type(error).__name__}: {error}")}
    np.savez(entry["out"], **answer)
