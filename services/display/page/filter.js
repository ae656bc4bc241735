/**
 * Filter of the tracks: words, all of which a track must match. A word that cannot be read hides nothing; it comes back
 * as a fault, with the nearest word that can be read.
 */

import { levelOf } from "./labels.js";
import { sourcesOf } from "./picture.js";

/** @typedef {import("./picture.js").Track} Track */
/** @typedef {(track: Track) => boolean} Test */
/** @typedef {{word: string, advice: string}} Fault */

/** Keys of comparisons, and what each reads. @type {Record<string, (track: Track) => number>} */
const FIGURES = {
  fl: levelOf,
  kt: (track) => Math.hypot(track.speedEast, track.speedNorth) * (3600 / 1852),
  sources: (track) => track.sourceCount,
  members: (track) => track.members,
};
const STATES = ["confirmed", "tentative", "coasted"];
const KINDS = ["single", "group"];
/** Keys of values. */
const NAMED = ["state", "kind", "main", "source", "type"];
/** Words that other displays have for the keys. @type {Record<string, string>} */
const OTHERS = {
  alt: "fl",
  altitude: "fl",
  height: "fl",
  level: "fl",
  gs: "kt",
  knots: "kt",
  speed: "kt",
  status: "state",
  aircraft: "type",
};

/**
 * Reads a filter. Words are parted by blanks: a text that callsign, address, code or number contain; `/expression/` on
 * the same; `fl>100`, `kt<200`, `sources>2`; `state=coasted`, `kind=group`, `main=NAME`, `source=NAME` (it contributes),
 * `type=A320`; a minus before a word turns it round.
 * @param {string} text
 * @param {(source: number) => string} sourceName
 * @param {string[]} [sources] Names of all sources, as far as known.
 * @returns {{matches: Test, faults: Fault[]}}
 */
export function readFilter(text, sourceName, sources = []) {
  /** @type {Test[]} */
  const tests = [];
  /** @type {Fault[]} */
  const faults = [];
  for (const word of text.split(/\s+/).filter((part) => part !== "")) {
    const isTurned = word.startsWith("-") && word.length > 1;
    const test = wordTest(isTurned ? word.slice(1) : word, sourceName, sources);
    if (typeof test !== "function") faults.push({ word, advice: (isTurned && test ? "-" : "") + test });
    else tests.push(isTurned ? (track) => !test(track) : test);
  }
  return { matches: (track) => tests.every((test) => test(track)), faults };
}

/**
 * Test of one word; where there is none, the nearest word, or nothing.
 * @param {string} word @param {(source: number) => string} sourceName @param {string[]} sources
 * @returns {Test | string}
 */
function wordTest(word, sourceName, sources) {
  const pattern = /^\/(.+)\/$/.exec(word);
  if (pattern) return expressionTest(pattern[1]);
  const parts = /^([^<>=]*)([<>=])(.*)$/.exec(word);
  if (!parts) {
    const wanted = word.toLowerCase();
    return (track) => namesOf(track).toLowerCase().includes(wanted);
  }
  const [given, sign, value] = [parts[1].toLowerCase(), parts[2], parts[3]];
  const key = sign === "=" ? [...NAMED, ...Object.keys(FIGURES)] : Object.keys(FIGURES);
  if (!key.includes(given)) {
    const meant = OTHERS[given] ?? nearest(given, key);
    return meant && `${meant}${sign}${value}`;
  }
  if (given in FIGURES) {
    const bound = value === "" ? NaN : Number(value);
    if (!Number.isFinite(bound)) return `${given}${sign}${parseFloat(value.replace(/^[^\d-]+/, "")) || 100}`;
    const figure = FIGURES[given];
    if (sign === "<") return (track) => figure(track) < bound;
    if (sign === ">") return (track) => figure(track) > bound;
    return (track) => Math.round(figure(track)) === bound;
  }
  return namedTest(given, value.toLowerCase(), sourceName, sources);
}

/** @param {string} expression @returns {Test | string} */
function expressionTest(expression) {
  try {
    const read = new RegExp(expression, "i");
    return (track) =>
      namesOf(track)
        .split(" ")
        .some((name) => read.test(name));
  } catch {
    return "";
  }
}

/**
 * @param {string} key One of `NAMED`. @param {string} wanted @param {(source: number) => string} sourceName
 * @param {string[]} sources
 * @returns {Test | string}
 */
function namedTest(key, wanted, sourceName, sources) {
  const known = key === "state" ? STATES : key === "kind" ? KINDS : key === "type" ? [] : sources;
  if (wanted === "" || (known.length > 0 && !known.some((word) => word.toLowerCase() === wanted))) {
    const meant = nearest(wanted, known);
    return meant && `${key}=${meant}`;
  }
  const called = (/** @type {number} */ source) => sourceName(source).toLowerCase() === wanted;
  if (key === "main") return (track) => called(track.source);
  if (key === "source") return (track) => sourcesOf(track).some(called);
  if (key === "state") return (track) => track.state === wanted;
  if (key === "kind") return (track) => track.kind === wanted;
  return (track) => track.type.toLowerCase() === wanted;
}

/** What a text is looked for in. @param {Track} track */
function namesOf(track) {
  return `${track.callsign} ${track.address} ${track.code} #${track.number}`;
}

/**
 * The most similar word, if any is similar: at most every third letter differs, and the first does not where nothing
 * else is the same.
 * @param {string} word @param {string[]} known
 */
export function nearest(word, known) {
  let [best, least] = ["", Infinity];
  for (const one of known) {
    const away = one.toLowerCase().startsWith(word) && word.length > 1 ? 0.5 : distance(word, one.toLowerCase());
    if (away < least && away <= Math.max(1, Math.max(word.length, one.length) / 3)) [best, least] = [one, away];
  }
  return best;
}

/** Letters to insert, to leave out, to change or to exchange with the next (restricted Damerau-Levenshtein). @param {string} a @param {string} b */
function distance(a, b) {
  const rows = [Array.from({ length: b.length + 1 }, (_, k) => k)];
  for (let i = 1; i <= a.length; i++) {
    const row = [i];
    for (let j = 1; j <= b.length; j++) {
      const change = rows[i - 1][j - 1] + Number(a[i - 1] !== b[j - 1]);
      row.push(Math.min(rows[i - 1][j] + 1, row[j - 1] + 1, change));
      if (i > 1 && j > 1 && a[i - 1] === b[j - 2] && a[i - 2] === b[j - 1])
        row[j] = Math.min(row[j], rows[i - 2][j - 2] + 1);
    }
    rows.push(row);
  }
  return rows[a.length][b.length];
}
