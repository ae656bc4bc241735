/**
 * Trails from the server: ten minutes of past positions of every track, for a page that was just opened or has moved
 * through time.
 */

import { Trail } from "./picture.js";
import { ofWindow } from "./window.js";

/**
 * Trails by track from the server's octets: the oldest point first.
 * @param {ArrayBuffer} octets
 * @returns {{until: number, tracks: Map<number, {time: number, east: number, north: number}[]>}} seconds UTC, metres.
 */
export function trailsOf(octets) {
  const view = new DataView(octets);
  const until = view.getFloat64(0, true);
  const tracks = new Map();
  for (let at = 8; at + 8 <= octets.byteLength; ) {
    const [number, count] = [view.getUint32(at, true), view.getUint32(at + 4, true)];
    at += 8;
    const points = [];
    for (let k = count - 1; k >= 0; k--) {
      const [age, east, north] = [0, 4, 8].map((place) => view.getFloat32(at + 12 * k + place, true));
      points.push({ time: until - age, east, north });
    }
    at += 12 * count;
    tracks.set(number, points);
  }
  return { until, tracks };
}

/**
 * Trail of the server's points, and of the page's own points that are newer than `until`, up to the picture's time `now`.
 * @param {{time: number, east: number, north: number}[]} points @param {Trail} own @param {number} until
 * @param {number} now Seconds UTC.
 */
export function joined(points, own, until, now) {
  const trail = new Trail();
  for (const { time, east, north } of points) trail.add(time, east, north);
  for (let k = 0; k < own.length; k++) {
    const at = own.at(k);
    if (own.timeOf(at) > until && own.timeOf(at) < now + 1) trail.add(own.timeOf(at), own.east[at], own.north[at]);
  }
  return trail;
}

/**
 * Asks for trails after leaps through time, one request at a time; answers that came too late are dropped.
 */
export class TrailRequests {
  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.edition = 0;
  }

  /** @param {number} time End of the trails, seconds UTC. */
  async ask(time) {
    const edition = ++this.edition;
    const answer = await fetch(ofWindow(`api/trails?until_s=${time}`));
    if (!answer.ok) return;
    const octets = await answer.arrayBuffer();
    if (edition !== this.edition) return;
    const { until, tracks } = trailsOf(octets);
    for (const [number, points] of tracks) {
      const track = this.app.picture.system.get(number);
      if (track) track.trail = joined(points, track.trail, until, this.app.picture.time);
    }
    this.app.dirty = true;
  }
}
