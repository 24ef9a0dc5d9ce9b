"""Run inside Blender's Python: convert a BVH of ours to FBX, GLB and BVH. Arguments: source.bvh, folder, frames.

The files beside this script are the sample ``kick`` (30 fps, frames 12 to 35), converted so by Blender 4.5.
"""

import sys
from pathlib import Path

import bpy

source, folder, frames = sys.argv[-3], Path(sys.argv[-2]), int(sys.argv[-1])
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_anim.bvh(filepath=source, global_scale=0.01, update_scene_fps=True, use_fps_scale=False)
scene = bpy.context.scene
scene.frame_start, scene.frame_end = 1, frames
bpy.context.object.select_set(True)
target = str(folder / "kick_blender")
bpy.ops.export_scene.fbx(
    filepath=target + ".fbx",
    use_selection=True,
    add_leaf_bones=False,
    bake_anim_simplify_factor=0.0,
    bake_anim_use_all_actions=False,
    bake_anim_use_nla_strips=False,
    object_types={"ARMATURE"},
)
bpy.ops.export_scene.gltf(filepath=target + ".glb", export_format="GLB", use_selection=True)
bpy.ops.export_anim.bvh(filepath=target + ".bvh", global_scale=100.0, frame_start=1, frame_end=frames)
