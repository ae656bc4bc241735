/**
 * The lower canvas: land and borders, overlays, range rings. It is painted anew only when the view or what lies there
 * has changed.
 */

import { NAUTICAL_MILE_M } from "./geodesy.js";

/** @typedef {{west: number, south: number, east: number, north: number, points: Float32Array}} Line */
/** @typedef {{land: Line[], borders: Line[]}} Ground */
/** @typedef {{name: string, kind: string, lines: Line[], closed: boolean}} Overlay */

/**
 * Lines from the server's octets: pairs of east and north in metres, f32 little-endian. NaN ends a line, a pair of
 * infinities ends the land.
 * @param {ArrayBuffer} octets @returns {Ground}
 */
export function groundOf(octets) {
  const values = new Float32Array(octets);
  /** @type {Ground} */
  const ground = { land: [], borders: [] };
  let lines = ground.land;
  let start = 0;
  for (let k = 0; k + 1 < values.length; k += 2) {
    if (values[k] === Infinity) {
      lines = ground.borders;
      start = k + 2;
    } else if (Number.isNaN(values[k])) {
      if (k > start + 2) lines.push(lineOf(values.subarray(start, k)));
      start = k + 2;
    }
  }
  return ground;
}

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
 * Lines of a GeoJSON collection whose coordinates are metres; a point is a line of one point.
 * @param {any} collection @returns {Overlay[]}
 */
export function overlaysOf(collection) {
  const features = Array.isArray(collection?.features) ? collection.features : [];
  return features
    .filter((/** @type {any} */ f) => f?.geometry)
    .map((/** @type {any} */ feature) => {
      const { type, coordinates } = feature.geometry;
      const lines =
        {
          Point: () => [[coordinates]],
          MultiPoint: () => coordinates.map((/** @type {number[]} */ point) => [point]),
          LineString: () => [coordinates],
          MultiLineString: () => coordinates,
          Polygon: () => coordinates,
          MultiPolygon: () => coordinates.flat(),
        }[/** @type {"Point"} */ (type)]?.() ?? [];
      return {
        name: String(feature.properties?.name ?? feature.properties?.ref ?? ""),
        kind: String(feature.properties?.aeroway ?? ""),
        lines: lines.map((/** @type {number[][]} */ line) =>
          lineOf(new Float32Array(line.flatMap((p) => [p[0], p[1]]))),
        ),
        closed: String(type).endsWith("Polygon"),
      };
    });
}

/**
 * Distance between two range rings, nautical miles, so that they stand some 120 pixels apart.
 * @param {number} scale metres a pixel
 */
export function ringStep(scale) {
  const wanted = (120 * scale) / NAUTICAL_MILE_M;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const step = [1, 2, 5, 10].find((s) => s * power >= wanted) ?? 10;
  return step * power;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("./view.js").View} view
 * @param {import("./colours.js").Colours} colours
 * @param {Ground} ground
 * @param {Overlay[]} overlays
 * @param {{rings: boolean, dim: boolean}} settings
 * @returns {import("./placement.js").Box[]} Names that it has written.
 */
export function paintGround(ctx, view, colours, ground, overlays, settings) {
  ctx.fillStyle = colours.water;
  ctx.fillRect(0, 0, view.width, view.height);
  const matrix = view.matrix();
  const bounds = view.bounds();
  /** @type {import("./placement.js").Box[]} */
  const names = [];
  ctx.globalAlpha = settings.dim ? 0.45 : 1;
  ctx.lineJoin = "round";

  ctx.beginPath();
  trace(ctx, matrix, bounds, ground.land, true);
  ctx.fillStyle = colours.land;
  ctx.fill("evenodd");
  ctx.strokeStyle = colours.coast;
  ctx.lineWidth = 1;
  ctx.stroke();
  ctx.beginPath();
  trace(ctx, matrix, bounds, ground.borders, false);
  ctx.strokeStyle = colours.border;
  ctx.stroke();

  ctx.strokeStyle = colours.overlay;
  ctx.fillStyle = colours.overlay;
  ctx.font = "11px system-ui, 'DejaVu Sans', sans-serif";
  for (const overlay of overlays) {
    ctx.beginPath();
    trace(ctx, matrix, bounds, overlay.lines, overlay.closed);
    if (overlay.closed) {
      ctx.globalAlpha *= 0.25;
      ctx.fill("evenodd");
      ctx.globalAlpha = settings.dim ? 0.45 : 1;
    }
    for (const { points } of overlay.lines) {
      if (points.length > 2) continue;
      const [x, y] = view.toScreen(points[0], points[1]);
      ctx.rect(x - 2, y - 2, 4, 4);
    }
    ctx.stroke();
    if (overlay.name !== "" && overlay.lines.length > 0 && view.scale < 60) {
      const [east, north] = overlay.lines[0].points;
      const [x, y] = view.toScreen(east, north);
      names.push(written(ctx, overlay.name, x + 4, y - 4));
    }
  }
  if (settings.rings) names.push(...paintRings(ctx, view, colours, bounds));
  ctx.globalAlpha = 1;
  return names;
}

/** Writes a name. @param {CanvasRenderingContext2D} ctx @param {string} text @param {number} x @param {number} y Its base line.
 * @returns {import("./placement.js").Box} */
function written(ctx, text, x, y) {
  ctx.fillText(text, x, y);
  return { left: x, top: y - 9, width: ctx.measureText(text).width, height: 11 };
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {{a: number, b: number, c: number, d: number, x0: number, y0: number}} m
 * @param {number[]} bounds @param {Line[]} lines @param {boolean} closed
 */
function trace(ctx, m, [west, south, east, north], lines, closed) {
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

/**
 * Rings about the origin, with their radii, and a cross at the origin.
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("./view.js").View} view
 * @param {import("./colours.js").Colours} colours
 * @param {number[]} bounds
 */
function paintRings(ctx, view, colours, [west, south, east, north]) {
  const names = [];
  const step = ringStep(view.scale);
  const nearest = Math.hypot(Math.max(west, -east, 0), Math.max(south, -north, 0)) / NAUTICAL_MILE_M;
  const farthest = Math.hypot(Math.max(-west, east), Math.max(-south, north)) / NAUTICAL_MILE_M;
  const [x, y] = view.toScreen(0, 0);
  ctx.strokeStyle = colours.grid;
  ctx.lineWidth = 1;
  ctx.setLineDash([2, 4]);
  ctx.beginPath();
  for (let ring = Math.max(1, Math.floor(nearest / step)); ring * step <= farthest; ring++) {
    const radius = (ring * step * NAUTICAL_MILE_M) / view.scale;
    ctx.moveTo(x + radius, y);
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
  }
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.moveTo(x - 7, y);
  ctx.lineTo(x + 7, y);
  ctx.moveTo(x, y - 7);
  ctx.lineTo(x, y + 7);
  ctx.stroke();
  ctx.fillStyle = colours.overlay;
  ctx.font = "10px system-ui, 'DejaVu Sans', sans-serif";
  for (let ring = Math.max(1, Math.floor(nearest / step)); ring * step <= farthest; ring++) {
    const radius = (ring * step * NAUTICAL_MILE_M) / view.scale;
    names.push(written(ctx, `${Number((ring * step).toPrecision(3))} NM`, x + 3, y - radius - 3));
  }
  return names;
}
