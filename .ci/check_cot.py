#!/usr/bin/env python3
"""Checks the Cursor on Target events of a demonstration with the parser of PyPI's `takproto`.

    check_cot.py KOSEKI FOLDER

Runs KOSEKI in FOLDER with a gateway of Cursor on Target, and compares each event with the recorded states.
"""

import csv
import datetime
import pathlib
import socket
import subprocess
import sys

import takproto

from compare_gateway import Frame

EVENTS_LEAST = 100
ORIGIN_DEG = (41.2971, 2.0785)
POSITION_SLACK_DEG = 1e-6
GATEWAY = """
[[gateway]]
name = "tak"
format = "cot"
send_to = "127.0.0.1:{port}"
"""


def events_of(koseki, folder, receiver):
    """The datagrams of a run."""
    config = pathlib.Path(__file__).parent.parent / 'config' / 'demo.toml'
    port = receiver.getsockname()[1]
    (folder / 'cot.toml').write_text(config.read_text() + GATEWAY.format(port=port))
    run = [koseki, 'up', folder / 'cot.toml', '--instance', 'ci-cot', '--for', '10', '--out', folder / 'run',
           '--set', 'recorder.enabled=true', '--set', 'recorder.format=["csv"]']
    with open(folder / 'said', 'w') as said, subprocess.Popen(run, stdout=said, stderr=said) as process:
        receiver.settimeout(0.2)
        datagrams = []
        while True:
            ended = process.poll() is not None
            try:
                datagrams.append(receiver.recv(65536))
            except TimeoutError:
                if ended:
                    break
    if process.returncode != 0:
        sys.exit((folder / 'said').read_text())
    return datagrams


def states_of(path):
    """The recorded states by track number and time of day in milliseconds."""
    states = {}
    with open(path, newline='') as file:
        for row in csv.DictReader(file):
            key = int(row['system_track_id']), int(float(row['time_s']) * 1000)
            states.setdefault(key, []).append([float(row[axis]) for axis in ('x', 'y', 'z')])
    return states


def is_of(event, states, frame):
    number = int(event.uid.rsplit('.', 1)[1])
    midnight = datetime.datetime.fromtimestamp(event.startTime / 1000, datetime.timezone.utc)
    midnight = midnight.replace(hour=0, minute=0, second=0, microsecond=0)
    time_ms = event.startTime - int(midnight.timestamp() * 1000)
    # A time of three decimals, cut off.
    near = [state for at in (time_ms - 1, time_ms, time_ms + 1) for state in states.get((number, at), [])]
    for state in near:
        latitude, longitude = frame.geodetic_deg(*state)[:2]
        if abs(latitude - event.lat) < POSITION_SLACK_DEG and abs(longitude - event.lon) < POSITION_SLACK_DEG:
            return True
    return False


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[2])
    folder.mkdir()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        receiver.bind(('127.0.0.1', 0))
        datagrams = events_of(sys.argv[1], folder, receiver)
    states = states_of(folder / 'run' / 'latest' / 'system_tracks.csv')
    frame = Frame(*ORIGIN_DEG, 0.0)
    wrong = []
    for datagram in datagrams:
        event = takproto.parse_proto(bytearray(datagram)).cotEvent
        if not event.type.startswith('a-u-') or event.staleTime < event.startTime or not event.detail.contact.callsign:
            wrong.append(datagram)
        elif not is_of(event, states, frame):
            wrong.append(datagram)
    print(f'{len(datagrams)} events, {len(wrong)} are not among the recorded states')
    for datagram in wrong[:5]:
        print('  ' + datagram.decode())
    sys.exit(1 if wrong or len(datagrams) < EVENTS_LEAST else 0)


if __name__ == '__main__':
    main()
