/**
 * Layers of marks: what a sensor measured at a moment, drawn beneath the tracks until it is too old, and stations that
 * are no targets, which stay until they are silent.
 *
 * A layer is an entry here: its key in addresses and requests, its title, how a record of a picture becomes a mark, and
 * how its marks are painted. Settings, requests, storage and panel take the layers from this list, in its order.
 */

import { FONT } from "./labels.js";
import { STATIONS } from "./stations.js";
import { PICTURE_AREA_KIND } from "./wire.js";

/** @typedef {"detections" | "areas" | "bearings" | "stations"} LayerKey */

/**
 * A mark: its source, the time of measurement, seconds UTC, and its place, metres.
 * @typedef {{source: number, time: number, east: number, north: number}} Mark
 * @typedef {Mark & {bearing: number, sigma: number}} Ray Direction and its standard deviation, radians.
 * @typedef {Mark & {targets: number, cue: boolean, major: number, minor: number, bearing: number}} Area Number of
 *   targets, or of a cue's track; half axes, metres, and the direction of the longer one, radians.
 */

/**
 * @template {Mark} T
 * @typedef {object} Layer
 * @property {LayerKey} key Of the setting, the request and the block of a picture.
 * @property {string} title
 * @property {boolean} [isOn] Whether it is shown unless it is switched off.
 * @property {(record: any) => Omit<Mark, "time"> & Partial<T>} mark Of a record of the block, without its time.
 * @property {(ctx: CanvasRenderingContext2D, scene: import("./painter.js").Scene, marks: T[]) => void} paint
 * @property {[string, (colours: import("./colours.js").Colours) => string, string][]} [legend] Signs, colours, texts.
 */

/** @type {Layer<Mark>} */
const DETECTIONS = {
  key: "detections",
  title: "Detections",
  mark: (spot) => ({ source: spot.source, east: spot.east_m, north: spot.north_m }),
  paint(ctx, { view, colours }, spots) {
    const m = view.matrix();
    ctx.fillStyle = colours.sensor.detection;
    for (const { east, north } of spots) {
      const x = m.a * east + m.c * north + m.x0;
      const y = m.b * east + m.d * north + m.y0;
      ctx.fillRect(x - 1, y - 1, 2, 2);
    }
  },
  legend: [["·", (colours) => colours.sensor.detection, "detection"]],
};

/** Areas in which wide-area sensors have counted targets, with their numbers, and cues. @type {Layer<Area>} */
const AREAS = {
  key: "areas",
  title: "Wide-area counts and cues",
  mark: (area) => ({
    source: area.sensor,
    east: area.east_m,
    north: area.north_m,
    targets: area.number,
    cue: PICTURE_AREA_KIND[area.kind] === "cue",
    major: area.semi_major_m,
    minor: area.semi_minor_m,
    bearing: area.semi_major_rad,
  }),
  paint(ctx, { view, colours }, areas) {
    ctx.font = FONT;
    ctx.lineWidth = 1.2;
    for (const area of areas) {
      const [x, y] = view.toScreen(area.east, area.north);
      ctx.strokeStyle = ctx.fillStyle = area.cue ? colours.sensor["ads-b"] : colours.sensor.tracker;
      const turn = area.bearing - view.up - Math.PI / 2;
      ctx.setLineDash(area.cue ? [5, 3] : []);
      ctx.beginPath();
      ctx.ellipse(
        x,
        y,
        Math.max(7, area.major / view.scale),
        Math.max(7, area.minor / view.scale),
        turn,
        0,
        2 * Math.PI,
      );
      ctx.stroke();
      ctx.setLineDash([]);
      ctx.fillText(area.cue ? `cue ${area.targets}` : String(area.targets), x - 4, y + 4);
    }
  },
};

/** Bearings, as far as the map reaches, each with its standard deviation to either side. @type {Layer<Ray>} */
const BEARINGS = {
  key: "bearings",
  title: "Bearings",
  mark: (ray) => ({
    source: ray.source,
    east: ray.east_m,
    north: ray.north_m,
    bearing: ray.bearing_rad,
    sigma: ray.sigma_rad,
  }),
  paint(ctx, { view, colours }, rays) {
    const reach = 1.5 * Math.hypot(view.width, view.height);
    const middle = new Path2D();
    const sides = new Path2D();
    for (const ray of rays) {
      const [x, y] = view.toScreen(ray.east, ray.north);
      for (const side of [-1, 0, 1]) {
        const angle = ray.bearing + side * ray.sigma - view.up;
        const path = side === 0 ? middle : sides;
        path.moveTo(x, y);
        path.lineTo(x + reach * Math.sin(angle), y - reach * Math.cos(angle));
      }
    }
    ctx.lineWidth = 1;
    ctx.strokeStyle = colours.sensor.tracker;
    ctx.stroke(middle);
    ctx.globalAlpha = 0.4;
    ctx.stroke(sides);
    ctx.globalAlpha = 1;
  },
};

/** Layers from the lowest up. @type {readonly Layer<any>[]} */
export const LAYERS = Object.freeze([STATIONS, DETECTIONS, AREAS, BEARINGS]);

/**
 * A value for each layer, by key.
 * @template T @param {(layer: Layer<any>) => T} value @returns {Record<LayerKey, T>}
 */
export function ofLayers(value) {
  return /** @type {Record<LayerKey, T>} */ (Object.fromEntries(LAYERS.map((layer) => [layer.key, value(layer)])));
}
