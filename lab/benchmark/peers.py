"""The peers of the benchmark: a textbook JPDA, and Stone Soup set up as its documentation does.

Each function takes scans in the order of time, and whole seconds; it returns a picture: by second, a list of
(number, east, north). A scan is (time_s, detections) with the time of its last detection; a detection is (time_s, z, R): z is
the position, or position and velocity (tracks of sensors), east and north, R its covariance.
"""
import datetime as dt
import itertools

import numpy as np

EPOCH = dt.datetime(2020, 1, 1)


def jpda(scans, seconds, *, noise, detection, clutter, speed_sigma, silent_s, gate=9.2, least=1e-3):
    """Joint probabilistic data association (Fortmann, Bar-Shalom, Scheffe 1983): nearly constant velocity of density
    `noise` (m2/s3), clutter per m2, three detections within `silent_s` to confirm, deletion after `silent_s` without one."""
    tracks, number, picture, at = [], itertools.count(1), {}, 0
    observed = np.eye(2, 4)

    def moved(track, to_s):
        step = to_s - track['time']
        motion = np.eye(4) + step * np.eye(4, k=2)
        corner = np.array([[step**3 / 3, step**2 / 2], [step**2 / 2, step]])
        return motion @ track['x'], motion @ track['P'] @ motion.T + noise * np.kron(corner, np.eye(2))

    # An antenna measures its scan one by one: each time is a scan of its own here.
    for time_s, detections in [*by_time(scans), (seconds[-1] + 1, [])]:
        while at < len(seconds) and seconds[at] < time_s:
            picture[seconds[at]] = [(t['id'], *moved(t, seconds[at])[0][:2]) for t in tracks if t['id']]
            at += 1
        for track in tracks:
            track['x'], track['P'] = moved(track, time_s)
            track['time'] = time_s
        likelihoods = np.zeros((len(tracks), len(detections)))
        for (row, track), (column, (z, R)) in itertools.product(enumerate(tracks), enumerate(detections)):
            apart, S = z - track['x'][:2], track['P'][:2, :2] + R
            distance = apart @ np.linalg.solve(S, apart)
            if distance < gate:
                density = np.exp(-distance / 2) / (2 * np.pi * np.sqrt(np.linalg.det(S)))
                likelihoods[row, column] = detection * density / (clutter * (1 - detection))
        for track, shares in zip(tracks, associated(likelihoods)):
            updated(track, detections, shares, observed)
            track['hits'] = [hit for hit in track['hits'] if time_s - hit < silent_s] + [time_s] * int(shares.sum() > .5)
            if len(track['hits']) >= 3 and not track['id']:
                track['id'] = next(number)
        tracks = [track for track in tracks if track['hits']]
        for column, (z, R) in enumerate(detections):
            if likelihoods.shape[0] == 0 or likelihoods[:, column].max() < least:
                P = np.diag([0, 0, speed_sigma**2, speed_sigma**2]).astype(float)
                P[:2, :2] = R
                tracks.append({'x': np.append(z, [0, 0]), 'P': P, 'time': time_s, 'hits': [time_s], 'id': 0})
    return picture


def by_time(scans):
    def time_of(found):
        return found[0]

    all_detections = sorted((found for _, detections in scans for found in detections), key=time_of)
    for time_s, same in itertools.groupby(all_detections, key=time_of):
        yield time_s, [(z, R) for _, z, R in same]


def associated(likelihoods, rounds=50):
    """Marginal probabilities of association by belief propagation (Williams, Lau 2014); exact where few compete."""
    up = np.ones_like(likelihoods)
    for _ in range(rounds):
        weighed = likelihoods * up
        down = likelihoods / (1 + weighed.sum(1, keepdims=True) - weighed)
        up = 1 / (1 + down.sum(0, keepdims=True) - down)
    weighed = likelihoods * up
    return weighed / (1 + weighed.sum(1, keepdims=True))


def updated(track, detections, shares, observed):
    """The update of a track by all detections, each with its probability."""
    used = [(share, z, R) for share, (z, R) in zip(shares, detections) if share > 1e-6]
    parts = [(1 - shares.sum(), track['x'], track['P'])]
    for share, z, R in used:
        gain = track['P'] @ observed.T @ np.linalg.inv(observed @ track['P'] @ observed.T + R)
        parts.append((share, track['x'] + gain @ (z - track['x'][:2]), track['P'] - gain @ observed @ track['P']))
    mean = sum(share * x for share, x, _ in parts)
    track['P'] = sum(share * (P + np.outer(x - mean, x - mean)) for share, x, P in parts)
    track['x'] = mean


def stone_soup(scans, seconds, *, noise, association, gate=5.0, detection=.9, clutter=1e-8,
               speed_sigma=0.0, delete_s=8.0, confirm=3, reach_m=2000.0):
    """Stone Soup's MultiTargetTracker: nearly constant velocity, Mahalanobis gate, `association` gnn (two-dimensional
    assignment) or jpda (belief propagation), Kalman update."""
    from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
    from stonesoup.dataassociator.probability import JPDAwithLBP
    from stonesoup.deleter.time import UpdateTimeDeleter
    from stonesoup.hypothesiser.distance import DistanceHypothesiser
    from stonesoup.hypothesiser.probability import PDAHypothesiser
    from stonesoup.initiator.simple import SimpleMeasurementInitiator
    from stonesoup.measures import Mahalanobis
    from stonesoup.models.measurement.linear import LinearGaussian
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.tracker.simple import MultiTargetMixtureTracker, MultiTargetTracker
    from stonesoup.types.detection import GaussianDetection
    from stonesoup.types.state import GaussianState
    from stonesoup.types.update import Update
    from stonesoup.updater.kalman import KalmanUpdater

    def scan_of(time_s, detections):
        found = set()
        for own_s, z, R in detections:
            mapping = (0, 2) if len(z) == 2 else (0, 2, 1, 3)
            model = LinearGaussian(4, mapping, np.asarray(R, float))
            stamp = EPOCH + dt.timedelta(seconds=own_s)
            state = np.asarray(z, float).reshape(-1, 1)
            found.add(GaussianDetection(state, np.asarray(R, float), timestamp=stamp, measurement_model=model))
        return EPOCH + dt.timedelta(seconds=time_s), found

    motion = CombinedLinearGaussianTransitionModel([ConstantVelocity(noise)] * 2)
    predictor = KalmanPredictor(motion)
    updater = KalmanUpdater(None)
    class NearGNN(GNNWith2DAssignment):
        """The stock associator, which otherwise predicts every track to every detection: hours."""

        def generate_hypotheses(self, tracks, detections, timestamp, **options):
            near = {}
            for track in tracks:
                x = predictor.predict(track, timestamp=timestamp).state_vector
                near[track] = {found for found in detections
                               if np.hypot(found.state_vector[0] - x[0], found.state_vector[1] - x[2]) < reach_m}
            return {track: self.hypothesiser.hypothesise(track, near[track], timestamp, **options) for track in tracks}

    if association == 'gnn':
        hypotheses = DistanceHypothesiser(predictor, updater, Mahalanobis(), missed_distance=gate)
        associator, kind = NearGNN(hypotheses), MultiTargetTracker
    else:
        hypotheses = PDAHypothesiser(predictor, updater, clutter_spatial_density=clutter, prob_detect=detection, prob_gate=.99)
        associator, kind = JPDAwithLBP(hypotheses), MultiTargetMixtureTracker
    prior = GaussianState(np.zeros((4, 1)), np.diag([0, speed_sigma**2, 0, speed_sigma**2]), timestamp=EPOCH)
    # A list of scans that the tracker empties: its picture at a second is read before the next scan.
    steps = iter([scan_of(*scan) for scan in scans])
    tracker = kind(SimpleMeasurementInitiator(prior), UpdateTimeDeleter(dt.timedelta(seconds=delete_s)), steps, associator,
                   updater)
    picture, numbers, at, running = {}, {}, 0, iter(tracker)
    for time_s, _ in scans + [(seconds[-1] + 1, [])]:
        while at < len(seconds) and seconds[at] < time_s:
            second = seconds[at]
            picture[second] = []
            for track in tracker.tracks:
                if sum(isinstance(state, Update) for state in track.states[-40:]) >= confirm:
                    x = np.asarray(track.state.state_vector, float).ravel()
                    step = second - (track.state.timestamp - EPOCH).total_seconds()
                    number = numbers.setdefault(track.id, len(numbers))
                    picture[second].append((number, x[0] + step * x[1], x[2] + step * x[3]))
            at += 1
        next(running, None)
    return picture
