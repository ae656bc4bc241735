"""Detections of three moving targets, in degrees, to fused tracks: start `koseki up examples/detections.toml` first."""

import time

import koseki

source, tracks, begin = koseki.publish("feed", "own"), koseki.subscribe("feed"), time.time()
while True:
    source.send_detections(latitude=[41.40, 41.43, 41.46], longitude=2.10 + 5e-4 * (time.time() - begin), sigma_m=20)
    time.sleep(0.5)
    while (fused := tracks.receive(0)) is not None:
        for track in fused[fused["state"] == koseki.TrackState.CONFIRMED]:
            print("track", track["track_number"], track["position_m"])
