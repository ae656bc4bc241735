"""Which fusion rule suits my sensors: which_rule.py TRUTH.csv TRACKS.csv ...

Files as for `koseki compare`; without them, half a minute of the simulated airport.
"""

import sys

import koseki

if len(sys.argv) > 2:
    truth, tracks = sys.argv[1], sys.argv[2:]
else:
    world = koseki.simulate(seconds=30)
    truth = world["truth"]
    tracks = [table for name, table in world.items() if name.startswith("sensor_tracks")]

rules = koseki.compare(tracks, truth=truth)["rules"]
for rule in sorted(rules, key=lambda rule: rule["gospa"]):
    print(f"{rule['rule']:24} GOSPA {rule['gospa']:8.1f} m")
