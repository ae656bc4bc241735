/**
 * Connection to the display process: says what is wanted, puts what comes into the app, and comes back by itself.
 *
 * A picture is answered after the frame that shows it, so that a page which cannot keep up gets fewer pictures and
 * never a queue of old ones.
 */

import { IDENTITY, PICTURE, PICTURE_TRACK, readPicture, TRACK_KIND, TRACK_STATE } from "./wire.js";
import { LAYERS, ofLayers } from "./layers.js";
import { reasonOf, whyOf } from "./why.js";
import { ofWindow } from "./window.js";

/** @typedef {import("./app.js").App} App */
/** @typedef {import("./app.js").Change} Change */

const NO_SOURCE = 65535;
/** Kind of the addresses of ships. */
const MMSI = 2;
/** Longest pause between two attempts to connect, milliseconds. */
const PAUSE_MAX_MS = 4000;

export class Connection {
  constructor() {
    /** @type {App | null} */
    this.app = null;
    /** @type {WebSocket | null} */
    this.socket = null;
    /** Text of each wish as it was sent last. @type {Map<string, string>} */
    this.sent = new Map();
    this.pause = 250;
    this.layerAge = 15;
    /** The same of stations. */
    this.stationAge = 600;
    this.pastEdition = 0;
  }

  /** @param {App} app */
  start(app) {
    this.app = app;
    this.open();
  }

  open() {
    const address = new URL(ofWindow("ws"), location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    address.hash = "";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.addEventListener("open", () => {
      this.pause = 250;
      this.sent.clear();
      this.pastEdition = -1;
      if (this.app) this.app.connected = true;
      this.ask();
    });
    socket.addEventListener("message", ({ data }) => {
      if (typeof data === "string") this.text(JSON.parse(data));
      else this.picture(data);
    });
    socket.addEventListener("close", () => {
      if (this.app) this.app.connected = false;
      setTimeout(() => this.open(), this.pause);
      this.pause = Math.min(PAUSE_MAX_MS, this.pause * 2);
    });
  }

  /** Sends what of the wishes has changed. */
  ask() {
    const { app, socket } = this;
    if (!app || !socket || socket.readyState !== WebSocket.OPEN) return;
    const { settings } = app;
    /** @type {Record<string, unknown>} */
    const wishes = {
      layers: [
        ...(settings.sensors ? ["sensor_tracks"] : []),
        ...LAYERS.filter(({ key }) => settings[key]).map(({ key }) => key),
      ],
      select: [...app.selected].slice(-16),
    };
    for (const [key, value] of Object.entries(wishes)) {
      const text = JSON.stringify(value);
      if (this.sent.get(key) === text) delete wishes[key];
      else this.sent.set(key, text);
    }
    if (this.pastEdition !== app.pastEdition) {
      this.pastEdition = app.pastEdition;
      wishes.past = settings.at > 0 ? { time_s: settings.at, speed: settings.speed } : null;
    }
    if (Object.keys(wishes).length > 0) socket.send(JSON.stringify(wishes));
  }

  /** @param {ArrayBuffer} octets */
  picture(octets) {
    const { app, socket } = this;
    if (!app) return;
    const picture = readPicture(octets);
    const { header, removed, tracks, identities, sensor_tracks } = picture;
    const time = header.time_ns / 1e9;
    const at = (/** @type {number} */ age_ms) => time - age_ms / 1000;
    const { stations, ...marks } = ofLayers(({ key, mark }) =>
      picture[key].map((record) => ({ ...mark(record), time: at(record.age_ms) })),
    );
    app.changes({
      time,
      full: (header.flags & PICTURE.FULL) !== 0,
      removed,
      tracks: tracks.map((track) => ({
        number: track.number,
        source: track.main_source === NO_SOURCE ? -1 : track.main_source,
        state: TRACK_STATE[track.state] ?? "confirmed",
        kind: TRACK_KIND[track.kind] ?? "single",
        members: track.members,
        time: at(track.age_ms),
        east: track.east_m,
        north: track.north_m,
        height: track.height_m,
        speedEast: track.east_mps,
        speedNorth: track.north_mps,
        knowsVelocity: (track.flags & PICTURE_TRACK.VELOCITY) !== 0,
        isLevel: (track.flags & PICTURE_TRACK.LEVEL) !== 0,
        isAltitude: (track.flags & PICTURE_TRACK.ALTITUDE) !== 0,
        climb: track.climb_mps,
        climbs: (track.flags & PICTURE_TRACK.CLIMBS) !== 0,
        sinks: (track.flags & PICTURE_TRACK.SINKS) !== 0,
        sourceCount: track.source_count,
        sourcesLow: track.sources_low,
        sourcesHigh: track.sources_high,
        alerts: track.alerts,
        onGround: (track.flags & PICTURE_TRACK.ON_GROUND) !== 0,
        sigmaMajor: track.semi_major_m,
        sigmaMinor: track.semi_minor_m,
        sigmaBearing: track.semi_major_rad,
      })),
      identities: identities.map((identity) => ({
        number: identity.number,
        isShip: identity.kind === MMSI,
        callsign: (identity.kind === MMSI && identity.name) || identity.callsign || identity.name,
        address: identity.kind === 0 ? "" : addressText(identity.address, identity.kind),
        code: (identity.valid & IDENTITY.MODE_3A) !== 0 ? identity.mode_3a.toString(8).padStart(4, "0") : "",
        type: identity.type_name,
      })),
      sensor: sensor_tracks.map((track) => ({
        number: track.track_number,
        source: track.source,
        time: at(track.age_ms),
        east: track.east_m,
        north: track.north_m,
      })),
      marks,
      stations: /** @type {any[]} */ (stations),
      layerAge: this.layerAge,
      stationAge: this.stationAge,
    });
    app.fusionSilent = (header.flags & PICTURE.FUSION_SILENT) !== 0;
    const answer = () => {
      if (this.socket === socket && socket?.readyState === WebSocket.OPEN)
        socket.send(JSON.stringify({ ack: header.sequence }));
    };
    // A hidden page paints no frames.
    if (document.hidden) setTimeout(answer, 500);
    else requestAnimationFrame(answer);
  }

  /** @param {any} message */
  text(message) {
    const { app } = this;
    if (!app) return;
    if (message.type === "hello") {
      this.layerAge = message.layer_age_s;
      this.stationAge = message.station_age_s;
      app.hello(message);
      app.learn({ sources: message.sources.map(sourceOf), hasOperators: message.operators });
    } else if (message.type === "selected") {
      for (const track of message.tracks) this.selected(app, track);
    } else if (message.type === "history") {
      const name = (/** @type {number} */ source) => app.sourceOf.get(source)?.name ?? `source ${source + 1}`;
      app.past(
        message.number,
        message.rows.map((/** @type {any[]} */ [time, east, north, height, speed, , nis, weights]) => ({
          time,
          east,
          north,
          height: height ?? NaN,
          speed,
          nis: nis ?? NaN,
          weights: weights.map((/** @type {[number, number]} */ [source, weight]) => ({
            source,
            name: name(source),
            weight,
          })),
        })),
      );
    } else if (message.type === "status") this.status(app, message);
    else if (message.type === "refused") console.error(`refused: ${message.error}`);
  }

  /** @param {App} app @param {any} track */
  selected(app, track) {
    const shares = track.contributions.map((/** @type {any} */ share) => ({
      source: share.source,
      name: share.name,
      kind: app.sourceOf.get(share.source)?.kind ?? "tracker",
      track: share.track_number,
      weight: share.weight,
      accuracy: share.accuracy ?? NaN,
      fresh: share.fresh,
      centre: share.centre,
      east: share.position_m?.[0] ?? NaN,
      north: share.position_m?.[1] ?? NaN,
      ...reasonOf(share),
    }));
    /** @type {[string, string][]} */
    const facts = [];
    // The past remembers less.
    for (const key of ["rule", "epoch", "sequence"]) if (track[key] != null) facts.push([key, String(track[key])]);
    if (track.identity?.mmsi) facts.push(["MMSI", track.identity.mmsi]);
    if (track.identity?.name) facts.push(["name", track.identity.name]);
    for (const [name, text] of track.stated ?? []) facts.push([name, text]);
    const owner = shares.find((/** @type {any} */ share) => share.centre && share.track === track.owner_track_number);
    if (track.owner_track_number)
      facts.push(["owned by", `${owner?.name ?? "another centre"}, its ${track.owner_track_number}`]);
    if (track.merged_into) facts.push(["merged into", String(track.merged_into)]);
    const motion = {
      climb: track.climb_rate_mps ?? NaN,
      climbSigma: track.climb_sigma_mps ?? NaN,
      turn: track.turn_rate_dps ?? NaN,
      turnSigma: track.turn_sigma_dps ?? NaN,
      modes: track.modes ?? [],
    };
    const rule = track.rule ?? "";
    app.details(track.number, track.reference_time_ns, shares, track.nis ?? NaN, { facts, rule, why: whyOf(track), motion });
  }

  /** @param {App} app @param {any} status */
  status(app, status) {
    app.historyFrom = status.history?.from_s ?? 0;
    app.liveTime = Math.max(app.liveTime, status.history?.to_s ?? 0);
    app.fusion = status.fusion;
    app.dataOffset = status.data_offset_s ?? NaN;
    app.unexplainedOffset = status.unexplained_offset_s ?? NaN;
    app.isReplay = status.replay ?? false;
    app.learn({
      time: status.time_s,
      sources: status.sources.map((/** @type {any} */ source) => ({
        ...sourceOf(source),
        ...app.siteOf(source.number),
      })),
      alarmEvents: status.alarm_events,
      alarms: status.alarms.map((/** @type {any} */ alarm) => ({
        id: alarm.id,
        source: alarm.source ?? -1,
        acknowledged: alarm.acknowledged && { operator: alarm.acknowledged.operator, time: alarm.acknowledged.time_s },
        shelved: alarm.shelved && { operator: alarm.shelved.operator, until: alarm.shelved.until_s },
        code: alarm.code,
        severity: alarm.severity,
        text: alarm.text,
        remedy: alarm.remedy ?? "",
        raised: alarm.raised_s,
        process: alarm.process ?? "",
        times: alarm.times,
        cleared: alarm.event === "cleared",
      })),
      orders: (status.orders ?? []).map((/** @type {any} */ order) => ({
        number: order.number,
        state: order.state,
        text: order.text,
        order: order.order,
        operator: order.operator,
        changed: order.changed_s,
        ends: order.ends_s ?? 0,
      })),
      stages: status.latency.map((/** @type {any} */ stage) => ({
        name: stage.stage,
        count: stage.count,
        p50: stage.p50_us,
        p99: stage.p99_us,
        p999: stage.p999_us,
        max: stage.max_us,
        buckets: stage.buckets,
      })),
      processes: status.processes.map((/** @type {any} */ process) => ({
        name: process.name,
        kind: process.kind,
        state: process.state,
        pid: process.pid,
        restarts: process.restarts,
        heard: process.heard_s ?? 0,
        note: [process.note, process.refused && `refused: ${process.refused}`].filter(Boolean).join(" · "),
        figures: process.figures.map((/** @type {unknown[]} */ [name, value]) => [String(name), String(value)]),
      })),
      system: status.system.map((/** @type {unknown[]} */ [name, value]) => [String(name), String(value)]),
    });
  }
}

/**
 * Address as people read it: hexadecimal for aircraft, the MMSI's digits for ships.
 * @param {number} address @param {number} kind
 */
function addressText(address, kind) {
  return kind === MMSI ? String(address).padStart(9, "0") : address.toString(16).padStart(6, "0").toUpperCase();
}

/** @param {any} source @returns {import("./panels.js").Source} */
function sourceOf(source) {
  return {
    number: source.number,
    name: source.name,
    kind: source.kind,
    adapter: source.adapter ?? "",
    rate: source.rate_hz ?? 0,
    lastHeard: source.heard_s ?? 0,
    lost: source.lost ?? 0,
    rejected: Object.entries(source.rejected ?? {}).filter(([, count]) => count > 0),
    refused: source.refused ?? "",
    dependsOn: source.depends_on ?? [],
    errors: source.errors ?? "",
    clockOffset: source.clock_offset_s ?? NaN,
    east: source.site_m?.[0] ?? NaN,
    north: source.site_m?.[1] ?? NaN,
    offset: source.registration?.offset_m ?? [0, 0],
  };
}
