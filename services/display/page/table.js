/**
 * Table of tracks: sorted, filtered, and only as many rows in the page as there is room for, so that five thousand
 * tracks cost no more than fifty.
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
   *   centre: (number: number) => void}} on
   */
  constructor(parent, on) {
    this.parent = parent;
    this.on = on;
    this.head = h("div.table-head", { role: "row" });
    for (const [column, title, about] of COLUMNS)
      this.head.append(h("button", { title: about, "data-column": column, click: () => on.sortBy(column) }, title));
    this.body = h("div.table-body");
    /** @type {HTMLElement[]} */
    this.rows = [];
    /** @type {Track[]} */
    this.order = [];
    parent.addEventListener("scroll", () => this.showRows());
    this.selected = /** @type {Set<number>} */ (new Set());
    this.units = "aviation";
    this.mainName = /** @type {(track: Track) => string} */ (() => "");
  }

  /** Puts the table into its parent. */
  mount() {
    this.parent.replaceChildren(this.head, this.body);
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
    for (const button of this.head.children) {
      const own = button.getAttribute("data-column") === column;
      if (own) button.setAttribute("aria-sort", falling ? "descending" : "ascending");
      else button.removeAttribute("aria-sort");
    }
    this.body.style.height = `${this.order.length * ROW}px`;
    this.showRows();
  }

  showRows() {
    const first = Math.max(0, Math.floor(this.parent.scrollTop / ROW) - 2);
    const count = Math.min(this.order.length - first, Math.ceil(this.parent.clientHeight / ROW) + 4);
    while (this.rows.length < count) this.rows.push(this.newRow());
    this.rows.forEach((row, k) => {
      const track = this.order[first + k];
      row.hidden = k >= count || !track;
      if (row.hidden) return;
      row.style.top = `${(first + k) * ROW}px`;
      row.dataset.track = String(track.number);
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
    });
  }

  newRow() {
    const row = h("div.table-row", { role: "row" }, ...COLUMNS.map(() => h("span")));
    row.addEventListener("click", (event) => this.on.select(Number(row.dataset.track), event.ctrlKey || event.metaKey));
    row.addEventListener("dblclick", () => this.on.centre(Number(row.dataset.track)));
    this.body.append(row);
    return row;
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
