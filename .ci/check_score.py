#!/usr/bin/env python3
"""Computes the scorecard of `koseki score` anew from the same files, and compares every figure and verdict (needs numpy, scipy).

usage: check_score.py TRUTH TRACKS CARD.json [--reference truth] [--areas FILE --origin LATITUDE,LONGITUDE] [--t0 10] [--settle 25]
                      [--gate 250] [--max-age 1] [--phases-tool phases.py] [--least LINES]
Files are in metres, with times from a midnight; t0 is 10 s after the first row of the truth unless given. Seconds without truth, heights
and velocities that a side does not know are not compared.
CARD.json is what `koseki score --json` printed with the same options. Nothing of Koseki is used here: another reader, another
assignment (scipy), another division into phases, limits typed from the sources again. Figures agree within 1e-6 of their size: both sides
compute with doubles, in another order. The covariance is not moved: tracks must have rows at whole seconds (`koseki fuse --refresh 1`).
--phases-tool: a tool with functions `manoeuvres` to compare the phases with, too. --least: fewest lines with a figure.
"""
import argparse, csv, importlib.util, json, math, sys
import numpy as np
from scipy.optimize import linear_sum_assignment

COVARIANCE = [f"P{i}{j}" for i in range(6) for j in range(i, 6)]
STEADY = ("steady_weight", "steady_P33", "steady_P34", "steady_P44", "steady_climb_weight", "steady_P55")
PLANE, RATE = ("straight", "entry", "turn", "exit", "after"), ("rate_steady", "rate_entry", "rate_change", "rate_exit", "rate_after")
MANOEUVRING, LONG = {"manoeuvring", "runway", "taxiway"}, 10**9


def rows(path, valid_velocity=False):
    """dicts with number, time, position, velocity, covariance, address, whether height is known"""
    found = []
    with open(path) as file:
        reader = csv.DictReader(file)
        names = reader.fieldnames
        number = next(name for name in ("target_id", "system_track_id", "sensor_track_id") if name in names)
        has_covariance = set(COVARIANCE) <= set(names)
        for row in reader:
            if row.get("state") in ("tentative", "suspended", "terminated") or valid_velocity and row.get("velocity_valid") == "0":
                continue
            covariance = np.full((6, 6), np.nan)
            if has_covariance and all(row[name] for name in COVARIANCE):
                upper = np.triu_indices(6)
                covariance[upper] = [float(row[name]) for name in COVARIANCE]
                covariance.T[upper] = covariance[upper]
            steady = [float(row.get(name) or "nan") for name in STEADY]
            high, moves = row.get("height_valid") != "0", row.get("velocity_valid") != "0"
            number_of = lambda name: float(row[name]) if high or name not in ("z", "vz") else 0.0
            found.append(dict(id=int(row[number]), t=float(row["time_s"]), x=np.array([number_of(c) for c in ("x", "y", "z")]),
                              v=np.array([number_of(c) if moves else 0.0 for c in ("vx", "vy", "vz")]), P=covariance, steady=steady, moves=moves,
                              address=int(row["address"], 16) if row.get("address") else None, high=high))
    return found


def pictures(found, max_age, reference):
    """second -> {number: row at that second}"""
    shown = {}
    if reference:
        by = {}
        for row in found:
            by.setdefault(row["id"], []).append(row)
        for of in by.values():
            of.sort(key=lambda row: row["t"])
            for one, two in zip(of, of[1:]):
                span = two["t"] - one["t"]
                for second in range(math.ceil(one["t"]), math.ceil(two["t"])):
                    if span > 5 and second != one["t"]:
                        continue
                    # The cubic by its divided differences, not by Hermite's basis.
                    s, slope = second - one["t"], (two["x"] - one["x"]) / span
                    second_order, third = (slope - one["v"]) / span, (two["v"] + one["v"] - 2 * slope) / span**2
                    place = one["x"] + s * (one["v"] + s * (second_order + (s - span) * third))
                    address = one["address"] if one["address"] is not None else two["address"]
                    # To the last digit as Koseki computes it: a phase hangs on whether a change is above a limit.
                    velocity = (1 - s / span) * one["v"] + s / span * two["v"]
                    shown.setdefault(second, {})[one["id"]] = dict(one, t=second, x=place, v=velocity, address=address,
                                                                 high=one["high"] and two["high"])
            if of[-1]["t"] % 1 == 0:
                shown.setdefault(int(of[-1]["t"]), {})[of[-1]["id"]] = of[-1]
        return shown
    for row in sorted(found, key=lambda row: row["t"]):
        first = math.ceil(row["t"] - 1e-9)
        for second in range(first, first + math.ceil(max_age) + 1):
            if row["t"] > second - max_age + 1e-9:
                shown.setdefault(second, {})[row["id"]] = dict(row, x=row["x"] + row["v"] * (second - row["t"]))
    return shown


def stages(t, v, limit):
    """0 steady, 1 entry, 2 within, 3 exit, 4 after, for the times and velocities of one target"""
    if len(t) < 2:
        return [0] * len(t)
    a = np.linalg.norm(np.diff(v, axis=0), axis=1) / np.diff(t)
    sides = np.stack([np.r_[a[:1], a], np.r_[a, a[-1:]]])
    on, found, began, ended = (sides.max(0) > limit) & (sides.min(0) > limit / 10), [], None, None
    for now, moves in zip(t, on):
        if moves:
            began, ended = (now if began is None else began), now
            found.append(1 if now - began < 6 else 2)
            continue
        since = math.inf if ended is None else now - ended
        began = None if since > 1 else began
        found.append(3 if since <= 15 else 4 if since <= 30 else 0)
    return found


def nees(error, P):
    try:
        np.linalg.cholesky(P)
        return float(error @ np.linalg.inv(P) @ error) / len(error)
    except np.linalg.LinAlgError:
        return math.nan


def compare(truth, tracks, options):
    """errors of pairs, target-seconds, track-seconds, number of seconds"""
    paths, first = {}, {}
    for second in sorted(truth):
        for number, row in truth[second].items():
            first.setdefault(number, second)
            if row["moves"]:
                paths.setdefault(number, []).append((second, row["v"]))
    phases = {}
    for number, path in paths.items():
        t, v = np.array([second for second, _ in path], float), np.array([velocity for _, velocity in path])
        plane, rate = stages(t, v[:, :2], 0.5), stages(t, v[:, 2:], 0.3)
        if options.phases_tool:
            check_phases(options.phases_tool, t, v, plane, rate)
        for (second, velocity), p, r in zip(path, plane, rate):
            phases[second, number] = {"all", PLANE[p], RATE[r], "climb" if abs(velocity[2]) > 2 else "level"}
    errors, targets, shown, seconds = [], [], [], 0
    place = lambda row: row["x"] if row["high"] else np.r_[row["x"][:2], math.nan]
    for second in range(options.t0, options.last + 1):
        T, Y = truth.get(second, {}), tracks.get(second, {})
        if not T:
            continue
        seconds += 1
        a, b = sorted(T), sorted(Y)
        pairs = {}
        if a and b:
            apart = np.array([place(T[i]) for i in a])[:, None] - np.array([place(Y[j]) for j in b])[None]
            d = np.linalg.norm(np.nan_to_num(apart), axis=2)
            for i, j in zip(*linear_sum_assignment(np.minimum(d, options.gate) ** 2)):
                if d[i, j] < options.gate:
                    pairs[a[i]] = b[j]
        for i in a:
            if second - first[i] >= options.settle:
                targets.append((i, second, T[i]["x"][:2], i in pairs))
                if i in pairs:
                    errors.append(error_of(T[i], Y[pairs[i]], phases.get((second, i), {"all"})))
        taken = set(pairs.values())
        shown += [(j, Y[j]["x"][:2], j in taken) for j in b]
    return errors, targets, shown, seconds


def check_phases(tool, t, v, plane, rate):
    names = ["steady", "entry", "in", "exit", "after"]
    for found, of, limit in ((plane, v[:, :2], 0.5), (rate, v[:, 2:], 0.3)):
        expected = list(tool.manoeuvres(t, of, limit))
        if [names[stage] for stage in found] != expected:
            sys.exit("the phases differ from those of the given tool")


def error_of(target, track, phases):
    e, w = track["x"] - target["x"], track["v"] - target["v"]
    speed = math.hypot(*target["v"][:2])
    course = lambda v: math.degrees(math.atan2(v[0], v[1]))
    high, moves, P = target["high"] and track["high"], target["moves"] and track["moves"], track["P"]
    known = bool(np.isfinite(P).all())
    group = lambda error, at, counts=True: nees(error, P[np.ix_(at, at)]) if known and counts else math.nan
    # The likeliest case: without a manoeuvre, unless a manoeuvre is more probable.
    weight, xx, xy, yy, climb_weight, climb = track["steady"]
    plane = np.array([[xx, xy], [xy, yy]]) if weight >= .5 else P[3:5, 3:5]
    rate = np.array([[climb]]) if climb_weight >= .5 else P[5:, 5:]
    u = target["v"][:2] / speed if speed else None
    return dict(place=target["x"][:2], phases=phases, target_speed=speed, position=math.hypot(*e[:2]),
                along=e[:2] @ u if speed else math.nan, across=e[0] * u[1] - e[1] * u[0] if speed else math.nan,
                height=e[2] if high else math.nan, speed=math.hypot(*track["v"][:2]) - speed if moves else math.nan,
                velocity=math.hypot(*w[:2]) if moves else math.nan,
                heading_deg=(course(track["v"]) - course(target["v"]) + 180) % 360 - 180 if speed > 3 and moves else math.nan,
                climb=w[2] if high and moves else math.nan, nees_position=group(e[:2], [0, 1]),
                nees_velocity=group(w[:2], [3, 4], moves), nees_height=group(e[2:], [2], high),
                nees_climb=group(w[2:], [5], high and moves),
                nees_likeliest_velocity=nees(w[:2], plane) if known and moves and math.isfinite(weight) else math.nan,
                nees_likeliest_climb=nees(w[2:], rate) if known and high and moves and math.isfinite(climb_weight) else math.nan,
                right=right(target["address"], track["address"]))


def right(target, track):
    return None if target is None else "missing" if track is None else target == track


def values(errors, name):
    found = np.array([error[name] for error in errors], float)
    return found[np.isfinite(found)]


def spread(v):
    if not len(v):
        return dict(n=0, mean=None, rms=None, p50=None, p90=None, p95=None, p99=None)
    q = np.percentile(np.abs(v), [50, 90, 95, 99])
    return dict(n=len(v), mean=v.mean(), rms=math.sqrt((v**2).mean()), p50=q[0], p90=q[1], p95=q[2], p99=q[3])


def phase_figures(errors):
    found = {}
    for phase in ("all", *PLANE, "level", "climb", *RATE):
        of = [error for error in errors if phase in error["phases"]]
        figures = {name: spread(values(of, name)) for name in
                   ("position", "along", "across", "heading_deg", "speed", "velocity", "height", "climb")}
        groups = {}
        for name, limit in (("position", 5.991 / 2), ("velocity", 5.991 / 2), ("height", 3.841), ("climb", 3.841),
                            ("likeliest_velocity", 5.991 / 2), ("likeliest_climb", 3.841)):
            v = values(of, f"nees_{name}")
            groups[name] = dict(n=len(v), nees=v.mean() if len(v) else None, in95=(v < limit).mean() if len(v) else None)
        found[phase] = dict(n=len(of), **figures, consistency=groups)
    return found


class Part:
    """figures of lines, of everything or of an area"""

    def __init__(self, errors, targets, shown, seconds, complete):
        self.errors, self.shown, self.seconds, self.complete = errors, shown, seconds, complete
        self.phases, self.targets, self.target_seconds = phase_figures(errors), len({i for i, *_ in targets}), len(targets)
        self.legs, self.gaps, self.reports = [], [], 0
        leg, before = [], None
        for number, second, _, reported in sorted(targets, key=lambda of: of[:2]):
            if before != (number, second - 1) and leg:
                self.close(leg)
                leg = []
            leg.append(reported)
            before = (number, second)
        if leg:
            self.close(leg)

    def close(self, leg):
        at = [place for place, reported in enumerate(leg) if reported]
        self.legs.append(leg)
        self.reports += len(at)
        bounds = [0, *at, len(leg) - 1]
        self.gaps += [gap for gap in np.diff(bounds) if gap > 0]

    def position(self, share):
        v = values(self.errors, "position")
        return np.percentile(v, 100 * share) if len(v) else None

    def quantile(self, name, share):
        v = np.abs(values(self.errors, name))
        return np.percentile(v, 100 * share) if len(v) else None

    def rms(self, phase="all", name="position"):
        return self.phases[phase][name]["rms"]

    def update(self, interval):
        whole = [leg[k:k + interval] for leg in self.legs for k in range(0, len(leg) - interval + 1, interval)]
        return sum(map(any, whole)) / len(whole) if whole else None

    def gap_rate(self, least, most):
        return sum(least <= gap <= most for gap in self.gaps) / self.reports if self.reports else None

    def longest(self):
        return max(self.gaps, default=None)

    def address(self, wrong):
        checks = [error["right"] for error in self.errors if error["right"] is not None]
        if wrong:
            checks = [check for check in checks if check != "missing"]
            return sum(check is False for check in checks) / len(checks) if checks else None
        return sum(check is True for check in checks) / len(checks) if checks else None

    def false_reports(self, beyond):
        none = sum(not paired for *_, paired in self.shown) if self.complete else 0
        far, number = sum(error["position"] > beyond for error in self.errors), len(self.errors) + none
        return (far + none) / number if number else None

    def false_tracks(self):
        balance = {}
        for number, _, paired in self.shown:
            balance[number] = balance.get(number, 0) + (1 if paired else -1)
        return sum(value < 0 for value in balance.values()) * 3600 / self.seconds

    def speeds(self):
        known = [error for error in self.errors if math.isfinite(error["speed"])]
        good = [abs(error["speed"]) <= max(5, 0.1 * error["target_speed"]) for error in known]
        return sum(good) / len(good) if good else None


def lines(standard):
    """name -> (kind of area, figure of a part, comparison, limit)"""
    p95, update = (lambda part: part.position(0.95)), (lambda n: lambda part: part.update(n))
    right, wrong = (lambda part: part.address(False)), (lambda part: part.address(True))
    longest, false_tracks = (lambda part: part.longest()), (lambda part: part.false_tracks())
    false_reports, gaps = (lambda m: lambda part: part.false_reports(m)), (lambda a, b: lambda part: part.gap_rate(a, b))
    course, rms = (lambda part: part.quantile("heading_deg", 0.9)), (lambda part: part.rms())
    m, none = "manoeuvring", (None, None)
    return {
        "ed-87": {
            "update_1s": (m, update(1), ">=", 0.99), "position_p95": (m, p95, "<=", 12), "gaps_3_to_5s": (m, gaps(3, 5), "<=", 1e-3),
            "gaps_over_5s": (m, gaps(6, LONG), "<=", 1e-6), "longest_gap": (None, longest, *none), "address_right": (m, right, ">=", 0.999),
            "address_wrong": (None, wrong, "<=", 1e-4), "false_reports": (m, false_reports(60), "<=", 1e-4),
            "false_tracks": (None, false_tracks, *none), "speed": (m, lambda part: part.speeds(), ">=", 0.9),
            "course_p90": (m, course, "<=", 15), "apron_update_1s": ("apron", update(1), ">=", 0.9),
            "apron_position_p95": ("apron", p95, "<=", 20), "stand_update_5s": ("stand", update(5), ">=", 0.95),
            "stand_position_p95": ("stand", p95, "<=", 25), "stand_address_right": ("stand", right, ">=", 0.98)},
        "ed-116": {
            "position_p95": (None, p95, "<=", 7.5), "update_1s": (None, update(1), ">=", 0.9), "longest_gap": (None, longest, *none),
            "false_reports": (None, false_reports(60), *none), "false_tracks": (None, false_tracks, *none),
            "speed": (None, lambda part: part.speeds(), *none), "course_p90": (None, course, *none)},
        "ed-117": {
            "position_p95": (m, p95, "<=", 7.5), "position_p99": (m, lambda part: part.position(0.99), "<=", 12),
            "update_1s": (m, update(1), ">=", 0.95), "runway_update_2s": ("runway", update(2), ">=", 0.999),
            "taxiway_update_2s": ("taxiway", update(2), ">=", 0.999), "gaps_3s": (m, gaps(3, LONG), "<=", 1e-3),
            "longest_gap": (None, longest, *none), "address_right": (None, right, ">=", 0.999), "address_wrong": (None, wrong, "<=", 1e-4),
            "false_reports": (None, false_reports(50), "<=", 1e-4), "apron_update_1s": ("apron", update(1), ">=", 0.7),
            "stand_update_1s": ("stand", update(1), ">=", 0.5), "stand_update_5s": ("stand", update(5), ">=", 0.999),
            "approach_update_1s": ("approach", update(1), ">=", 0.95), "approach_position_p95": ("approach", p95, "<=", 20),
            "outer_position_p95": ("outer-approach", p95, "<=", 40)},
        "ed-142": {
            "terminal_position_rms": ("terminal", rms, "<=", 150), "en_route_position_rms": ("en-route", rms, "<=", 350),
            "update_5s": ("terminal", update(5), *none), "update_8s": ("en-route", update(8), *none), "longest_gap": (None, longest, *none),
            "address_right": (None, right, *none), "address_wrong": (None, wrong, *none), "false_tracks": (None, false_tracks, *none)},
        "esassp": {
            "5N_N-R2": ("en-route", update(8), ">", 0.9), "5N_N-R3": ("en-route", rms, "<=", 500), "3N_N-R2": ("terminal", update(5), ">", 0.9),
            "3N_N-R3": ("terminal", rms, "<=", 300), "longest_gap": (None, longest, *none),
            "height_p95": (None, lambda part: part.quantile("height", 0.95), *none),
            "velocity_rms_straight": (None, lambda part: part.rms("straight", "velocity"), *none),
            "velocity_rms_turn": (None, lambda part: part.rms("turn", "velocity"), *none), "course_p90": (None, course, *none),
            "address_right": (None, right, *none), "address_wrong": (None, wrong, *none), "false_tracks": (None, false_tracks, *none)},
    }[standard]


def verdict(figure, comparison, limit, reference):
    if figure is None:
        return "not measured"
    if limit is None:
        return "no limit known"
    if reference == "smoothed":
        return "precision only"
    return "pass" if {"<=": figure <= limit, ">=": figure >= limit, ">": figure > limit}[comparison] else "fail"


def local(origin):
    """longitude, latitude -> east, north in the plane that touches the ellipsoid at the origin"""
    def earth(latitude, longitude):
        p, l, e2 = math.radians(latitude), math.radians(longitude), 0.0066943799901413165
        n = 6378137 / math.sqrt(1 - e2 * math.sin(p) ** 2)
        return np.array([n * math.cos(p) * math.cos(l), n * math.cos(p) * math.sin(l), n * (1 - e2) * math.sin(p)])
    latitude, longitude = origin
    p, l, centre = math.radians(latitude), math.radians(longitude), earth(latitude, longitude)
    east = np.array([-math.sin(l), math.cos(l), 0])
    north = np.array([-math.sin(p) * math.cos(l), -math.sin(p) * math.sin(l), math.cos(p)])
    return lambda place: np.array([east @ (earth(place[1], place[0]) - centre), north @ (earth(place[1], place[0]) - centre)])


def drawn(ring, to_local):
    """the ring in the plane: sides straight in longitude and latitude, as RFC 7946 has them, in parts of 10 km at most"""
    places = []
    for one, two in zip(np.array(ring, float), np.array(ring[1:], float)):
        parts = max(1, math.ceil(np.linalg.norm(to_local(two) - to_local(one)) / 10_000))
        places += [to_local(one + part / parts * (two - one)) for part in range(parts)]
    return np.array([*places, to_local(ring[-1])])


def inside(polygons, place):
    """by the winding of the outline about the place, and of no hole"""
    def winds(ring):
        d = ring - place
        turned = np.diff(np.arctan2(d[:, 1], d[:, 0]))
        return abs(((turned + np.pi) % (2 * np.pi) - np.pi).sum()) > np.pi
    return any(winds(rings[0]) and not any(winds(hole) for hole in rings[1:]) for rings in polygons)


class Comparison:
    def __init__(self):
        self.number, self.faults = 0, []

    def same(self, where, ours, theirs):
        self.number += 1
        if isinstance(ours, dict):
            for key in ours.keys() | theirs.keys():
                self.same(f"{where}.{key}", ours.get(key), theirs.get(key))
        elif ours is None or theirs is None or isinstance(ours, str):
            if ours != theirs:
                self.faults.append(f"{where}: {ours} here, {theirs} by koseki")
        elif not math.isclose(ours, theirs, rel_tol=1e-6, abs_tol=1e-6):
            self.faults.append(f"{where}: {ours} here, {theirs} by koseki")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("truth", "tracks", "card"):
        parser.add_argument(name)
    parser.add_argument("--reference", default="truth")
    parser.add_argument("--areas")
    parser.add_argument("--origin")
    parser.add_argument("--phases-tool")
    parser.add_argument("--t0", type=int)
    for name, value in (("settle", 25), ("gate", 250), ("max-age", 1), ("least", 0)):
        parser.add_argument(f"--{name}", type=type(value), default=value)
    options = parser.parse_args()
    if options.phases_tool:
        sys.path.insert(0, options.phases_tool.rpartition("/")[0])
        sys.dont_write_bytecode = True
        spec = importlib.util.spec_from_file_location("phases", options.phases_tool)
        options.phases_tool = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(options.phases_tool)
    card = json.load(open(options.card))
    is_truth = options.reference == "truth"
    truth_rows = rows(options.truth, not is_truth)
    truth = pictures(truth_rows, 1e-3, not is_truth)
    options.last = max(truth) if not is_truth else math.floor(max(row["t"] for row in truth_rows))
    if options.t0 is None:
        options.t0 = min(truth) + 10 if min(truth) + 10 <= options.last else min(truth)
    tracks = pictures(rows(options.tracks), options.max_age, False)
    errors, targets, shown, seconds = compare(truth, tracks, options)
    areas = [(None, None, None)]
    if options.areas:
        to_local = local([float(number) for number in options.origin.split(",")])
        for feature in json.load(open(options.areas))["features"]:
            geometry, properties = feature["geometry"], feature["properties"]
            polygons = [geometry["coordinates"]] if geometry["type"] == "Polygon" else geometry["coordinates"]
            polygons = [[drawn(ring, to_local) for ring in rings] for rings in polygons]
            areas.append((properties["name"], properties.get("kind"), polygons))
    compared, figures, verdicts = Comparison(), 0, set()
    compared.same("reference", options.reference, card["reference"])
    compared.same("areas", len(areas) - 1, len(card.get("areas", [])))
    for (name, kind, polygons), theirs in zip(areas, [card, *card.get("areas", [])]):
        within = (lambda place: True) if polygons is None else (lambda place: inside(polygons, place))
        part = Part([error for error in errors if within(error["place"])], [target for target in targets if within(target[2])],
                    [track for track in shown if within(track[1])], seconds, is_truth)
        where = name or "everything"
        compared.same(f"{where}.targets", part.targets, theirs["targets"])
        compared.same(f"{where}.target_seconds", part.target_seconds, theirs["target_seconds"])
        compared.same(where, part.phases, theirs["phases"])
        for standard in theirs.get("standards", []):
            expected = {line: of for line, of in lines(standard["standard"]).items()
                        if kind is None or of[0] in (None, kind) or of[0] == "manoeuvring" and kind in MANOEUVRING}
            found = {line["line"]: line for line in standard["lines"]}
            compared.same(f"{where}.{standard['standard']}", " ".join(sorted(expected)), " ".join(sorted(found)))
            for line, (_, figure, comparison, limit) in expected.items():
                figure = figure(part)
                ours = dict(figure=figure, limit=limit, comparison=comparison, verdict=verdict(figure, comparison, limit, options.reference))
                compared.same(f"{where}.{standard['standard']}.{line}", ours, {key: found[line][key] for key in ours})
                figures += figure is not None
                verdicts.add(ours["verdict"])
    print(f"{len(errors)} errors of {len({i for i, *_ in targets})} targets: {compared.number} values compared, "
          f"{figures} lines with a figure ({', '.join(sorted(verdicts))})")
    if figures < options.least or not errors:
        sys.exit(f"fewer than {options.least} lines have a figure")
    if compared.faults:
        sys.exit("\n".join(compared.faults[:20]))


if __name__ == "__main__":
    main()
