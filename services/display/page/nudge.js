/**
 * Labels that the user puts somewhere: with the mouse, or with Ctrl and the arrows for the selected tracks. A label put
 * by hand keeps its place beside its symbol until it is given back.
 */

import { byId, h, setText } from "./dom.js";

/** Pixels by which a key moves a label. */
const STEP = 8;
/** Farthest that a label can be put from its symbol, pixels. */
const REACH = 240;

/** @typedef {import("./app.js").App} App */
/** @typedef {import("./lettering.js").Label} Label */

/** Moves labels by a distance in pixels. @param {App} app @param {Label[]} labels @param {number} dx @param {number} dy */
export function nudge(app, labels, dx, dy) {
  const bounded = (/** @type {number} */ value) => Math.min(REACH, Math.max(-REACH, value));
  for (const { wish, left, top } of labels.map(({ block }) => block)) {
    const [fromX, fromY] = wish.spot.pinned ?? [left - wish.x, top - wish.y];
    wish.spot.pinned = [bounded(fromX + dx), bounded(fromY + dy)];
  }
  app.dirty = true;
}

/** Lets labels be placed automatically again. @param {App} app @param {Label[]} labels */
export function giveBack(app, labels) {
  for (const { wish } of labels) Object.assign(wish.spot, { pinned: null, place: -1 });
  app.dirty = true;
}

/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] };

/** Makes the keys answer, and counts the labels without a place. @param {App} app */
export function controlLabels(app) {
  document.addEventListener("keydown", (event) => {
    const isMap = event.target === app.trackCanvas || event.target === document.body;
    if (!event.ctrlKey || event.altKey || event.metaKey || !isMap || app.selected.size === 0) return;
    const labels = app.painter.lettering.labels.filter(({ track }) => app.selected.has(track.number));
    if (event.key in ARROWS) nudge(app, labels, ...ARROWS[event.key]);
    else if (event.key === "Backspace") giveBack(app, labels);
    else return;
    event.preventDefault();
  });
  const count = h("div", { id: "leftout", role: "status", hidden: true });
  byId("map").append(count);
  setInterval(() => {
    const { leftOut } = app.painter.lettering;
    count.hidden = leftOut === 0;
    setText(count, `${leftOut} label${leftOut === 1 ? "" : "s"} without room`);
  }, 500);
}

/**
 * Boxes of all that lies upon the map, pixels of the map.
 * @param {HTMLElement} map @returns {import("./placement.js").Box[]}
 */
export function controlsOn(map) {
  const outer = map.getBoundingClientRect();
  const scale = map.clientWidth / outer.width || 1;
  return [...map.children]
    .filter((child) => !(child instanceof HTMLCanvasElement) && child.id !== "help")
    .map((child) => child.getBoundingClientRect())
    .filter(({ width, height }) => width > 12 && height > 0)
    .map(({ left, top, width, height }) => ({
      left: (left - outer.left) * scale,
      top: (top - outer.top) * scale,
      width: width * scale,
      height: height * scale,
    }));
}
