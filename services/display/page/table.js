/**
 * Table of tracks: sorted, filtered, and only as many rows in the page as there is room for, so that five thousand
 * tracks cost no more than fifty. One row takes the focus; arrows move it.
 */

import { h, setText } from "./dom.js";
import { heightText, speedText } from "./labels.js";
import { isGrave, nameOf } from "./picture.js";

/** @typedef {import("./picture.js").Track} Track */

const ROW = 21;

/** @type {[string, string, string][]} Column, its title, what it says. */
const COLUMNS = [
  ["name", "Track", "Callsign, else code, address or number"],
  ["address", "Addr", "24-bit address"],
  ["code", "Code", "Mode 3/A code, octal"],
  ["height", "Level", "Height: flight level in hundreds of feet, or metres"],
  ["speed", "Speed", "Ground speed: knots, or metres per second"],
  ["sources", "Src", "How many sources contribute"],
  ["main", "Main", "Source with the largest weight"],
];

export class TrackTable {
  /**
   * @param {HTMLElement} parent Element that scrolls.
   * @param {{sortBy: (column: string) => void, select: (number: number, more: boolean) => void,
   *   goTo: (number: number) => void}} on
   */
  constructor(parent, on) {
    this.parent = parent;
    this.on = on;
    this.head = h("div.table-head", { role: "row", "aria-rowindex": 1 });
    COLUMNS.forEach(([column, title, about], k) =>
      this.head.append(
        h(
          "div",
          { role: "columnheader", "aria-colindex": k + 1 },
          h("button", { title: about, "data-column": column, click: () => on.sortBy(column) }, title),
        ),
      ),
    );
    this.body = h("div.table-body", { role: "rowgroup" });
    this.table = h(
      "div",
      { role: "grid", "aria-label": "Tracks", "aria-colcount": COLUMNS.length, "aria-multiselectable": "true" },
      h("div.table-top", { role: "rowgroup" }, this.head),
      this.body,
    );
    this.body.addEventListener("keydown", (event) => this.key(event));
    /** @type {HTMLElement[]} */
    this.rows = [];
    /** @type {Track[]} */
    this.order = [];
    /** Number of the track whose row takes the focus; -1: the first row. */
    this.current = -1;
    parent.addEventListener("scroll", () => this.showRows());
    this.selected = /** @type {Set<number>} */ (new Set());
    this.units = "aviation";
    this.mainName = /** @type {(track: Track) => string} */ (() => "");
  }

  /** Puts the table into its parent. */
  mount() {
    this.parent.replaceChildren(this.table);
  }

  /**
   * @param {Track[]} tracks @param {string} sort @param {Set<number>} selected @param {string} units
   * @param {(track: Track) => string} mainName
   */
  update(tracks, sort, selected, units, mainName) {
    Object.assign(this, { selected, units, mainName });
    const falling = sort.startsWith("-");
    const column = sort.replace(/^-/, "");
    const key = keyOf(column, mainName);
    const keyed = tracks.map((track) => /** @type {const} */ ([key(track), track]));
    keyed.sort(([a, x], [b, y]) => {
      // Unknown values come last in either order.
      const missing = Number(a === "" || Number.isNaN(a)) - Number(b === "" || Number.isNaN(b));
      if (missing !== 0) return missing;
      const less = a < b ? -1 : a > b ? 1 : 0;
      return (falling ? -less : less) || x.number - y.number;
    });
    this.order = keyed.map(([, track]) => track);
    COLUMNS.forEach(([own], k) => {
      const header = this.head.children[k];
      if (own === column) header.setAttribute("aria-sort", falling ? "descending" : "ascending");
      else header.removeAttribute("aria-sort");
    });
    this.table.setAttribute("aria-rowcount", String(this.order.length + 1));
    this.body.style.height = `${this.order.length * ROW}px`;
    this.showRows();
  }

  showRows() {
    const isFocused = this.body.contains(document.activeElement);
    const first = Math.max(0, Math.floor(this.parent.scrollTop / ROW) - 2);
    const count = Math.min(this.order.length - first, Math.ceil(this.parent.clientHeight / ROW) + 4);
    while (this.rows.length < count) this.rows.push(this.newRow());
    const last = first + count - 1;
    const place = this.order.findIndex((track) => track.number === this.current);
    // A row that is not in the page cannot be reached with Tab: the nearest takes its turn.
    const stop = Math.min(last, Math.max(first, place));
    this.rows.forEach((row, k) => {
      const track = this.order[first + k];
      row.hidden = k >= count || !track;
      if (row.hidden) return;
      row.style.top = `${(first + k) * ROW}px`;
      row.dataset.track = String(track.number);
      row.setAttribute("aria-rowindex", String(first + k + 2));
      row.setAttribute("aria-selected", String(this.selected.has(track.number)));
      row.tabIndex = first + k === stop ? 0 : -1;
      const alert = isGrave(track) ? " alert" : "";
      const selected = this.selected.has(track.number) ? " selected" : "";
      const classes = `table-row ${track.state}${alert}${selected}`;
      if (row.className !== classes) row.className = classes;
      const cells = [
        nameOf(track) + (track.kind === "group" ? ` ×${track.members}` : ""),
        track.address,
        track.code,
        heightText(track, this.units),
        speedText(track, this.units),
        String(track.sourceCount),
        this.mainName(track),
      ];
      cells.forEach((text, n) => setText(row.children[n], text));
      // The focus stays with its track when the order changes.
      if (isFocused && first + k === place && row !== document.activeElement) row.focus({ preventScroll: true });
    });
  }

  newRow() {
    const cells = COLUMNS.map((_, k) => h("span", { role: "gridcell", "aria-colindex": k + 1 }));
    const row = h("div.table-row", { role: "row" }, ...cells);
    row.addEventListener("click", (event) => this.on.select(Number(row.dataset.track), event.ctrlKey || event.metaKey));
    row.addEventListener("dblclick", () => this.on.goTo(Number(row.dataset.track)));
    row.addEventListener("focus", () => (this.current = Number(row.dataset.track)));
    this.body.append(row);
    return row;
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (event.altKey || event.shiftKey) return;
    const at = this.order.findIndex((track) => track.number === this.current);
    const page = Math.max(1, Math.floor(this.parent.clientHeight / ROW) - 2);
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -Infinity, End: Infinity };
    const step = /** @type {Record<string, number>} */ (steps)[event.key];
    if (step !== undefined) this.focus(at + step);
    else if (event.key === " ") this.on.select(this.current, true);
    else if (event.key === "Enter") this.on.goTo(this.current);
    else return;
    event.preventDefault();
  }

  /** Gives the focus to a row, which is brought into sight. @param {number} place */
  focus(place) {
    const at = Math.min(this.order.length - 1, Math.max(0, place));
    if (at < 0) return;
    this.current = this.order[at].number;
    const room = this.parent.clientHeight - ROW;
    const top = Math.min(at * ROW, Math.max(this.parent.scrollTop, (at + 1) * ROW - room));
    this.parent.scrollTop = top;
    this.showRows();
    this.rows.find((row) => row.dataset.track === String(this.current) && !row.hidden)?.focus({ preventScroll: true });
  }
}

/**
 * @param {string} column @param {(track: Track) => string} mainName
 * @returns {(track: Track) => string | number}
 */
function keyOf(column, mainName) {
  if (column === "address") return (track) => track.address;
  if (column === "code") return (track) => track.code;
  if (column === "height") return (track) => track.height;
  if (column === "speed") return (track) => Math.hypot(track.speedEast, track.speedNorth);
  if (column === "sources") return (track) => track.sourceCount;
  if (column === "main") return mainName;
  return nameOf;
}
