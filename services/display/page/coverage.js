/**
 * Coverage and probability of detection of each source, counted by the server since its start: in polar cells about the
 * sensor's site.
 */

import { dayAndClock, h } from "./dom.js";
import { ofWindow } from "./window.js";

/** Share of the reports owed from which a cell belongs to the coverage, and tries from which that is known. */
const COVERED = 0.5;
const TRIES_MIN = 5;
/** Time between two requests while coverage is shown, milliseconds. */
const ASK_EVERY_MS = 10_000;

/** @typedef {{sector: number, ring: number, seen: number, hits: number, tries: number}} Cell */

/** Probability of detection in a cell; NaN where too little is known. @param {Cell} cell */
export function probabilityOf({ hits, tries }) {
  return tries >= TRIES_MIN ? Math.min(1, hits / tries) : NaN;
}

export class Coverage {
  constructor() {
    /** Start of the counting, seconds UTC; 0: unknown. */
    this.since = 0;
    this.sectors = 72;
    this.ring = 10_000;
    /** @type {Map<number, {name: string, east: number, north: number, cells: Cell[]}>} */
    this.sources = new Map();
    this.due = 0;
  }

  /** Asks the server when it is time. @param {number} now Milliseconds. @param {() => void} changed */
  async refresh(now, changed) {
    if (now < this.due) return;
    this.due = now + ASK_EVERY_MS;
    const answer = await fetch(ofWindow("api/coverage.json"));
    if (!answer.ok) return;
    this.take(await answer.json());
    changed();
  }

  /** @param {any} message */
  take(message) {
    this.since = message.since_s ?? 0;
    this.sectors = message.sectors;
    this.ring = message.ring_m;
    this.sources.clear();
    for (const { number, name, site_m, cells } of message.sources)
      this.sources.set(number, {
        name,
        east: site_m[0],
        north: site_m[1],
        cells: cells.map((/** @type {number[]} */ [sector, ring, seen, hits, tries]) => ({ sector, ring, seen, hits, tries })),
      });
  }

  /**
   * Outline of a source's coverage, metres from its site: per sector the far edge of the farthest cell that the source
   * covers. Cells that no other source can judge count if the source has seen targets there.
   * @param {number} source @returns {[number, number][]}
   */
  outline(source) {
    const reach = new Float64Array(this.sectors);
    for (const cell of this.sources.get(source)?.cells ?? []) {
      const probability = probabilityOf(cell);
      const isCovered = Number.isNaN(probability) ? cell.seen >= 1 : probability >= COVERED;
      if (isCovered) reach[cell.sector] = Math.max(reach[cell.sector], (cell.ring + 1) * this.ring);
    }
    /** @type {[number, number][]} */
    const points = [];
    reach.forEach((distance, sector) => {
      if (distance === 0) {
        // Nothing is known there: the outline returns to the site.
        if (points.length > 0 && points[points.length - 1].some((value) => value !== 0)) points.push([0, 0]);
        return;
      }
      for (const edge of [sector, sector + 1]) {
        const angle = (edge / this.sectors) * 2 * Math.PI;
        points.push([distance * Math.sin(angle), distance * Math.cos(angle)]);
      }
    });
    return points;
  }
}

/** Colour of a probability of detection. @param {number} probability NaN: unknown. */
export function probabilityColour(probability) {
  if (Number.isNaN(probability)) return "#8090a0";
  return probability >= 0.9 ? "#2e9e57" : probability >= 0.7 ? "#c9b22c" : probability >= 0.4 ? "#d97a26" : "#c0392b";
}

/** Lines of the legend: sign, colour, text. @type {[string, string, string][]} */
export const PROBABILITY_LEGEND = [
  ["■", probabilityColour(1), "detected ≥ 90 %"],
  ["■", probabilityColour(0.8), "70 to 90 %"],
  ["■", probabilityColour(0.5), "40 to 70 %"],
  ["■", probabilityColour(0), "below 40 %"],
  ["■", probabilityColour(NaN), "too little known"],
];

/**
 * Outlines of all sources, or the cells of the one called `only`.
 * @param {CanvasRenderingContext2D} ctx @param {import("./view.js").View} view @param {string[]} palette
 * @param {Coverage} coverage @param {string} only
 */
export function paintCoverage(ctx, view, palette, coverage, only) {
  for (const [number, source] of coverage.sources) {
    const isOnly = source.name === only;
    if (isOnly) paintCells(ctx, view, coverage, source);
    if (only !== "" && !isOnly) continue;
    const outline = coverage.outline(number);
    if (outline.length < 3) continue;
    ctx.strokeStyle = ctx.fillStyle = palette[number % palette.length];
    ctx.lineWidth = 1.2;
    const corners = outline.map(([east, north]) => view.toScreen(source.east + east, source.north + north));
    ctx.beginPath();
    for (const [x, y] of corners) ctx.lineTo(x, y);
    ctx.closePath();
    ctx.globalAlpha = 0.05;
    if (!isOnly) ctx.fill();
    ctx.globalAlpha = 0.7;
    ctx.stroke();
    // Each source has its name at another side.
    const [right, up] = [Math.sin(number), Math.cos(number)];
    const along = (/** @type {[number, number]} */ [x, y]) => x * right - y * up;
    const [x, y] = corners.reduce((a, b) => (along(b) > along(a) ? b : a));
    ctx.fillText(source.name, x + 4, y - 4);
    ctx.globalAlpha = 1;
  }
}

/**
 * @param {CanvasRenderingContext2D} ctx @param {import("./view.js").View} view @param {Coverage} coverage
 * @param {{east: number, north: number, cells: Cell[]}} source
 */
function paintCells(ctx, view, coverage, source) {
  const corner = (/** @type {number} */ sector, /** @type {number} */ ring) => {
    const angle = (sector / coverage.sectors) * 2 * Math.PI;
    const range = ring * coverage.ring;
    return view.toScreen(source.east + range * Math.sin(angle), source.north + range * Math.cos(angle));
  };
  ctx.globalAlpha = 0.35;
  for (const cell of source.cells) {
    const { sector, ring } = cell;
    ctx.fillStyle = probabilityColour(probabilityOf(cell));
    ctx.beginPath();
    for (const [s, r] of [[sector, ring], [sector, ring + 1], [sector + 1, ring + 1], [sector + 1, ring]])
      ctx.lineTo(...corner(s, r));
    ctx.fill();
  }
  ctx.globalAlpha = 1;
}

/**
 * Choice of the source whose probability of detection is shown, and the export of all counts.
 * @param {Coverage} coverage @param {import("./panels.js").Source[]} sources @param {string} pd
 * @param {(patch: {pd: string}) => void} set
 */
export function coverageChoice(coverage, sources, pd, set) {
  const names = ["", ...sources.map(({ name }) => name)];
  const choice = h(
    "select",
    { "data-setting": "pd" },
    ...names.map((name) => h("option", { value: name, selected: name === pd }, name || "of no source")),
  );
  choice.addEventListener("change", () => {
    const { value } = /** @type {HTMLSelectElement} */ (choice);
    // A focused choice would hold the panel still.
    choice.blur();
    set({ pd: value });
  });
  const since = coverage.since > 0 ? `counted since ${dayAndClock(coverage.since)} UTC` : "";
  return h(
    "div.pad",
    {},
    h("h2", {}, "Coverage"),
    h("label.setting", {}, "Probability of detection", choice),
    h("p.soft", {}, since, " ", h("a", { href: "api/coverage.geojson", download: "coverage.geojson" }, "GeoJSON of all sources")),
  );
}
