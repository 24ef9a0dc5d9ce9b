"""The part that runs inside Blender's Python: two strips of its non-linear animation over each other, read back.

    python blender_side.py REQUEST.npz ANSWER.npz

REQUEST.npz holds parents (J,), offsets (J, 3) m, a JSON list `jobs` of {"pair", "reach", "mode"}, and for each pair N
`left_N`, `right_N` (n, J, 7): w, x, y, z of a joint's rotation against its rest pose and the shift of its place from
there in its parent's frame, one row a frame, n = 2 R + 2, the seam half way.

ANSWER.npz holds for each job N the rows of its overlap and one on each side as Blender shows them, `job_N` (2 reach +
2, J, 7), and Blender's `version`. Quaternions go in and come out as they are, with their signs and without being
normalised. `auto` (2,) says how much of an overlap Blender's automatic blending gives to the left strip's fade out and
to the right one's fade in.

modes : ``replace``, the right strip blends in over the left one; ``fade``, the left one blends out as well;
``combine``, both blend modes are Combine and both fade

Imports nothing of this project, so that any Python that has bpy can run it.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

PATHS = (("rotation_quaternion", 4), ("location", 3))


def make_armature(parents: np.ndarray, offsets: np.ndarray) -> Any:
    """An armature whose bones all rest in the world's axes, so that pose channels are local rotations and shifts."""
    import bpy  # type: ignore[import-not-found]

    bpy.ops.wm.read_factory_settings(use_empty=True)
    thing = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.mode_set(mode="EDIT")
    heads = np.zeros((len(parents), 3))
    for joint, parent in enumerate(parents):
        heads[joint] = offsets[joint] + (heads[parent] if parent >= 0 else 0)
        bone = thing.data.edit_bones.new(f"b{joint}")
        bone.head, bone.tail, bone.roll = heads[joint], heads[joint] + (0, 0.05, 0), 0.0
        if parent >= 0:
            bone.parent = thing.data.edit_bones[f"b{parent}"]
    bpy.ops.object.mode_set(mode="POSE")
    for bone in thing.pose.bones:
        bone.rotation_mode = "QUATERNION"
    thing.animation_data_create()
    return thing


def make_action(name: str, rows: np.ndarray) -> tuple[Any, Any]:
    """An action with one key a frame, straight lines between them, and its slot (None before Blender 4.4)."""
    import bpy

    action = bpy.data.actions.new(name)
    slot = None
    if hasattr(action, "slots"):
        slot = action.slots.new(id_type="OBJECT", name="rig")
        curves = action.layers.new("layer").strips.new(type="KEYFRAME").channelbag(slot, ensure=True).fcurves
    else:
        curves = action.fcurves
    points = np.empty((len(rows), 2), np.float32)
    points[:, 0] = np.arange(len(rows))
    straight = np.full(len(rows), bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items["LINEAR"].value)
    for joint in range(rows.shape[1]):
        channel = 0
        for path, width in PATHS:
            for index in range(width):
                curve = curves.new(f'pose.bones["b{joint}"].{path}', index=index)
                curve.keyframe_points.add(len(rows))
                points[:, 1] = rows[:, joint, channel]
                curve.keyframe_points.foreach_set("co", points.ravel())
                curve.keyframe_points.foreach_set("interpolation", straight)
                curve.update()
                channel += 1
    return action, slot


def lay_strip(thing: Any, action: Any, slot: Any, span: tuple[float, float], combine: bool) -> Any:
    """A track of its own with the action on it, frame by frame where it is, shown between two frames only."""
    track = thing.animation_data.nla_tracks.new()
    strip = track.strips.new(action.name, 0, action)
    if slot is not None:
        strip.action_slot = slot
    strip.use_auto_blend = False
    strip.extrapolation = "NOTHING"
    strip.blend_type = "COMBINE" if combine else "REPLACE"
    strip.action_frame_start, strip.action_frame_end = span
    strip.frame_start, strip.frame_end = span
    strip.scale = 1.0
    if not np.allclose((strip.frame_start, strip.frame_end, strip.action_frame_start), (*span, span[0])):
        raise RuntimeError(f"Blender moved a strip from {span} to {(strip.frame_start, strip.frame_end)}")
    return strip


def evaluate(
    thing: Any, pair: tuple[tuple[Any, Any], tuple[Any, Any]], reach: int, mode: str, frames: int
) -> np.ndarray:
    """The 2 × reach frames of an overlap around the seam and one on each side: (2 reach + 2, J, 7).

    pair : action and slot of the left and of the right source, `frames` long
    """
    import bpy

    tracks = thing.animation_data.nla_tracks
    while len(tracks):
        tracks.remove(tracks[0])
    middle = (frames - 1) / 2
    combine = mode == "combine"
    lower = lay_strip(thing, *pair[0], (-1.0, middle + reach), combine)
    upper = lay_strip(thing, *pair[1], (middle - reach, frames + 1.0), combine)
    upper.blend_in = 2.0 * reach
    if mode != "replace":
        lower.blend_out = 2.0 * reach
    bones = thing.pose.bones
    order = [int(bone.name[1:]) for bone in bones]  # Blender lists children after their parents in an order of its own
    rows = np.empty((2 * reach + 2, len(bones), 7))
    first = int(np.ceil(middle)) - reach - 1
    for frame in range(first, first + 2 * reach + 2):
        bpy.context.scene.frame_set(frame)
        column = 0
        for path, width in PATHS:
            values = np.empty(len(bones) * width, np.float32)
            bones.foreach_get(path, values)
            rows[frame - first, order, column : column + width] = values.reshape(-1, width)
            column += width
    return rows


def auto_blend(thing: Any, reach: int, frames: int) -> np.ndarray:
    """What automatic blending makes of the two strips that stand there, as shares of their overlap: (2,)."""
    import bpy

    strips = [track.strips[0] for track in thing.animation_data.nla_tracks]
    for strip in strips:
        strip.use_auto_blend = True
        strip.frame_end = strip.frame_end  # blending is worked out when a strip is moved
    bpy.context.scene.frame_set(frames // 2)
    return np.array([strips[0].blend_out, strips[1].blend_in]) / (2 * reach)


def answer(request: Any) -> dict[str, np.ndarray]:
    """All jobs of a request, in one scene."""
    import bpy

    thing = make_armature(request["parents"], request["offsets"])
    pairs: dict[str, Any] = {}
    found = {"version": np.array(bpy.app.version_string)}
    for number, job in enumerate(json.loads(str(request["jobs"]))):
        key = job["pair"]
        rows = [request[f"{side}_{key}"] for side in ("left", "right")]
        if key not in pairs:
            pairs[key] = tuple(make_action(f"{side}_{key}", r) for side, r in zip("ab", rows, strict=True))
        found[f"job_{number}"] = evaluate(thing, pairs[key], job["reach"], job["mode"], len(rows[0]))
        reach, frames = job["reach"], len(rows[0])
    return found | {"auto": auto_blend(thing, reach, frames)}


if __name__ == "__main__":
    with np.load(sys.argv[1]) as asked:
        given = dict(asked)
    np.savez(sys.argv[2], **answer(given))  # type: ignore[arg-type, unused-ignore]
