#!/usr/bin/env python3
"""Fuse random settings of sensors, trackers and motion, and compare the picture with filters on the measurements.

usage: accuracy.py TOOLS FOLDER [--seed N] [--settings N] [--keep] KOSEKI ...

TOOLS has gen_scenario.py, central.py and baseline.py. Each setting is drawn from its own seed, and printed: the tuple
behind a seed is the command that makes it again. Several executables are compared on the same files. For each:

    R/c      error of position over that of one filter on all measurements, with known association and relative biases
    /ivw     the same over that of a plain average of the tracks, with known association and biases
    NEES     squared error over the stated covariance, per axis: 1 is honest; everything by phase with --keep
    velocity the same of the velocity: in straight flight by the likeliest case, in the first 6 s of manoeuvres, and in the rest
    climb    the same of the climb rate: while constant by the likeliest case, and in the first 6 s of its changes
    ghosts   system tracks of no target
    shown    share of the targets' time in which they are shown

Where the sensors have offsets, the common part of all offsets is invisible to every method. Each method is then scored
relative to its own common point: the mean error in the plane of each second is taken off first. NEES, ghosts and shares stay
those of the picture itself.

A summary follows: median and nine tenths of R/c, shares of settings with an honest NEES (0.7 to 1.4), with at most one
ghost, and worse than the average by more than 3 %.
"""
import argparse
import csv
import json
import math
import pathlib
import random
import shutil
import statistics
import subprocess
import sys

HONEST = (0.7, 1.4)
# Largest distance of a row from its target for the mean error, metres.
FAR_M = 1000


def drawn(seed):
    """Settings of the generator, and whether the places of the sensors are known."""
    dice = random.Random(seed)
    maybe = lambda share: dice.random() < share
    number = dice.choice([1, 2, 3, 3, 5, 5, 8, 16])
    kin = dice.choice(['real', 'gentle', 'speed', 'vert', 'hover', 'weave', 'mix', ''])
    settings = {'sensors': number, 'targets': 10 if number > 8 else 20}
    if kin:
        settings['kin'] = kin
    if kin == 'hover':
        settings |= {'spd_lo': 10, 'spd_hi': 30, 'area': '5e3', 'alt_scale': .03, 'q': 2}
        finest, coarsest = 5, 40
    else:
        settings['area'] = dice.choice(['50e3', '100e3', '200e3'])
        finest, coarsest = 10, 300
    log_uniform = lambda low, high: math.exp(dice.uniform(math.log(low), math.log(high)))
    settings['periods'] = '/'.join(f'{log_uniform(.5, 15):.1f}' for _ in range(number))
    settings['sigmas'] = '/'.join(f'{log_uniform(finest, coarsest):.0f}' for _ in range(number))
    settings |= {'pd': round(dice.uniform(.65, .97), 2), 'dropout': dice.choice([0, .1, .4]),
                 'false_per_scan': dice.choice([0, .05, .3, 1])}
    if kin and maybe(.3):
        settings['turb'] = .1
    if maybe(.5):
        settings['zsig'] = 8
    if maybe(.4) and kin != 'hover':
        settings['ang'] = 1
    elif maybe(.2):
        settings['aspect'] = dice.choice([2, 3, 6])
    if maybe(.5):
        settings['bias'] = dice.choice([30, 60, 200]) if kin != 'hover' else 10
    for share, key, values in [(.15, 'azbias', [.2, .5]), (.15, 'drift', [.2, .5]), (.2, 'stamp_err', [.1, .3, 1]),
                               (.15, 'tails', [3]), (.15, 'outliers', [.03]), (.1, 'wander', [20, 50]), (.15, 'quant', [10, 50]),
                               (.15, 'tquant', [.1, .5, 1]), (.15, 'arrival', [1, 3])]:
        if maybe(share):
            settings[key] = dice.choice(values)
    if maybe(.3):
        settings['diag'] = dice.choice([1, 2])
    if maybe(.2):
        settings |= {'claim': dice.choice([.25, 4]), 'claim_all': dice.choice([0, 1])}
    if maybe(.15):
        settings |= {'dup': 1, 'copynoise': dice.choice([0, 10, 30])}
    if maybe(.5):
        settings['filters'] = '/'.join(dice.choice(['kf', 'imm', 'ab', 'plots']) for _ in range(number))
    if maybe(.5):
        settings['qs'] = '/'.join(dice.choice(['2', '20', '200']) for _ in range(number))
    settings['xsensor'] = dice.randint(1, number)
    return settings, maybe(.5)


class Setting:
    def __init__(self, tools, folder, seed):
        self.seed, self.folder = seed, folder
        self.settings, self.has_places = drawn(seed)
        words = [f'{key}={value}' for key, value in self.settings.items()]
        self.words = ' '.join(words) + (' places known' if self.has_places else '')
        sets = [word for setting in words for word in ('--set', setting)]
        run = lambda script, *rest: subprocess.run([sys.executable, tools / script, *map(str, rest)], check=True, capture_output=True)
        run('gen_scenario.py', 'A', folder, '--seed', seed, '--raw', *sets)
        run('central.py', folder, folder / 'central.csv')
        run('baseline.py', folder, folder / 'ivw.csv', '--know-relative')

    def fused(self, koseki, name):
        options = []
        if self.has_places:
            meta = json.loads((self.folder / 'meta.json').read_text())
            own = [sensor for sensor in meta['sensors'] if sensor['id'] <= meta['params']['sensors']]
            with (self.folder / 'places.toml').open('w') as config:
                for place, sensor in enumerate(own):
                    turn, radius = 2 * math.pi * place / len(own), meta['params']['area'] / 2
                    config.write(f"[[sensor]]\nid = {sensor['id']}\nperiod_s = {sensor['period']}\n"
                                 f'position_m = [{math.cos(turn) * radius:.1f}, {math.sin(turn) * radius:.1f}]\n')
            options = ['--config', self.folder / 'places.toml']
        out = self.folder / f'{name}.csv'
        subprocess.run([koseki, 'fuse', *options, '--tracks', *sorted(self.folder.glob('sensor_tracks_*.csv')), '--refresh', '1',
                        '--out', out], check=True, capture_output=True)
        return self.score(koseki, out)

    def score(self, koseki, tracks):
        card = self.card(koseki, tracks)
        if self.settings.get('bias') and card['rmse_pos'] is not None:
            card['rmse_pos'] = self.card(koseki, self.without_mean_error(tracks))['rmse_pos']
        return card

    def without_mean_error(self, tracks):
        """The tracks without their mean error in the plane of each second, by the nearest target of each row."""
        with open(self.folder / 'truth.csv') as file:
            places = {}
            for row in csv.DictReader(file):
                places.setdefault(float(row['time_s']), []).append((float(row['x']), float(row['y'])))
        with open(tracks) as file:
            reader = csv.DictReader(file)
            rows = list(reader)
        errors = {}
        for row in rows:
            x, y, time_s = float(row['x']), float(row['y']), float(row['time_s'])
            near = min(((x - a, y - b) for a, b in places.get(time_s, [])), key=lambda error: math.hypot(*error), default=None)
            if near and math.hypot(*near) < FAR_M:
                errors.setdefault(time_s, []).append(near)
        means = {time_s: [statistics.fmean(values) for values in zip(*found)] for time_s, found in errors.items()}
        moved = tracks.with_name('moved.csv')
        with moved.open('w', newline='') as file:
            writer = csv.DictWriter(file, reader.fieldnames)
            writer.writeheader()
            for row in rows:
                mean = means.get(float(row['time_s']), [0, 0])
                writer.writerow(row | {axis: f'{float(row[axis]) - part:.3f}' for axis, part in zip('xy', mean)})
        return moved

    def card(self, koseki, tracks):
        command = [koseki, 'score', '--truth', self.folder / 'truth.csv', '--tracks', tracks, '--json']
        return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)


def by_phase(score):
    """NEES of velocity and climb rate in the phases in which one of both cases holds."""
    nees = lambda phase, group: score['phases'][phase]['consistency'][group]['nees']
    text = lambda value: '-' if value is None else f'{value:.2f}'
    of = lambda group, phases: ' '.join(text(nees(phase, group)) for phase in phases)
    return (f"velocity {of('likeliest_velocity', ['straight'])} {of('velocity', ['entry', 'turn'])} "
            f"climb {of('likeliest_climb', ['rate_steady'])} {of('climb', ['rate_entry'])}")


def summary(rows):
    ratios = sorted(row['ratio'] for row in rows)
    share = lambda holds: f'{100 * sum(map(holds, rows)) / len(rows):.0f} %'
    print(f'  R/c median {statistics.median(ratios):.3f}, nine tenths {ratios[int(.9 * (len(ratios) - 1))]:.2f}; '
          f"NEES honest {share(lambda row: HONEST[0] <= row['nees'] <= HONEST[1])}; "
          f"at most one ghost {share(lambda row: row['ghosts'] <= 1)}; worse than the average {share(lambda row: row['ivw'] > 1.03)}")
    return statistics.median(ratios)


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split('usage: ')[1].split('\n')[0])
    parser.add_argument('tools', type=pathlib.Path)
    parser.add_argument('folder', type=pathlib.Path)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--settings', type=int, default=100)
    parser.add_argument('--keep', action='store_true', help='keep the files of the settings, and print NEES by phase')
    parser.add_argument('--most', type=float, help='largest median of R/c of the first executable')
    parser.add_argument('koseki', nargs='+')
    given = parser.parse_args()
    found = [[] for _ in given.koseki]
    for seed in range(given.seed, given.seed + given.settings):
        folder = given.folder / str(seed)
        folder.mkdir(parents=True)
        setting = Setting(given.tools, folder, seed)
        central, average = (setting.score(given.koseki[0], folder / f'{name}.csv') for name in ('central', 'ivw'))
        print(f'{seed}  {setting.words}')
        for number, koseki in enumerate(given.koseki):
            score = setting.fused(koseki, f'fused{number}')
            if None in (score['rmse_pos'], central['rmse_pos'], average['rmse_pos']):
                print('      nothing to compare')
                continue
            row = {'ratio': score['rmse_pos'] / central['rmse_pos'], 'ivw': score['rmse_pos'] / average['rmse_pos'],
                   'nees': score['nees_pos'], 'ghosts': score['spurious']}
            found[number].append(row)
            print(f"      R/c {row['ratio']:.2f} /ivw {row['ivw']:.2f} NEES {row['nees']:.2f} ghosts {row['ghosts']} "
                  f"{by_phase(score)} switches {score['id_switches']} shown {score['completeness']:.3f} ({central['completeness']:.3f})", flush=True)
            if given.keep:
                print('      ' + json.dumps(score['phases']))
        if not given.keep:
            shutil.rmtree(folder)
    medians = []
    for koseki, rows in zip(given.koseki, found):
        print(f'{koseki}: {len(rows)} settings')
        medians.append(summary(rows))
    if given.most and medians[0] > given.most:
        sys.exit(f'the median of R/c is {medians[0]:.3f}, more than {given.most}')


main()
