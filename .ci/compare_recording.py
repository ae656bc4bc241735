#!/usr/bin/env python3
"""Compare the recording of all topics, as an independent reader decodes it, with the tables of the same run.

usage: compare_recording.py FOLDER

FOLDER: a run's, with format = ["csv", "mcap"].  The files all_topics_*.mcap are decoded by PyPI's `mcap` and
`mcap-ros2-support`, which know of Koseki only what the files' schemas say.  Every table must have as many rows as its
topic has samples, in the same order, and every cell must be what the sample says: words and whole numbers as they
stand, exact numbers to the last bit, rounded ones as the nearest decimal.
Exit status 1 if a cell is not, or if there are no system tracks at all.
"""
import csv
import datetime
import glob
import importlib.util
import os
import struct
import sys
from decimal import Decimal

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from compare_gateway import Frame

HERE = os.path.dirname(os.path.abspath(__file__))
LAYOUT = os.path.join(HERE, '..', 'crates', 'messages', 'layout', 'koseki_messages.py')
NOBODY = 0xffff
COVARIANCE = [f'P{i}{j}' for i in range(6) for j in range(i, 6)]
STEADY = ('steady_weight', 'steady_P33', 'steady_P34', 'steady_P44', 'steady_climb_weight', 'steady_P55')


def constants():
    spec = importlib.util.spec_from_file_location('koseki_messages', LAYOUT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


K = constants()


def word(group, code):
    """The word of a code, as tables write it."""
    names = [name for name, value in vars(K).items() if name.startswith(f'{group}_') and value == code]
    return names[0][len(group) + 1:].lower() if names else ''


def named(group, code):
    """The same of words that hyphens divide."""
    return word(group, code).replace('_', '-')


class Time(int):
    """Nanoseconds since 1970."""


class Milliseconds(Time):
    """A time that is written with three decimals."""


class Rounded(float):
    """A number that is written with a few decimals."""


class Single(float):
    """A number of 32 bits."""


def rounded(values):
    return [Rounded(value) for value in values]


def text(octets, valid=True):
    return bytes(octets).decode('ascii').rstrip(' \0') if valid else None


def sensor(number):
    return None if number == NOBODY else number + 1


def where(valid, value):
    return value if valid else None


def identity(message):
    who = message.identity
    return {'address': where(who.kind == K.IDENTITY_KIND_AIRCRAFT, f'{who.address:06X}'),
            'mode_3a': where(who.valid & K.IDENTITY_MODE_3A, f'{who.mode_3a:04o}'),
            'callsign': text(who.callsign, who.valid & K.IDENTITY_CALLSIGN)}


def ship(message):
    who = message.identity
    return {'mmsi': where(who.kind == K.IDENTITY_KIND_SHIP, f'{who.address:09}'),
            'name': text(who.name, who.valid & K.IDENTITY_NAME)}


def description(message):
    is_group = message.kind == K.KIND_GROUP and message.members > 0
    confidence = message.target_type.confidence
    return {'kind': 'group' if is_group else None, 'members': where(is_group, message.members),
            'type': text(message.target_type.name, confidence > 0),
            'type_confidence': where(confidence > 0, Single(confidence))}


def kinematics(message):
    return dict(zip(('x', 'y', 'z', 'vx', 'vy', 'vz'), rounded([*message.position_m, *message.velocity_mps])))


def covariance(message):
    return dict(zip(COVARIANCE, rounded(message.covariance.upper)))


def steady(message):
    """What is known without a manoeuvre."""
    xx, xy, yy = message.steady_velocity_covariance
    plane = [message.mode_probabilities[K.MODE_STEADY], xx, xy, yy] if xx > 0 and yy > 0 else [None] * 4
    constant = max(message.mode_probabilities[mode] for mode in (K.MODE_LEVEL, K.MODE_CLIMB))
    rate = [constant, message.steady_climb_variance] if message.steady_climb_variance > 0 else [None] * 2
    return dict(zip(STEADY, [None if value is None else Rounded(value) for value in plane + rate]))


def sensor_track(message, _):
    return {'time_s': Time(message.time_of_measurement_ns), 'sensor_id': message.source + 1,
            'sensor_track_id': message.track_number, **kinematics(message), **covariance(message),
            'state': word('STATE', message.state), **identity(message), 'method': message.method,
            'trace': where(message.valid & K.SENSOR_TRACK_TRACE, Rounded(message.trace_m2)),
            'height_valid': int(bool(message.valid & K.SENSOR_TRACK_HEIGHT)),
            'velocity_valid': int(bool(message.valid & K.SENSOR_TRACK_VELOCITY)), **description(message),
            **ship(message)}


def system_track(message, frame):
    parts = message.contributions[:message.contribution_count]
    latitude, longitude, height_m = frame.geodetic(*message.position_m)
    return {'time_s': Time(message.reference_time_ns), 'system_track_id': message.track_number,
            **kinematics(message), 'state': word('STATE', message.state),
            'sources': [part.source + 1 for part in parts], 'weights': rounded(part.weight for part in parts),
            'selected': sensor(message.selected_source),
            'lambda': [where(part.accuracy == part.accuracy, Rounded(part.accuracy)) for part in parts],
            **identity(message), **covariance(message),
            'sensor_track_ids': [part.track_number for part in parts],
            'report_times_s': [Time(part.time_of_measurement_ns) for part in parts],
            'height_valid': message.height_valid, 'trigger': sensor(message.trigger_source),
            'merged_into': message.merged_into or None, **description(message),
            'utc': datetime.datetime.fromtimestamp(message.reference_time_ns // 10**9, datetime.timezone.utc),
            'latitude': Rounded(latitude), 'longitude': Rounded(longitude),
            'flight_level': where(message.height_valid, Rounded(height_m / 30.48)), **ship(message),
            'velocity_valid': message.velocity_valid,
            'climb_valid': int(bool(message.height_valid) and message.covariance.upper[20] < 200), **steady(message)}


def detection(message, _):
    quantities = {K.DETECTION_KIND_POSITION2: 2, K.DETECTION_KIND_POSITION3: 3, K.DETECTION_KIND_RANGE_BEARING: 2,
                  K.DETECTION_KIND_RANGE_BEARING_ELEVATION: 3, K.DETECTION_KIND_BEARING: 1,
                  K.DETECTION_KIND_BEARING_ELEVATION: 2}[message.kind]
    values = [where(place < quantities, value) for place, value in enumerate(message.values)]
    values.append(where(message.valid & K.SENSOR_DETECTION_RANGE_RATE, message.range_rate_mps))
    has_sigmas = message.valid & K.SENSOR_DETECTION_SIGMAS
    sigmas = [where(has_sigmas and value is not None, sigma) for value, sigma in zip(values, message.sigmas)]
    ages = message.identity_ages

    def age(ms):
        return where(ms, Rounded(ms / 1e3))

    return {'time_s': Time(message.time_of_measurement_ns), 'sensor_id': message.source + 1, 'scan': message.scan,
            'detection_id': message.detection_id, 'kind': word('DETECTION_KIND', message.kind),
            **dict(zip(('m0', 'm1', 'm2', 'm3'), values)), **dict(zip(('s0', 's1', 's2', 's3'), sigmas)),
            **dict(zip(('px', 'py', 'pz'), message.platform_m)), 'truth_id': None, **identity(message),
            'mmsi': ship(message)['mmsi'],
            'level': where(message.valid & K.SENSOR_DETECTION_LEVEL, Rounded(message.level / 4)),
            'address_age_s': age(ages.address_ms), 'mode_3a_age_s': age(ages.mode_3a_ms),
            'callsign_age_s': age(ages.callsign_ms), 'level_age_s': age(message.level_age_ms), 'name': ship(message)['name']}


def bearing(message, _):
    def known(bit, value):
        return where(message.valid & bit, value)

    return {'time_s': Time(message.time_of_measurement_ns),
            'emitter_id': known(K.SENSOR_BEARING_EMITTER, message.emitter_id),
            'bearing_rad': message.bearing_rad, 'sigma_rad': message.sigma_rad,
            **dict(zip(('px', 'py', 'pz'), message.platform_m)),
            'heading_rad': known(K.SENSOR_BEARING_HEADING, message.heading_rad),
            'frequency_hz': known(K.SENSOR_BEARING_FREQUENCY, message.frequency_hz),
            'pulse_interval_s': known(K.SENSOR_BEARING_PULSE_INTERVAL, message.pulse_interval_s)}


def arrival(message, _):
    def known(bit, value):
        return where(message.valid & bit, value)

    def three(names, values, bit=None):
        return {name: known(bit, value) if bit else value for name, value in zip(names, values)}

    def name(octets):
        return bytes(octets).rstrip(b'\0').decode()

    difference = K.SENSOR_ARRIVAL_DIFFERENCE
    is_difference = message.valid & difference
    return {'time_s': Time(message.time_of_measurement_ns), 'emitter_id': message.emitter_id,
            'kind': 'tdoa' if is_difference else 'toa', 'receiver': name(message.receiver),
            't_s': None if is_difference else message.time_s, 'tdoa_s': known(difference, message.time_s),
            'sigma_s': message.sigma_s, **three(('px', 'py', 'pz'), message.receiver_m),
            'receiver_2': known(difference, name(message.receiver_2)),
            **three(('px_2', 'py_2', 'pz_2'), message.receiver_2_m, difference),
            **three(('reference_x', 'reference_y', 'reference_z'), message.reference_m, K.SENSOR_ARRIVAL_REFERENCE)}


def fix(message, _):
    return {'time_s': Time(message.time_of_measurement_ns), 'emitter_id': message.emitter_id,
            **dict(zip(('x', 'y', 'z'), message.position_m)),
            **dict(zip(('Pxx', 'Pxy', 'Pyy'), message.covariance_m2))}


def platform_state(message, _):
    def known(bit, value):
        return where(message.valid & bit, value)

    return {'time_s': Time(message.time_ns), 'sensor_id': message.source + 1,
            **dict(zip(('px', 'py', 'pz'), message.position_m)),
            **dict(zip(('vx', 'vy', 'vz'), (known(K.PLATFORM_STATE_VELOCITY, speed) for speed in message.velocity_mps))),
            'heading_rad': known(K.PLATFORM_STATE_HEADING, message.heading_rad),
            'pitch_rad': known(K.PLATFORM_STATE_ATTITUDE, message.pitch_rad),
            'roll_rad': known(K.PLATFORM_STATE_ATTITUDE, message.roll_rad),
            'position_sigma_m': known(K.PLATFORM_STATE_POSITION_SIGMA, message.position_sigma_m),
            'heading_sigma_rad': known(K.PLATFORM_STATE_HEADING_SIGMA, message.heading_sigma_rad)}


def cue(message, _):
    return {'made_s': Time(message.made_ns), 'time_s': Time(message.time_ns), 'sensor_id': message.source + 1,
            'sensor_track_id': message.track_number, **kinematics(message),
            **dict(zip(('longer_m', 'shorter_m'), rounded(message.half_axes_m))),
            'orientation_rad': Rounded(message.orientation_rad)}


def wide_area(message, _):
    return {'time_s': Time(message.time_of_observation_ns), 'arrival_s': Time(message.arrival_ns),
            **dict(zip(('x', 'y', 'z'), message.position_m)), **dict(zip(('vx', 'vy', 'vz'), message.velocity_mps)),
            'count': message.targets,
            'route': where(message.valid & K.WIDE_AREA_ORIGIN, list(message.origin_m))}


def alarm(message, _):
    """No row for what only goes on standing.  The codes' words stand in no schema."""
    if message.event == K.ALARM_EVENT_STANDING:
        return None
    return {'time_s': Time(message.time_ns), 'raised_s': Time(message.raised_ns),
            'event': word('ALARM_EVENT', message.event), 'severity': word('ALARM_SEVERITY', message.severity),
            'sensor_id': sensor(message.source), 'partner_id': sensor(message.partner),
            'process': bytes(message.process).rstrip(b'\0').decode(), 'text': bytes(message.text).rstrip(b'\0').decode()}


def decision(message, _):
    return {'time_s': Milliseconds(message.time_ns), 'decision': word('DECISION_KIND', message.kind),
            'system_track_id': message.system_track or None,
            'other_system_track_id': message.other_system_track or None,
            'sensor_id': sensor(message.source), 'other_sensor_id': sensor(message.other_source),
            'sensor_track_id': message.sensor_track or None,
            **{name: where(value == value, Rounded(value)) for name, value in
               (('value', message.value), ('limit', message.limit))}}


def statement(message, _):
    known = lambda bit, values: [where(message.valid & bit, Rounded(value)) for value in values]
    is_station = message.valid & K.TARGET_STATEMENT_STATION
    flag = lambda bit: where(is_station, int(message.valid & bit != 0))
    return {'time_s': Time(message.time_ns), 'sensor_id': message.source + 1, 'sensor_track_id': message.track_number,
            'category': named('CATEGORY', message.category),
            'navigation': named('NAVIGATION', message.navigation), 'emergency': named('EMERGENCY', message.emergency),
            **dict(zip(('length_m', 'width_m'), known(K.TARGET_STATEMENT_SIZE, (message.length_m, message.width_m)))),
            'selected_altitude_m': known(K.TARGET_STATEMENT_SELECTED_ALTITUDE, [message.selected_altitude_m])[0],
            **dict(zip(('operator_latitude', 'operator_longitude'),
                       known(K.TARGET_STATEMENT_OPERATOR, message.place_deg))),
            **dict(zip(('station_latitude', 'station_longitude'), known(K.TARGET_STATEMENT_STATION, message.place_deg))),
            'station_name': text(message.name, is_station) or None, 'aid': where(is_station, named('AID', message.aid)),
            'virtual': flag(K.TARGET_STATEMENT_VIRTUAL), 'off_position': flag(K.TARGET_STATEMENT_OFF_POSITION)}


# Ending of a topic's name: stem of the table's, and how a sample is a row.
TABLES = {'tracks': ('sensor_tracks', sensor_track), 'detections': ('detections', detection),
          'bearings': ('bearings', bearing), 'arrivals': ('arrivals', arrival), 'fixes': ('fixes', fix),
          'state': ('platform_states', platform_state), 'statements': ('statements', statement), 'cues': ('cues', cue), 'reports': ('wide_area', wide_area)}
SYSTEM = {'system/tracks': ('system_tracks', system_track), 'system/alarms': ('alarms', alarm),
          'system/decisions': ('decisions', decision)}


def is_said(cell, value, first_day_ns):
    """Whether a cell of a table says a value."""
    if value is None:
        return cell == ''
    if isinstance(value, list):
        cells = cell.split('|') if value or cell else []
        return len(cells) == len(value) and all(is_said(*pair, first_day_ns) for pair in zip(cells, value))
    if isinstance(value, datetime.datetime):
        return cell.startswith(value.strftime('%Y-%m-%dT%H:%M:%S'))
    if isinstance(value, Milliseconds):
        return abs(Decimal(cell) * 10**9 - (value - first_day_ns)) <= 500_001
    if isinstance(value, Time):
        return Decimal(cell) * 10**9 == value - first_day_ns
    if isinstance(value, Rounded):
        decimals = len(cell.partition('.')[2])
        # A limit may be infinite.
        return float(cell) == value or abs(float(cell) - value) <= 0.5 * 10**-decimals + 1e-9
    if isinstance(value, Single):
        return struct.pack('f', float(cell)) == struct.pack('f', value)
    return float(cell) == value if isinstance(value, float) else cell == str(value)


def tables(folder):
    """The samples of the recording by the table that they are rows of, the frame's origin and the first day."""
    found, origin, first_day_ns = {}, None, None
    for path in sorted(glob.glob(os.path.join(folder, 'all_topics_*.mcap'))):
        with open(path, 'rb') as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory()])
            for metadata in reader.iter_metadata():
                first_day_ns = int(metadata.metadata['first_day_ns'])
            for _, channel, _, message in reader.iter_decoded_messages(log_time_order=False):
                parts = channel.topic.split('/')
                if channel.topic in SYSTEM:
                    stem, row = SYSTEM[channel.topic]
                elif len(parts) == 3 and parts[2] in TABLES:
                    stem, row = TABLES[parts[2]]
                    stem = f'{stem}_{parts[1]}'
                else:
                    if channel.topic == 'system/frame-origin':
                        origin = message
                    continue
                found.setdefault(stem, (row, []))[1].append(message)
    return found, origin, first_day_ns


def differences(path, row, messages, frame, first_day_ns):
    """Everything about a table that is not as in its topic, and its number of cells."""
    cells, found = 0, []
    with open(path, newline='') as file:
        lines = list(csv.reader(file))
    names, rows = lines[0], lines[1:]
    samples = [sample for sample in (row(message, frame) for message in messages) if sample is not None]
    if len(rows) != len(samples):
        found.append(f'{len(rows)} rows for {len(samples)} samples')
    for number, (line, sample) in enumerate(zip(rows, samples), 2):
        values = sample if isinstance(sample, dict) else dict(zip(names, sample, strict=True))
        if unknown := values.keys() - set(names):
            found.append(f'no columns {unknown}')
        for name, cell in zip(names, line, strict=True):
            if name not in values:
                continue
            cells += 1
            if not is_said(cell, values[name], first_day_ns):
                found.append(f'line {number}, {name}: "{cell}" for {values[name]}')
    return cells, found


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = sys.argv[1]
    topics, origin, first_day_ns = tables(folder)
    frame = Frame(origin.latitude_deg, origin.longitude_deg, origin.height_m)
    wrong, expected = [], set()
    for stem, (row, messages) in sorted(topics.items()):
        path = os.path.join(folder, f'{stem}.csv')
        cells, found = differences(path, row, messages, frame, first_day_ns)
        print(f'{stem}: {len(messages)} samples, {cells} cells, {len(found)} different')
        wrong += [f'{stem}: {each}' for each in found]
        expected.add(f'{stem}.csv')
    for path in glob.glob(os.path.join(folder, '*.csv')):
        with open(path) as file:
            if os.path.basename(path) not in expected and len(file.readlines()) > 1:
                wrong.append(f'{path}: no topic has these rows')
    for each in wrong[:10]:
        print('  ' + each)
    sys.exit(1 if wrong or 'system_tracks' not in topics else 0)


main()
