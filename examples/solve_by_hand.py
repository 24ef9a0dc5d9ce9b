"""The method in a few lines of numpy, beside the package: one joint, one seam, one dense system of equations."""

import numpy as np

import kinestitch as ks
from kinestitch.core.rotation import quat_distance, quat_to_rotvec, rotvec_to_quat

JOINT, CUT, STIFFNESS = "mixamorig:RightUpLeg", 100, 1296.0

clips = {"walk": ks.sample("walk"), "run": ks.sample("run")}
joint = clips["walk"].skeleton.index(JOINT)
walk, run = (quat_to_rotvec(clips[name].rotations[:, joint]) for name in ("walk", "run"))

# The target: the walk up to the cut, then the run from its frame 40 on; and the second differences that each source
# has among its own neighbours, so that none is taken across the cut.
target = np.concatenate([walk[:CUT], run[40:]])
frames = len(target)
L = np.zeros((frames, frames))
for t in range(1, frames - 1):
    L[t, t - 1 : t + 2] = 1.0, -2.0, 1.0
delta = L @ target
delta[CUT - 1] = walk[CUT - 2] - 2 * walk[CUT - 1] + walk[CUT]
delta[CUT] = run[39] - 2 * run[40] + run[41]

# minimise  ‖R − target‖² + λ ‖L R − δ‖²
dense = np.linalg.solve(np.eye(frames) + STIFFNESS * L.T @ L, target + STIFFNESS * L.T @ delta)

line = ks.replace(ks.timeline(clips, "walk"), CUT, clips["walk"].frames, "run", 40, seam=ks.Seam(stiffness=STIFFNESS))
ours = ks.stitch(line, clips, chart="principal").rotations[:, joint]
gap = quat_distance(rotvec_to_quat(dense), ours).max()
print(f"{frames} frames, largest difference to the package: {gap:.1e} rad")
assert gap < 1e-9
