#!/usr/bin/env python3
"""Compare Koseki with its peers; each row of docs/benchmark.md is one command.

usage: benchmark.py ROW [ROW ...] [--seeds N,N,...] [--koseki FILE] [--data FOLDER] [--json]

Rows:
    airport, en-route    tracks of four simulated sensors, fused
    radars               detections of three simulated radars, tracked together
    ferry-lidar, ferry-radar, ferry-both
                         recorded detections in a harbour (data set Autoferry), all scenarios in --data

Needs: pip install numpy scipy stonesoup. The simulated worlds are made by `koseki simulate`. No method is given the truth, and
none is tuned to a row: docs/benchmark.md states the set-ups. Figures of each method, the mean of all seeds or scenarios:

    GOSPA     m, power 2, alpha 2, in the plane, with the row's cut-off (Rahmathullah, Garcia-Fernandez, Svensson 2017)
    RMSE      m, of pairs nearer than the cut-off
    shown     share of the targets' seconds that have a track
    false     tracks without a target, mean at a second
    switches  changes of a target's track number, a target and minute
    seconds   processor time of the method's process or loop
"""
import argparse
import csv
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy.optimize import linear_sum_assignment

import peers

ROOT = pathlib.Path(__file__).resolve().parents[2]
FUSED = {'airport': 'demo', 'en-route': 'en-route'}
SIMULATED_S = 90
TARGETS = 40
# Sensors of the simulated airport that are radars.
RADARS = '125'
# Seconds at the begin that do not count: every method starts its tracks in them.
SETTLE_S = 15


def table(path):
    with open(path, newline='') as lines:
        yield from csv.DictReader(lines)


def compared(picture, truth, cut_off_m):
    """Figures of a picture against a truth: by second, {target: (east, north)}."""
    gospa, squares, pairs, wanted, false, switches, last = [], 0., 0, 0, 0, 0, {}
    for second, targets in truth.items():
        shown, names = picture.get(second, []), list(targets)
        places = np.array([targets[name] for name in names]).reshape(-1, 2)
        tracks = np.array([track[1:3] for track in shown]).reshape(-1, 2)
        apart = np.hypot(*(places[:, None] - tracks[None]).transpose(2, 0, 1))
        rows, columns = linear_sum_assignment(np.minimum(apart, cut_off_m)**2)
        near = [(row, column) for row, column in zip(rows, columns) if apart[row, column] < cut_off_m]
        located = sum(apart[pair]**2 for pair in near)
        alone = len(names) + len(shown) - 2 * len(near)
        gospa.append(math.sqrt(located + alone * cut_off_m**2 / 2))
        squares, pairs, wanted, false = squares + located, pairs + len(near), wanted + len(names), false + len(shown) - len(near)
        for row, column in near:
            number = shown[column][0]
            switches += last.get(names[row], number) != number
            last[names[row]] = number
    return {'GOSPA': statistics.fmean(gospa), 'RMSE': math.sqrt(squares / max(pairs, 1)), 'shown': pairs / max(wanted, 1),
            'false': false / len(truth), 'switches': 60 * switches / max(wanted, 1)}


class Koseki:
    def __init__(self, executable):
        self.executable = executable

    def run(self, *arguments):
        subprocess.run([self.executable, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)

    def picture(self, command, files, folder, *options):
        """The picture that `koseki fuse` or `koseki track` writes at whole seconds."""
        out = folder / 'koseki.csv'
        inputs, step = ('--tracks', '--refresh') if command == 'fuse' else ('--detections', '--period')
        self.run(command, inputs, *files, step, 1, '--out', out, *options)
        picture = {}
        for row in table(out):
            number = row.get('system_track_id') or row['sensor_track_id']
            picture.setdefault(round(float(row['time_s'])), []).append((number, float(row['x']), float(row['y'])))
        return picture


def scans_of(rows):
    """Rows (sensor, scan, time_s, z, R) as scans in the order of time; a scan has the time of its last row."""
    scans = {}
    for sensor, scan, *detection in rows:
        scans.setdefault((sensor, scan), []).append(detection)
    return sorted(((max(found[0] for found in scan), scan) for scan in scans.values()), key=lambda scan: scan[0])


def sensor_tracks(files):
    """Confirmed sensor tracks as measurements of position and velocity in the plane."""
    upper = [(row, column) for row in range(6) for column in range(row, 6)]
    plane = (0, 1, 3, 4)
    for file in files:
        for row in table(file):
            if row['state'] == 'confirmed':
                covariance = np.zeros((6, 6))
                for place in upper:
                    covariance[place] = covariance[place[::-1]] = float(row['P%d%d' % place])
                z = np.array([float(row[name]) for name in ('x', 'y', 'vx', 'vy')])
                yield row['sensor_id'], row['time_s'], float(row['time_s']), z, covariance[np.ix_(plane, plane)]


def detections(files):
    for file in files:
        for row in table(file):
            if row['kind'] != 'none':
                R = np.diag([float(row['s0'])**2, float(row['s1'])**2])
                yield row['sensor_id'], row['scan'], float(row['time_s']), np.array([float(row['m0']), float(row['m1'])]), R


def simulated_truth(folder, files):
    """Targets by second, from the first to the last detection or report of each in the files of detections."""
    seen = {}
    for file in files:
        for row in table(file):
            seen.setdefault(row['truth_id'], []).append(float(row['time_s']))
    truth = {second: {} for second in range(SETTLE_S, SIMULATED_S)}
    for row in table(folder / 'truth.csv'):
        second, times = int(row['time_s']), seen.get(row['target_id'])
        if second in truth and times and min(times) + SETTLE_S <= second <= max(times):
            truth[second][row['target_id']] = (float(row['x']), float(row['y']))
    return truth


def fused(row, koseki, folder, seed):
    koseki.run('simulate', '--scenario', FUSED[row], '--seed', seed, '--for', SIMULATED_S, '--out', folder,
               '--set', f'scenario.targets={TARGETS}')
    # Sensor 5 is a radar without a tracker of its own.
    files = [folder / f'sensor_tracks_{sensor}.csv' for sensor in range(1, 5)]
    truth = simulated_truth(folder, sorted(folder.glob('detections_[1-4].csv')))
    scans, seconds = scans_of(sensor_tracks(files)), list(truth)
    peer = dict(noise=20.0, association='gnn', confirm=2)
    return truth, 300.0, {
        'Koseki': lambda: koseki.picture('fuse', files, folder),
        '… covariance intersection': lambda: koseki.picture('fuse', files, folder, '--rule', 'covariance-intersection'),
        'Stone Soup, GNN': lambda: peers.stone_soup(scans, seconds, **peer)}


def tracked(row, koseki, folder, seed):
    koseki.run('simulate', '--scenario', 'demo', '--seed', seed, '--for', SIMULATED_S, '--out', folder,
               '--set', f'scenario.targets={TARGETS}')
    files = [folder / f'detections_{sensor}.csv' for sensor in RADARS]
    truth = simulated_truth(folder, files)
    scans, seconds = scans_of(detections(files)), list(truth)
    peer = dict(noise=20.0, detection=.9, clutter=1e-9, speed_sigma=150.0)
    return truth, 300.0, {
        'Koseki': lambda: koseki.picture('track', files, folder),
        'JPDA': lambda: peers.jpda(scans, seconds, silent_s=12.0, **peer),
        'Stone Soup, GNN': lambda: peers.stone_soup(scans, seconds, association='gnn', delete_s=12.0, **peer)}


# Sensors of the data set: number, standard deviation in m as in examples/autoferry.toml.
LIDAR, RADAR = (1, 3.0), (2, 5.0)
FERRY = {'ferry-lidar': [LIDAR], 'ferry-radar': [RADAR], 'ferry-both': [LIDAR, RADAR]}


def ferry(row, koseki, folder, scenario):
    sigmas = dict(FERRY[row])
    entries = [e for e in json.loads((scenario / f'{scenario.name}_detections.json').read_text()) if e['sensorID'] in sigmas]
    file = folder / 'detections.json'
    file.write_text(json.dumps(entries))
    known = {}
    for entry in json.loads((scenario / f'{scenario.name}_groundTruth.json').read_text()):
        for target in entry if isinstance(entry, list) else [entry]:
            known.setdefault(target['targetID'], {})[target['time']] = target['position'][:2]
    midnight = entries[0]['time'] // 86400 * 86400
    truth = {}
    for second in range(math.ceil(entries[0]['time']), math.floor(entries[-1]['time'])):
        truth[second - int(midnight)] = {name: [np.interp(second, sorted(places), [places[t][axis] for t in sorted(places)])
                                                for axis in (1, 0)] for name, places in known.items()}
    scans = []
    for entry in entries:
        found, (north, east) = np.array(entry['measurement'], float).reshape(2, -1).T, entry['ownshipPosition'][:2]
        R = np.eye(2) * sigmas[entry['sensorID']]**2
        at_s = entry['time'] - midnight
        scans.append((at_s, [(at_s, np.array([z[1] + east, z[0] + north]), R) for z in found]))
    scans.sort(key=lambda scan: scan[0])
    seconds, config = list(truth), ROOT / 'examples/autoferry.toml'
    peer = dict(noise=.05, detection=.85, clutter=1e-5, speed_sigma=5.0)
    return truth, 20.0, {
        'Koseki': lambda: koseki.picture('track', [file], folder, '--config', config),
        'JPDA': lambda: peers.jpda(scans, seconds, silent_s=5.0, **peer),
        'Stone Soup, JPDA': lambda: peers.stone_soup(scans, seconds, association='jpda', delete_s=5.0, **peer)}


def cases(row, seeds, data):
    """The function that makes a row's cases, and what each case is called."""
    if row in FERRY:
        scenarios = sorted(data.glob('scenario*'), key=lambda path: int(path.name[8:]))
        if not scenarios:
            sys.exit(f'benchmark: {row}: no scenario in {data}; --data names the folder of the data set')
        return ferry, scenarios
    return (fused if row in FUSED else tracked), seeds


def measured(row, koseki, seeds, data):
    """By method, its figures in each case."""
    make, names = cases(row, seeds, data)
    figures = {}
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            truth, cut_off_m, methods = make(row, koseki, pathlib.Path(folder), name)
            for method, picture in methods.items():
                begin = time.process_time() + sum(os.times()[2:4])
                shown = picture()
                used = time.process_time() + sum(os.times()[2:4]) - begin
                figures.setdefault(method, []).append(compared(shown, truth, cut_off_m) | {'seconds': used})
                print(f'{row} {getattr(name, "name", name)}: {method}: done in {used:.1f} s', file=sys.stderr)
    return figures


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument('rows', nargs='+', choices=[*FUSED, 'radars', *FERRY])
    parser.add_argument('--seeds', default='1,2,3,4')
    parser.add_argument('--koseki', default=ROOT / 'target/release/koseki')
    parser.add_argument('--data', type=pathlib.Path, default=ROOT.parent / 'shared/data/autoferry')
    parser.add_argument('--json', action='store_true')
    chosen = parser.parse_args()
    for row in chosen.rows:
        figures = measured(row, Koseki(chosen.koseki), [int(seed) for seed in chosen.seeds.split(',')], chosen.data)
        means = {method: {key: statistics.fmean(case[key] for case in all_cases) for key in all_cases[0]}
                 for method, all_cases in figures.items()}
        if chosen.json:
            print(json.dumps({row: means}))
            continue
        print('| row | method | GOSPA m | RMSE m | shown | false | switches | s |\n| --- | --- | --- | --- | --- | --- | --- | --- |')
        for method, mean in means.items():
            print(f"| {row} | {method} | {mean['GOSPA']:.1f} | {mean['RMSE']:.1f} | {100 * mean['shown']:.1f} % | {mean['false']:.2f} "
                  f"| {mean['switches']:.2f} | {mean['seconds']:.1f} |")


if __name__ == '__main__':
    main()
