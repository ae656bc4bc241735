/** What labels say: up to three lines of fields, and the texts of heights, speeds and rates. */

import { bearing, KNOT_MPS } from "./geodesy.js";
import { ALERTS, nameOf } from "./picture.js";

const HUNDRED_FEET_M = 30.48;
export const LINE_HEIGHT = 13;
export const FONT = '11.5px "DejaVu Sans Mono", ui-monospace, Menlo, Consolas, monospace';

/**
 * Lines of a label where the configuration has no others (`[display.labels]`).
 * @type {readonly (readonly string[])[]}
 */
export const LABEL_LINES = [["name"], ["level", "speed"], ["sources", "main", "type"]];

/** @type {Record<string, (track: import("./picture.js").Track, units: string, mainName: string) => string>} */
const FIELDS = {
  name: nameOf,
  callsign: (track) => track.callsign,
  address: (track) => track.address,
  code: (track) => track.code,
  number: (track) => `#${track.number}`,
  type: (track) => track.type,
  level: heightText,
  speed: speedText,
  climb: (track, units) => rateText(track, units),
  angle: (track) => angleText(track),
  sources: (track) => String(track.sourceCount),
  main: (_track, _units, mainName) => mainName,
};

/**
 * Lines of a track's label, the most important first. The first line has the size of a group and the alerts.
 * @param {import("./picture.js").Track} track @param {string} units @param {string} mainName
 * @param {readonly (readonly string[])[]} lines Fields of each line.
 * @returns {string[]}
 */
export function labelOf(track, units, mainName, lines = LABEL_LINES) {
  const texts = lines.map((fields) => fields.map((field) => FIELDS[field]?.(track, units, mainName) ?? ""));
  if (track.kind === "group") texts[0].push(`×${track.members}`);
  for (const [bit, word] of ALERTS) if ((track.alerts & bit) !== 0) texts[0].push(word);
  return texts.map((words) => words.filter((word) => word !== "").join(" "));
}

/** Rate of the height: hundreds of feet a minute, or metres a second. @param {import("./picture.js").Track} track @param {string} units */
function rateText(track, units) {
  if (!Number.isFinite(track.height) || !Number.isFinite(track.climb)) return "";
  if (units === "metric") return `${signed(track.climb)}`;
  const rate = Math.round((track.climb * 60) / HUNDRED_FEET_M);
  return `${rate < 0 ? "−" : "+"}${String(Math.abs(rate)).padStart(2, "0")}`;
}

/** Direction of the motion, degrees. @param {import("./picture.js").Track} track */
function angleText(track) {
  if (!track.knowsVelocity || Math.hypot(track.speedEast, track.speedNorth) < 0.5) return "---°";
  return `${String(Math.round(bearing(track.speedEast, track.speedNorth)) % 360).padStart(3, "0")}°`;
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
  return Number.isFinite(track.height) && Number.isFinite(track.climb) ? `${signed(track.climb)} m/s` : "–";
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

/** Ground speed; dashes if it is unknown. @param {import("./picture.js").Track} track @param {string} units */
export function speedText(track, units) {
  if (!track.knowsVelocity) return "---";
  const speed = Math.hypot(track.speedEast, track.speedNorth);
  if (units === "metric") return `${Math.round(speed)}m/s`;
  return (speed / KNOT_MPS).toFixed(track.isShip || units === "maritime" ? 1 : 0);
}
