/**
 * Labels: what they say, and where they go.
 *
 * A label has up to three lines. Where labels would cover one another, each tries eight places round its symbol, its
 * last one first so that nothing jumps, then a shorter form, and is left out where not even its name has room. A grid
 * of cells of the screen remembers what is taken: the cost is that of the labels, not of their pairs.
 */

import { KNOT_MPS } from "./geodesy.js";
import { ALERTS, nameOf } from "./picture.js";

const CELL = 6;
const HUNDRED_FEET_M = 30.48;
/** Pixels between symbol and label. */
const GAP = 12;
/** Places round the symbol: direction of the label's middle, in the order in which they are tried. */
const PLACES = [
  [1, -1],
  [1, 1],
  [-1, -1],
  [-1, 1],
  [1, 0],
  [-1, 0],
  [0, -1],
  [0, 1],
];

export const LINE_HEIGHT = 13;
export const FONT = '11.5px "DejaVu Sans Mono", ui-monospace, Menlo, Consolas, monospace';

/**
 * Lines of a track's label, the most important first.
 * @param {import("./picture.js").Track} track @param {string} units @param {string} mainName
 * @returns {string[]}
 */
export function labelOf(track, units, mainName) {
  const first = [nameOf(track)];
  if (track.kind === "group") first.push(`×${track.members}`);
  for (const [bit, word] of ALERTS) if ((track.alerts & bit) !== 0) first.push(word);
  const second = `${heightText(track, units)} ${speedText(track, units)}`.trimStart();
  const third = [`${track.sourceCount}`, mainName];
  if (track.type) third.push(track.type);
  return [first.join(" "), second, third.join(" ")];
}

/**
 * Height with the direction of its change. An altitude by the pressure of the region is marked `A`; a height that no
 * transponder has stated is marked `~`: it is calculated. A ship has none.
 * @param {import("./picture.js").Track} track @param {string} units
 */
export function heightText(track, units) {
  if (track.isShip || units === "maritime") return "";
  if (track.onGround) return "GND";
  if (!Number.isFinite(track.height)) return "---";
  const change = track.climbs ? "↑" : track.sinks ? "↓" : " ";
  const mark = track.isAltitude ? "A" : track.isLevel ? "" : "~";
  if (units === "metric") return `${mark}${Math.round(track.height)}m${change}`;
  return `${mark}${levelText(levelOf(track))}${change}`;
}

/** Height in hundreds of feet. @param {{height: number}} track */
export function levelOf(track) {
  return track.height / HUNDRED_FEET_M;
}

/** Level as it is written: three digits. @param {number} level */
export function levelText(level) {
  const rounded = Math.round(level);
  return `${rounded < 0 ? "−" : ""}${String(Math.abs(rounded)).padStart(3, "0")}`;
}

/**
 * Motion of a selected track; NaN: unknown.
 * @typedef {object} Motion
 * @property {number} climb Rate of the height, metres per second. @property {number} climbSigma
 * @property {number} turn Degrees per second, positive to the right. @property {number} turnSigma
 * @property {{mode: string, probability: number}[]} modes The most probable models of the plane and of the vertical.
 */

/** @type {Motion} */
export const NO_MOTION = { climb: NaN, climbSigma: NaN, turn: NaN, turnSigma: NaN, modes: [] };

/** Rate of climb with its error. @param {{height: number, climb: number}} track @param {Motion} motion */
export function climbText(track, motion) {
  if (Number.isFinite(motion.climb)) return `${signed(motion.climb)} ± ${motion.climbSigma.toFixed(1)} m/s`;
  return Number.isFinite(track.height) ? `${signed(track.climb)} m/s` : "–";
}

/** Rate of turn with its error. @param {Motion} motion */
export function turnText(motion) {
  if (!Number.isFinite(motion.turn)) return "–";
  const side = motion.turn > 0 ? "right" : "left";
  const isNoise = Math.abs(motion.turn) < motion.turnSigma;
  return `${Math.abs(motion.turn).toFixed(1)} ± ${motion.turnSigma.toFixed(1)} °/s${isNoise ? "" : ` ${side}`}`;
}

/** Probable models of the motion. @param {Motion} motion */
export function modesText(motion) {
  const text = motion.modes.map(
    ({ mode, probability }) => `${mode.replaceAll("_", " ")} ${Math.round(100 * probability)} %`,
  );
  return text.join(", ") || "–";
}

/** A number with one decimal; what rounds to zero has no sign. @param {number} value */
function signed(value) {
  const text = value.toFixed(1);
  return text === "-0.0" ? "0.0" : text.replace("-", "−");
}

/** Ground speed. @param {import("./picture.js").Track} track @param {string} units */
export function speedText(track, units) {
  const speed = Math.hypot(track.speedEast, track.speedNorth);
  if (units === "metric") return `${Math.round(speed)}m/s`;
  return (speed / KNOT_MPS).toFixed(track.isShip || units === "maritime" ? 1 : 0);
}

export class LabelGrid {
  /** @param {number} width @param {number} height */
  constructor(width, height) {
    this.columns = Math.ceil(width / CELL) + 1;
    this.rows = Math.ceil(height / CELL) + 1;
    this.taken = new Uint8Array(this.columns * this.rows);
  }

  clear() {
    this.taken.fill(0);
  }

  /**
   * Whether a box is free; takes it if so.
   * @param {number} x @param {number} y @param {number} width @param {number} height
   */
  take(x, y, width, height) {
    const left = Math.max(0, Math.floor(x / CELL));
    const right = Math.min(this.columns - 1, Math.floor((x + width) / CELL));
    const top = Math.max(0, Math.floor(y / CELL));
    const bottom = Math.min(this.rows - 1, Math.floor((y + height) / CELL));
    for (let row = top; row <= bottom; row++)
      for (let column = left; column <= right; column++) if (this.taken[row * this.columns + column]) return false;
    this.mark(x, y, width, height);
    return true;
  }

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  mark(x, y, width, height) {
    const left = Math.max(0, Math.floor(x / CELL));
    const right = Math.min(this.columns - 1, Math.floor((x + width) / CELL));
    const top = Math.max(0, Math.floor(y / CELL));
    const bottom = Math.min(this.rows - 1, Math.floor((y + height) / CELL));
    for (let row = top; row <= bottom; row++)
      this.taken.fill(1, row * this.columns + left, row * this.columns + Math.max(left, right + 1));
  }
}

/**
 * @typedef {object} Placed
 * @property {import("./picture.js").Track} track
 * @property {number} x @property {number} y Its symbol.
 * @property {number} left @property {number} top @property {number} width @property {number} height
 * @property {number} lines How many of its lines are shown.
 */

/**
 * Finds a label's place; `null` where there is none.
 * @param {LabelGrid | null} grid No grid: labels may cover each other.
 * @param {import("./picture.js").Track} track @param {number} x @param {number} y
 * @param {number} lines @param {number} glyph Width of a character, pixels.
 * @returns {Placed | null}
 */
export function place(grid, track, x, y, lines, glyph) {
  for (let shown = Math.min(lines, track.label.length); shown > 0; shown--) {
    let longest = 0;
    for (let k = 0; k < shown; k++) longest = Math.max(longest, track.label[k].length);
    const width = longest * glyph + 4;
    const height = shown * LINE_HEIGHT + 1;
    for (let turn = 0; turn < PLACES.length; turn++) {
      const number = (track.place + turn) % PLACES.length;
      const [right, down] = PLACES[number];
      const left = right > 0 ? x + GAP : right < 0 ? x - GAP - width : x - width / 2;
      const top = down > 0 ? y + GAP - 6 : down < 0 ? y - GAP + 6 - height : y - height / 2;
      if (!grid || grid.take(left, top, width, height)) {
        track.place = number;
        return { track, x, y, left, top, width, height, lines: shown };
      }
      if (!grid) break;
    }
  }
  return null;
}
