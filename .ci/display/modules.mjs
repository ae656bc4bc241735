/** Tests of the page's modules that need no browser: node --test .ci/display/modules.mjs */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

const page = new URL("../../services/display/page/", import.meta.url);
const module = (name) => import(new URL(name, page));
const { COLOURS } = await module("colours.js");
const { Coverage, probabilityOf } = await module("coverage.js");
const { bearing, courseText, placeOf, sexagesimal } = await module("geodesy.js");
const { centresOf, groundOf, lengthText, roundLength } = await module("ground.js");
const { climbText, heightText, modesText, NO_MOTION, turnText } = await module("labels.js");
const { layersOf, layersText, overlaysOf, zoomOf } = await module("maps.js");
const { blankTrack, forgetMains, noteMain, Picture, Trail } = await module("picture.js");
const { DEFAULTS, read, write } = await module("settings.js");
const { STATIONS, stationAt, stationLines } = await module("stations.js");
const { joined, trailsOf } = await module("trails.js");
const { View } = await module("view.js");
const { NO_REASONS, reasonOf, whyOf } = await module("why.js");

const near = (a, b, limit = 1e-6) => assert.ok(Math.abs(a - b) <= limit, `${a} is not ${b}`);

test("a point goes to the screen and comes back, turned and enlarged", () => {
  const view = Object.assign(new View(), { width: 800, height: 600, east: 1200, north: -50, scale: 12.5, up: 1.1 });
  for (const [east, north] of [
    [0, 0],
    [5000, -70],
    [-3, 9000],
  ]) {
    const back = view.toGround(...view.toScreen(east, north));
    near(back[0], east);
    near(back[1], north);
  }
  const under = view.toGround(100, 200);
  view.zoom(3, 100, 200);
  const still = view.toGround(100, 200);
  near(still[0], under[0]);
  near(still[1], under[1]);
  // The bearing that points up does so.
  const [x, y] = view.toScreen(view.east + 100 * Math.sin(1.1), view.north + 100 * Math.cos(1.1));
  near(x, 400);
  assert.ok(y < 300);
});

test("the place under the cursor is the one that Rust has projected there", () => {
  const vectors = JSON.parse(readFileSync(new URL("places.json", import.meta.url), "utf8"));
  assert.ok(vectors.length >= 20);
  for (const { origin, metres, place } of vectors) {
    const [latitude_deg, longitude_deg, height_m] = origin;
    const found = placeOf({ latitude_deg, longitude_deg, height_m }, metres[0], metres[1]);
    near(found.latitude_deg, place[0], 2e-9);
    near((found.longitude_deg - place[1] + 540) % 360, 180, 2e-9);
  }
  assert.equal(placeOf({ latitude_deg: 41, longitude_deg: 2, height_m: 0 }, 7e6, 0), null);
});

test("the map shows what it is told to show", () => {
  const view = Object.assign(new View(), { width: 1000, height: 500 });
  view.show(-40_000, -10_000, 60_000, 90_000);
  const [west, south, east, north] = view.bounds();
  assert.ok(west < -40_000 && south < -10_000 && east > 60_000 && north > 90_000);
});

test("origin, north pole's direction and the horizon", () => {
  const origin = { latitude_deg: 41.3, longitude_deg: 2.1, height_m: 0 };
  const there = placeOf(origin, 0, 0);
  near(there.latitude_deg, 41.3, 1e-9);
  near(there.longitude_deg, 2.1, 1e-9);
  assert.ok(placeOf(origin, 0, 1000).latitude_deg > 41.3);
  assert.equal(placeOf(origin, 7e6, 0), null);
  assert.equal(sexagesimal(-2.5, "E", "W"), "2°30′00″W");
  near(bearing(-1, 0), 270);
});

test("settings survive the address, and nonsense in it does not count", () => {
  const settings = {
    ...DEFAULTS,
    theme: "day",
    filter: "fl>100 -GND",
    labels: 3,
    sensors: true,
    declutter: false,
    at: 12.5,
  };
  assert.deepEqual(read(write(settings)), settings);
  assert.equal(write({ ...DEFAULTS }), "#");
  assert.deepEqual(read("#labels=&theme=pink&constructor=1&scale=NaN&__proto__=1"), { ...DEFAULTS });
});

test("a source that takes over is a hand-over, and a leap through time is none", () => {
  const track = Object.assign(blankTrack(), { number: 1, source: -1 });
  const at = (time, source) => {
    const before = track.source;
    Object.assign(track, { time, source });
    noteMain(track, before, time);
    return track.handOver;
  };
  forgetMains(track, 100);
  for (let time = 100; time < 160; time++) assert.equal(at(time, time % 2), 0, "two take turns");
  assert.equal(at(160, 2), 160, "a third takes over");
  assert.equal(at(161, 0), 160);
  forgetMains(track, 5000);
  assert.equal(at(5000, 1), 0, "after a leap it is another one");
  assert.equal(at(5001, 2), 0, "and the next may have been the main one just before");
  assert.equal(at(5040, 0), 5040, "what was not the main one for long takes over");
});

test("level, arrow and table read the same height", () => {
  const shown = (change) => heightText(Object.assign(blankTrack(), { isLevel: true }, change), "aviation");
  assert.equal(shown({ height: 11000, isLevel: false }), "~361 ", "a calculated height is marked");
  assert.equal(shown({ height: 11000, climb: 9 }), "361 ", "an arrow is for the server to decide");
  assert.equal(shown({ height: 11000, climbs: true }), "361↑");
  assert.equal(shown({ height: 11000, sinks: true }), "361↓");
  assert.equal(shown({ height: -40 }), "−001 ", "a wrong height is not hidden behind 000");
  assert.equal(shown({ height: -10 }), "000 ");
});

test("rates stand beside their errors, and what is not known is no number", () => {
  const track = Object.assign(blankTrack(), { height: 3000, climb: -0.04 });
  const motion = {
    climb: -7.36,
    climbSigma: 0.42,
    turn: -3.04,
    turnSigma: 0.5,
    modes: [
      { mode: "left_turn", probability: 0.816 },
      { mode: "climb_change", probability: 0.5 },
    ],
  };
  assert.equal(climbText(track, motion), "−7.4 ± 0.4 m/s");
  assert.equal(climbText(track, NO_MOTION), "0.0 m/s", "without a vertical filter, by the velocity");
  assert.equal(climbText(blankTrack(), NO_MOTION), "–");
  assert.equal(turnText(motion), "3.0 ± 0.5 °/s left");
  assert.equal(turnText({ ...motion, turn: 0.3 }), "0.3 ± 0.5 °/s", "noise has no side");
  assert.equal(turnText(NO_MOTION), "–");
  assert.equal(modesText(motion), "left turn 82 %, climb change 50 %");
  assert.equal(modesText(NO_MOTION), "–");
});

test("a trail is bounded, in order, and takes no point twice", () => {
  const trail = new Trail();
  for (let k = 0; k < 5000; k++) trail.add(1.7e9 + k, k, -k);
  trail.add(1.7e9 + 4000, 0, 0);
  assert.ok(trail.length < 1000);
  let before = -Infinity;
  for (let k = 0; k < trail.length; k++) {
    const at = trail.at(k);
    assert.ok(trail.timeOf(at) > before);
    near(trail.east[at], trail.timeOf(at) - 1.7e9, 0.01);
    before = trail.timeOf(at);
  }
  near(before, 1.7e9 + 4999, 2.1);
});

test("layers forget what is old", () => {
  const picture = new Picture();
  const spot = (source, number, time) => ({ source, number, time, east: 0, north: 0 });
  picture.addLayers(0, [spot(1, 7, 10), spot(2, 7, 20)], { detections: [spot(1, 0, 10)] });
  picture.addLayers(5, [spot(1, 7, 12)], { detections: [spot(1, 0, 20)] });
  assert.equal(picture.sensor.size, 2);
  picture.addLayers(15, [], {});
  assert.equal(picture.sensor.size, 1);
  assert.equal(picture.marks.detections.length, 1);
});

test("land, borders and overlays", () => {
  const values = [0, 0, 1, 0, 1, 1, NaN, NaN, Infinity, Infinity, 5, 5, 6, 6, 7, 5, NaN, NaN];
  const ground = groundOf(new Float32Array(values).buffer);
  assert.deepEqual([ground.land.length, ground.borders.length], [1, 1]);
  assert.deepEqual([ground.borders[0].west, ground.borders[0].north], [5, 6]);
  const feature = (type, coordinates) => ({ properties: { name: type }, geometry: { type, coordinates } });
  const square = [
    [0, 0],
    [1, 0],
    [1, 1],
    [0, 0],
  ];
  const features = [
    feature("Point", [1, 2]),
    feature("MultiPoint", square),
    feature("LineString", square),
    feature("Polygon", [square]),
    feature("MultiPolygon", [[square], [square]]),
    feature("Nothing", []),
    null,
  ];
  assert.deepEqual(
    overlaysOf({ features }).map(({ lines, closed }) => [lines.length, closed]),
    [
      [1, false],
      [4, false],
      [1, false],
      [1, true],
      [2, true],
      [0, false],
    ],
  );
  assert.deepEqual(overlaysOf(7), []);
});

test("styles, zooms and names of features, and what is no style", () => {
  const properties = { name: "RUXET", minzoom: 7, maxzoom: "12", stroke: "#f80", "stroke-width": 3, fill: "red;", "marker-symbol": "circle" };
  const [feature] = overlaysOf({ name: "fixes.geojson", features: [{ properties, geometry: { type: "Point", coordinates: [1, 2] } }] });
  assert.deepEqual([feature.layer, feature.name, feature.minzoom, feature.maxzoom, feature.isPoint], ["fixes.geojson", "RUXET", 7, 12, true]);
  assert.deepEqual([feature.style.stroke, feature.style.strokeWidth, feature.style.fill, feature.style.symbol], ["#f80", 3, "", "circle"]);
  near(zoomOf(156543.034, 0), 0, 1e-9);
  near(zoomOf(156543.034 / 1024, 60), 9, 1e-9);
});

test("layers of the map keep their order and their switches, and new ones are on", () => {
  const overlays = [{ layer: "a.geojson" }, { layer: "b.geojson" }, { layer: "a.geojson" }];
  const names = (setting) => layersText(layersOf(setting, overlays));
  assert.equal(names(""), "land|borders|a.geojson|b.geojson|range rings");
  assert.equal(names("-b.geojson|land|gone|land"), "-b.geojson|land|borders|a.geojson|range rings");
  assert.equal(names(names("-borders|range rings")), names("-borders|range rings"));
});

test("a track that comes again under its number has its trail, and the trails that are kept are bounded", () => {
  const picture = new Picture();
  for (let number = 1; number <= 2100; number++) {
    const { trail } = picture.appear(number);
    for (const time of [0, 10, 20]) trail.add(time, number, 0);
    picture.remove(number);
  }
  assert.equal(picture.system.size, 0);
  assert.equal(picture.left.size, 2000);
  const { trail } = picture.appear(2100);
  trail.add(30, 7, 0);
  assert.deepEqual([...Array(trail.length).keys()].map((k) => trail.east[trail.at(k)]), [2100, 2100, 2100, 7]);
  assert.equal(picture.appear(1).trail.length, 0);
  assert.notEqual(picture.appear(2099).trail, picture.system.get(2100).trail);
});

test("sensors at one place share their rings", () => {
  const sites = [[0, 0, "a"], [50, 0, "b"], [NaN, NaN, "c"], [900, 0, "d"]].map(([east, north, name]) => ({ east, north, name }));
  assert.deepEqual(centresOf(sites).map(({ name }) => name), ["a, b", "d"]);
});

test("true and magnetic bearings", () => {
  assert.deepEqual([courseText(20, NaN), courseText(1, 2), courseText(359.6, -1)], ["020°", "001° / 359°M", "000° / 001°M"]);
});

test("range rings stand apart at every scale", () => {
  for (const scale of [0.05, 3, 77, 900, 30_000])
    for (const units of ["aviation", "metric"]) {
      const pixels = roundLength(120 * scale, units, true).length / scale;
      assert.ok(pixels >= 119 && pixels <= 301, `${pixels} ${units}`);
    }
});

test("rings and the scale follow the setting of the units", () => {
  const text = (metres, units, up) => {
    const { length, unit } = roundLength(metres, units, up);
    return `${lengthText(length, unit)}, ${lengthText(3 * length, unit)}`;
  };
  assert.deepEqual(["aviation", "maritime", "metric"].map((units) => text(9000, units, true)), ["5 NM, 15 NM", "5 NM, 15 NM", "10 km, 30 km"]);
  assert.deepEqual(["aviation", "metric"].map((units) => text(9000, units, false)), ["2 NM, 6 NM", "5 km, 15 km"]);
  assert.deepEqual(["aviation", "metric"].map((units) => text(420, units, true)), ["500 m, 1500 m", "500 m, 1.5 km"]);
  assert.deepEqual(["aviation", "metric"].map((units) => text(0.3, units, false)), ["0.2 m, 0.6 m", "0.2 m, 0.6 m"]);
});

test("coverage reaches to the farthest cell in which the source detects, or that it alone sees", () => {
  const coverage = new Coverage();
  const cells = [
    [0, 2, 50, 48, 50],
    [0, 5, 4, 2, 20],
    [3, 7, 9, 0, 0],
  ];
  coverage.take({ since_s: 5, sectors: 4, ring_m: 1000, sources: [{ number: 3, name: "radar", site_m: [10, 20], cells }] });
  const outline = coverage.outline(3).map(([east, north]) => [Math.round(east) + 0, Math.round(north) + 0]);
  assert.deepEqual(outline, [
    [0, 3000],
    [3000, 0],
    [0, 0],
    [-8000, 0],
    [0, 8000],
  ]);
  assert.deepEqual(coverage.outline(9), []);
  const probabilities = coverage.sources.get(3).cells.map(probabilityOf);
  assert.deepEqual(probabilities, [0.96, 0.1, NaN]);
});

test("trails of the server are joined with newer points of the page", () => {
  const octets = new ArrayBuffer(8 + 8 + 24 + 8);
  const view = new DataView(octets);
  view.setFloat64(0, 1.7e9, true);
  [7, 2].forEach((value, k) => view.setUint32(8 + 4 * k, value, true));
  [0, 100, 1, 4, 96, 1].forEach((value, k) => view.setFloat32(16 + 4 * k, value, true));
  [9, 0].forEach((value, k) => view.setUint32(40 + 4 * k, value, true));
  const { until, tracks } = trailsOf(octets);
  assert.deepEqual([until, tracks.size, tracks.get(9)], [1.7e9, 2, []]);
  const own = new Trail();
  for (const age of [2, -3, -6]) own.add(1.7e9 - age, 100 - age, 1);
  own.add(1.7e9 + 99, 0, 0);
  const trail = joined(tracks.get(7), own, until, 1.7e9 + 6);
  const points = Array.from({ length: trail.length }, (_, k) => trail.at(k));
  assert.deepEqual(
    points.map((at) => [trail.timeOf(at) - 1.7e9, trail.east[at]]),
    [
      [-4, 96],
      [0, 100],
      [3, 103],
      [6, 106],
    ],
  );
});

test("what is unknown of a contributor is not a number, and reasons are those of the server", () => {
  const known = reasonOf({ age_s: 1.5, sigma_m: [30, 20], residual_m: [3, 4], residual_sigmas: 0.2, bias_m: [0, -7, 1], reason: "A." });
  assert.deepEqual([known.age, known.sigmaShort, known.residual, known.bias, known.reason], [1.5, 20, 5, 7, "A."]);
  const unknown = reasonOf({});
  assert.ok([unknown.age, unknown.sigmaLong, unknown.residual].every(Number.isNaN) && unknown.reason === "");
  assert.deepEqual(whyOf({}), NO_REASONS);
  const rules = [{ rule: "mosaic", summary: "S", in_force: false, shares: [[0, "radar", 1]], apart_m: null }];
  const why = whyOf({ rules, decisions_missing: "None." });
  assert.ok(Number.isNaN(why.rules[0].apart) && why.decisionsMissing === "None.");
});

/** Light, red, green and blue from 0 to 1, of a colour written #rrggbb. */
const light = (colour) =>
  [1, 3, 5].map((at) => {
    const value = parseInt(colour.slice(at, at + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  });

/** Contrast of two colours as the Web Content Accessibility Guidelines define it, 1 to 21. */
function contrast(one, other) {
  const [dark, bright] = [one, other]
    .map(light)
    .map(([red, green, blue]) => 0.2126 * red + 0.7152 * green + 0.0722 * blue)
    .sort((a, b) => a - b);
  return (bright + 0.05) / (dark + 0.05);
}

/** Light as people see it: all three cones, no red ones, no green ones (Machado, Oliveira and Fernandes, 2009). */
const VISIONS = {
  full: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
};

/** Lightness and the two opponent colours (CIELAB, white D65) of a colour that is seen so. */
function seen(colour, vision) {
  const times = (matrix, vector) => matrix.map((row) => row.reduce((sum, value, k) => sum + value * vector[k], 0));
  const rgb = times(vision, light(colour)).map((value) => Math.min(1, Math.max(0, value)));
  const [x, y, z] = times([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]], rgb)
    .map((value, k) => value / [0.9505, 1, 1.089][k])
    .map((value) => (value > 0.008856 ? Math.cbrt(value) : 7.787 * value + 16 / 116));
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

test("symbols and labels stand out from land and water in each set of colours", () => {
  for (const [set, colours] of Object.entries(COLOURS)) {
    const { confirmed, tentative, coasted, alert, selected, measure, unknown, overlay, scale, sources } = colours;
    const text = [confirmed, tentative, coasted, alert, selected, measure, unknown, overlay, ...scale, ...sources];
    for (const ground of [colours.land, colours.water]) {
      for (const colour of text) assert.ok(contrast(colour, ground) >= 4.5, `${set}: ${colour} on ${ground}`);
      for (const colour of Object.values(colours.sensor))
        assert.ok(contrast(colour, ground) >= 3, `${set}: ${colour} on ${ground}`);
    }
  }
});

test("people without red or green cones tell states, heights and sources apart", () => {
  for (const [set, colours] of Object.entries(COLOURS)) {
    const { confirmed, tentative, coasted, alert, selected, measure } = colours;
    const groups = [
      [[confirmed, tentative, coasted, alert, selected, measure], 15],
      [colours.scale, 12],
      [colours.sources, 12],
    ];
    for (const [name, vision] of Object.entries(VISIONS))
      for (const [group, least] of groups)
        group.forEach((one, k) => {
          for (const other of group.slice(k + 1)) {
            const [a, b] = [seen(one, vision), seen(other, vision)];
            const difference = Math.hypot(...a.map((value, n) => value - b[n]));
            assert.ok(difference >= least, `${set}, ${name}: ${one} and ${other} differ by ${difference.toFixed(1)}`);
          }
        });
  }
});

test("a station stays between its reports, has its facts, and is found under the pointer", () => {
  const picture = new Picture();
  const record = {
    mmsi: 2111111,
    source: 1,
    east_m: 100,
    north_m: 200,
    name: "",
    aid: 0,
    flags: 1,
    length_m: 0,
    width_m: 0,
  };
  const station = (change, time) => ({ ...STATIONS.mark({ ...record, ...change }), time });
  const buoy = { mmsi: 992111840, name: "BUOY 7 ", aid: 24, flags: 4, length_m: 6, width_m: 4, east_m: 5000 };
  picture.addStations(0, [station({}, 590), station(buoy, 100)]);
  picture.addStations(0, [station({}, 600)]);
  assert.deepEqual([...picture.stations.keys()], [2111111, 992111840]);
  const [base, aid] = picture.stations.values();
  assert.equal(base.time, 600, "the latest report of each");
  assert.deepEqual(stationLines(base, 605, "coast"), ["MMSI 002111111", "base station", "at most 5 s ago by coast"]);
  assert.deepEqual(stationLines(aid, 605, ""), [
    "BUOY 7",
    "MMSI 992111840",
    "aid to navigation: port mark",
    "OFF POSITION",
    "6 × 4 m",
    "at most 505 s ago",
  ]);
  const virtual = station({ ...buoy, flags: 2, aid: 200, length_m: 0 }, 605);
  assert.equal(stationLines(virtual, 605, "")[2], "virtual aid to navigation");
  const view = Object.assign(new View(), { width: 800, height: 600, east: 0, north: 0, scale: 50, up: 0 });
  const [x, y] = view.toScreen(100, 200);
  assert.equal(stationAt(picture.stations.values(), view, x + 5, y - 5), 2111111);
  assert.equal(stationAt(picture.stations.values(), view, x + 20, y), -1);
  picture.addStations(200, []);
  assert.deepEqual([...picture.stations.keys()], [2111111], "the aid has been silent for too long");
  picture.clearLayers();
  assert.equal(picture.stations.size, 0);
});

test("stations are shown unless they are switched off", () => {
  assert.equal(read("").stations, true);
  assert.equal(read("").detections, false);
  assert.equal(write({ ...DEFAULTS, stations: false }), "#stations=0");
  assert.equal(read("#stations=0").stations, false);
});
