#!/usr/bin/env python3
"""Converts an extract of OpenStreetMap to GeoJSON of aerodrome surfaces, as an overlay of the display.

    services/display/aerodrome.py EXTRACT [--out airport.geojson]

EXTRACT is OSM XML (File > Save of JOSM, `osmium extract`, or the page "Export" of openstreetmap.org) or the JSON of
Overpass, for example of

    [out:json]; nwr["aeroway"](41.27,2.05,41.32,2.12); (._;>;); out body;

Runways and taxiways that are lines become areas of their width (tag `width`, else 45 and 15 m). Each feature has its
name (`ref`, else `name`), a style (simplestyle) and the zoom from which it is seen. Names of taxiways and stands are
shown from close by only. The data are those of OpenStreetMap's contributors, under the Open Database Licence.
"""

import argparse
import json
import math
import sys
import xml.etree.ElementTree

EARTH_M = 6_371_008.8
WIDTHS_M = {"runway": 45.0, "taxiway": 15.0}
# Kind: order of drawing, style, zoom from which it is seen.
KINDS = {
    "aerodrome": (0, {"stroke": "#5a7186", "fill-opacity": 0.04}, 8),
    "apron": (1, {"stroke-width": 0, "fill": "#41505c", "fill-opacity": 0.5}, 11),
    "taxiway": (2, {"stroke-width": 0, "fill": "#55646f", "fill-opacity": 0.7}, 12),
    "runway": (3, {"stroke": "#9aaab8", "fill": "#6c7b87", "fill-opacity": 0.9}, 8),
    "terminal": (4, {"stroke": "#8a7f5c", "fill": "#8a7f5c", "fill-opacity": 0.4}, 12),
    "hangar": (4, {"stroke-width": 0, "fill": "#8a7f5c", "fill-opacity": 0.25}, 13),
    "holding_position": (5, {"marker-color": "#e0a030", "marker-symbol": "cross"}, 15),
    "parking_position": (5, {"marker-color": "#5a7186", "marker-symbol": "circle"}, 16),
    "navigationaid": (5, {"marker-color": "#7fb8e6", "marker-symbol": "triangle"}, 10),
}


def elements_of(text):
    """Nodes (longitude, latitude, tags) and ways (nodes, tags) by number, and relations (members, tags)."""
    nodes, ways, relations = {}, {}, []
    if text.lstrip().startswith("{"):
        for element in json.loads(text)["elements"]:
            tags = element.get("tags", {})
            if element["type"] == "node":
                nodes[element["id"]] = (element["lon"], element["lat"], tags)
            elif element["type"] == "way":
                ways[element["id"]] = (element["nodes"], tags)
            else:
                members = [(m["type"], m["ref"], m["role"]) for m in element["members"]]
                relations.append((members, tags))
        return nodes, ways, relations
    for element in xml.etree.ElementTree.fromstring(text):
        tags = {tag.get("k"): tag.get("v") for tag in element.findall("tag")}
        if element.tag == "node":
            nodes[int(element.get("id"))] = (float(element.get("lon")), float(element.get("lat")), tags)
        elif element.tag == "way":
            ways[int(element.get("id"))] = ([int(nd.get("ref")) for nd in element.findall("nd")], tags)
        elif element.tag == "relation":
            members = [(m.get("type"), int(m.get("ref")), m.get("role")) for m in element.findall("member")]
            relations.append((members, tags))
    return nodes, ways, relations


def widened(line, width_m):
    """Closed ring of this width about a line of [longitude, latitude], with mitred corners."""
    latitude = math.radians(line[0][1])
    metre = (math.degrees(1 / (EARTH_M * math.cos(latitude))), math.degrees(1 / EARTH_M))
    plane = [(x / metre[0], y / metre[1]) for x, y in line]
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(plane, plane[1:])]
    normals = [(-dy / math.hypot(dx, dy), dx / math.hypot(dx, dy)) for dx, dy in steps if (dx, dy) != (0, 0)]
    if not normals:
        return None
    normals = [normals[0], *normals, normals[-1]]
    sides = ([], [])
    for point, before, after in zip(plane, normals, normals[1:]):
        bisector = (before[0] + after[0], before[1] + after[1])
        square = bisector[0] ** 2 + bisector[1] ** 2
        # A sharp corner would have an endless mitre.
        scale = width_m / max(square, 0.5)
        for side, sign in zip(sides, (1, -1)):
            x, y = (point[axis] + sign * scale * bisector[axis] for axis in (0, 1))
            side.append([round(x * metre[0], 8), round(y * metre[1], 8)])
    ring = sides[1] + sides[0][::-1]
    return [*ring, ring[0]]


def width_of(tags):
    try:
        return float(tags.get("width", "").removesuffix("m").strip())
    except ValueError:
        return WIDTHS_M[tags["aeroway"]]


def feature(tags, kind, coordinates):
    _, style, minzoom = KINDS[tags["aeroway"]]
    name = tags.get("ref") or tags.get("name") or ""
    if tags["aeroway"] in ("apron", "hangar"):
        name = ""
    properties = {"aeroway": tags["aeroway"], "minzoom": minzoom, **style}
    if name:
        properties["name"] = name
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def features_of(text):
    """Features in the order of drawing."""
    nodes, ways, relations = elements_of(text)
    line_of = lambda numbers: [list(nodes[number][:2]) for number in numbers if number in nodes]
    found = []
    for longitude, latitude, tags in nodes.values():
        if tags.get("aeroway") in KINDS:
            found.append(feature(tags, "Point", [longitude, latitude]))
    for numbers, tags in ways.values():
        kind = tags.get("aeroway")
        line = line_of(numbers)
        if kind not in KINDS or len(line) < 2:
            continue
        is_closed = numbers[0] == numbers[-1] and len(line) > 3
        if is_closed and (kind not in WIDTHS_M or tags.get("area") == "yes"):
            found.append(feature(tags, "Polygon", [line]))
        elif kind in WIDTHS_M:
            ring = widened(line, width_of(tags))
            if ring:
                found.append(feature(tags, "Polygon", [ring]))
        else:
            found.append(feature(tags, "LineString", line))
    for members, tags in relations:
        if tags.get("aeroway") not in KINDS:
            continue
        rings = [line_of(ways[ref][0]) for kind, ref, _ in members if kind == "way" and ref in ways]
        polygons = [[ring] for ring in rings if len(ring) > 3 and ring[0] == ring[-1]]
        if polygons:
            found.append(feature(tags, "MultiPolygon", polygons))
    return sorted(found, key=lambda one: KINDS[one["properties"]["aeroway"]][0])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("extract", help="OSM XML, or JSON of Overpass")
    parser.add_argument("--out", help="GeoJSON file [default: standard output]")
    given = parser.parse_args()
    try:
        with open(given.extract, encoding="utf-8") as file:
            features = features_of(file.read())
    except (OSError, ValueError, KeyError, xml.etree.ElementTree.ParseError) as error:
        sys.exit(f"{given.extract}: {error!r}; an extract is OSM XML or JSON of Overpass")
    if not features:
        sys.exit(f"{given.extract}: no aeroway in it; extract the region of an aerodrome")
    text = json.dumps({"type": "FeatureCollection", "features": features}, ensure_ascii=False, separators=(",", ":"))
    if given.out:
        with open(given.out, "w", encoding="utf-8") as file:
            file.write(text + "\n")
    else:
        print(text)


if __name__ == "__main__":
    main()
