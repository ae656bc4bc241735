/** Tests of measuring lines, without a browser: node --test .ci/display/measuring.mjs */

import assert from "node:assert/strict";
import { test } from "node:test";

const page = new URL("../../services/display/page/", import.meta.url);
const module = (name) => import(new URL(name, page));
const { pathBetween, placeOf } = await module("geodesy.js");
const { approach, Measuring, textsOf } = await module("measuring.js");
const { blankTrack, Picture } = await module("picture.js");
const { View } = await module("view.js");

const near = (a, b, limit) => assert.ok(Math.abs(a - b) <= limit, `${a} is not ${b}`);
const point = (east, north) => ({ east, north });
const ORIGIN = { latitude_deg: 41.5, longitude_deg: 2, height_m: 0 };

test("ranges along the equator and along a meridian are those of the ellipsoid", () => {
  const equator = { latitude_deg: 0, longitude_deg: 0, height_m: 0 };
  const [west, east] = [placeOf(equator, -200_000, 0), placeOf(equator, 200_000, 0)];
  const along = pathBetween(equator, point(-200_000, 0), point(200_000, 0));
  near(along.range, ((east.longitude_deg - west.longitude_deg) * Math.PI * 6378137) / 180, 0.5);
  near(along.there, 90, 1e-6);
  near(along.back, 270, 1e-6);

  const [south, north] = [placeOf(ORIGIN, 0, -200_000).latitude_deg, placeOf(ORIGIN, 0, 200_000).latitude_deg];
  const square = (2 - 1 / 298.257223563) / 298.257223563;
  let arc = 0;
  const steps = 1000;
  for (let k = 0; k < steps; k++) {
    const latitude = ((south + ((k + 0.5) * (north - south)) / steps) * Math.PI) / 180;
    const step = ((north - south) / steps) * (Math.PI / 180);
    arc += (6378137 * (1 - square) * step) / (1 - square * Math.sin(latitude) ** 2) ** 1.5;
  }
  const up = pathBetween(ORIGIN, point(0, -200_000), point(0, 200_000));
  near(up.range, arc, 1);
  near(up.there, 0, 1e-6);
  near(up.back, 180, 1e-6);
});

test("bearings are true ones: at the edge of the map north is not upward", () => {
  const path = pathBetween(ORIGIN, point(0, 0), point(300_000, 0));
  near(path.there, 90, 1e-6);
  const there = placeOf(ORIGIN, 300_000, 0);
  const convergence = (there.longitude_deg - 2) * Math.sin((41.5 * Math.PI) / 180);
  near(path.back, 270 + convergence, 0.02);
  assert.equal(pathBetween(ORIGIN, point(0, 0), point(7e6, 0)), null);
});

test("a track's height does not lengthen its range", () => {
  // What flies 300 km away lies 11 km along the vertical of its own place, which is not that of the origin.
  const ground = pathBetween(ORIGIN, point(0, 0), point(300_000, 0)).range;
  const lean = Math.sin(300 / 6378) * 11_000;
  near(pathBetween(ORIGIN, point(0, 0), point(300_000 + lean, 0), 0, 11_000).range, ground, 3);
});

const flying = (number, east, north, speedEast, speedNorth) =>
  Object.assign(blankTrack(), { number, east, north, speedEast, speedNorth, height: 3048 });

test("closest approach: head on, overtaken, and parting", () => {
  const meet = approach(flying(1, 0, 0, 100, 0), flying(2, 10_000, 500, -100, 0));
  near(meet.time, 50, 1e-9);
  near(meet.distance, 500, 1e-9);
  assert.ok(approach(flying(1, 0, 0, -100, 0), flying(2, 10_000, 0, 100, 0)).time < 0);
  assert.deepEqual(approach(flying(1, 0, 0, 90, 0), flying(2, 0, 700, 90, 0)), { time: 0, distance: 700 });
});

test("a line says bearings, range, and time in the units of the page", () => {
  const line = { from: { east: 0, north: 0 }, to: { east: 18_520, north: 0 } };
  const eastward = flying(1, 0, 0, 100, 0);
  assert.deepEqual(textsOf(line, eastward, null, ORIGIN, "aviation", NaN), [
    "090.0°T / 270.1°T  10.00 NM",
    "3:05 to go at 194 kt",
  ]);
  assert.deepEqual(textsOf(line, null, null, ORIGIN, "metric", 2.5), [
    "090.0°T / 270.1°T  18.52 km",
    "087.5°M / 267.6°M",
  ]);
  const other = Object.assign(flying(2, 18_520, 0, -100, 0), { height: 2438.4 });
  const texts = textsOf(line, eastward, other, ORIGIN, "aviation", NaN);
  assert.equal(texts[1], "CPA 0 m in 1:33  Δ 2000 ft");
  assert.equal(textsOf(line, eastward, flying(2, 18_520, 0, 200, 0), ORIGIN, "metric", NaN)[1], "no approach  Δ 0 m");
});

test("lines stay on their tracks, are several, and go one by one", () => {
  const ctx = { font: "", measureText: (text) => ({ width: 7 * text.length }) };
  const view = Object.assign(new View(), { width: 1000, height: 800 });
  const picture = new Picture();
  picture.system.set(7, flying(7, 1000, 0, 100, 0));
  const scene = { view, picture, settings: { units: "aviation" }, origin: ORIGIN, declination: NaN };
  const measuring = new Measuring();
  measuring.begin({ east: 0, north: 0, track: -1 });
  measuring.lead({ east: 0, north: 0, track: 7 });
  measuring.begin({ east: 0, north: 5000, track: -1 });
  measuring.lead({ east: 9000, north: 5000, track: -1 });
  measuring.layOut(ctx, scene);
  assert.deepEqual(measuring.notes[0].ends[1], view.toScreen(1000, 0));
  picture.system.get(7).east = 3000;
  measuring.layOut(ctx, scene);
  assert.deepEqual(measuring.notes[0].ends[1], view.toScreen(3000, 0));
  picture.system.clear();
  measuring.layOut(ctx, scene);
  assert.deepEqual(measuring.notes[0].ends[1], view.toScreen(3000, 0), "where a track was last, its line ends");
  measuring.dropAt(...view.toScreen(4000, 5000));
  assert.deepEqual(measuring.lines.map(({ to }) => to.track), [7]);
  for (let k = 0; k < 20; k++) measuring.begin({ east: k, north: 0, track: -1 });
  assert.equal(measuring.lines.length, 8);
});
