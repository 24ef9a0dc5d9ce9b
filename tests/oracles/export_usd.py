"""Let Blender write a USD file. Runs in .venv-bpy.

    python export_usd.py IN OUT FPS

IN is a USD file whose time codes are frames; OUT holds the same skeleton and animation, as Blender understood them.
"""

import sys

import bpy

source, target, fps = sys.argv[1], sys.argv[2], float(sys.argv[3])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps, scene.render.fps_base = round(fps), round(fps) / fps
bpy.ops.wm.usd_import(filepath=source)
first, last = bpy.data.actions[0].frame_range
scene.frame_start, scene.frame_end = int(first), int(last)
bpy.ops.wm.usd_export(filepath=target, export_animation=True, export_armatures=True)
