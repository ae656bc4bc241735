/** Lines of the map, metres of the system frame, and their paths on the canvas. */

/** @typedef {{west: number, south: number, east: number, north: number, points: Float32Array}} Line */

/** @param {Float32Array} points @returns {Line} */
export function lineOf(points) {
  const line = { west: Infinity, south: Infinity, east: -Infinity, north: -Infinity, points };
  for (let k = 0; k < points.length; k += 2) {
    line.west = Math.min(line.west, points[k]);
    line.east = Math.max(line.east, points[k]);
    line.south = Math.min(line.south, points[k + 1]);
    line.north = Math.max(line.north, points[k + 1]);
  }
  return line;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {{a: number, b: number, c: number, d: number, x0: number, y0: number}} m
 * @param {number[]} bounds @param {Line[]} lines @param {boolean} closed
 */
export function trace(ctx, m, [west, south, east, north], lines, closed) {
  for (const line of lines) {
    if (line.east < west || line.west > east || line.north < south || line.south > north) continue;
    const points = line.points;
    let lastX = NaN;
    let lastY = NaN;
    for (let k = 0; k < points.length; k += 2) {
      const x = m.a * points[k] + m.c * points[k + 1] + m.x0;
      const y = m.b * points[k] + m.d * points[k + 1] + m.y0;
      if (k === 0) ctx.moveTo(x, y);
      else if (k + 2 < points.length && Math.abs(x - lastX) + Math.abs(y - lastY) < 1.5) continue;
      else ctx.lineTo(x, y);
      lastX = x;
      lastY = y;
    }
    if (closed) ctx.closePath();
  }
}
