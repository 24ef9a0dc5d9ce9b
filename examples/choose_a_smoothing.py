"""How long a seam may take: the same cut with five smoothing times, and what each costs."""

from dataclasses import replace

import kinestitch as ks

clips = {"walk": ks.sample("walk"), "run": ks.sample("run")}
line = ks.replace(ks.timeline(clips, "walk"), 100, 201, "run", 40)

print("seconds        λ  step at the seam  largest change  dynamics kept")
for seconds in (0.02, 0.05, 0.1, 0.2, 0.4):
    seam = ks.Seam(smoothing=seconds)
    solved = ks.solve_timeline(replace(line, seams=(seam,)), clips)
    numbers = ks.report(solved)["seams"][0]
    print(
        f"{seconds:7.2f} {numbers['lambda']:8.0f} {numbers['rotation_step_deg_after']:16.1f}°"
        f" {numbers['deviation_max_deg']:14.1f}° {numbers['dynamics_kept']:14.2f}"
    )
