"""Feeds of targets that move straight, sent as receivers send them: Beast over TCP, AIS over UDP, aircraft.json over HTTP.

Each feed has `what`, the argument of `koseki open`, and `second_s`, the time (monotonic) at which the first target's second
position was sent. Frames of Mode S are encoded here; AIS by pyais.
"""
import http.server
import json
import math
import socket
import threading
import time

GENERATOR = 0xFFF409
KNOT_MPS = 1852 / 3600
M_PER_DEGREE = 111_200
FOOT_M = 0.3048


def remainders():
    """Remainders of all octets in the cyclic code of Mode S."""
    table = []
    for octet in range(256):
        rest = octet << 16
        for _ in range(8):
            rest = (rest << 1 ^ GENERATOR) if rest & 0x800000 else rest << 1
            rest &= 0xFFFFFF
        table.append(rest)
    return table


REMAINDERS = remainders()


def with_parity(octets):
    rest = 0
    for octet in octets:
        rest = (rest << 8 & 0xFFFFFF) ^ REMAINDERS[rest >> 16 ^ octet]
    return octets + rest.to_bytes(3, 'big')


def zones(latitude):
    """Number of zones of longitude."""
    if abs(latitude) >= 87:
        return 1 if abs(latitude) > 87 else 2
    turn = 1 - (1 - math.cos(math.pi / 30)) / math.cos(math.radians(latitude)) ** 2
    return math.floor(2 * math.pi / math.acos(turn))


def compact(latitude, longitude, odd):
    """Latitude and longitude in compact form, 17 bits each."""
    def cell(value, size):
        return math.floor(131_072 * (value % size) / size + 0.5)

    height = 360 / (60 - odd)
    row = cell(latitude, height)
    middle = height * (row / 131_072 + math.floor(latitude / height))
    width = 360 / max(zones(middle) - odd, 1)
    return row % 131_072, cell(longitude, width) % 131_072


def squitter(address, message):
    """Extended squitter (DF 17) of 56 bits of message."""
    return with_parity((0x8D << 80 | address << 56 | message).to_bytes(11, 'big'))


def airborne_position(address, latitude, longitude, feet, odd):
    row, column = compact(latitude, longitude, odd)
    steps = (feet + 1000) // 25
    altitude = (steps >> 4) << 5 | 1 << 4 | steps & 0xF
    return squitter(address, 11 << 51 | altitude << 36 | odd << 34 | row << 17 | column)


def airborne_velocity(address, east_knots, north_knots):
    def part(knots):
        return (1 << 10 if knots < 0 else 0) | min(round(abs(knots)) + 1, 1023)

    return squitter(address, 19 << 51 | 1 << 48 | 2 << 43 | part(east_knots) << 32 | part(north_knots) << 21)


def operation_status(address):
    """Version 2, accuracy NACp 9 (30 m), integrity 3."""
    return squitter(address, 31 << 51 | 2 << 13 | 9 << 8 | 3 << 4)


def beast(ticks, frame):
    """Frame in the form of Beast, `ticks` of 12 MHz."""
    body = (ticks % (1 << 48)).to_bytes(6, 'big') + b'\x80' + frame
    return b'\x1a3' + body.replace(b'\x1a', b'\x1a\x1a')


class Target:
    def __init__(self, number, latitude, longitude, speed_mps, course_deg):
        self.number, self.latitude, self.longitude = number, latitude, longitude
        self.speed_mps, self.course_deg = speed_mps, course_deg

    def at(self, seconds):
        north = self.speed_mps * seconds * math.cos(math.radians(self.course_deg)) / M_PER_DEGREE
        east = self.speed_mps * seconds * math.sin(math.radians(self.course_deg)) / M_PER_DEGREE
        return self.latitude + north, self.longitude + east / math.cos(math.radians(self.latitude))


def targets(speed_mps):
    return [Target(place + 1, 50 + 0.1 * place, 8 + 0.1 * place, speed_mps, 40 * place) for place in range(5)]


class Feed:
    """A feed, sent from its beginning until the process ends."""

    def __init__(self):
        self.begun = time.monotonic()
        self.second_s = None
        threading.Thread(target=self.send, daemon=True).start()

    def passed(self):
        return time.monotonic() - self.begun

    def sent(self, positions):
        """Notes that each target's position of this number, from 0, was sent."""
        if positions == 1 and self.second_s is None:
            self.second_s = time.monotonic()


class Beast(Feed):
    def __init__(self):
        self.server = socket.create_server(('127.0.0.1', 0))
        self.what = f'tcp://127.0.0.1:{self.server.getsockname()[1]}'
        super().__init__()

    def send(self):
        while True:
            connection, _ = self.server.accept()
            threading.Thread(target=self.serve, args=(connection,), daemon=True).start()

    def serve(self, connection):
        # A position is known from its two halves: the second position comes with the third half.
        try:
            for half in range(1 << 30):
                passed = self.passed()
                for target in targets(200):
                    address, ticks = 0x3C0000 + target.number, int(passed * 12e6)
                    east = 200 * math.sin(math.radians(target.course_deg)) / KNOT_MPS
                    north = 200 * math.cos(math.radians(target.course_deg)) / KNOT_MPS
                    frames = [airborne_position(address, *target.at(passed), 30_000, half % 2),
                              airborne_velocity(address, east, north), operation_status(address)]
                    connection.sendall(b''.join(beast(ticks, frame) for frame in frames))
                self.sent(half - 1)
                time.sleep(0.5)
        except OSError:
            connection.close()


# A base station, a buoy off its position, a virtual aid.
STATIONS = [
    {'type': 4, 'mmsi': '002111111', 'lat': 50.02, 'lon': 8.1, 'year': 2026, 'month': 1, 'day': 1},
    {'type': 21, 'mmsi': '992111840', 'lat': 50.2, 'lon': 8.05, 'name': 'BUOY 7', 'aid_type': 24, 'off_position': 1,
     'to_bow': 3, 'to_stern': 3, 'to_port': 2, 'to_starboard': 2},
    {'type': 21, 'mmsi': '992116841', 'lat': 50.3, 'lon': 8.15, 'name': 'WRECK NORTH', 'aid_type': 20, 'virtual_aid': 1},
]


class Ais(Feed):
    def __init__(self):
        free = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        free.bind(('127.0.0.1', 0))
        self.port = free.getsockname()[1]
        free.close()
        self.what = f'udp://127.0.0.1:{self.port}'
        super().__init__()

    def send(self):
        import pyais
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

        def send(message):
            for sentence in pyais.encode_dict(message, sentence_type='VDM'):
                sender.sendto(f'{sentence}\r\n'.encode(), ('127.0.0.1', self.port))

        for position in range(1 << 30):
            for target in targets(8):
                latitude, longitude = target.at(self.passed())
                message = {'type': 1, 'mmsi': 211_000_000 + target.number, 'lat': latitude, 'lon': longitude,
                           'course': target.course_deg, 'speed': 8 / KNOT_MPS, 'second': int(time.time()) % 60, 'accuracy': 1}
                send(message)
            for station in STATIONS:
                send({**station, 'second': int(time.time()) % 60})
            self.sent(position)
            time.sleep(2)


class Json(Feed):
    def __init__(self):
        feed = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                document = feed.document()
                self.send_response(200)
                self.send_header('content-length', str(len(document)))
                self.end_headers()
                self.wfile.write(document)

            def log_message(self, *_):
                pass

        self.asked = 0
        self.server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), Handler)
        self.what = f'http://127.0.0.1:{self.server.server_port}/data/aircraft.json'
        super().__init__()

    def send(self):
        self.server.serve_forever()

    def document(self):
        aircraft = []
        for target in targets(200):
            latitude, longitude = target.at(self.passed())
            aircraft.append({'hex': f'3c{target.number:04x}', 'lat': latitude, 'lon': longitude, 'alt_baro': 30_000,
                             'gs': 200 / KNOT_MPS, 'track': target.course_deg, 'seen': 0, 'seen_pos': 0, 'nac_p': 9,
                             'type': 'adsb_icao'})
        self.sent(self.asked)
        self.asked += 1
        return json.dumps({'now': time.time(), 'aircraft': aircraft}).encode()
