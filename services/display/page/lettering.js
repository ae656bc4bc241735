/**
 * Labels on the map: which wish for a place, and how they are painted once they have one.
 *
 * The rank of a label is the interest in its track: selected and alerting tracks always have a label; then come those
 * that the configuration prefers, confirmed tracks, and tentative ones.
 */

import { blockOf, groupsOf } from "./fans.js";
import { FONT, LINE_HEIGHT } from "./labels.js";
import { leaderEnd, PAD_X, PAD_Y, Placement } from "./placement.js";
import { isGrave } from "./picture.js";

/** Length of a bar that stands for a weight of 1, pixels. */
const SHARE_BAR = 60;
/** Leaders shorter than this are not drawn, pixels. */
const LEADER_MIN = 9;
/** Where the leader begins, pixels from the middle of the symbol. */
const LEADER_FROM = 6;
/** Largest share of the map that a block takes; a larger one is left out, and its targets are counted. */
const BLOCK_SHARE_MAX = 0.125;
/** Shortest speed vector that is drawn, pixels: east and north added. */
export const VECTOR_MIN = 6;

/** @typedef {import("./picture.js").Track} Track */
/** @typedef {import("./painter.js").Scene} Scene */
/** @typedef {import("./painter.js").Share} Share */
/** @typedef {import("./placement.js").Box} Box */
/** @typedef {import("./placement.js").Laid} Laid */
/** Label of a track: its box, and that of the block in which it is a row. @typedef {Laid & {track: Track, block: Laid}} Label */
/** @typedef {import("./placement.js").Wish & {track: Track, members?: Track[]}} TrackWish */

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
    /** Which track stands for the group of a track, and where the blocks of these are. @type {Map<number, number>} */
    this.leads = new Map();
    /** @type {Map<number, import("./placement.js").Spot>} */
    this.blocks = new Map();
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
    /** @type {TrackWish[]} */
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
    const fanned = this.placement.isCrowd ? wishes : this.fan(wishes);
    const labels = this.placement.arrange(fanned).flatMap((laid) => this.labelled(laid));
    this.leftOut = wishes.length - labels.length;
    return [...labels, ...this.hoveredLabel(scene, wishes, labels)];
  }

  /** Puts one wish for a block in the place of those of its members. @param {TrackWish[]} wishes */
  fan(wishes) {
    const free = wishes.filter(({ rank, spot }) => rank < 3 && !spot.pinned);
    const symbols = free.map((wish) => ({ ...wish, number: wish.track.number }));
    const groups = groupsOf(symbols, this.leads);
    const before = this.leads;
    this.leads = new Map();
    const blocks = new Map();
    const taken = new Set();
    const fanned = [];
    for (const [lead, members] of groups) {
      // A block whose lead has left stays where it is.
      const former = this.blocks.get(before.get(lead) ?? -1) ?? { place: -1, lines: 0, isForced: false, pinned: null };
      const spot = this.blocks.get(lead) ?? { ...former };
      blocks.set(lead, spot);
      const width = Math.max(...members.map(({ widths }) => widths[0]));
      const block = blockOf(members.length, width, LINE_HEIGHT);
      const mean = (/** @type {"x" | "y" | "vx" | "vy"} */ key) =>
        members.reduce((sum, member) => sum + member[key], 0) / members.length;
      const { width: mapWidth, height: mapHeight } = this.placement;
      const isShown = block.width * block.height < BLOCK_SHARE_MAX * mapWidth * mapHeight;
      for (const { track, number, x, y } of members) {
        this.leads.set(number, lead);
        taken.add(track);
        track.spot.place = -1;
        this.placement.keepOutSymbol(x, y);
      }
      if (!isShown) continue;
      const [x, y, vx, vy] = [mean("x"), mean("y"), mean("vx"), mean("vy")];
      const tracks = members.map(({ track }) => track).sort((a, b) => (a.label[0] < b.label[0] ? -1 : 1));
      const size = { widths: [block.width], heights: [block.height] };
      // A block needs so much room that it must come first.
      fanned.push({ track: tracks[0], members: tracks, spot, x, y, vx, vy, rank: 2, isBlock: true, ...size });
    }
    this.blocks = blocks;
    return [...fanned, ...wishes.filter(({ track }) => !taken.has(track))];
  }

  /** Labels of what has been laid: one, or each row of a block. @param {Laid} laid @returns {Label[]} */
  labelled(laid) {
    const { track, members } = /** @type {TrackWish} */ (laid.wish);
    if (!members) return [Object.assign(laid, { track, block: laid })];
    const width = Math.max(...members.map(({ label }) => label[0].length)) * this.glyph;
    const { rows, step } = blockOf(members.length, width, LINE_HEIGHT);
    return members.map((member, k) => ({
      wish: laid.wish,
      lines: 1,
      left: laid.left + Math.floor(k / rows) * step,
      top: laid.top + (k % rows) * LINE_HEIGHT,
      width,
      height: LINE_HEIGHT - 2,
      track: member,
      block: laid,
    }));
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
      this.blocks.clear();
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
    return { track, spot: track.spot, x, y, vx, vy, rank, isBlock: false, widths, heights };
  }

  /** Label of the track under the pointer, where there was no place for it: it covers others while the pointer is there.
   * @param {Scene} scene @param {TrackWish[]} wishes @param {Label[]} labels @returns {Label[]} */
  hoveredLabel({ hovered, view }, wishes, labels) {
    const wish = wishes.find(({ track }) => track.number === hovered);
    if (!wish || labels.some(({ track }) => track.number === hovered)) return [];
    return this.labelled(besides(wish, view.width, view.height));
  }

  /** Labels beside their symbols, whatever lies there. @param {Scene} scene
   * @param {{track: Track, x: number, y: number}[]} drawn @returns {Label[]} */
  pileUp(scene, drawn) {
    return drawn.flatMap(({ track, x, y }) => {
      const wish = this.wishOf(scene, track, x, y, 0, 0);
      return wish ? this.labelled(besides(wish, Infinity, Infinity)) : [];
    });
  }

  /** Dims what lies beneath the labels, and draws their leaders. @param {CanvasRenderingContext2D} ctx
   * @param {Scene} scene @param {(track: Track) => string} colourOf */
  paintBacks(ctx, { settings, colours, hovered }, colourOf) {
    if (!settings.declutter) return;
    ctx.fillStyle = colours.halo;
    const back = (/** @type {import("./placement.js").Box} */ { left, top, width, height }) =>
      ctx.fillRect(left - PAD_X, top - PAD_Y, width + 2 * PAD_X, height + 2 * PAD_Y);
    const blocks = new Set(this.labels.map(({ block }) => block));
    blocks.forEach(back);
    const last = this.labels.at(-1);
    // Twice, so that what it covers cannot be seen.
    if (last && last.track.number === hovered) back(last);
    /** @type {Map<string, Path2D>} */
    const leaders = new Map();
    for (const block of blocks) {
      const { x, y, track } = /** @type {TrackWish} */ (block.wish);
      const [toX, toY] = leaderEnd(x, y, block);
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
    if (scene.selected.size === 0) return;
    for (const label of this.labels) {
      const list = scene.selected.has(label.track.number) ? scene.shares.get(label.track.number) : undefined;
      if (list) this.paintShareBars(ctx, scene, label, list);
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

/** A label right above its symbol, or left below where the map ends. @param {TrackWish} wish
 * @param {number} mapWidth @param {number} mapHeight @returns {import("./placement.js").Laid} */
function besides(wish, mapWidth, mapHeight) {
  const lines = wish.widths.length;
  const [width, height] = [wish.widths[lines - 1], wish.heights[lines - 1]];
  const left = Math.min(wish.x + 10, mapWidth - width);
  const top = Math.min(wish.y - 7 - height, mapHeight - height);
  return { wish, lines, left, top: mapHeight === Infinity ? top : Math.max(0, top), width, height };
}
