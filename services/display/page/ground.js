/**
 * The lower canvas: land and borders, overlays, range rings. It is painted anew only when the view or what lies there
 * has changed.
 */

import { NAUTICAL_MILE_M } from "./geodesy.js";
import { lineOf, trace } from "./lines.js";
import { paintOverlays, zoomOf } from "./maps.js";

/** @typedef {import("./lines.js").Line} Line */
/** @typedef {{land: Line[], borders: Line[]}} Ground */

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

/**
 * Unit of round lengths near `metres`: kilometres; or nautical miles, and metres below a quarter of one.
 * @param {number} metres @param {string} units
 */
function unitOf(metres, units) {
  if (units === "metric") return 1000;
  return metres < NAUTICAL_MILE_M / 4 ? 1 : NAUTICAL_MILE_M;
}

/**
 * The nearest round length below `metres`, or above it, and its unit: metres, both.
 * @param {number} metres @param {string} units @param {boolean} [up]
 */
export function roundLength(metres, units, up = false) {
  const unit = unitOf(metres, units);
  const power = unit * 10 ** Math.floor(Math.log10(metres / unit));
  const step = up ? [1, 2, 5].find((s) => s * power >= metres) ?? 10 : [5, 2].find((s) => s * power <= metres) ?? 1;
  return { length: step * power, unit };
}

/** Text of a round length. @param {number} metres @param {number} unit */
export function lengthText(metres, unit) {
  if (unit === NAUTICAL_MILE_M) return `${Number((metres / unit).toPrecision(3))} NM`;
  return unit === 1000 && metres >= 1000 ? `${Number((metres / unit).toPrecision(3))} km` : `${Number(metres.toPrecision(3))} m`;
}

/**
 * @typedef {object} GroundScene
 * @property {Ground} ground @property {import("./maps.js").Overlay[]} overlays
 * @property {{name: string, isOn: boolean}[]} layers From the lowest up.
 * @property {{east: number, north: number, name: string}[]} sites Sensors.
 * @property {{rings: boolean, siterings: boolean, dim: boolean, units: string}} settings
 * @property {number} latitude Of the origin, degrees.
 */

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("./view.js").View} view
 * @param {import("./colours.js").Colours} colours
 * @param {GroundScene} scene
 * @returns {import("./placement.js").Box[]} Names that it has written.
 */
export function paintGround(ctx, view, colours, { ground, overlays, layers, sites, settings, latitude }) {
  ctx.fillStyle = colours.water;
  ctx.fillRect(0, 0, view.width, view.height);
  const matrix = view.matrix();
  const bounds = view.bounds();
  const dim = settings.dim ? 0.45 : 1;
  const zoom = zoomOf(view.scale, latitude);
  const lines = (/** @type {Line[]} */ lines, /** @type {boolean} */ closed) => trace(ctx, matrix, bounds, lines, closed);
  /** @type {[number, number, number, number][]} */
  const names = [];
  ctx.lineJoin = "round";
  for (const { name, isOn } of layers) {
    if (!isOn) continue;
    ctx.globalAlpha = dim;
    ctx.lineWidth = 1;
    if (name === "land") {
      ctx.beginPath();
      lines(ground.land, true);
      ctx.fillStyle = colours.land;
      ctx.fill("evenodd");
      ctx.strokeStyle = colours.coast;
      ctx.stroke();
    } else if (name === "borders") {
      ctx.beginPath();
      lines(ground.borders, false);
      ctx.strokeStyle = colours.border;
      ctx.stroke();
    } else if (name === "range rings") {
      const centres = settings.siterings ? centresOf(sites) : [];
      if (settings.rings) centres.unshift({ east: 0, north: 0, name: "" });
      for (const centre of centres) names.push(...paintRings(ctx, view, colours, bounds, centre, settings.units));
    } else {
      const own = overlays.filter(({ layer }) => layer === name);
      paintOverlays(ctx, view, colours, own, zoom, dim, lines, names);
    }
  }
  ctx.globalAlpha = 1;
  return names.map(([left, top, width, height]) => ({ left, top, width, height }));
}

/**
 * Writes a name, and returns its box: left, top, width, height.
 * @param {CanvasRenderingContext2D} ctx @param {string} text @param {number} x @param {number} y Its base line.
 * @returns {[number, number, number, number]}
 */
function written(ctx, text, x, y) {
  ctx.fillText(text, x, y);
  return [x, y - 9, ctx.measureText(text).width, 11];
}

/**
 * Places of sensors; sensors within a hundred metres share one.
 * @param {{east: number, north: number, name: string}[]} sites
 */
export function centresOf(sites) {
  /** @type {{east: number, north: number, name: string}[]} */
  const centres = [];
  for (const { east, north, name } of sites) {
    if (!Number.isFinite(east)) continue;
    const near = centres.find((other) => Math.hypot(other.east - east, other.north - north) < 100);
    if (near) near.name += `, ${name}`;
    else centres.push({ east, north, name });
  }
  return centres;
}

/**
 * Rings about the origin or a sensor, with their radii, and a cross in the middle.
 * @param {CanvasRenderingContext2D} ctx
 * @param {import("./view.js").View} view
 * @param {import("./colours.js").Colours} colours
 * @param {number[]} bounds
 * @param {{east: number, north: number, name: string}} centre @param {string} units
 * @returns {[number, number, number, number][]} Boxes of the names that it has written.
 */
function paintRings(ctx, view, colours, [west, south, east, north], centre, units) {
  /** @type {[number, number, number, number][]} */
  const names = [];
  // Rings stand at least 120 pixels apart.
  const { length: step, unit } = roundLength(120 * view.scale, units, true);
  const [left, right] = [west - centre.east, east - centre.east];
  const [low, high] = [south - centre.north, north - centre.north];
  const nearest = Math.hypot(Math.max(left, -right, 0), Math.max(low, -high, 0));
  const farthest = Math.hypot(Math.max(-left, right), Math.max(-low, high));
  const [x, y] = view.toScreen(centre.east, centre.north);
  ctx.strokeStyle = colours.grid;
  ctx.lineWidth = 1;
  ctx.setLineDash([2, 4]);
  ctx.beginPath();
  for (let ring = Math.max(1, Math.floor(nearest / step)); ring * step <= farthest; ring++) {
    const radius = (ring * step) / view.scale;
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
  if (centre.name !== "") names.push(written(ctx, centre.name, x + 6, y + 12));
  for (let ring = Math.max(1, Math.floor(nearest / step)); ring * step <= farthest; ring++) {
    const radius = (ring * step) / view.scale;
    names.push(written(ctx, lengthText(ring * step, unit), x + 3, y - radius - 3));
  }
  return names;
}
