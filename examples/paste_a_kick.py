"""Paste a kick into a walk and draw the result: the main job in Python."""

import kinestitch as ks
from kinestitch.render.filmstrip import filmstrip

# Two clips made by code; ks.read("walk.fbx") takes the place of ks.sample("walk") for clips of your own.
clips = {"walk": ks.sample("walk"), "kick": ks.sample("kick")}

# The edit is a value of its own: frames 84 to 129 of the walk give way to frames 30 to 111 of the kick.
line = ks.replace(ks.timeline(clips, "walk"), 84, 130, "kick", 30, 112)

# Solving leaves everything as it was but the frames around the two seams. Feet that stand in the clips stand there too.
solved = ks.solve_timeline(line, clips, foot_lock=True)
ks.write(solved.motion, "walk_kick.bvh")

for seam in ks.report(solved)["seams"]:
    before, after = seam["rotation_step_deg_before"], seam["rotation_step_deg_after"]
    print(f"seam at frame {seam['frame']}: the worst joint turned {before:.0f}° in one frame, now {after:.1f}°")

pasted = [(84, 84 + 82, "kick")]
filmstrip([clips["walk"], solved.motion], "walk_kick.png", labels=["before", "after"], segments=[[], pasted])
