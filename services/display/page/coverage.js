/**
 * Coverage of each source, as the page has seen it: in each direction from the sensor's site the farthest system track
 * to which the source contributed. It holds what was seen since the page was opened.
 */

/** Directions that are told apart. */
const SECTORS = 90;

export class Coverage {
  constructor() {
    /** Farthest distance by sector, metres, by source. @type {Map<number, Float32Array>} */
    this.reach = new Map();
  }

  /**
   * @param {number} source @param {number} east @param {number} north Metres from the sensor's site.
   */
  add(source, east, north) {
    let reach = this.reach.get(source);
    if (!reach) this.reach.set(source, (reach = new Float32Array(SECTORS)));
    const turn = Math.atan2(east, north) / (2 * Math.PI);
    const sector = Math.floor(((turn + 1) % 1) * SECTORS) % SECTORS;
    reach[sector] = Math.max(reach[sector], Math.hypot(east, north));
  }

  /**
   * Outline of a source's coverage, east and north in metres from its site, without the sectors in which nothing was
   * seen.
   * @param {number} source @returns {[number, number][]}
   */
  outline(source) {
    const reach = this.reach.get(source) ?? new Float32Array();
    /** @type {[number, number][]} */
    const points = [];
    reach.forEach((distance, sector) => {
      const angle = ((sector + 0.5) / SECTORS) * 2 * Math.PI;
      if (distance > 0) points.push([distance * Math.sin(angle), distance * Math.cos(angle)]);
    });
    return points;
  }
}
