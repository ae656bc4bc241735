"""Koseki beside Stone Soup on the same detections: stone_soup.py

Stone Soup's detections become a table for `koseki.track`; what comes back are tracks of Stone Soup's own types, so that its metrics and plotters take them. Positions are metres east and north; the comparison
is in the plane, after the first third of the time, when tracks have begun. Stone Soup's tracker is told that targets fly
straight; Koseki's, as it is, also follows those that turn.
"""

import sys
import time
from datetime import datetime, timedelta, timezone

import numpy as np
import pandas
from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
from stonesoup.deleter.error import CovarianceBasedDeleter
from stonesoup.hypothesiser.distance import DistanceHypothesiser
from stonesoup.initiator.simple import MultiMeasurementInitiator
from stonesoup.measures import Mahalanobis
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.tracker.simple import MultiTargetTracker
from stonesoup.types.detection import Detection
from stonesoup.types.state import GaussianState
from stonesoup.types.track import Track
from stonesoup.updater.kalman import KalmanUpdater

import koseki

BEGIN = datetime(2026, 1, 1, tzinfo=timezone.utc)
#: East, its speed, north, its speed in Stone Soup's states.
PLACE, VELOCITY = [0, 2], [1, 3]


def scene(seconds=90, period=3, targets=10, false_alarms=20, seed=1):
    """Detections, scan by scan, and the truth: targets in straight flight among false alarms."""
    dice = np.random.default_rng(seed)
    places, velocities = dice.uniform(-20e3, 20e3, (targets, 2)), dice.uniform(-150, 150, (targets, 2))
    model = LinearGaussian(ndim_state=4, mapping=PLACE, noise_covar=np.diag([50.0**2] * 2))
    scans = []
    for second in range(0, seconds, period):
        seen = (places + velocities * second)[dice.random(targets) < 0.9]
        seen = np.vstack([seen + dice.normal(0, 50, seen.shape), dice.uniform(-30e3, 30e3, (false_alarms, 2))])
        at = BEGIN + timedelta(seconds=second)
        scans.append((at, {Detection(place[:, None], timestamp=at, measurement_model=model) for place in seen}))
    rows = [(second, target, *(places[target] + velocities[target] * second), 0.0, *velocities[target], 0.0)
            for second in range(seconds) for target in range(targets)]
    return scans, pandas.DataFrame(rows, columns=["time_s", "target_id", "x", "y", "z", "vx", "vy", "vz"])


def from_stone_soup(scans):
    """Table of detections for `koseki.track`, of Stone Soup's in the plane."""
    rows = [((at - BEGIN).total_seconds(), 1, scan, "position2", *map(float, detection.state_vector),
             *np.sqrt(np.diag(detection.measurement_model.noise_covar)))
            for scan, (at, detections) in enumerate(scans)
            for detection in sorted(detections, key=lambda one: tuple(map(float, one.state_vector)))]
    table = pandas.DataFrame(rows, columns=["time_s", "sensor_id", "scan", "kind", "m0", "m1", "s0", "s1"])
    table.insert(3, "detection_id", range(1, len(table) + 1))
    return table.assign(m2=None, m3=None, s2=None, s3=None, px=0.0, py=0.0, pz=0.0)


def to_stone_soup(table, number="sensor_track_id"):
    """Tracks of Stone Soup, of a table of tracks: states of east, its speed, north, its speed, with covariances."""
    tracks = {}
    for row in pandas.DataFrame(table).itertuples():
        state = np.array([[row.x], [row.vx], [row.y], [row.vy]])
        covariance = np.zeros((4, 4))
        for i, of in enumerate((0, 3, 1, 4)):
            for j, other in enumerate((0, 3, 1, 4)):
                covariance[i, j] = getattr(row, f"P{min(of, other)}{max(of, other)}")
        track = tracks.setdefault(getattr(row, number), Track(id=str(getattr(row, number))))
        track.append(GaussianState(state, covariance, timestamp=BEGIN + timedelta(seconds=row.time_s)))
    return set(tracks.values())


def koseki_tracks(scans):
    """Koseki's multiple-hypothesis tracker: a table of tracks."""
    return koseki.track(from_stone_soup(scans))


def stone_soup(scans):
    """Stone Soup's global-nearest-neighbour tracker on the same detections: a table of tracks."""
    motion = CombinedLinearGaussianTransitionModel([ConstantVelocity(1.0)] * 2)
    model = LinearGaussian(ndim_state=4, mapping=PLACE, noise_covar=np.diag([50.0**2] * 2))
    updater = KalmanUpdater(model)
    associator = GNNWith2DAssignment(DistanceHypothesiser(KalmanPredictor(motion), updater, Mahalanobis(), 4))
    deleter = CovarianceBasedDeleter(500.0**2)
    prior = GaussianState([[0], [0], [0], [0]], np.diag([0, 150.0**2, 0, 150.0**2]))
    initiator = MultiMeasurementInitiator(prior, deleter, associator, updater, model, min_points=4)
    tracker = MultiTargetTracker(initiator, deleter, iter(scans), associator, updater)
    rows = [((at - BEGIN).total_seconds(), track.id, *track.state_vector[PLACE].flat, 0.0,
             *track.state_vector[VELOCITY].flat, 0.0) for at, tracks in tracker for track in tracks]
    table = pandas.DataFrame(rows, columns=["time_s", "sensor_track_id", "x", "y", "z", "vx", "vy", "vz"])
    table["sensor_track_id"] = pandas.factorize(table["sensor_track_id"])[0]
    return table


def main():
    scans, truth = scene()
    for name, tracker in [("Koseki", koseki_tracks), ("Stone Soup", stone_soup)]:
        begin = time.perf_counter()
        table = tracker(scans)
        spent = time.perf_counter() - begin
        score = koseki.score(truth, table, t0=30, max_age=4)
        print(f"{name:10} {spent:5.2f} s: GOSPA {score['gospa']:6.1f} m, position error {score['rmse_pos']:5.1f} m, "
              f"targets shown {score['completeness']:4.0%}, switches {score['id_switches']}, spurious {score['spurious']}")
    tracks = to_stone_soup(koseki_tracks(scans))
    longest = max(tracks, key=len)
    print(f"{len(tracks)} tracks of Koseki as Stone Soup's, the longest with {len(longest)} states:")
    print(longest.state_vector.T, "by", longest.timestamp)


if __name__ == "__main__":
    main()
