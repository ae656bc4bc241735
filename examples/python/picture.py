"""A picture of tracks with their ellipses: picture.py OUT.png [TRACKS.csv ...]

Sensor tracks as for `koseki fuse`, fused by the rule "auto"; without files, half a minute of the simulated airport. Each
line is a system track; an ellipse, every ten seconds, would hold the target with a probability of 95 % if it were not
drawn so many times as large.
"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas
from matplotlib.patches import Ellipse

import koseki

#: Size of an ellipse of two dimensions that holds 95 %, in standard deviations.
SIGMAS = np.sqrt(5.991)
#: Errors are metres where tracks are kilometres.
MAGNIFIED = 20

tracks = sys.argv[2:]
if not tracks:
    tracks = [table for name, table in koseki.simulate(seconds=30).items() if name.startswith("sensor_tracks")]
states = pandas.DataFrame(koseki.fuse(tracks))
states = states[states["state"] == "confirmed"]

figure, axes = plt.subplots(figsize=(10, 10))
for number, track in states.groupby("system_track_id"):
    (line,) = axes.plot(track["x"] / 1000, track["y"] / 1000, linewidth=0.8)
    for _, state in track[track["time_s"] // 10 != (track["time_s"] // 10).shift()].iterrows():
        variances, axis = np.linalg.eigh([[state["P00"], state["P01"]], [state["P01"], state["P11"]]])
        width, height = 2 * MAGNIFIED * SIGMAS * np.sqrt(variances) / 1000
        turned = np.degrees(np.arctan2(axis[1, 0], axis[0, 0]))
        place = (state["x"] / 1000, state["y"] / 1000)
        axes.add_patch(Ellipse(place, width, height, angle=turned, fill=False, color=line.get_color(), linewidth=0.5))
axes.set(xlabel="east, km", ylabel="north, km", aspect="equal", title=f"Tracks, with ellipses {MAGNIFIED} times as large")
figure.savefig(sys.argv[1], dpi=120)
print(f"{sys.argv[1]}: {states['system_track_id'].nunique()} tracks")
