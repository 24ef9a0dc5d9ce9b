"""Ask ufbx what an FBX file says. Runs in .venv-ufbx, as a child process: a reader in C may crash.

    python ask_ufbx.py REQUESTS.json

REQUESTS.json is a list of {"path", "out", "start" (s), "fps", "frames", "take" (optional)}. For each, `out` becomes an
.npz of names (N,), parents (N,), translations (F, N, 3) and rotations (F, N, 4) in the parent's frame, positions
(F, N, 3) in metres, Y up, and matrices (F, N, 3, 3), parent frames and scale included; or of one text `error`.
"""

import ctypes
import gc
import json
import os
import sys
from pathlib import Path

import numpy as np
import ufbx


def items(listing):
    """The members of a ufbx list; each gets the reference that ufbx 0.0.5 forgets to hand out."""
    found = []
    for i in range(len(listing)):
        item = listing[i]
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(item))
        found.append(item)
    return found


def ask(request):
    scene = ufbx.load_file(request["path"], target_axes=ufbx.axes_right_handed_y_up, target_unit_meters=1.0)
    stacks = [stack for stack in items(scene.anim_stacks) if stack.name == request.get("take")]
    anim = stacks[0].anim if stacks else scene.anim
    nodes = [node for node in items(scene.nodes) if not node.is_root]
    index = {node.element_id: i for i, node in enumerate(nodes)}
    shape = (request["frames"], len(nodes))
    moved, turned = np.empty((*shape, 3)), np.empty((*shape, 4))
    positions, matrices = np.empty((*shape, 3)), np.empty((*shape, 3, 3))
    for frame in range(request["frames"]):
        time = request["start"] + frame / request["fps"]
        posed = scene.evaluate(anim, time)
        again = [node for node in items(posed.nodes) if not node.is_root]
        for i, node in enumerate(again):
            local = node.local_transform
            moved[frame, i], turned[frame, i] = tuple(local.translation), tuple(local.rotation)
            columns = node.node_to_world
            matrices[frame, i] = np.array([columns.c0, columns.c1, columns.c2]).T
            positions[frame, i] = tuple(columns.c3)
    parents = [index.get(node.parent.element_id, -1) if node.parent is not None else -1 for node in nodes]
    return {
        "names": np.array([node.name for node in nodes]),
        "parents": np.array(parents),
        "translations": moved,
        "rotations": turned,
        "positions": positions,
        "matrices": matrices,
    }


gc.disable()  # the collector stumbles over what ufbx 0.0.5 hands out
for entry in json.loads(Path(sys.argv[1]).read_text()):
    try:
        answer = ask(entry)
    except Exception as error:  # the tests decide what a refusal means
        answer = {"error": np.array(f"{type(error).__name__}: {error}")}
    np.savez(entry["out"], **answer)
os._exit(0)  # ufbx 0.0.5 may crash while the interpreter takes its objects down
