#!/usr/bin/env python3
"""Compare our reading of AIS with that of a second decoder (pyais 3), field by field.

usage: compare_ais.py AIS_FIELDS [POSITIONS.csv]

AIS_FIELDS is the example of that name of the crate `formats`.  Messages of all 27 types with random fields, a fifth of
which are not available or out of range, are encoded and decoded by pyais; ours comes from the same sentences.  What
follows from the fields (velocities, times, accuracies, centres of hulls, categories) is computed here a second time,
from recommendation ITU-R M.1371-5.  Each message with static data is followed by a position of the same ship, which
shows its name and call sign.  POSITIONS.csv holds real positions, with the columns Time, MMSI, Latitude_degrees,
Longitude_degrees, COG_degrees and SOG_knots; each becomes a message of type 1.
Exit status 1 on any difference that KNOWN does not explain.
"""
import collections
import csv
import datetime
import json
import math
import random
import subprocess
import sys

import pyais
from pyais.messages import MSG_CLASS, MessageType24PartA, MessageType24PartB

PER_TYPE = 150
SEED = 20260301
KNOT_MPS = 1852 / 3600
START_S = 1_577_836_800
STATUS = {0: 'engine', 1: 'anchored', 2: 'not-under-command', 3: 'restricted', 4: 'constrained', 5: 'moored',
          6: 'aground', 7: 'fishing', 8: 'sailing', 14: 'rescue'}
SHIP = {30: 'fishing', 31: 'towing', 32: 'towing', 33: 'dredging', 34: 'diving', 35: 'military', 36: 'sailing',
        37: 'pleasure', 50: 'pilot', 51: 'rescue', 52: 'tug', 53: 'tender', 54: 'anti-pollution', 55: 'law-enforcement',
        56: 'ship', 57: 'ship', 58: 'medical', 59: 'ship'}
TENS = {2: 'wing-in-ground', 4: 'high-speed', 6: 'passenger', 7: 'cargo', 8: 'tanker', 9: 'ship'}
NUMBERS = {'970': 'rescue-transmitter', '972': 'man-overboard', '974': 'rescue-beacon', '111': 'rescue'}
DEVICES = ('rescue-transmitter', 'man-overboard', 'rescue-beacon')
# pyais rounds coordinates to a millionth of a degree.
POSITION_M = 0.1
RADIUS95_SIGMAS = math.sqrt(-2 * math.log(0.05))
TOLERANCE = {'velocity_mps': 1e-9, 'covariance_m2': 1e-4}

KNOWN = {
    'blank': 'pyais cuts blanks before a text; the recommendation pads behind only, ours keeps them',
    'copy': 'the same bits have come within the last 10 s: ours counts a copy of another receiver',
}


def text(dice, longest):
    if dice.random() < 0.1:
        return ''
    letters = 'ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 -/.&\''
    return ''.join(dice.choice(letters) for _ in range(dice.randint(1, longest)))


def number(dice, low, high, others):
    return dice.choice(others) if dice.random() < 0.2 else dice.uniform(low, high)


def mmsi(dice, kind):
    start = dice.random()
    if kind == 4:
        return int('00%03d%04d' % (dice.randint(201, 775), dice.randint(0, 9999)))
    if kind == 21:
        return int('99%03d%04d' % (dice.randint(201, 775), dice.randint(0, 9999)))
    if kind == 9 or start < 0.05:
        return int('111%03d%03d' % (dice.randint(201, 775), dice.randint(0, 999)))
    if start < 0.15 and kind in (1, 3, 14):
        return int('%s%06d' % (dice.choice(('970', '972', '974')), dice.randint(0, 999999)))
    if start < 0.2:
        return int('98%03d%04d' % (dice.randint(201, 775), dice.randint(0, 9999)))
    return dice.randint(201, 775) * 1_000_000 + dice.randint(0, 999_999)


def fields(dice, kind):
    """Random fields of a message in the units of pyais."""
    distance = lambda most: dice.choice((0, most, dice.randint(0, most), dice.randint(0, most // 5)))
    all_of = {
        'mmsi': mmsi(dice, kind), 'repeat': dice.randint(0, 3), 'accuracy': dice.random() < 0.5,
        'status': dice.randint(0, 15), 'turn': 0,
        'lat': number(dice, -90, 90, (91, 0, 90, -90, 95.5, 89.9999)),
        'lon': number(dice, -180, 180, (181, 0, 180, -180, 190.25, -179.9999)),
        'speed': round(number(dice, 0, 40, (102.3, 102.2, 102.1, 0, 0.1, 0.2)), 1),
        'course': round(number(dice, 0, 359.9, (360, 0, 359.9, 409.5)), 1),
        'heading': round(number(dice, 0, 359, (511, 0, 359, 360))),
        'second': round(number(dice, 0, 59, (60, 61, 62, 63))),
        'shipname': text(dice, 20), 'callsign': text(dice, 7), 'name': text(dice, 20), 'text': text(dice, 60),
        'ship_type': dice.randint(0, 255), 'aid_type': dice.randint(0, 31), 'off_position': dice.random() < 0.5,
        'virtual_aid': dice.random() < 0.5, 'destination': text(dice, 20),
        'to_bow': distance(511), 'to_stern': distance(511), 'to_port': distance(63), 'to_starboard': distance(63),
        'alt': round(number(dice, 0, 4094, (4095, 4094, 0))), 'reserved_1': dice.choice((0, 0x80, 0xff)),
        'dest_mmsi': 211000001, 'data': bytes(dice.randint(0, 255) for _ in range(8)),
        'radio': dice.randint(0, 2**19 - 1),
    }
    if kind == 9:
        all_of['speed'] = round(number(dice, 0, 300, (1023, 1022, 1021, 0)))
    if kind == 27:
        all_of.update(lat=number(dice, -90, 90, (91, 0, 90, 910 / 600)),
                      lon=number(dice, -180, 180, (181, 0, 180, 1810 / 600)),
                      speed=round(number(dice, 0, 40, (63, 62, 0))), course=round(number(dice, 0, 359, (511, 360, 0))))
    if kind == 21 and dice.random() < 0.3:
        all_of.update(name='A' * 19 + 'B', name_ext='EXT %d' % dice.randint(0, 999))
    return all_of


def encoded(kind, values, sequence):
    of = MSG_CLASS[kind]
    if kind == 24:
        of = dict(a=MessageType24PartA, b=MessageType24PartB)['b' if values.get('partno') else 'a']
    names = {field.name for field in of.fields()} if of.fields() else None
    chosen = values if names is None else {name: value for name, value in values.items() if name in names}
    return pyais.encode_msg(of.create(**chosen), sentence_type='VDM', radio_channel='A', seq_id=sequence)


def ecef(latitude, longitude):
    squared, (sine, cosine) = 6.69437999014e-3, (math.sin(latitude), math.cos(latitude))
    across = 6378137 / math.sqrt(1 - squared * sine**2)
    return [across * cosine * math.cos(longitude), across * cosine * math.sin(longitude), across * (1 - squared) * sine]


def geodetic_deg(x, y, z):
    squared, radius = 6.69437999014e-3, math.hypot(x, y)
    latitude = math.atan2(z, radius * (1 - squared))
    for _ in range(5):
        across = 6378137 / math.sqrt(1 - squared * math.sin(latitude)**2)
        latitude = math.atan2(z + squared * across * math.sin(latitude), radius)
    return [math.degrees(latitude), math.degrees(math.atan2(y, x))]


def centre(position, heading_deg, hull):
    """The centre of a hull, degrees: in the plane tangential to WGS-84 at the antenna."""
    bow, stern, port, starboard = hull
    if bow == 0 and port == 0:
        return position
    ahead, right, turn = (bow - stern) / 2, (starboard - port) / 2, math.radians(heading_deg)
    east, north = ahead * math.sin(turn) + right * math.cos(turn), ahead * math.cos(turn) - right * math.sin(turn)
    lat, lon = map(math.radians, position)
    axes = ([-math.sin(lon), math.cos(lon), 0],
            [-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)])
    return geodetic_deg(*(at + east * e + north * n for at, e, n in zip(ecef(lat, lon), *axes)))


def hull_of(message):
    if message['msg_type'] == 24 and (message['partno'] == 0 or str(message['mmsi']).startswith('98')):
        return None
    hull = [message['to_' + side] for side in ('bow', 'stern', 'port', 'starboard')]
    length, width = hull[0] + hull[1], hull[2] + hull[3]
    is_bound = 511 in hull[:2] or 63 in hull[2:]
    return None if is_bound or not 0 < width <= length <= 500 else hull


def category(message):
    digits = '%09d' % message['mmsi']
    if message['msg_type'] == 9:
        return 'rescue'
    if digits[:3] in NUMBERS:
        return NUMBERS[digits[:3]]
    if digits[:2] in ('00', '99'):
        return {'00': 'base-station', '99': 'aid'}[digits[:2]]
    kind = message.get('ship_type', 0)
    return SHIP.get(kind) or (TENS.get(kind // 10) if kind < 100 else None) or 'unknown'


def time_of_day_ns(second, received_s):
    if second is None or second > 59:
        return received_s % 86400 * 10**9
    measured = received_s + 2 - (received_s + 2 - second) % 60
    return (received_s if received_s - measured > 30 else measured) % 86400 * 10**9


def place(message):
    position = [message['lat'], message['lon']]
    return position if abs(position[0]) <= 90 and abs(position[1]) <= 180 else None


def offset_m(message, hull, direction):
    """Standard deviation of the distance from the antenna to the hull's centre, metres, unless the distance is known."""
    if hull:
        bow, stern, port, starboard = hull
        if bow == 0 and port == 0:
            return 0.2 * stern
        return math.hypot((bow - stern) / 2, (starboard - port) / 2) if direction is None else None
    is_ship = category(dict(message, ship_type=0)) == 'unknown'
    return 40 if message['msg_type'] in (1, 2, 3, 27) and is_ship else None


def with_offset(quality, sigma_m, direction):
    """The quality with this error along the heading, or in an unknown direction."""
    if quality == 'unknown' or sigma_m is None:
        return quality
    own = (quality.get('radius95_m', 0) / RADIUS95_SIGMAS)**2
    turn = math.radians(direction or 0)
    parts = [0.5, 0, 0.5] if direction is None else [math.sin(turn)**2, math.sin(turn) * math.cos(turn), math.cos(turn)**2]
    before = quality.get('covariance_m2', [own, 0, own])
    return {'covariance_m2': [value + sigma_m**2 * part for value, part in zip(before, parts)]}


def target(message, known, received_s):
    """The observation that a report of a position gives."""
    position, kind = place(message), message['msg_type']
    if position is None:
        return None
    knots, course, heading = message['speed'], message['course'], message.get('heading', 511)
    knots = None if knots >= {9: 1022, 27: 63}.get(kind, 102.2) else knots
    course = None if course >= 360 else course
    heading = None if heading >= 360 else heading
    direction = heading if heading is not None else course if knots is not None and knots > 2 else None
    if known.get('hull') and direction is not None:
        position = centre(position, direction, known['hull'])
    velocity = None
    if knots is not None and course is not None:
        turn = math.radians(course)
        velocity = [knots * KNOT_MPS * math.sin(turn), knots * KNOT_MPS * math.cos(turn)]
    elif knots is not None and knots < 0.2:
        velocity = [0, 0]
    radius, second = 10 if message['accuracy'] else 30, message.get('second')
    quality = {'radius95_m': radius}
    if second in (61, 62, 63):
        quality = 'unknown'
    elif kind == 27:
        own, step = (radius / RADIUS95_SIGMAS)**2, 185.2**2 / 12
        quality = {'covariance_m2': [own + step * math.cos(math.radians(message['lat']))**2, 0, own + step]}
    quality = with_offset(quality, offset_m(message, known.get('hull'), direction), direction)
    altitude = message.get('alt', 4095)
    altitude = None if altitude >= 4094 else altitude
    is_barometric = kind == 9 and message['reserved_1'] & 0x80 != 0
    is_device = category(message) in DEVICES
    status = message.get('status')
    is_test = is_device and status == 15
    return {
        'identity': {'mmsi': message['mmsi'], 'name': known.get('name') or None,
                     'callsign': known.get('callsign') or None},
        'track_number': message['mmsi'], 'time_of_day_ns': time_of_day_ns(second, received_s), 'position_deg': position,
        'velocity_mps': velocity, 'pressure_altitude_m': altitude if is_barometric else None,
        'geometric_height_m': None if is_barometric else altitude, 'is_test': is_test,
        'alerts': [2 if is_device else 0, 2 if is_device and status == 14 else 0], 'quality': quality,
    }


def statements(message):
    kind, found = message['msg_type'], []
    if kind in (1, 2, 3, 9, 18, 19, 27):
        status, own = message.get('status', 15), dict(message, ship_type=0)
        emergency = {14: 'distress', 15: 'none'}.get(status, 'unknown') if category(own) in DEVICES else 'unknown'
        if kind in (18, 19) and category(own) in DEVICES:
            emergency = 'unknown'
        stated = {'track_number': message['mmsi'], 'category': category(own),
                  'navigation': STATUS.get(status, 'unknown'), 'emergency': emergency, 'size_m': None}
        found += [stated] if (stated['category'], stated['navigation']) != ('unknown', 'unknown') else []
    if kind in (5, 19, 24):
        hull = hull_of(message)
        stated = {'track_number': message['mmsi'], 'category': category(message), 'navigation': 'unknown',
                  'emergency': 'unknown', 'size_m': hull and [hull[0] + hull[1], hull[2] + hull[3]]}
        found += [stated] if stated['category'] != 'unknown' or hull else []
    return found or None


def fixed(message):
    kind, position = message['msg_type'], place(message)
    if position is None:
        return None
    is_aid = kind == 21
    hull = hull_of(message) if is_aid else None
    return {
        'mmsi': message['mmsi'], 'name': is_aid and message['name'] or None,
        'category': 'aid' if is_aid else 'base-station',
        'size_m': hull and [hull[0] + hull[1], hull[2] + hull[3]], 'aid_type': message['aid_type'] if is_aid else 0,
        'is_virtual': is_aid and message['virtual_aid'],
        'is_off_position': is_aid and message['off_position'] and message['second'] < 60, 'position_deg': position,
    }


def expected(message, stations, received_s):
    kind, mmsi_ = message['msg_type'], message['mmsi']
    known = stations.setdefault(mmsi_, {})
    if kind in (5, 19, 24):
        known['hull'] = hull_of(message) or known.get('hull')
        known['name'] = message.get('shipname') or known.get('name')
        known['callsign'] = message.get('callsign') or known.get('callsign')
    found = {'type': kind}
    if kind in (1, 2, 3, 9, 18, 19, 27):
        found['target'] = target(message, known, received_s)
    if kind in (4, 21):
        found['fixed'] = fixed(message)
    found['statements'] = statements(message)
    return {name: value for name, value in found.items() if value is not None}


def differences(path, ours, theirs, counts):
    """Paths at which the two differ; counts compared values."""
    if isinstance(theirs, dict) and isinstance(ours, dict):
        names = sorted(set(ours) | set(theirs))
        pairs = [(name, ours.get(name), theirs.get(name)) for name in names]
        return [found for name, *pair in pairs for found in differences(path + (name,), *pair, counts)]
    field = next(name for name in reversed(path) if isinstance(name, str))
    if field == 'position_deg' and ours and theirs:
        counts[field] += 1
        places = [ecef(*map(math.radians, position)) for position in (ours, theirs)]
        return [] if math.dist(*places) <= POSITION_M else [(path, ours, theirs)]
    if isinstance(theirs, list) and isinstance(ours, list) and len(ours) == len(theirs):
        pairs = enumerate(zip(ours, theirs))
        return [found for place_, pair in pairs for found in differences(path + (place_,), *pair, counts)]
    counts[field] += 1
    is_number = all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in (ours, theirs))
    if is_number and abs(ours - theirs) <= TOLERANCE.get(field, 0):
        return []
    return [] if ours == theirs else [(path, ours, theirs)]


def messages(dice):
    """Kinds and fields of the messages, static data followed by a position."""
    for kind in range(1, 28):
        for _ in range(PER_TYPE):
            values = fields(dice, kind)
            if kind == 24:
                values['partno'] = dice.randint(0, 1)
            yield kind, values
            if kind in (5, 19, 24):
                yield 18, dict(fields(dice, 18), mmsi=values['mmsi'])


def real_messages(path):
    with open(path, newline='') as file:
        for row in csv.DictReader(file):
            at = datetime.datetime.fromisoformat(row['Time']).replace(tzinfo=datetime.timezone.utc)
            number_of = lambda name, default: float(row[name]) if row[name] else default
            yield 1, {'mmsi': int(row['MMSI']), 'lat': float(row['Latitude_degrees']),
                      'lon': float(row['Longitude_degrees']), 'course': number_of('COG_degrees', 360),
                      'speed': number_of('SOG_knots', 102.3), 'heading': 511,
                      'second': at.second, 'status': 0, 'turn': 0, 'accuracy': True, 'repeat': 0}, int(at.timestamp())


def tagged(line, received_s):
    tag = 'c:%d' % received_s
    total = 0
    for letter in tag:
        total ^= ord(letter)
    return '\\%s*%02X\\%s' % (tag, total, line)


def compare(program, all_messages, title):
    lines, wanted, stations, recent = [], {}, {}, {}
    for number_, (kind, values, received_s) in enumerate(all_messages):
        sentences = encoded(kind, values, number_ % 10)
        message = pyais.decode(*sentences).asdict(enum_as_int=True)
        lines += [tagged(line, received_s) for line in sentences]
        is_copy = received_s - recent.get(tuple(sentences), -99) <= 10
        if not is_copy:
            recent[tuple(sentences)] = received_s
        wanted[len(lines) - 1] = expected(message, stations, received_s), is_copy
    result = subprocess.run([program], input='\n'.join(lines), capture_output=True, text=True, check=True)
    found = {}
    for line in result.stdout.splitlines():
        ours = json.loads(line)
        found[ours.pop('line')] = ours
    counts, known, open_ = collections.Counter(), collections.Counter(), []
    for place_, (theirs, is_copy) in wanted.items():
        ours = found.pop(place_, {})
        if is_copy and ours == {'type': None}:
            known['copy'] += 1
            continue
        for path, mine, other in differences((), ours, theirs, counts):
            if path[-1] in ('name', 'callsign') and isinstance(mine, str) and mine.strip() == other:
                known['blank'] += 1
            else:
                open_.append((place_, theirs['type'], path, mine, other))
    print('%s: %d messages in %d lines, %d values compared' % (title, len(wanted), len(lines), sum(counts.values())))
    print('  ' + ', '.join('%s %d' % item for item in sorted(counts.items())))
    for reason, count in known.items():
        print('  %d: %s' % (count, KNOWN[reason]))
    for difference in open_[:20]:
        print('  DIFFERS', difference)
    print('  %d differences without an explanation, %d lines of ours without a message' % (len(open_), len(found)))
    return not open_ and not found


def main():
    dice = random.Random(SEED)
    received = lambda number_: START_S + 11 * number_
    made = ((kind, values, received(number_)) for number_, (kind, values) in enumerate(messages(dice)))
    is_equal = compare(sys.argv[1], made, 'random messages')
    for path in sys.argv[2:]:
        is_equal &= compare(sys.argv[1], real_messages(path), path.rsplit('/', 1)[-1])
    return 0 if is_equal else 1


if __name__ == '__main__':
    sys.exit(main())
