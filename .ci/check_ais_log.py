#!/usr/bin/env python3
"""Open a log of AIS from two receivers, and count the numbers that each ship has.

usage: check_ais_log.py KOSEKI FOLDER [SEED]

The sentences are encoded by pyais 3.  Thirty ships, of which a third are of class B, state positions and static data;
two receivers hear nine in ten of their messages each.  The log holds both receivers' lines with tag blocks, in the order
of receipt: fragments of different ships, and of the same message at both receivers, are interleaved.
Exit status 1 unless each ship has one confirmed system track, with its MMSI and name.
"""
import csv
import math
import pathlib
import random
import subprocess
import sys

import pyais

LINES_MIN = 1_000
SHIPS = 30
START_S = 1_577_836_800
# Degrees per metre of latitude.
DEGREES_PER_M = 1 / 111_200
KNOT_MPS = 1852 / 3600


def tagged(station, second, sentence):
    """The sentence with a tag block of its receiver and time."""
    block = f's:{station},c:{second}'
    total = 0
    for octet in block.encode():
        total ^= octet
    return f'\\{block}*{total:02X}\\{sentence}'


class Ship:
    def __init__(self, dice, place):
        self.mmsi = 211_000_000 + 37 * place
        self.name = f'KOSEKI {place}'
        self.is_class_a = place % 3 != 0
        self.latitude = 54 + 0.02 * place
        self.longitude = 8 + dice.uniform(-0.2, 0.2)
        self.knots = dice.uniform(4, 18)
        self.course = dice.uniform(0, 359)
        self.period_s = 10 if self.is_class_a else 30
        self.phase_s = dice.randrange(self.period_s)

    def at(self, second):
        along = self.knots * KNOT_MPS * second * DEGREES_PER_M
        latitude = self.latitude + along * math.cos(math.radians(self.course))
        east = along * math.sin(math.radians(self.course)) / math.cos(math.radians(self.latitude))
        return latitude, self.longitude + east

    def messages(self, second):
        """Messages that the ship sends in this second, as lists of sentences."""
        if second % self.period_s == self.phase_s:
            latitude, longitude = self.at(second)
            yield {'type': 1 if self.is_class_a else 18, 'lat': latitude, 'lon': longitude, 'speed': self.knots,
                   'course': self.course, 'accuracy': True, 'second': second % 60, 'mmsi': self.mmsi}
        if second % 60 == self.phase_s:
            if self.is_class_a:
                yield {'type': 5, 'mmsi': self.mmsi, 'shipname': self.name, 'callsign': f'DA{self.mmsi % 10_000:04}',
                       'ship_type': 70, 'to_bow': 100, 'to_stern': 20, 'to_port': 10, 'to_starboard': 8}
            else:
                yield {'type': 24, 'partno': 0, 'mmsi': self.mmsi, 'shipname': self.name}
                yield {'type': 24, 'partno': 1, 'mmsi': self.mmsi, 'ship_type': 36, 'callsign': f'DB{self.mmsi % 10_000:04}',
                       'to_bow': 10, 'to_stern': 4, 'to_port': 2, 'to_starboard': 2}


def log(dice, ships):
    """Lines of both receivers, until there are enough."""
    heard = []
    for second in range(3600):
        for ship in ships:
            for message in ship.messages(second):
                channel = dice.choice('AB')
                for station in ('north', 'south'):
                    if dice.random() < 0.9:
                        # Each receiver numbers groups for itself: both may have the same number at a time.
                        sentences = pyais.encode_dict(message, sentence_type='VDM', radio_channel=channel,
                                                       seq_id=dice.randrange(10))
                        begun = second + dice.uniform(0, 0.3)
                        for part, sentence in enumerate(sentences):
                            heard.append((begun + part * dice.uniform(0.05, 0.3), tagged(station, START_S + second, sentence)))
        if len(heard) >= LINES_MIN and second >= 180:
            break
    return [line for _, line in sorted(heard)]


def main():
    koseki, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    dice = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 20_260_301)
    ships = [Ship(dice, place) for place in range(SHIPS)]
    lines = log(dice, ships)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / 'two-receivers.ais').write_text('\n'.join(lines) + '\n')
    starts = [line for line in lines if 'VDM,2,1' in line]
    apart = sum('VDM,2,1' in first and 'VDM,2,2' not in second for first, second in zip(lines, lines[1:]))
    print(f'{len(lines)} lines, {len(starts)} messages of two fragments, {apart} of them with lines between')
    run = folder / 'run'
    subprocess.run([koseki, 'open', folder / 'two-receivers.ais', '--no-display', '--out', run], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    subprocess.run([koseki, 'recording', 'export', run / 'latest', '--csv', folder / 'tables'], check=True,
                   stdout=subprocess.DEVNULL)
    numbers, names = {}, {}
    with (folder / 'tables' / 'system_tracks.csv').open() as table:
        for row in csv.DictReader(table):
            if row['state'] == 'confirmed' and row['mmsi']:
                numbers.setdefault(int(row['mmsi']), set()).add(row['system_track_id'])
                names[int(row['mmsi'])] = row['name']
    wrong = [ship for ship in ships if len(numbers.get(ship.mmsi, ())) != 1 or names[ship.mmsi] != ship.name]
    for ship in wrong:
        print(f'{ship.mmsi}: numbers {numbers.get(ship.mmsi)}, name {names.get(ship.mmsi)!r}, not {ship.name!r}')
    strangers = numbers.keys() - {ship.mmsi for ship in ships}
    print(f'{SHIPS - len(wrong)} of {SHIPS} ships with one number, MMSI and name; strangers: {sorted(strangers)}')
    sys.exit(bool(wrong or strangers))


main()
