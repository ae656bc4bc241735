#!/usr/bin/env python3
"""Compare what a gateway sent in CAT062, as a reference decoder reads it, with the system tracks that were published.

usage: compare_gateway.py REFERENCE.jsonl system_tracks.csv LATITUDE_DEG LONGITUDE_DEG [HEIGHT_M]

REFERENCE.jsonl: one decoded record a line, item number -> value.  system_tracks.csv: the recorder's file of the same run.
The place is the origin of the system frame.  Every record must be one of the published states: time, plane position,
latitude and longitude, velocity and identity within half a least significant bit.
Exit status 1 if one is not, or if there is no record at all.
"""
import csv
import json
import math
import sys

A, E2 = 6378137.0, 6.69437999014e-3     # WGS-84: semi-major axis in m, square of the first eccentricity
TICKS_PER_S, TICKS_PER_DAY = 128, 86400 * 128
POSITION_LSB_M = 0.5                    # I062/100
VELOCITY_LSB = 0.25                     # I062/185
ANGLE_LSB_DEG = 180 / 2**25             # I062/105
SLACK = 1e-3                            # the files are decimal; of metres and metres per second
ANGLE_SLACK_DEG = 1e-8


def ecef(latitude, longitude, height):
    n = A / math.sqrt(1 - E2 * math.sin(latitude) ** 2)
    return ((n + height) * math.cos(latitude) * math.cos(longitude),
            (n + height) * math.cos(latitude) * math.sin(longitude),
            (n * (1 - E2) + height) * math.sin(latitude))


class Frame:
    """East, north, up of a place, to latitude and longitude."""

    def __init__(self, latitude_deg, longitude_deg, height_m):
        self.latitude, self.longitude = math.radians(latitude_deg), math.radians(longitude_deg)
        self.origin = ecef(self.latitude, self.longitude, height_m)

    @staticmethod
    def axes(latitude, longitude):
        """East, north and up of a place, in earth-centred axes."""
        sp, cp, sl, cl = math.sin(latitude), math.cos(latitude), math.sin(longitude), math.cos(longitude)
        return (-sl, cl, 0), (-sp * cl, -sp * sl, cp), (cp * cl, cp * sl, sp)

    def turned(self, latitude_deg, longitude_deg, vector):
        """A vector of the system frame along true east and north of another place."""
        ours = self.axes(self.latitude, self.longitude)
        there = self.axes(math.radians(latitude_deg), math.radians(longitude_deg))
        earth = [sum(vector[i] * ours[i][k] for i in range(3)) for k in range(3)]
        return [sum(earth[k] * axis[k] for k in range(3)) for axis in there[:2]]

    def geodetic_deg(self, east, north, up):
        return self.geodetic(east, north, up)[:2]

    def geodetic(self, east, north, up):
        """Latitude and longitude in degrees, height above the ellipsoid in metres."""
        axes = self.axes(self.latitude, self.longitude)
        x, y, z = (self.origin[k] + east * axes[0][k] + north * axes[1][k] + up * axes[2][k] for k in range(3))
        p = math.hypot(x, y)
        latitude = math.atan2(z, p * (1 - E2))
        for _ in range(5):
            n = A / math.sqrt(1 - E2 * math.sin(latitude) ** 2)
            latitude = math.atan2(z + E2 * n * math.sin(latitude), p)
        n = A / math.sqrt(1 - E2 * math.sin(latitude) ** 2)
        height = p * math.cos(latitude) + z * math.sin(latitude) - n * (1 - E2 * math.sin(latitude) ** 2)
        return math.degrees(latitude), math.degrees(math.atan2(y, x)), height


def ticks_of(seconds):
    return round(seconds * TICKS_PER_S) % TICKS_PER_DAY


def published(path):
    """The states that a gateway sends, by time and address."""
    states = {}
    with open(path, newline='') as file:
        for row in csv.DictReader(file):
            if row['state'] == 'tentative':
                continue
            state = {key: float(row[key]) for key in ('time_s', 'x', 'y', 'z', 'vx', 'vy', 'vz')}
            state['address'] = int(row['address'], 16) if row['address'] else None
            state['mode_3a'] = row['mode_3a'] or None
            state['callsign'] = row['callsign'].strip() or None
            states.setdefault((ticks_of(state['time_s']), state['address']), []).append(state)
    return states


def identity(record):
    aircraft = record.get('380', {})
    code = record.get('060')
    sign = record.get('245', {}).get('CHR') or aircraft.get('ID')
    return {'address': aircraft.get('ADR'),
            'mode_3a': code['MODE3A'] if code else None,
            'callsign': sign.strip() if sign else None}


def differences(record, state, frame):
    """Everything about a record that is not as in the state."""
    found = []

    def near(name, ours, theirs, lsb, slack=SLACK):
        if abs(ours - theirs) > lsb / 2 + slack:
            found.append(f'{name} {theirs} for {ours}')

    position = record['100']
    near('X', state['x'], position['X'], POSITION_LSB_M)
    near('Y', state['y'], position['Y'], POSITION_LSB_M)
    latitude, longitude = frame.geodetic_deg(state['x'], state['y'], state['z'])
    near('LAT', latitude, record['105']['LAT'], ANGLE_LSB_DEG, ANGLE_SLACK_DEG)
    near('LON', longitude, record['105']['LON'], ANGLE_LSB_DEG, ANGLE_SLACK_DEG)
    if '185' in record:
        east, north = frame.turned(latitude, longitude, (state['vx'], state['vy'], state['vz']))
        near('VX', east, record['185']['VX'], VELOCITY_LSB)
        near('VY', north, record['185']['VY'], VELOCITY_LSB)
    for key, value in identity(record).items():
        if value != state[key]:
            found.append(f'{key} {value} for {state[key]}')
    return found


def main():
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    states = published(sys.argv[2])
    frame = Frame(*(float(argument) for argument in sys.argv[3:5]), float(sys.argv[5]) if len(sys.argv) == 6 else 0.0)
    counts, wrong = {}, []
    with open(sys.argv[1]) as file:
        for line, text in enumerate(file, 1):
            record = json.loads(text)
            counts[record['_c']] = counts.get(record['_c'], 0) + 1
            if record['_c'] != 62:
                continue
            candidates = states.get((ticks_of(record['070']), identity(record)['address']), [])
            best = min((differences(record, state, frame) for state in candidates), key=len, default=None)
            if best is None:
                wrong.append(f'record {line}: no state of this target was published with time {record["070"]}')
            elif best:
                wrong.append(f'record {line}: {"; ".join(best)}')
    print(', '.join(f'{count} records of CAT{category:03}' for category, count in sorted(counts.items())))
    print(f'{len(wrong)} of CAT062 are not among the published states')
    for each in wrong[:10]:
        print('  ' + each)
    sys.exit(1 if wrong or not counts.get(62) else 0)


if __name__ == '__main__':
    main()
