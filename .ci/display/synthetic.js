/**
 * Stands in for main.js where the page is measured without a server: thousands of tracks that fly circles, each heard
 * once a second, as pictures at 4 Hz. `?tracks=5000` says how many. With `&straight` they fly straight on instead, spread
 * over a rectangle of 560 by 380 km.
 */

import { App } from "./app.js";
import { control } from "./controls.js";
import { controlLabels } from "./nudge.js";
import { groundOf } from "./ground.js";
import { NO_REASONS, reasonOf } from "./why.js";

const asked = new URLSearchParams(location.search);
const count = Number(asked.get("tracks") ?? 5000);
const straight = asked.has("straight");
const app = new App(() => {});
control(app);
controlLabels(app);
Object.assign(globalThis, { koseki: app });

const origin = { latitude_deg: 41.297, longitude_deg: 2.078, height_m: 4 };
app.hello({ instance: "synthetic", origin });
app.connected = true;
const kinds = ["radar", "multilateration", "ads-b"];
const sources = kinds.map((kind, number) => ({
  number,
  name: ["approach", "wam", "receivers"][number],
  kind,
  adapter: "",
  rate: count,
  lastHeard: 0,
  lost: number,
  refused: number === 1 ? '07:08:09: line 2, column px: "" is empty; write a number' : "",
  dependsOn: /** @type {[string, number][]} */ ([]),
  rejected: /** @type {[string, number][]} */ (number === 0 ? [["position", 12]] : []),
  errors: `+${12 * number}.0 m east, -5.0 m north ± 0.4 (removed), covariances × ${1 + number / 2}`,
  clockOffset: 0.012,
  east: -20000 * number,
  north: 9000 * number,
  offset: /** @type {[number, number]} */ ([12 * number, -5]),
}));
app.learn({ sources });

// A repeatable draw (xorshift, Marsaglia 2003).
let seed = 2463534242;
const draw = () => {
  seed ^= seed << 13;
  seed ^= seed >>> 17;
  seed ^= seed << 5;
  return (seed >>> 0) / 4294967296;
};
const flights = Array.from({ length: count }, (_, k) => {
  const distance = 280_000 * Math.sqrt(draw());
  const azimuth = 2 * Math.PI * draw();
  return {
    number: k + 1,
    east: straight ? 560_000 * (draw() - 0.5) : distance * Math.sin(azimuth),
    north: straight ? 380_000 * (draw() - 0.5) : distance * Math.cos(azimuth),
    radius: straight ? 1e8 : 4000 + 20000 * draw(),
    phase: 2 * Math.PI * draw(),
    speed: 70 + 190 * draw(),
    height: 300 + 11500 * draw(),
    climb: draw() < 0.3 ? (draw() - 0.5) * 24 : 0,
    callsign: `${["BAW", "VLG", "IBE", "AFR", "DLH", "RYR"][Math.floor(6 * draw())]}${100 + Math.floor(8900 * draw())}`,
    state: draw() < 0.06 ? "tentative" : draw() < 0.05 ? "coasted" : "confirmed",
    kind: draw() < 0.01 ? "group" : "single",
    alerts: k === 17 ? 2 : 0,
    source: Math.floor(3 * draw()),
    sourcesLow: 1 + Math.floor(7 * draw()),
    sourceCount: 1 + Math.floor(3 * draw()),
    sigma: 15 + 60 * draw(),
    address: Math.floor(16777215 * draw())
      .toString(16)
      .padStart(6, "0")
      .toUpperCase(),
  };
});
const began = Date.now() / 1000;

/** @param {typeof flights[0]} flight @param {number} time */
function stateOf(flight, time) {
  const turn = flight.phase + (flight.speed / flight.radius) * (time - began);
  return {
    number: flight.number,
    source: flight.source,
    state: flight.state,
    kind: flight.kind,
    members: flight.kind === "group" ? 4 : 0,
    time,
    east: flight.east + flight.radius * (Math.sin(turn) - Math.sin(flight.phase)),
    north: flight.north + flight.radius * (Math.cos(turn) - Math.cos(flight.phase)),
    height: flight.height,
    speedEast: flight.speed * Math.cos(turn),
    speedNorth: -flight.speed * Math.sin(turn),
    isLevel: flight.number % 5 !== 0,
    climb: flight.climb,
    climbs: flight.climb > 2,
    sinks: flight.climb < -2,
    sourceCount: flight.sourceCount,
    sourcesLow: flight.sourcesLow,
    alerts: flight.alerts,
    callsign: flight.callsign,
    address: flight.address,
    code: "2345",
    sigmaMajor: flight.sigma,
    sigmaMinor: flight.sigma * 0.6,
    sigmaBearing: flight.phase,
  };
}

let slot = 0;
function picture() {
  const time = Date.now() / 1000;
  const due = flights.filter((flight) => app.stats.pictures === 0 || flight.number % 4 === slot);
  slot = (slot + 1) % 4;
  const tracks = due.map((flight) => stateOf(flight, time));
  const sensor = flights.flatMap((flight) => {
    const track = stateOf(flight, time);
    return kinds.map((_, source) => ({
      number: flight.number,
      source,
      time,
      east: track.east + 150 * (source - 1),
      north: track.north + 90,
    }));
  });
  app.changes({ time, full: false, tracks, removed: [], sensor: app.settings.sensors ? sensor : undefined });
  for (const number of app.selected) {
    const flight = flights[number - 1];
    if (!flight) continue;
    const track = stateOf(flight, time);
    const weights = [0.62 + 0.1 * Math.sin(time / 7), 0.25, 0];
    weights[2] = 1 - weights[0] - weights[1];
    app.details(
      number,
      String(Math.round(time * 1e9)),
      weights.map((weight, source) => ({
        source,
        name: sources[source].name,
        kind: kinds[source],
        track: 100 + number,
        weight,
        fresh: true,
        centre: false,
        accuracy: 10 * weight,
        east: track.east + 400 * (source - 1),
        north: track.north + 300,
        ...reasonOf({}),
      })),
      2 + Math.sin(time),
      {
        facts: [["quality", "0.93"]],
        rule: "auto",
        why: NO_REASONS,
        motion: { climb: flight.climb, climbSigma: 0.5, turn: 0, turnSigma: 0.5, modes: [{ mode: "steady", probability: 0.9 }] },
      },
    );
  }
}
setInterval(picture, 250);
picture();

/** The coast in a sphere's tangent plane, from the file in degrees: good enough to look at. */
function projected(/** @type {ArrayBuffer} */ buffer) {
  const octets = new Uint8Array(buffer);
  const head = new DataView(buffer);
  const [rings, borders] = [head.getUint32(8, true), head.getUint32(12, true)];
  let at = 16;
  const unsigned = () => {
    let value = 0;
    for (let factor = 1; ; factor *= 128) {
      const octet = octets[at++];
      value += (octet & 127) * factor;
      if (octet < 128) return value;
    }
  };
  const signed = () => {
    const value = unsigned();
    return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
  };
  const radians = Math.PI / 180;
  const [lat0, lon0] = [origin.latitude_deg * radians, origin.longitude_deg * radians];
  const points = [];
  for (let line = 0; line < rings + borders; line++) {
    if (line === rings) points.push(Infinity, Infinity);
    const length = unsigned();
    let [lon, lat] = [0, 0];
    let seen = false;
    const own = [];
    for (let k = 0; k < length; k++) {
      lon += signed();
      lat += signed();
      const [l, f] = [lon * 0.0025 * radians - lon0, lat * 0.0025 * radians];
      const up = Math.sin(lat0) * Math.sin(f) + Math.cos(lat0) * Math.cos(f) * Math.cos(l);
      const east = Math.cos(f) * Math.sin(l);
      const north = Math.cos(lat0) * Math.sin(f) - Math.sin(lat0) * Math.cos(f) * Math.cos(l);
      const stretch = up > 0.5 ? 1 : Math.sin(Math.PI / 3) / Math.hypot(east, north);
      seen ||= up > 0.5;
      own.push(6378137 * east * stretch, 6378137 * north * stretch);
    }
    if (seen) points.push(...own, NaN, NaN);
  }
  return new Float32Array(points).buffer;
}
const answer = await fetch("coast.bin");
app.ground = groundOf(projected(await answer.arrayBuffer()));
