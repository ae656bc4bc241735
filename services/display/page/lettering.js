/**
 * Labels on the map: which wish for a place, and how they are painted once they have one.
 *
 * The rank of a label is the interest in its track: selected and alerting tracks always have a label; then come those
 * that the configuration prefers, confirmed tracks, and tentative ones.
 */

import { FONT, LINE_HEIGHT } from "./labels.js";
import { leaderEnd, PAD_X, PAD_Y, Placement } from "./placement.js";
import { isGrave } from "./picture.js";

/** Length of a bar that stands for a weight of 1, pixels. */
const SHARE_BAR = 60;
/** Leaders shorter than this are not drawn, pixels. */
const LEADER_MIN = 9;
/** Where the leader begins, pixels from the middle of the symbol. */
const LEADER_FROM = 6;
/** Shortest speed vector that is drawn, pixels: east and north added. */
export const VECTOR_MIN = 6;

/** @typedef {import("./picture.js").Track} Track */
/** @typedef {import("./painter.js").Scene} Scene */
/** @typedef {import("./painter.js").Share} Share */
/** @typedef {import("./placement.js").Box} Box */
/** @typedef {import("./placement.js").Laid & {track: Track, x: number, y: number}} Label */
/** @typedef {import("./placement.js").Wish & {track: Track}} TrackWish */

export class Lettering {
  constructor() {
    this.glyph = 0;
    this.placement = new Placement();
    /** @type {Label[]} */
    this.labels = [];
    /** Tracks on the map whose label found no place. */
    this.leftOut = 0;
    /** Scale and direction of the last picture, and those for which the labels were last laid out anew. */
    this.scale = "";
    this.laidAt = "";
  }

  /**
   * Lays the labels of the tracks out and paints them.
   * @param {CanvasRenderingContext2D} ctx @param {Scene} scene
   * @param {{track: Track, x: number, y: number}[]} drawn @param {(track: Track) => string} colourOf
   */
  paint(ctx, scene, drawn, colourOf) {
    const { settings, selected } = scene;
    this.labels = [];
    this.leftOut = 0;
    if (settings.labels === 0 && selected.size === 0) return;
    ctx.font = FONT;
    if (this.glyph === 0) this.glyph = ctx.measureText("M").width;
    this.labels = settings.declutter ? this.layOut(scene, drawn) : this.pileUp(scene, drawn);
    this.paintBacks(ctx, scene, colourOf);
    this.paintTexts(ctx, scene, colourOf);
  }

  /**
   * Labels in places that keep them apart.
   * @param {Scene} scene @param {{track: Track, x: number, y: number}[]} drawn @returns {Label[]}
   */
  layOut(scene, drawn) {
    const { view, settings, chrome, measure } = scene;
    this.settle(view, drawn);
    const m = view.matrix();
    const wishes = [];
    const inView = drawn.filter(({ x, y }) => x >= 0 && y >= 0 && x <= view.width && y <= view.height);
    this.placement.begin(view.width, view.height, inView.length);
    for (const box of chrome) this.placement.keepOut(box);
    for (const { box } of measure?.notes ?? []) this.placement.keepOut(box);
    for (const { track, x, y } of inView) {
      const vx = m.a * track.speedEast + m.c * track.speedNorth;
      const vy = m.b * track.speedEast + m.d * track.speedNorth;
      const [dx, dy] = [vx * settings.vector, vy * settings.vector];
      if (Math.abs(dx) + Math.abs(dy) >= VECTOR_MIN) this.placement.keepOff(x, y, x + dx, y + dy, vx, vy);
      const wish = this.wishOf(scene, track, x, y, vx, vy);
      if (wish) wishes.push(wish);
    }
    const laid = this.placement.arrange(wishes);
    this.leftOut = this.placement.leftOut;
    const labels = laid.map((label) => labelled(label));
    return [...labels, ...this.hoveredLabel(scene, wishes)];
  }

  /**
   * Forgets the places where the map has become larger or smaller: leaders that were long for want of room need not be
   * so any longer. While the map is being changed the labels stay.
   * @param {import("./view.js").View} view @param {{track: Track}[]} drawn
   */
  settle(view, drawn) {
    const scale = `${view.scale} ${view.up}`;
    if (scale === this.scale && scale !== this.laidAt) {
      for (const { track } of drawn) track.spot.place = -1;
      this.laidAt = scale;
    }
    this.scale = scale;
  }

  /**
   * @param {Scene} scene @param {Track} track @param {number} x @param {number} y @param {number} vx @param {number} vy
   * @returns {TrackWish | null}
   */
  wishOf(scene, track, x, y, vx, vy) {
    const full = scene.selected.has(track.number);
    const lines = full ? track.label.length : Math.min(scene.settings.labels, track.label.length);
    if (lines === 0) return null;
    const widths = [];
    const heights = [];
    const bars = full ? scene.shares.get(track.number) : undefined;
    for (let k = 0, longest = 0; k < lines; k++) {
      longest = Math.max(longest, track.label[k].length * this.glyph);
      widths.push(bars ? Math.max(longest, this.barsWidth(bars)) : longest);
      heights.push((k + 1) * LINE_HEIGHT - 2 + (bars ? bars.length * LINE_HEIGHT + 6 : 0));
    }
    const rank = full || isGrave(track) ? 3 : scene.prefers(track) ? 2 : track.state === "tentative" ? 0 : 1;
    return { track, spot: track.spot, x, y, vx, vy, rank, widths, heights };
  }

  /** Label of the track under the pointer, where there was no place for it: it covers others while the pointer is there.
   * @param {Scene} scene @param {TrackWish[]} wishes @returns {Label[]} */
  hoveredLabel({ hovered, view }, wishes) {
    const wish = wishes.find(({ track }) => track.number === hovered);
    if (!wish || wish.spot.place >= 0 || wish.spot.pinned) return [];
    return [labelled(besides(wish, view.width, view.height))];
  }

  /** Labels beside their symbols, whatever lies there. @param {Scene} scene
   * @param {{track: Track, x: number, y: number}[]} drawn @returns {Label[]} */
  pileUp(scene, drawn) {
    return drawn.flatMap(({ track, x, y }) => {
      const wish = this.wishOf(scene, track, x, y, 0, 0);
      return wish ? [labelled(besides(wish, Infinity, Infinity))] : [];
    });
  }

  /** Dims what lies beneath the labels, and draws their leaders. @param {CanvasRenderingContext2D} ctx
   * @param {Scene} scene @param {(track: Track) => string} colourOf */
  paintBacks(ctx, { settings, colours, hovered }, colourOf) {
    if (!settings.declutter) return;
    ctx.fillStyle = colours.halo;
    const back = (/** @type {Label} */ { left, top, width, height }) =>
      ctx.fillRect(left - PAD_X, top - PAD_Y, width + 2 * PAD_X, height + 2 * PAD_Y);
    this.labels.forEach(back);
    const last = this.labels.at(-1);
    // Twice, so that what it covers cannot be seen.
    if (last && last.track.number === hovered) back(last);
    /** @type {Map<string, Path2D>} */
    const leaders = new Map();
    for (const label of this.labels) {
      const { x, y, track } = label;
      const [toX, toY] = leaderEnd(x, y, label);
      const reach = Math.hypot(toX - x, toY - y);
      if (reach < LEADER_MIN) continue;
      const colour = colourOf(track);
      let path = leaders.get(colour);
      if (!path) leaders.set(colour, (path = new Path2D()));
      path.moveTo(x + ((toX - x) * LEADER_FROM) / reach, y + ((toY - y) * LEADER_FROM) / reach);
      path.lineTo(toX, toY);
    }
    ctx.globalAlpha = 0.5;
    ctx.lineWidth = 1;
    for (const [colour, path] of leaders) {
      ctx.strokeStyle = colour;
      ctx.stroke(path);
    }
    ctx.globalAlpha = 1;
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Scene} scene @param {(track: Track) => string} colourOf */
  paintTexts(ctx, scene, colourOf) {
    let colour = "";
    // Whole pixels keep letters sharp and allow drawing each only once.
    for (const { track, left, top, lines } of this.labels) {
      const own = colourOf(track);
      if (own !== colour) ctx.fillStyle = colour = own;
      for (let k = 0; k < lines; k++)
        ctx.fillText(track.label[k], Math.round(left), Math.round(top) + (k + 1) * LINE_HEIGHT - 4);
    }
    for (const label of this.labels) {
      const list = scene.shares.get(label.track.number);
      if (list && scene.selected.has(label.track.number)) this.paintShareBars(ctx, scene, label, list);
    }
  }

  /** Width of the bars with their names. @param {Share[]} list */
  barsWidth(list) {
    return (Math.max(10, ...list.map((share) => share.name.length)) + 5) * this.glyph + SHARE_BAR + 10;
  }

  /**
   * Weights of a selected track's contributors, as bars below its label.
   * @param {CanvasRenderingContext2D} ctx @param {Scene} scene @param {Label} label @param {Share[]} list
   */
  paintShareBars(ctx, { colours }, { left, top, lines }, list) {
    const bar = left + this.barsWidth(list) - SHARE_BAR - 5 * this.glyph - 4;
    list.forEach((share, k) => {
      const base = Math.round(top) + (lines + k + 1) * LINE_HEIGHT;
      ctx.fillStyle = colours.confirmed;
      ctx.fillText(share.name, left, base);
      ctx.fillStyle = colours.measure;
      ctx.fillRect(bar, base - 8, Math.max(1, SHARE_BAR * share.weight), 8);
      ctx.fillStyle = colours.confirmed;
      ctx.fillText(share.weight.toFixed(2), bar + SHARE_BAR + 4, base);
    });
  }

  /** Label at a pixel. @param {number} x @param {number} y @returns {Label | null} */
  at(x, y) {
    return (
      this.labels.findLast(
        ({ left, top, width, height }) => x >= left && y >= top && x <= left + width && y <= top + height,
      ) ?? null
    );
  }
}

/** @param {import("./placement.js").Laid} laid @returns {Label} */
function labelled(laid) {
  const { track, x, y } = /** @type {TrackWish} */ (laid.wish);
  return { ...laid, track, x, y };
}

/** A label right above its symbol, or left below where the map ends. @param {TrackWish} wish
 * @param {number} mapWidth @param {number} mapHeight @returns {import("./placement.js").Laid} */
function besides(wish, mapWidth, mapHeight) {
  const lines = wish.widths.length;
  const [width, height] = [wish.widths[lines - 1], wish.heights[lines - 1]];
  const left = Math.min(wish.x + 10, mapWidth - width);
  const top = Math.min(wish.y - 7 - height, mapHeight - height);
  return { wish, lines, left, top: mapHeight === Infinity ? top : Math.max(0, top), width, height };
}
