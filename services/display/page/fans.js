/**
 * Fans: targets whose symbols lie upon each other and move together (vehicles on an apron, a formation). Single labels
 * would cover the map round them; one block with a row for each target, and one leader, does not.
 *
 * Symbols that touch are linked, and what is linked is a group. Targets that cross each other differ in velocity and are
 * not linked. A link once made holds a little longer, so that a block does not come and go.
 */

/** Distance of two symbols that are linked, and of two that were, pixels. */
const LINK = 9;
const LINK_KEPT = 14;
/** Largest difference of their velocities, pixels a second. */
const DRIFT = 0.5;
/** Fewest targets of a group: two find places for their own labels. */
const MEMBERS_MIN = 3;
/** Rows of a column, and columns of a block, at most. */
const ROWS_MAX = 10;
const COLUMNS_MAX = 6;
/** Pixels between two columns. */
const GUTTER = 10;

/** @typedef {{number: number, x: number, y: number, vx: number, vy: number}} Symbol */

/**
 * Groups of symbols, by the number of the target that stands for each.
 * @template {Symbol} S
 * @param {S[]} symbols
 * @param {Map<number, number>} before Of each target in a group of the last picture: which stood for it.
 * @returns {Map<number, S[]>} In the order of their numbers.
 */
export function groupsOf(symbols, before) {
  const sorted = [...symbols].sort((a, b) => a.x - b.x || a.number - b.number);
  const parent = sorted.map((_, k) => k);
  const root = (/** @type {number} */ k) => {
    while (parent[k] !== k) k = parent[k] = parent[parent[k]];
    return k;
  };
  for (let k = 0; k < sorted.length; k++)
    for (let n = k + 1; n < sorted.length && sorted[n].x - sorted[k].x < LINK_KEPT; n++)
      if (linked(sorted[k], sorted[n], before)) parent[root(n)] = root(k);
  /** @type {Map<number, S[]>} */
  const sets = new Map();
  sorted.forEach((symbol, k) => {
    const set = sets.get(root(k));
    if (set) set.push(symbol);
    else sets.set(root(k), [symbol]);
  });
  /** @type {Map<number, S[]>} */
  const groups = new Map();
  for (const set of sets.values()) {
    if (set.length < MEMBERS_MIN) continue;
    const members = set.sort((a, b) => a.number - b.number).slice(0, ROWS_MAX * COLUMNS_MAX);
    const lead = members.find(({ number }) => before.get(number) === number) ?? members[0];
    groups.set(lead.number, members);
  }
  return groups;
}

/** @param {Symbol} a @param {Symbol} b @param {Map<number, number>} before */
function linked(a, b, before) {
  const lead = before.get(a.number);
  const reach = lead !== undefined && lead === before.get(b.number) ? LINK_KEPT : LINK;
  return Math.hypot(a.x - b.x, a.y - b.y) < reach && Math.hypot(a.vx - b.vx, a.vy - b.vy) < DRIFT;
}

/**
 * Rows and columns of a block, and its size.
 * @param {number} count Of rows. @param {number} rowWidth @param {number} rowHeight pixels
 */
export function blockOf(count, rowWidth, rowHeight) {
  const columns = Math.ceil(count / ROWS_MAX);
  const rows = Math.ceil(count / columns);
  return { rows, step: rowWidth + GUTTER, width: columns * (rowWidth + GUTTER) - GUTTER, height: rows * rowHeight };
}
