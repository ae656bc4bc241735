/**
 * The picture: every track the page knows of, with where it was before.
 */

import { ALERT } from "./wire.js";

/**
 * @typedef {object} Track
 * @property {number} number System-track number, or the sensor's own.
 * @property {number} source Main source of a system track; source of a sensor track; -1: none.
 * @property {string} state tentative, confirmed, coasted
 * @property {string} kind single or group
 * @property {number} members Expected members of a group.
 * @property {number} time Time of the state, seconds UTC.
 * @property {number} east @property {number} north metres
 * @property {number} height Metres, the transponder's level or above the ellipsoid; NaN: unknown.
 * @property {boolean} isLevel Whether it is the transponder's level.
 * @property {boolean} isAltitude Whether it is an altitude by the pressure of the region (QNH).
 * @property {number} climb Rate of the height, metres per second.
 * @property {boolean} climbs @property {boolean} sinks Whether it is shown as climbing, or as descending.
 * @property {number} speedEast @property {number} speedNorth metres per second
 * @property {boolean} knowsVelocity Whether the speeds are known; else they have no meaning.
 * @property {number} sourceCount
 * @property {number} sourcesLow Bit n: source n contributes. @property {number} sourcesHigh The same of source 32 + n.
 * @property {number} alerts Bits, as the messages have them.
 * @property {boolean} onGround
 * @property {string} callsign @property {string} address @property {string} code
 * @property {string} type @property {boolean} isShip
 * @property {number} sigmaMajor @property {number} sigmaMinor Axes of the 1-sigma ellipse, metres; 0: unknown.
 * @property {number} sigmaBearing Direction of the larger axis, radians clockwise from north.
 * @property {number} handOver When another source became the main one last, seconds; 0: never.
 * @property {Map<number, number>} mains When each source was the main one last, seconds.
 * @property {number} mainsSince Since when that has been noted, seconds.
 * @property {Trail} trail
 * @property {string[]} label Lines of its label, longest form.
 * @property {import("./placement.js").Spot} spot Where its label is.
 */

/** @typedef {import("./layers.js").Mark} Mark */

/**
 * Sensor track.
 * @typedef {object} Spot
 * @property {number} number Number at its source.
 * @property {number} source
 * @property {number} time seconds UTC
 * @property {number} east @property {number} north metres
 */

/** Points that a trail keeps, and seconds between two: ten minutes. */
const TRAIL_MAX = 300;
const TRAIL_STEP_S = 2;

/** Past positions of one track: a ring, whole from the start, so that memory stays what it is. */
export class Trail {
  constructor() {
    this.east = new Float32Array(TRAIL_MAX);
    this.north = new Float32Array(TRAIL_MAX);
    /** Seconds after `base`. */
    this.after = new Float32Array(TRAIL_MAX);
    this.base = 0;
    this.start = 0;
    this.length = 0;
  }

  /** @param {number} time @param {number} east @param {number} north */
  add(time, east, north) {
    const last = this.length > 0 ? this.timeOf(this.at(this.length - 1)) : -Infinity;
    // A clock that starts again (another recording) starts the trail again; a look into the past does not.
    if (time < last - 3600) this.length = 0;
    else if (time - last < TRAIL_STEP_S) return;
    if (this.length === 0) this.base = time;
    if (this.length === TRAIL_MAX) this.start = (this.start + 1) % TRAIL_MAX;
    else this.length++;
    const k = this.at(this.length - 1);
    this.east[k] = east;
    this.north[k] = north;
    this.after[k] = time - this.base;
  }

  /** Place in the arrays of the point with number `k`, oldest first. @param {number} k */
  at(k) {
    return (this.start + k) % TRAIL_MAX;
  }

  /** Time of the point at a place in the arrays, seconds UTC. @param {number} k */
  timeOf(k) {
    return this.base + this.after[k];
  }
}

/** Alerts, the gravest first, and what a label says of each. */
export const ALERTS = /** @type {const} */ ([
  [ALERT.UNLAWFUL_INTERFERENCE, "HIJACK"],
  [ALERT.EMERGENCY, "EMERG"],
  [ALERT.COMMUNICATION_FAILURE, "RCF"],
  [ALERT.RESOLUTION_ADVISORY, "ACAS RA"],
  [ALERT.MINIMUM_FUEL, "MINFUEL"],
  [ALERT.MEDICAL, "MEDICAL"],
  [ALERT.SPECIAL_IDENTIFICATION, "SPI"],
]);
/** Alerts that turn a track to the colour of alarm. */
const GRAVE =
  ALERT.UNLAWFUL_INTERFERENCE |
  ALERT.EMERGENCY |
  ALERT.COMMUNICATION_FAILURE |
  ALERT.RESOLUTION_ADVISORY |
  ALERT.MINIMUM_FUEL;

/** @param {Track} track */
export function isGrave(track) {
  return (track.alerts & GRAVE) !== 0;
}

/** @returns {Track} */
export function blankTrack() {
  return {
    number: 0,
    source: -1,
    state: "confirmed",
    kind: "single",
    members: 0,
    time: 0,
    east: 0,
    north: 0,
    height: NaN,
    isLevel: false,
    isAltitude: false,
    climb: 0,
    climbs: false,
    sinks: false,
    speedEast: 0,
    speedNorth: 0,
    knowsVelocity: false,
    sourceCount: 0,
    sourcesLow: 0,
    sourcesHigh: 0,
    alerts: 0,
    onGround: false,
    callsign: "",
    address: "",
    code: "",
    type: "",
    isShip: false,
    sigmaMajor: 0,
    sigmaMinor: 0,
    sigmaBearing: 0,
    handOver: 0,
    mains: new Map(),
    mainsSince: 0,
    trail: new Trail(),
    label: [],
    spot: { place: -1, lines: 0, isForced: false, pinned: null },
  };
}

/** Seconds for which a source must not have been the main one, for its becoming so to be a hand-over. */
export const HAND_OVER_AFTER_S = 30;

/**
 * Forgets which sources were the main one, after a leap to the time `time`, seconds.
 * @param {Track} track @param {number} time
 */
export function forgetMains(track, time) {
  track.mains.clear();
  track.mainsSince = time;
  track.handOver = 0;
}

/**
 * Notes which source is the main one, where it was `before`. Two that are worth the same take turns: that is no
 * hand-over.
 * @param {Track} track @param {number} before -1: none. @param {number} time Of the picture, seconds.
 */
export function noteMain(track, before, time) {
  if (track.source < 0) return;
  const last = track.mains.get(track.source) ?? track.mainsSince;
  if (before >= 0 && before !== track.source && track.time - last > HAND_OVER_AFTER_S) track.handOver = time;
  track.mains.set(track.source, track.time);
}

/** What a person calls a track. @param {Track} track */
export function nameOf(track) {
  return track.callsign || track.code || track.address || `#${track.number}`;
}

/** Numbers of the sources that contribute, of the first 64. @param {Track} track */
export function sourcesOf(track) {
  const sources = [];
  for (let bits = track.sourcesLow; bits !== 0; bits &= bits - 1) sources.push(31 - Math.clz32(bits & -bits));
  for (let bits = track.sourcesHigh; bits !== 0; bits &= bits - 1) sources.push(63 - Math.clz32(bits & -bits));
  return sources;
}

/** Most trails of tracks that have left: 7 MB. */
const LEFT_MAX = 2000;

export class Picture {
  constructor() {
    /** Time of the picture, seconds UTC; 0 before the first. */
    this.time = 0;
    /** @type {Map<number, Track>} System tracks by number. */
    this.system = new Map();
    /** @type {Map<number, Trail>} Trails of tracks that have left the picture, the earliest first. */
    this.left = new Map();
    /** @type {Map<number, Spot>} Sensor tracks by source and number. */
    this.sensor = new Map();
    /** @type {Record<string, Mark[]>} Marks of each layer that passes, by key, the oldest first. */
    this.marks = {};
    /** @type {Map<number, import("./stations.js").Station>} Stations that are no targets, by MMSI. */
    this.stations = new Map();
  }

  /** Removes a track; its trail is kept, since another fusion may continue the track. @param {number} number */
  remove(number) {
    const trail = this.system.get(number)?.trail;
    this.system.delete(number);
    if (!trail || trail.length < 2) return;
    this.left.set(number, trail);
    if (this.left.size > LEFT_MAX) this.left.delete(this.left.keys().next().value ?? 0);
  }

  /** Adds a track, with the trail that it had before. @param {number} number */
  appear(number) {
    const track = blankTrack();
    track.trail = this.left.get(number) ?? track.trail;
    this.left.delete(number);
    this.system.set(number, track);
    return track;
  }

  clearLayers() {
    this.sensor.clear();
    this.marks = {};
    this.stations.clear();
  }

  /**
   * Adds what has come of the lower layers, and drops what is older than `since`.
   * @param {number} since @param {Spot[]} sensor @param {Record<string, Mark[]>} marks
   */
  addLayers(since, sensor, marks) {
    // Track numbers have 32 bits, source numbers 16: their combination is an exact integer.
    for (const spot of sensor) this.sensor.set(spot.source * 2 ** 32 + spot.number, spot);
    for (const [key, spot] of this.sensor) if (spot.time < since) this.sensor.delete(key);
    const keys = Object.keys({ ...this.marks, ...marks });
    this.marks = Object.fromEntries(
      keys.map((key) => [key, recent(this.marks[key] ?? [], marks[key] ?? [], since)]),
    );
  }

  /**
   * Puts in the latest reports of stations, and drops stations without a report since `since`.
   * @param {number} since @param {import("./stations.js").Station[]} stations
   */
  addStations(since, stations) {
    for (const station of stations) this.stations.set(station.mmsi, station);
    for (const [mmsi, { time }] of this.stations) if (time < since) this.stations.delete(mmsi);
  }
}

/** Most marks of a layer that are kept. */
const LAYER_MAX = 40_000;

/** @template {{time: number}} T @param {T[]} known @param {T[]} added @param {number} since @returns {T[]} */
function recent(known, added, since) {
  if (known.length === 0 && added.length === 0) return known;
  return [...known, ...added].filter((item) => item.time >= since).slice(-LAYER_MAX);
}
