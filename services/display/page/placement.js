/**
 * Where labels go: beside their symbols, clear of each other, of symbols, speed vectors, names on the map and controls.
 *
 * A label that may lie anywhere would be easy to place and hard to read: eyes look for it where it was. The layout
 * therefore is that of the picture before, mended. Each label keeps its place beside its symbol while nothing else lies
 * there; only labels without such a place look for one: sixteen directions at growing distances, whole first, then with
 * the first line alone. The order is that of interest. What finds no place is left out and counted. The search is
 * greedy (Christensen, Marks and Shieber, 1995, compare it with others), deterministic, and bounded for each picture:
 * what remains is tried in the pictures that follow.
 *
 * Of two free places the better is the one that stays free: the search looks two minutes ahead, with all motions as they
 * are. With 200 straight tracks on a map of 1480 × 1000 pixels, 0.9 % of the labels moved in a second without it, and
 * 0.3 % with it.
 */

import { BOX, LEADER, NOBODY, Occupancy, SYMBOL, VECTOR } from "./occupancy.js";

/** Distances between symbol and label that are tried in turn, pixels. */
const LENGTHS = [12, 22, 34, 46, 58, 69, 80];
/** Directions in the order in which they are tried: where the label's nearest point lies at distance 1. */
const DIRECTIONS = [
  [0.8, -0.6],
  [0.8, 0.6],
  [-0.8, -0.6],
  [-0.8, 0.6],
  [1, 0],
  [-1, 0],
  [0, -1],
  [0, 1],
  [0.94, -0.34],
  [0.94, 0.34],
  [-0.94, -0.34],
  [-0.94, 0.34],
  [0.44, -0.89],
  [0.44, 0.89],
  [-0.44, -0.89],
  [-0.44, 0.89],
];
const PLACES = LENGTHS.length * DIRECTIONS.length;
/** Distances at which targets that overlap fan out: names alone, where nothing nearer is free. */
const FAN_LENGTHS = [96, 112, 128, 144, 160, 180, 200, 220, 240];
/** Distances at which only a block of many names is put. */
const BLOCK_LENGTHS = [270, 300, 330, 360, 400];
const ALL_LENGTHS = [...LENGTHS, ...FAN_LENGTHS, ...BLOCK_LENGTHS];
const FAN_PLACES = (LENGTHS.length + FAN_LENGTHS.length) * DIRECTIONS.length;
const BLOCK_PLACES = ALL_LENGTHS.length * DIRECTIONS.length;
/** Free pixels round a place that is taken anew, so that it can be kept for long. */
const MARGIN = 5;
/** Moments of the time ahead at which a place taken anew shall still be free, seconds. They begin close to each other: in
 * a crowd, symbols pass a label within seconds. */
const AHEAD = [0, 5, 10, 15, 20, 30, 40, 60, 80, 100, 120];
/** Time after which a vector must have passed a label that shall not move for it, seconds; its place among the moments. */
const PASSED_S = 20;
const AHEAD_S = AHEAD[AHEAD.length - 1];
const PASSED = AHEAD.indexOf(PASSED_S);
/** What is as bad as a leader that is so many pixels longer: no free pixels round a label, a leader across a symbol or a
 * label, a vector across a block, and each BRIEF_S of the time ahead for which the place is no longer free. */
const COST_TIGHT = 10;
const COST_CROSSED = 30;
const COST_VECTOR = 80;
const COST_BRIEF = 30;
const BRIEF_S = 20;
/** Brevity of a place from which on a label does not grow there. */
const BREVITY_MAX = 3.5;
/** How many displaced labels are as bad as a symbol under a label. */
const HIDDEN = 3;
/** … and as a control, or a name on the map, under one. */
const COVERED = 20;
/** Most labels for which the time ahead is looked at, and which fan out: a crowd takes less work. */
const AHEAD_COUNT_MAX = 600;
/** Tests of a place that a picture may cost, besides those of the labels that keep theirs. */
const TESTS_MAX = 40_000;
/** The same in a crowd, where most labels find no place. */
const CROWD_TESTS_MAX = 3_000;
/** Half of the side of a symbol that labels keep clear of, pixels. */
const HALF = 5;
/** Free pixels between two labels at least, so that their texts can be told apart: beside and above. */
export const PAD_X = 3;
export const PAD_Y = 1;

/** What makes a label give up its place: a leader that comes across does not. */
const HARD = BOX | SYMBOL | VECTOR;

/**
 * A label that wants a place.
 * @typedef {object} Wish
 * @property {Spot} spot Its track, which remembers the place.
 * @property {number} x @property {number} y Its symbol.
 * @property {number} vx @property {number} vy Its motion, pixels a second.
 * @property {number} rank Interest: the higher ones first, 0 to 3; 3 always has a label.
 * @property {boolean} isBlock Whether it is a block of many names: it may lie far away, and over vectors.
 * @property {number[]} widths @property {number[]} heights Size with one line, with two, …
 */

/**
 * What a track remembers of its label.
 * @typedef {object} Spot
 * @property {number} place Where its label is; -1: nowhere.
 * @property {number} lines With how many lines.
 * @property {boolean} isForced Whether it has displaced others: it then bears symbols and vectors.
 * @property {[number, number] | null} pinned Where its user has put it: from the symbol to the label's corner, pixels.
 */

/**
 * @typedef {object} Box
 * @property {number} left @property {number} top @property {number} width @property {number} height
 */

/** @typedef {Box & {wish: Wish, lines: number}} Laid */

/** Whether a label must be shown, whatever it displaces. @param {Wish} wish */
function isMust(wish) {
  return wish.rank === 3 || wish.isBlock;
}

/** Whether a label, once it lies, does not give way to `other`, which must be shown. @param {Wish} wish @param {Wish} other */
function isFirm(wish, other) {
  return wish.rank === 3 || wish.spot.pinned !== null || (wish.isBlock && other.isBlock);
}

export class Placement {
  constructor() {
    /** The screen at each of the moments looked at: shapes have the same number in all. */
    this.moments = AHEAD.map(() => new Occupancy());
    /** How many of them are looked at. */
    this.depth = 1;
    this.width = 0;
    this.height = 0;
    /** Rectangles of no label. @type {Box[]} */
    this.closed = [];
    /** Labels that found no place in the last picture. */
    this.leftOut = 0;
    this.tests = 0;
    /** Which of the labels without a place is tried first. */
    this.turn = 0;
    /** @type {Laid[]} */
    this.laid = [];
    /** Shapes of each label: its box, its leader. @type {number[][]} */
    this.shapes = [];
  }

  /**
   * Begins a picture of this size, with nothing on it.
   * @param {number} width @param {number} height @param {number} count Labels that will want a place.
   */
  begin(width, height, count) {
    this.width = width;
    this.height = height;
    this.closed.length = 0;
    this.depth = count <= AHEAD_COUNT_MAX ? AHEAD.length : 1;
    for (let k = 0; k < this.depth; k++) this.moments[k].clear(width, height);
  }

  /** @private @param {number} kind @param {number} owner @param {number} x @param {number} y @param {number} toX
   * @param {number} toY @param {number} vx @param {number} vy @returns {number} */
  add(kind, owner, x, y, toX, toY, vx, vy) {
    let shape = 0;
    for (let k = 0; k < this.depth; k++) {
      const [dx, dy] = [AHEAD[k] * vx, AHEAD[k] * vy];
      shape = this.moments[k].add(kind, owner, x + dx, y + dy, toX + dx, toY + dy);
    }
    return shape;
  }

  /** Whether there are more labels than are looked after well. */
  get isCrowd() {
    return this.depth === 1;
  }

  /** Keeps labels off the symbol of a target that wants no label of its own. @param {number} x @param {number} y */
  keepOutSymbol(x, y) {
    this.add(SYMBOL, NOBODY, x - HALF, y - HALF, x + HALF, y + HALF, 0, 0);
  }

  /** Keeps labels out of a rectangle. @param {Box} box */
  keepOut(box) {
    const { left, top, width, height } = box;
    this.closed.push(box);
    this.add(BOX, NOBODY, left, top, left + width, top + height, 0, 0);
  }

  /**
   * Keeps labels off a line that moves.
   * @param {number} x @param {number} y @param {number} toX @param {number} toY
   * @param {number} vx @param {number} vy Pixels a second.
   */
  keepOff(x, y, toX, toY, vx, vy) {
    this.add(VECTOR, NOBODY, x, y, toX, toY, vx, vy);
  }

  /**
   * Finds a place for each label.
   * @param {Wish[]} wishes In an order that does not change from picture to picture.
   * @returns {Laid[]} Those that have one.
   */
  arrange(wishes) {
    this.laid = [];
    this.shapes = [];
    this.tests = 0;
    wishes.forEach(({ x, y, vx, vy }, owner) =>
      this.add(SYMBOL, owner, x - HALF, y - HALF, x + HALF, y + HALF, vx, vy),
    );
    const ranks = [3, 2, 1, 0].map((rank) => wishes.map((_, owner) => owner).filter((o) => wishes[o].rank === rank));
    /** @type {number[]} */
    const homeless = [];
    for (const owner of ranks.flat()) if (!this.pin(owner, wishes[owner])) homeless.push(owner);
    const left = homeless.filter((owner) => !this.keep(owner, wishes[owner]));
    const must = left.filter((owner) => isMust(wishes[owner]));
    for (const owner of must)
      if (!this.find(owner, wishes[owner])) left.push(...this.force(owner, wishes[owner], wishes));
    this.search(left.filter((owner) => !isMust(wishes[owner])), wishes);
    this.leftOut = wishes.length - this.laid.length;
    return this.laid;
  }

  /** Looks for places as long as the picture may cost it. @private @param {number[]} left @param {Wish[]} wishes */
  search(left, wishes) {
    let tried = 0;
    const most = this.depth > 1 ? TESTS_MAX : CROWD_TESTS_MAX;
    const start = left.length > 0 ? this.turn % left.length : 0;
    for (let k = 0; k < left.length; k++) {
      const owner = left[(start + k) % left.length];
      if (this.tests > most) continue;
      tried++;
      this.find(owner, wishes[owner]);
    }
    this.turn = tried === left.length ? 0 : start + tried;
  }

  /** Puts a label where its user has put it. @private @param {number} owner @param {Wish} wish */
  pin(owner, wish) {
    const { pinned } = wish.spot;
    if (!pinned) return false;
    const lines = wish.widths.length;
    const [width, height] = [wish.widths[lines - 1], wish.heights[lines - 1]];
    const left = Math.min(this.width - width, Math.max(0, wish.x + pinned[0]));
    const top = Math.min(this.height - height, Math.max(0, wish.y + pinned[1]));
    wish.spot.lines = lines;
    this.lay(owner, wish, left, top, lines);
    return true;
  }

  /** Leaves a label where it is, if it can stay there. @private @param {number} owner @param {Wish} wish */
  keep(owner, wish) {
    const { spot } = wish;
    if (spot.place < 0) return false;
    const most = wish.widths.length;
    // One with fewer lines becomes whole where there is more room than it needs.
    if (spot.lines < most && spot.place < PLACES && this.canGrow(wish, spot.place, most)) spot.lines = most;
    const lines = Math.min(spot.lines, most);
    if (!this.canStay(wish, spot.place, lines)) {
      spot.place = -1;
      return false;
    }
    this.layAt(owner, wish, spot.place, lines);
    return true;
  }

  /** Whether there is room for more lines, and will be for a while. @private
   * @param {Wish} wish @param {number} place @param {number} lines */
  canGrow(wish, place, lines) {
    return this.isFree(wish, place, lines, MARGIN, HARD) && this.brevity(wish, place, lines) < BREVITY_MAX;
  }

  /** Whether a label need not leave its place: a vector that will have passed is borne. @private
   * @param {Wish} wish @param {number} place @param {number} lines */
  canStay(wish, place, lines) {
    if (wish.spot.isForced) return this.isFree(wish, place, lines, 0, BOX);
    if (!this.isFree(wish, place, lines, 0, BOX | SYMBOL)) return false;
    if (wish.isBlock || this.isFree(wish, place, lines, 0, VECTOR)) return true;
    return this.depth > 1 && this.isSoonFree(wish, place, lines);
  }

  /** Finds a new place. @private @param {number} owner @param {Wish} wish */
  find(owner, wish) {
    const most = wish.widths.length;
    let lines = most;
    let place = this.best(owner, wish, lines, 0, PLACES);
    if (place < 0) lines = 1;
    if (place < 0 && most > 1) place = this.best(owner, wish, lines, 0, PLACES);
    if (place < 0 && this.depth > 1) place = this.best(owner, wish, lines, PLACES, wish.isBlock ? BLOCK_PLACES : FAN_PLACES);
    wish.spot.place = place;
    if (place < 0) return false;
    Object.assign(wish.spot, { lines, isForced: false });
    this.layAt(owner, wish, place, lines);
    return true;
  }

  /** Cheapest free place from a number to before another; -1: none is free. @private @param {number} owner
   * @param {Wish} wish @param {number} lines @param {number} from @param {number} to */
  best(owner, wish, lines, from, to) {
    let best = -1;
    let least = Infinity;
    for (let place = from; place < to; place++) {
      let cost = ALL_LENGTHS[Math.floor(place / DIRECTIONS.length)];
      if (cost >= least) break;
      this.tests++;
      if (!this.isFree(wish, place, lines, 0, wish.isBlock ? BOX | SYMBOL : HARD)) continue;
      if (wish.isBlock && !this.isFree(wish, place, lines, 0, VECTOR)) cost += COST_VECTOR;
      if (!this.isFree(wish, place, lines, MARGIN, HARD | LEADER)) cost += COST_TIGHT;
      if (!this.hasLeader(owner, wish, place, lines)) cost += COST_CROSSED;
      if (cost < least) cost += COST_BRIEF * this.brevity(wish, place, lines);
      if (cost < least) [best, least] = [place, cost];
    }
    return best;
  }

  /**
   * Puts a label that must be shown where it displaces least. A block that would cover another such label is left out.
   * @private @param {number} owner @param {Wish} wish @param {Wish[]} wishes
   * @returns {number[]} Owners of the labels that it has displaced.
   */
  force(owner, wish, wishes) {
    const lines = wish.widths.length;
    let best = 0;
    let least = Infinity;
    for (let place = 0; place < (wish.isBlock ? BLOCK_PLACES : PLACES); place++) {
      const box = this.boxOf(wish, place, lines);
      const { left, top, width, height } = box;
      if (left < 0 || top < 0 || left + width > this.width || top + height > this.height) continue;
      if (wish.isBlock && this.laid.some((laid) => isFirm(laid.wish, wish) && overlap(laid, box))) continue;
      const covered = this.closed.filter((closed) => overlap(closed, box)).length;
      const hits = (/** @type {number} */ mask) => this.moments[0].hits(99, mask, left, top, left + width, top + height);
      const displaced = this.under(wish, box, wishes).length;
      const lost = displaced + HIDDEN * hits(SYMBOL) + hits(VECTOR) + COVERED * covered;
      if (lost < least) [best, least] = [place, lost];
    }
    if (wish.isBlock && least === Infinity) return [];
    const lost = this.under(wish, this.boxOf(wish, best, lines), wishes);
    for (const other of lost) {
      for (const shape of this.shapes[other]) for (const moment of this.moments) moment.remove(shape);
      wishes[other].spot.place = -1;
      const at = this.laid.findIndex((laid) => laid.wish === wishes[other]);
      this.laid.splice(at, 1);
    }
    Object.assign(wish.spot, { place: best, lines, isForced: true });
    this.layAt(owner, wish, best, lines);
    return lost;
  }

  /** Owners of labels that `wish` displaces from a rectangle. @private
   * @param {Wish} wish @param {Box} box @param {Wish[]} wishes */
  under(wish, box, wishes) {
    const owners = [];
    for (const laid of this.laid)
      if (!isFirm(laid.wish, wish) && overlap(laid, box)) owners.push(wishes.indexOf(laid.wish));
    return owners;
  }

  /** Rectangle of a label at a place. @private @param {Wish} wish @param {number} place @param {number} lines */
  boxOf(wish, place, lines) {
    const [right, down] = DIRECTIONS[place % DIRECTIONS.length];
    const length = ALL_LENGTHS[Math.floor(place / DIRECTIONS.length)];
    const width = wish.widths[lines - 1];
    const height = wish.heights[lines - 1];
    return {
      left: wish.x + length * right - (width * (1 - Math.sign(right))) / 2,
      top: wish.y + length * down - (height * (1 - Math.sign(down))) / 2,
      width,
      height,
    };
  }

  /**
   * Whether a label can be at a place.
   * @private @param {Wish} wish @param {number} place @param {number} lines @param {number} margin @param {number} mask
   */
  isFree(wish, place, lines, margin, mask) {
    const { left, top, width, height } = this.boxOf(wish, place, lines);
    const [right, bottom] = [left + width, top + height];
    if (left < margin || top < margin || right > this.width - margin || bottom > this.height - margin) return false;
    return this.moments[0].hits(1, mask, left - margin, top - margin, right + margin, bottom + margin) === 0;
  }

  /** For how long of the time ahead a place is no longer free, in units of BRIEF_S. @private
   * @param {Wish} wish @param {number} place @param {number} lines */
  brevity(wish, place, lines) {
    const { left, top, width, height } = this.boxOf(wish, place, lines);
    for (let k = 1; k < this.depth; k++) {
      const [x, y] = [left + AHEAD[k] * wish.vx, top + AHEAD[k] * wish.vy];
      const inside = x >= 0 && y >= 0 && x + width <= this.width && y + height <= this.height;
      if (!inside || this.moments[k].hits(1, HARD, x, y, x + width, y + height) > 0)
        return 1 + (AHEAD_S - AHEAD[k]) / BRIEF_S;
    }
    return 0;
  }

  /** Whether a place is free again soon. @private @param {Wish} wish @param {number} place @param {number} lines */
  isSoonFree(wish, place, lines) {
    const { left, top, width, height } = this.boxOf(wish, place, lines);
    const [x, y] = [left + PASSED_S * wish.vx, top + PASSED_S * wish.vy];
    return this.moments[PASSED].hits(1, HARD, x, y, x + width, y + height) === 0;
  }

  /** Whether nothing lies between a symbol and its label. @private
   * @param {number} owner @param {Wish} wish @param {number} place @param {number} lines */
  hasLeader(owner, wish, place, lines) {
    if (place < DIRECTIONS.length) return true;
    const [toX, toY] = leaderEnd(wish.x, wish.y, this.boxOf(wish, place, lines));
    return this.moments[0].isClear(owner, wish.x, wish.y, toX, toY);
  }

  /** @private @param {number} owner @param {Wish} wish @param {number} place @param {number} lines */
  layAt(owner, wish, place, lines) {
    const { left, top } = this.boxOf(wish, place, lines);
    this.lay(owner, wish, left, top, lines);
  }

  /** @private @param {number} owner @param {Wish} wish @param {number} left @param {number} top @param {number} lines */
  lay(owner, wish, left, top, lines) {
    const box = { left, top, width: wish.widths[lines - 1], height: wish.heights[lines - 1] };
    const { x, y, vx, vy } = wish;
    const [toX, toY] = leaderEnd(x, y, box);
    this.shapes[owner] = [
      this.add(BOX, owner, left - PAD_X, top - PAD_Y, left + box.width + PAD_X, top + box.height + PAD_Y, vx, vy),
      this.add(LEADER, owner, x, y, toX, toY, vx, vy),
    ];
    this.laid.push({ wish, lines, ...box });
  }
}

/**
 * Point of a label that its leader goes to: the nearest.
 * @param {number} x @param {number} y @param {Box} box @returns {[number, number]}
 */
export function leaderEnd(x, y, { left, top, width, height }) {
  return [Math.min(left + width, Math.max(left, x)), Math.min(top + height, Math.max(top, y))];
}

/** @param {Box} a @param {Box} b */
export function overlap(a, b) {
  return a.left < b.left + b.width && b.left < a.left + a.width && a.top < b.top + b.height && b.top < a.top + a.height;
}
