#!/usr/bin/env python3
"""Makes page/coast.bin: the world's land and borders at 1:50 million, small enough to be in the executable.

    npm pack world-atlas && tar xf world-atlas-*.tgz
    services/display/coastlines.py package/countries-50m.json services/display/page/coast.bin

The data are Natural Earth's (public domain), as the npm package `world-atlas` 2.0.2 has them in TopoJSON.

Form of the file, little-endian: the octets "KCOAST1\\n", the number of rings of land and the number of borders (u32
each), then the lines, rings first. A line is the number of its points and then each point's longitude and latitude less
those of the point before, in steps of 0.0025 degrees (0 before the first). All of these are variable-length integers,
seven bits an octet with the lowest first; differences are in zigzag form (0, -1, 1, -2, ...). A ring repeats its first
point at its end.
"""

import json
import struct
import sys

STEP_DEG = 0.0025


def unsigned(value):
    octets = bytearray()
    while value > 127:
        octets.append(value & 127 | 128)
        value >>= 7
    octets.append(value)
    return octets


def zigzag(value):
    return unsigned(2 * value if value >= 0 else -2 * value - 1)


def decoded_arcs(topology):
    """Arcs as lists of (longitude, latitude) in steps."""
    (scale_x, scale_y), (shift_x, shift_y) = (topology["transform"][key] for key in ("scale", "translate"))
    for arc in topology["arcs"]:
        x = y = 0
        points = []
        for dx, dy in arc:
            x, y = x + dx, y + dy
            points.append((round((x * scale_x + shift_x) / STEP_DEG), round((y * scale_y + shift_y) / STEP_DEG)))
        yield points


def joined(arcs, numbers):
    """Line that the arcs make; a negative number is the complement of one that is passed backwards."""
    line = []
    for number in numbers:
        arc = arcs[number] if number >= 0 else arcs[~number][::-1]
        line.extend(arc[1:] if line else arc)
    return line


def rings(geometry):
    if geometry["type"] == "GeometryCollection":
        for part in geometry["geometries"]:
            yield from rings(part)
    elif geometry["type"] == "Polygon":
        yield from geometry["arcs"]
    elif geometry["type"] == "MultiPolygon":
        for polygon in geometry["arcs"]:
            yield from polygon


def written(line):
    line = [point for k, point in enumerate(line) if k == 0 or point != line[k - 1]]
    octets = unsigned(len(line))
    before = (0, 0)
    for point in line:
        octets += zigzag(point[0] - before[0]) + zigzag(point[1] - before[1])
        before = point
    return octets


def main(topology_path, out_path):
    with open(topology_path, encoding="utf-8") as file:
        topology = json.load(file)
    arcs = list(decoded_arcs(topology))
    land = [joined(arcs, ring) for ring in rings(topology["objects"]["land"])]
    coast = {number if number >= 0 else ~number for ring in rings(topology["objects"]["land"]) for number in ring}
    countries = {
        number if number >= 0 else ~number for ring in rings(topology["objects"]["countries"]) for number in ring
    }
    borders = [arcs[number] for number in sorted(countries - coast)]
    octets = b"KCOAST1\n" + struct.pack("<II", len(land), len(borders))
    with open(out_path, "wb") as file:
        file.write(octets + b"".join(written(line) for line in land + borders))


if __name__ == "__main__":
    main(*sys.argv[1:])
