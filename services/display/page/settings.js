/**
 * Everything that makes up what is seen, kept in the page's address (after the #), so that an address shows a colleague
 * the same. A setting that has its default is left out.
 */

import { levelOf } from "./labels.js";
import { sourcesOf } from "./picture.js";

/**
 * @typedef {object} Settings
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
 * @property {string} units aviation or metric
 * @property {boolean} sensors Sensor tracks. @property {boolean} detections
 * @property {boolean} bearings Of direction finders. @property {boolean} areas Wide-area counts and cues.
 * @property {boolean} coverage Outline of each source's coverage.
 * @property {string} pd Name of the source whose probability of detection is shown; "": none.
 * @property {boolean} rings Range rings about the origin. @property {boolean} siterings The same about each sensor.
 * @property {string} maps Layers of the map from the lowest up, separated by "|"; a minus switches one off.
 * @property {boolean} biases Sites with learned offsets.
 * @property {boolean} dim Map dimmed.
 * @property {boolean} inview Table shows only what is on the map.
 * @property {boolean} isolate Only selected tracks are shown.
 * @property {boolean} follow Map follows the selected track.
 * @property {string} filter What tracks must match.
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
  detections: false,
  bearings: false,
  areas: false,
  rings: true,
  siterings: false,
  maps: "",
  biases: false,
  coverage: false,
  pd: "",
  dim: false,
  inview: false,
  isolate: false,
  follow: false,
  filter: "",
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
  units: ["aviation", "metric"],
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

/**
 * Test that a filter's text makes. Words are parted by blanks and must all hold: a text that callsign, address, code or
 * number begin with or contain; `/expression/` on the same; `fl>100`, `kt<200`, `sources>2`; `state=coasted`,
 * `kind=group`, `main=NAME`, `source=NAME` (it contributes); a minus before a word turns it round. A word that cannot be
 * read matches nothing.
 * @param {string} text
 * @param {(source: number) => string} sourceName
 * @returns {(track: import("./picture.js").Track) => boolean}
 */
export function filterOf(text, sourceName) {
  const tests = text
    .trim()
    .split(/\s+/)
    .filter((word) => word !== "")
    .map((word) =>
      word.startsWith("-") && word.length > 1 ? not(wordTest(word.slice(1), sourceName)) : wordTest(word, sourceName),
    );
  return (track) => tests.every((test) => test(track));
}

/** @typedef {(track: import("./picture.js").Track) => boolean} Test */

/** @param {Test} test @returns {Test} */
function not(test) {
  return (track) => !test(track);
}

/**
 * @param {string} word
 * @param {(source: number) => string} sourceName
 * @returns {Test}
 */
function wordTest(word, sourceName) {
  const compared = /^(fl|kt|sources|members)(<|>|=)(-?[\d.]+)$/i.exec(word);
  if (compared) {
    const bound = Number(compared[3]);
    const value = figureOf(compared[1].toLowerCase());
    if (compared[2] === "<") return (track) => value(track) < bound;
    if (compared[2] === ">") return (track) => value(track) > bound;
    return (track) => Math.round(value(track)) === bound;
  }
  const named = /^(state|kind|main|source|type)=(.+)$/i.exec(word);
  if (named) {
    const wanted = named[2].toLowerCase();
    const key = named[1].toLowerCase();
    const called = (/** @type {number} */ source) => sourceName(source).toLowerCase() === wanted;
    if (key === "main") return (track) => called(track.source);
    if (key === "source") return (track) => sourcesOf(track).some(called);
    if (key === "state") return (track) => track.state === wanted;
    if (key === "kind") return (track) => track.kind === wanted;
    return (track) => track.type.toLowerCase() === wanted;
  }
  const names = (/** @type {import("./picture.js").Track} */ track) =>
    `${track.callsign} ${track.address} ${track.code} #${track.number}`;
  const pattern = /^\/(.+)\/$/.exec(word);
  if (pattern) {
    try {
      const expression = new RegExp(pattern[1], "i");
      return (track) =>
        names(track)
          .split(" ")
          .some((name) => expression.test(name));
    } catch {
      return () => false;
    }
  }
  const part = word.toLowerCase();
  return (track) => names(track).toLowerCase().includes(part);
}

/** @param {string} name @returns {(track: import("./picture.js").Track) => number} */
function figureOf(name) {
  if (name === "fl") return levelOf;
  if (name === "kt") return (track) => Math.hypot(track.speedEast, track.speedNorth) * (3600 / 1852);
  if (name === "sources") return (track) => track.sourceCount;
  return (track) => track.members;
}
