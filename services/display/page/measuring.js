/**
 * Measuring lines: range, bearings, time to go, and the closest point of approach of two tracks. An end that is put on a
 * track stays on it.
 */

import { KNOT_MPS, FOOT_M, NAUTICAL_MILE_M, pathBetween } from "./geodesy.js";
import { FONT } from "./labels.js";
import { overlap } from "./placement.js";

/** Most lines; a further one takes the place of the oldest. */
const LINES_MAX = 8;
/** Pixels from a line within which it is meant. */
const NEAR = 9;
/** Height of a row of text, pixels. */
const ROW = 14;
/** Slower motion leads nowhere, metres per second. */
const SPEED_MIN_MPS = 0.5;

/** @typedef {import("./picture.js").Track} Track */
/** @typedef {import("./picture.js").Picture} Picture */
/** @typedef {import("./geodesy.js").Place} Place */
/** @typedef {import("./placement.js").Box} Box */
/** End of a line: metres, and the track that it stays on; -1: none. @typedef {{east: number, north: number, track: number}} End */
/** @typedef {{from: End, to: End}} Line */
/** @typedef {{line: Line, texts: string[], ends: [[number, number], [number, number]], box: Box}} Note */

export class Measuring {
  constructor() {
    /** @type {Line[]} */
    this.lines = [];
    /** What was painted last. @type {Note[]} */
    this.notes = [];
  }

  /** Begins a line. @param {End} from */
  begin(from) {
    this.lines.push({ from, to: { ...from } });
    if (this.lines.length > LINES_MAX) this.lines.shift();
  }

  /** Leads the newest line somewhere. @param {End} to */
  lead(to) {
    const line = this.lines.at(-1);
    if (line) line.to = to;
  }

  /** Takes the newest line away. */
  drop() {
    this.lines.pop();
  }

  /** Takes the line at a pixel away. @param {number} x @param {number} y */
  dropAt(x, y) {
    const near = this.notes.find(
      ({ ends, box }) => distanceTo(x, y, ends) < NEAR || overlap(box, { left: x, top: y, width: 1, height: 1 }),
    );
    if (near) this.lines = this.lines.filter((line) => line !== near.line);
  }

  /**
   * Lines of this picture with their texts and where these are.
   * @param {CanvasRenderingContext2D} ctx
   * @param {{view: import("./view.js").View, picture: Picture, settings: {units: string}, origin: Place,
   *   declination: number}} scene
   */
  layOut(ctx, { view, picture, settings, origin, declination }) {
    ctx.font = FONT;
    this.notes = [];
    for (const line of this.lines) {
      const tracks = [line.from, line.to].map((end) => moved(end, picture));
      const texts = textsOf(line, tracks[0], tracks[1], origin, settings.units, declination);
      /** @type {[[number, number], [number, number]]} */
      const ends = [view.toScreen(line.from.east, line.from.north), view.toScreen(line.to.east, line.to.north)];
      const width = Math.max(...texts.map((text) => ctx.measureText(text).width)) + 8;
      const height = texts.length * ROW + 3;
      const middle = [(ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2];
      const box = {
        left: Math.max(0, Math.min(view.width - width, middle[0] + 6)),
        top: Math.max(0, Math.min(view.height - height, middle[1] - height - 4)),
        width,
        height,
      };
      for (const other of this.notes) if (overlap(box, other.box)) box.top = other.box.top + other.box.height + 2;
      this.notes.push({ line, texts, ends, box });
    }
  }

  /** @param {CanvasRenderingContext2D} ctx @param {import("./colours.js").Colours} colours */
  paint(ctx, colours) {
    ctx.font = FONT;
    ctx.lineWidth = 1.5;
    ctx.strokeStyle = colours.measure;
    ctx.setLineDash([6, 3]);
    ctx.beginPath();
    for (const { ends } of this.notes) {
      ctx.moveTo(...ends[0]);
      ctx.lineTo(...ends[1]);
    }
    ctx.stroke();
    ctx.setLineDash([]);
    for (const { texts, box } of this.notes) {
      ctx.fillStyle = colours.halo;
      ctx.fillRect(box.left, box.top, box.width, box.height);
      ctx.fillStyle = colours.measure;
      texts.forEach((text, k) => ctx.fillText(text, box.left + 4, box.top + (k + 1) * ROW - 3));
    }
  }
}

/** Moves an end to where its track is. @param {End} end @param {Picture} picture @returns {Track | null} */
function moved(end, picture) {
  const track = picture.system.get(end.track) ?? null;
  if (track) Object.assign(end, { east: track.east, north: track.north });
  return track;
}

/**
 * What a line says. @param {{from: {east: number, north: number}, to: {east: number, north: number}}} line
 * @param {Track | null} from @param {Track | null} to @param {Place} origin @param {string} units
 * @param {number} declination Of magnetic north, degrees east; NaN: unknown.
 */
export function textsOf(line, from, to, origin, units, declination) {
  const height = (/** @type {Track | null} */ track) => (track && Number.isFinite(track.height) ? track.height : 0);
  const path = pathBetween(origin, line.from, line.to, height(from), height(to));
  if (!path) return ["beyond the horizon"];
  const texts = [`${bearings(path.there, path.back, "T")}  ${distanceText(path.range, units)}`];
  if (Number.isFinite(declination)) texts.push(bearings(path.there - declination, path.back - declination, "M"));
  if (from && to) texts.push(approachText(from, to, units));
  const alone = from && to ? null : (from ?? to);
  if (alone) texts.push(toGoText(alone, path.range, units));
  return texts;
}

/** @param {number} there @param {number} back @param {string} north T: true, M: magnetic. */
function bearings(there, back, north) {
  return `${bearingText(there)}${north} / ${bearingText(back)}${north}`;
}

/** Bearing with one decimal: 094.3°. @param {number} degrees */
export function bearingText(degrees) {
  const tenths = (Math.round(10 * degrees) + 3600) % 3600;
  return `${(tenths / 10).toFixed(1).padStart(5, "0")}°`;
}

/** Distance: nautical miles or kilometres, and metres below two kilometres. @param {number} metres @param {string} units */
export function distanceText(metres, units) {
  if (metres < 2000) return `${metres.toFixed(0)} m`;
  return units === "metric" ? `${(metres / 1000).toFixed(2)} km` : `${(metres / NAUTICAL_MILE_M).toFixed(2)} NM`;
}

/** @param {number} mps @param {string} units */
function rateText(mps, units) {
  return units === "metric" ? `${mps.toFixed(0)} m/s` : `${(mps / KNOT_MPS).toFixed(0)} kt`;
}

/** Minutes and seconds: 3:05. @param {number} seconds */
function minutes(seconds) {
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

/** Time in which a track flies a distance at its speed. @param {Track} track @param {number} range @param {string} units */
function toGoText(track, range, units) {
  const speed = Math.hypot(track.speedEast, track.speedNorth);
  return speed < SPEED_MIN_MPS ? "stands still" : `${minutes(range / speed)} to go at ${rateText(speed, units)}`;
}

/** Closest point of approach, if both go straight on. @param {Track} from @param {Track} to @param {string} units */
function approachText(from, to, units) {
  const { time, distance } = approach(from, to);
  const when = time > 0 ? `CPA ${distanceText(distance, units)} in ${minutes(time)}` : "no approach";
  const apart = Math.abs(from.height - to.height);
  if (!Number.isFinite(apart)) return when;
  return `${when}  Δ ${units === "metric" ? `${apart.toFixed(0)} m` : `${(apart / FOOT_M).toFixed(0)} ft`}`;
}

/**
 * When two tracks are nearest to each other, seconds ahead, and how near in the plane, metres, if both go straight on.
 * Without motion relative to each other the time is 0. Negative: it was then.
 * @param {Track} from @param {Track} to
 */
export function approach(from, to) {
  const [east, north] = [to.east - from.east, to.north - from.north];
  const [vEast, vNorth] = [to.speedEast - from.speedEast, to.speedNorth - from.speedNorth];
  const square = vEast * vEast + vNorth * vNorth;
  const time = square < SPEED_MIN_MPS * SPEED_MIN_MPS ? 0 : -(east * vEast + north * vNorth) / square;
  return { time, distance: Math.hypot(east + time * vEast, north + time * vNorth) };
}

/** Distance of a pixel from a line. @param {number} x @param {number} y @param {[[number, number], [number, number]]} ends */
function distanceTo(x, y, [[fromX, fromY], [toX, toY]]) {
  const [dx, dy] = [toX - fromX, toY - fromY];
  const square = dx * dx + dy * dy;
  const part = square > 0 ? Math.min(1, Math.max(0, ((x - fromX) * dx + (y - fromY) * dy) / square)) : 0;
  return Math.hypot(x - fromX - part * dx, y - fromY - part * dy);
}

/**
 * Measures without a mouse: between the selected tracks, or from a selected one to the middle of the map.
 * @param {import("./app.js").App} app
 */
export function measureSelected(app) {
  const tracks = [...app.selected].flatMap((number) => app.picture.system.get(number) ?? []);
  if (tracks.length === 0) return;
  const ends = tracks.map(({ east, north, number }) => ({ east, north, track: number }));
  if (ends.length === 1) ends.push({ east: app.view.east, north: app.view.north, track: -1 });
  app.measure ??= new Measuring();
  for (const to of ends.slice(1)) {
    app.measure.begin({ ...ends[0] });
    app.measure.lead(to);
  }
  app.dirty = true;
}
