/**
 * What lies on the screen: rectangles and segments, found by the cells that they touch. A place is tested against its
 * neighbours alone, whatever the number of tracks.
 */

/** Side of a cell, pixels. */
const CELL = 32;

/** What lies on the screen, as bits. */
export const BOX = 1;
export const VECTOR = 2;
export const LEADER = 4;
export const SYMBOL = 8;
const RECTANGLES = BOX | SYMBOL;
/** No track: what belongs to the map. */
export const NOBODY = -1;

/** Rectangles and segments on the screen, found by the cells that they touch. */
export class Occupancy {
  constructor() {
    this.columns = 1;
    this.rows = 1;
    /** First entry of each cell, then the next of each entry; -1: none. */
    this.heads = new Int32Array(1);
    this.next = new Int32Array(256);
    this.item = new Int32Array(256);
    this.entries = 0;
    /** Of each shape: four coordinates, kind and owner. */
    this.shapes = new Float32Array(256);
    this.kinds = new Uint8Array(64);
    this.owners = new Int32Array(64);
    this.count = 0;
  }

  /** @param {number} width @param {number} height */
  clear(width, height) {
    this.columns = Math.ceil(width / CELL) + 1;
    this.rows = Math.ceil(height / CELL) + 1;
    if (this.heads.length < this.columns * this.rows) this.heads = new Int32Array(this.columns * this.rows);
    this.heads.fill(-1);
    this.entries = this.count = 0;
  }

  /**
   * Adds a rectangle from (x, y) to (toX, toY), or the segment between the two.
   * @param {number} kind @param {number} owner @param {number} x @param {number} y @param {number} toX @param {number} toY
   * @returns {number} The shape.
   */
  add(kind, owner, x, y, toX, toY) {
    const shape = this.count++;
    if (shape === this.kinds.length) {
      this.shapes = doubled(this.shapes, Float32Array);
      this.kinds = doubled(this.kinds, Uint8Array);
      this.owners = doubled(this.owners, Int32Array);
    }
    this.shapes.set([x, y, toX, toY], 4 * shape);
    this.kinds[shape] = kind;
    this.owners[shape] = owner;
    if ((kind & RECTANGLES) !== 0) this.enter(shape, x, y, toX, toY);
    else this.enterAlong(shape, x, y, toX, toY);
    return shape;
  }

  /** Enters a segment piece by piece: the box of a long one holds many cells that it does not touch. @private
   * @param {number} shape @param {number} x @param {number} y @param {number} toX @param {number} toY */
  enterAlong(shape, x, y, toX, toY) {
    const reach = Math.max(Math.abs(toX - x), Math.abs(toY - y));
    const pieces = Math.min(100, Math.max(1, Math.ceil(reach / CELL)));
    const [stepX, stepY] = [(toX - x) / pieces, (toY - y) / pieces];
    for (let k = 0; k < pieces; k++) {
      const [ownX, ownY] = [x + k * stepX, y + k * stepY];
      this.enter(shape, Math.min(ownX, ownX + stepX), Math.min(ownY, ownY + stepY), Math.max(ownX, ownX + stepX), Math.max(ownY, ownY + stepY));
    }
  }

  /** @private @param {number} shape @param {number} x @param {number} y @param {number} toX @param {number} toY */
  enter(shape, x, y, toX, toY) {
    const right = Math.min(this.columns - 1, Math.floor(toX / CELL));
    const bottom = Math.min(this.rows - 1, Math.floor(toY / CELL));
    for (let row = Math.max(0, Math.floor(y / CELL)); row <= bottom; row++)
      for (let column = Math.max(0, Math.floor(x / CELL)); column <= right; column++) {
        if (this.entries === this.next.length) {
          this.next = doubled(this.next, Int32Array);
          this.item = doubled(this.item, Int32Array);
        }
        const cell = row * this.columns + column;
        this.next[this.entries] = this.heads[cell];
        this.item[this.entries] = shape;
        this.heads[cell] = this.entries++;
      }
  }

  /** Takes a shape away. @param {number} shape */
  remove(shape) {
    this.kinds[shape] = 0;
  }

  /**
   * How many shapes of the kinds `mask` lie in a rectangle, one in two cells twice; the count ends at `most`.
   * @param {number} most @param {number} mask @param {number} x @param {number} y @param {number} toX @param {number} toY
   */
  hits(most, mask, x, y, toX, toY) {
    const right = Math.min(this.columns - 1, Math.floor(toX / CELL));
    const bottom = Math.min(this.rows - 1, Math.floor(toY / CELL));
    const { shapes, kinds } = this;
    let found = 0;
    for (let row = Math.max(0, Math.floor(y / CELL)); row <= bottom; row++)
      for (let column = Math.max(0, Math.floor(x / CELL)); column <= right; column++)
        for (let entry = this.heads[row * this.columns + column]; entry >= 0; entry = this.next[entry]) {
          const shape = this.item[entry];
          const kind = kinds[shape];
          if ((kind & mask) === 0) continue;
          const at = 4 * shape;
          if ((kind & RECTANGLES) !== 0) {
            if (shapes[at] >= toX || shapes[at + 2] <= x || shapes[at + 1] >= toY || shapes[at + 3] <= y) continue;
          } else if (!crosses(shapes[at], shapes[at + 1], shapes[at + 2], shapes[at + 3], x, y, toX, toY)) continue;
          if (++found === most) return found;
        }
    return found;
  }

  /**
   * Whether a segment is clear of all rectangles but those of `owner`.
   * @param {number} owner @param {number} x @param {number} y @param {number} toX @param {number} toY
   */
  isClear(owner, x, y, toX, toY) {
    const left = Math.max(0, Math.floor(Math.min(x, toX) / CELL));
    const right = Math.min(this.columns - 1, Math.floor(Math.max(x, toX) / CELL));
    const bottom = Math.min(this.rows - 1, Math.floor(Math.max(y, toY) / CELL));
    const { shapes } = this;
    for (let row = Math.max(0, Math.floor(Math.min(y, toY) / CELL)); row <= bottom; row++)
      for (let column = left; column <= right; column++)
        for (let entry = this.heads[row * this.columns + column]; entry >= 0; entry = this.next[entry]) {
          const shape = this.item[entry];
          if ((this.kinds[shape] & RECTANGLES) === 0 || this.owners[shape] === owner) continue;
          const at = 4 * shape;
          if (crosses(x, y, toX, toY, shapes[at], shapes[at + 1], shapes[at + 2], shapes[at + 3])) return false;
        }
    return true;
  }
}

/** @template {Float32Array | Int32Array | Uint8Array} T @param {T} list @param {new (length: number) => T} type */
function doubled(list, type) {
  const longer = new type(2 * list.length);
  longer.set(list);
  return longer;
}

/**
 * Whether the segment from (x, y) to (toX, toY) meets a rectangle (Liang and Barsky, 1984).
 * @param {number} x @param {number} y @param {number} toX @param {number} toY
 * @param {number} left @param {number} top @param {number} right @param {number} bottom
 */
function crosses(x, y, toX, toY, left, top, right, bottom) {
  let from = 0;
  let to = 1;
  for (let side = 0; side < 4; side++) {
    const step = side < 2 ? toX - x : toY - y;
    const room = side === 0 ? x - left : side === 1 ? right - x : side === 2 ? y - top : bottom - y;
    const toward = side % 2 === 0 ? -step : step;
    if (toward === 0) {
      if (room < 0) return false;
      continue;
    }
    const part = room / toward;
    if (toward < 0) from = Math.max(from, part);
    else to = Math.min(to, part);
    if (from > to) return false;
  }
  return true;
}
