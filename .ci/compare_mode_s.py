#!/usr/bin/env python3
"""Compare our decoding of Mode S frames with that of two other decoders, value by value.

usage: compare_mode_s.py FRAMES.jsonl[.gz] OURS.jsonl [LATITUDE LONGITUDE]

FRAMES holds a line of JSON for each frame, with `timestamp`, `frame` and the values that rs1090 (jet1090) decoded.
OURS is the output of crates/formats/examples/mode_s_fields.rs for the same lines:

    zcat FRAMES | cargo run -p formats --example mode_s_fields LATITUDE LONGITUDE > OURS

The second decoder is pyModeS 3 (`pip install pyModeS`).  Its positions are those of its functions for pairs, with the
latest frame of the other parity, and for single frames near our position before: its decoder of streams gives the older
frame of a pair the place of the newer one.  LATITUDE and LONGITUDE are the reference on the ground.
Single values must be equal to the last digit that the other decoder gives, positions within 2 m.  What is known to
differ, and why, is listed in KNOWN below: it is checked as well, and counted.
Exit status 1 on any other difference.
"""
import collections
import gzip
import json
import math
import sys

import pyModeS
from pyModeS.position import (airborne_position_pair, airborne_position_with_ref, surface_position_pair,
                              surface_position_with_ref)

POSITION_M = 2.0
ANGLE_DEG = 1e-9
# Longest time between the frames of a pair: in the air, on the ground.
PAIR_S = {False: 10, True: 25}
EARTH_M = 6371e3


def bits(frame, first, last):
    """Bits of a frame, numbered from 1."""
    return (int(frame, 16) >> (4 * len(frame) - last)) & ((1 << (last - first + 1)) - 1)


def rs1090_movement(ours, other, line):
    code = bits(line['frame'], 38, 44)
    return 13 <= code <= 38 and other == 1 + (code - 9) * 0.25


def undefined_characters(ours, other, line):
    return ours is not None and '?' in ours and ours.replace('?', '#').startswith(other)


def no_altitude(ours, other, line):
    return ours is None and other == 0 and bits(line['frame'], 20, 32) == 0


def metric(ours, other, line):
    return ours is None and bits(line['frame'], 26, 26) == 1


def up_to_zero(ours, other, line):
    return ours is not None and ours <= 0 and not other


def unknown_request(ours, other, line):
    return bits(line['frame'], 9, 13) not in (0, 1, 4, 5)


def rounded(ours, other, line):
    return ours is not None and other == round(ours / 100) * 100


def waits(ours, other, line):
    return ours is None and not line['refused']


def repeated(ours, other, line):
    return ours is None and line['refused'] == 'Repeated'


def near_ground(ours, other, line):
    return ours is not None and other is None


REPEATED = 'a transmission that two receivers passed on gives one observation here'
SHIFTED = 'a downlink request that rs1090 does not know shifts what it reads behind; nearly all such frames are noise'

# (decoder, value): [(what the difference must be, why)]
KNOWN = {
    ('rs1090', 'speed'): [(rs1090_movement, 'movements 13 to 38 are 2 kn to 14.5 kn in steps of 0.5 kn by DO-260B; '
                           'rs1090 continues the steps of 0.25 kn before them')],
    ('rs1090', 'callsign'): [(undefined_characters, 'a code without a character is ? here, # or nothing there')],
    ('pyModeS', 'callsign'): [(undefined_characters, 'a code without a character is ? here, # there')],
    ('rs1090', 'altitude'): [(no_altitude, 'an altitude code of zeros states no altitude'),
                             (up_to_zero, 'rs1090 has no altitudes below 25 ft'),
                             (unknown_request, SHIFTED),
                             (metric, 'the standard has no coding for metric units; the frame is noise')],
    ('rs1090', 'selected'): [(rounded, 'selected altitudes have steps of 32 ft; rs1090 rounds them to 100 ft')],
    ('rs1090', 'squawk'): [(unknown_request, SHIFTED)],
    ('pyModeS', 'position'): [(repeated, REPEATED)],
    ('rs1090', 'position'): [(repeated, REPEATED),
                             (waits, 'a first frame waits for its pair; rs1090 was given the airport'),
                             (near_ground, 'a first frame in the air is near the last place on the ground; '
                              'rs1090 waits')],
}


def distance_m(a, b):
    (y0, x0), (y1, x1) = [[math.radians(angle) for angle in place] for place in (a, b)]
    h = math.sin((y1 - y0) / 2) ** 2 + math.cos(y0) * math.cos(y1) * math.sin((x1 - x0) / 2) ** 2
    return 2 * EARTH_M * math.asin(math.sqrt(h))


def equal(name, ours, other):
    if ours is None or other is None:
        return ours is other
    if name == 'position':
        return distance_m(ours, other) <= POSITION_M
    if isinstance(other, int) and isinstance(ours, float):
        # Whole knots there, cut; here the sum of squares.
        return ours == other or math.floor(ours + 1e-6) == other
    if isinstance(other, float):
        return abs(ours - other) <= max(ANGLE_DEG, 1e-6 * abs(other))
    return ours == other


def of_rs1090(values):
    """Values of a line under our names; a name that is absent is not compared."""
    found = {'icao': values['icao24']}
    kind = values.get('bds')
    if values['df'] == '20':
        found['altitude'] = values.get('altitude')
    elif values['df'] == '21':
        found['squawk'] = values.get('squawk')
    elif kind == '05':
        found['altitude'] = values.get('altitude')
    elif kind in ('06', '09'):
        found['speed'] = values.get('groundspeed')
        found['track'] = values.get('track')
    elif kind == '08':
        found['callsign'] = values.get('callsign')
    elif kind == '62':
        found['nacp'] = values.get('NACp')
        is_ours = values.get('source') == 'MCP/FCU'
        found['selected'] = values.get('selected_altitude') if is_ours else None
    if kind == '09':
        found['rate'] = values.get('vertical_rate')
    if kind in ('05', '06'):
        found['cpr'] = [int(values['parity'] == 'odd'), values['lat_cpr'], values['lon_cpr']]
        latitude = values.get('latitude')
        found['position'] = None if latitude is None else [latitude, values['longitude']]
    return found


def of_pymodes(values):
    """The same of pyModeS, without positions."""
    found = {'icao': values['icao'].lower()}
    kind = values.get('typecode')
    if values['df'] in (4, 20, 0, 16):
        found['altitude'] = values.get('altitude')
    elif values['df'] in (5, 21):
        found['squawk'] = values.get('squawk')
    elif kind in range(1, 5):
        found['callsign'] = values.get('callsign')
    elif kind in range(5, 9) or kind == 19:
        found['speed'] = values.get('groundspeed')
        found['track'] = values.get('track')
    elif kind in range(9, 19):
        found['altitude'] = values.get('altitude')
    elif kind == 29 and values.get('subtype') == 1:
        is_ours = values.get('selected_altitude_source') == 'MCP/FCU'
        found['selected'] = values.get('selected_altitude') if is_ours else None
        found['nacp'] = values['nac_p']
        found['sil'] = values['sil']
    elif kind == 31:
        found['version'] = values['version']
    if kind == 19:
        found['rate'] = values.get('vertical_rate')
        if values.get('subtype') in (1, 2) and values.get('groundspeed') is not None:
            found['nacv'] = values['nac_v']
    if 'cpr_lat' in values:
        found['cpr'] = [values['cpr_format'], values['cpr_lat'], values['cpr_lon']]
    return found


class Positions:
    """Positions by the functions of pyModeS."""

    def __init__(self, reference):
        self.reference = reference
        self.halves, self.places = {}, {}

    def of(self, line, values, ours):
        """The position of a frame; ours if there is neither a pair nor a place before."""
        is_surface, time_s, icao = values['typecode'] < 9, line['timestamp'], values['icao']
        own = (time_s, values['cpr_lat'], values['cpr_lon'])
        parity = values['cpr_format']
        self.halves[icao, is_surface, parity] = own
        other = self.halves.get((icao, is_surface, 1 - parity))
        place = self.places.get(icao)
        found = None
        if other and time_s - other[0] <= PAIR_S[is_surface]:
            even, odd = (other, own) if parity else (own, other)
            if is_surface:
                found = surface_position_pair(*even[1:], *odd[1:], lat_ref=self.reference[0], lon_ref=self.reference[1],
                                              even_is_newer=parity == 0)
            else:
                found = airborne_position_pair(*even[1:], *odd[1:], even_is_newer=parity == 0)
        if found is None and place:
            near = surface_position_with_ref if is_surface else airborne_position_with_ref
            found = near(parity, *own[1:], *place)
        if ours:
            self.places[icao] = ours
        return found and list(found)


OURS = {'icao': 'icao', 'callsign': 'callsign', 'altitude': 'altitude_ft', 'speed': 'speed_kt', 'track': 'track_deg',
        'rate': 'rate_ftpmin', 'nacv': 'nacv', 'squawk': 'squawk', 'selected': 'selected_ft', 'nacp': 'nacp',
        'sil': 'sil', 'version': 'version', 'cpr': 'cpr'}


def of_ours(values):
    found = {name: values.get(key) for name, key in OURS.items()}
    for name in ('altitude', 'rate', 'selected', 'speed'):
        if found[name] is not None:
            found[name] = round(found[name], 6)
    found['position'] = (values['observation'] or {}).get('place_deg')
    return found


def main():
    frames, decoded, *reference = sys.argv[1:]
    opened = gzip.open(frames, 'rt') if frames.endswith('.gz') else open(frames)
    lines = [json.loads(line) for line in opened]
    ours = [json.loads(line) for line in open(decoded)]
    assert len(lines) == len(ours), (len(lines), len(ours))
    reference = tuple(map(float, reference)) or None
    positions = Positions(reference)
    equals, known, wrong = collections.Counter(), collections.Counter(), collections.Counter()
    for line, own_line in zip(lines, ours):
        own = of_ours(own_line)
        line['refused'] = own_line['refused']
        other = pyModeS.decode(line['frame'])
        pymodes = of_pymodes(other)
        if 'cpr' in pymodes:
            pymodes['position'] = positions.of(line, other, own['position'])
        for decoder, values in (('rs1090', of_rs1090(line)), ('pyModeS', pymodes)):
            for name, value in values.items():
                key = (decoder, name)
                if equal(name, own[name], value):
                    equals[key] += value is not None
                    continue
                reasons = KNOWN.get(key, [])
                why = next((why for is_known, why in reasons if is_known(own[name], value, line)), None)
                if why:
                    known[key + (why,)] += 1
                    continue
                wrong[key] += 1
                if wrong[key] <= 5:
                    print(f"{decoder} {name}: ours {own[name]} ({own_line['refused']}), {value}: {line['frame']} "
                          f"at {line['timestamp']}")
    print(f'{len(lines)} frames, {sum(values["observation"] is not None for values in ours)} observations')
    for key, count in sorted(equals.items()):
        print(f'{count:7} equal  {" ".join(key)}')
    for key, count in sorted(known.items()):
        print(f'{count:7} known  {": ".join(key)}')
    for key, count in sorted(wrong.items()):
        print(f'{count:7} WRONG  {" ".join(key)}')
    sys.exit(bool(wrong))


if __name__ == '__main__':
    main()
