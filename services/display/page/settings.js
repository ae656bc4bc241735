/**
 * Everything that makes up what is seen, kept in the page's address (after the #), so that an address shows a colleague
 * the same. A setting that has its default is left out.
 */

import { ofLayers } from "./layers.js";

/**
 * @typedef {OwnSettings & Record<import("./layers.js").LayerKey, boolean>} Settings With the layers that are shown.
 *
 * @typedef {object} OwnSettings
 * @property {number} e @property {number} n Middle of the map, metres.
 * @property {number} scale Metres a pixel; 0: so that all tracks are seen.
 * @property {number} up Bearing that points up, degrees.
 * @property {string} theme night, day or print
 * @property {number} labels Most lines of a label: 0 (none) to 3.
 * @property {boolean} declutter Leave out and shorten labels that would cover others.
 * @property {number} vector Length of speed vectors, seconds.
 * @property {number} trail Length of trails, seconds; -1: all that is kept.
 * @property {boolean} trails Trails of all tracks, not of the selected alone.
 * @property {number} sigma Size of the accuracy ellipses in standard deviations; 0: none.
 * @property {string} colour state, height, source (how many contribute) or main (main source)
 * @property {string} units aviation, metric, or maritime (as aviation, and without levels)
 * @property {boolean} sensors Sensor tracks.
 * @property {boolean} coverage Outline of each source's coverage.
 * @property {string} pd Name of the source whose probability of detection is shown; "": none.
 * @property {boolean} handovers Rings round tracks with another main source.
 * @property {boolean} rings Range rings about the origin. @property {boolean} siterings The same about each sensor.
 * @property {string} maps Layers of the map from the lowest up, separated by "|"; a minus switches one off.
 * @property {boolean} biases Sites with learned offsets.
 * @property {boolean} dim Map dimmed.
 * @property {boolean} inview Table shows only what is on the map.
 * @property {boolean} isolate Only selected tracks are shown.
 * @property {boolean} follow Map follows the selected track.
 * @property {string} filter What tracks must match.
 * @property {string} letters What a letter does that is pressed on the map: it begins a search (search), or is a key of
 *   its own (keys).
 * @property {number} size Size of text and symbols, per cent.
 * @property {string} sound Severity from which alarms sound; off: none.
 * @property {string} sort Column of the table, with "-" before it for falling order.
 * @property {string} tab Panel beside the map; "": none.
 * @property {string} sel Selected system tracks, separated by commas.
 * @property {number} at Time shown, seconds UTC; 0: live.
 * @property {number} speed Speed of play; 0: paused.
 */

/** @type {Readonly<Settings>} */
export const DEFAULTS = Object.freeze({
  e: 0,
  n: 0,
  scale: 0,
  up: 0,
  theme: "night",
  labels: 2,
  declutter: true,
  vector: 60,
  trail: 60,
  trails: true,
  sigma: 0,
  colour: "state",
  units: "aviation",
  sensors: false,
  ...ofLayers(({ isOn }) => isOn ?? false),
  rings: true,
  siterings: false,
  maps: "",
  biases: false,
  coverage: false,
  handovers: false,
  pd: "",
  dim: false,
  inview: false,
  isolate: false,
  follow: false,
  filter: "",
  letters: "search",
  size: 100,
  sound: "off",
  sort: "name",
  tab: "tracks",
  sel: "",
  at: 0,
  speed: 0,
});

/** Words that a setting may be; a word that is not among them is as if it were not there. */
export const CHOICES = Object.freeze({
  theme: ["night", "day", "print"],
  colour: ["state", "height", "source", "main"],
  units: ["aviation", "metric", "maritime"],
  letters: ["search", "keys"],
  sound: ["off", "critical", "major", "warning"],
  tab: ["", "tracks", "track", "sources", "alarms", "latency", "system", "view"],
});

/**
 * Settings that an address holds.
 * @param {string} hash @returns {Settings}
 */
export function read(hash) {
  /** @type {Record<string, string | number | boolean>} */
  const settings = { ...DEFAULTS };
  for (const [key, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
    const before = Object.hasOwn(DEFAULTS, key) ? settings[key] : undefined;
    if (typeof before === "number") {
      const value = Number(text);
      if (text !== "" && Number.isFinite(value)) settings[key] = value;
    } else if (typeof before === "boolean") {
      settings[key] = text === "1";
    } else if (before !== undefined) {
      const choices = /** @type {Record<string, string[]>} */ (CHOICES)[key];
      if (!choices || choices.includes(text)) settings[key] = text;
    }
  }
  return /** @type {Settings} */ (/** @type {unknown} */ (settings));
}

/**
 * Address that holds the settings.
 * @param {Settings} settings
 */
export function write(settings) {
  const parameters = new URLSearchParams();
  for (const [key, value] of Object.entries(settings)) {
    if (value === /** @type {Record<string, unknown>} */ (DEFAULTS)[key]) continue;
    parameters.set(key, typeof value === "boolean" ? (value ? "1" : "0") : String(value));
  }
  return `#${parameters}`;
}
