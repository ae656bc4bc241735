/**
 * Layers of the map: land, borders, range rings, and the operator's GeoJSON files, each with a switch and a place in
 * the order. Features of GeoJSON have names, styles by the keys of simplestyle 1.1, and the zooms at which they are
 * seen.
 */

import { h } from "./dom.js";
import { lineOf } from "./lines.js";

/** @typedef {import("./lines.js").Line} Line */

/**
 * Style of a feature; "" or NaN: the default of the colour set.
 * @typedef {object} Style
 * @property {string} stroke @property {number} strokeWidth Pixels. @property {number} strokeOpacity
 * @property {string} fill @property {number} fillOpacity
 * @property {string} marker Colour of a point. @property {string} symbol triangle, square, circle or cross
 */

/**
 * @typedef {object} Overlay
 * @property {string} layer Name of its file. @property {string} name @property {Line[]} lines
 * @property {boolean} closed Whether it is an area. @property {boolean} isPoint
 * @property {number} minzoom @property {number} maxzoom Zooms of web maps between which it is seen, both included.
 * @property {Style} style
 */

/** Metres a pixel at zoom 0 of web maps at the equator. */
const ZOOM_0_M = 156_543.034;
/** Scale up to which names of lines and areas are shown without a zoom of their own, metres a pixel. */
const NAMES_UP_TO = 60;
/** Layers that are always there, from the lowest up; GeoJSON files lie between borders and rings. */
const LAND = "land";
const BORDERS = "borders";
const RINGS = "range rings";

/** Zoom of web maps that has this scale. @param {number} scale Metres a pixel. @param {number} latitude Degrees. */
export function zoomOf(scale, latitude) {
  return Math.log2((ZOOM_0_M * Math.cos((latitude * Math.PI) / 180)) / scale);
}

/** @param {unknown} value @returns {number} */
const number = (value) => (value === undefined || value === null || value === "" ? NaN : Number(value));

/** A colour that canvases take, else "". @param {unknown} value */
const colour = (value) => (typeof value === "string" && /^#([0-9a-f]{3}|[0-9a-f]{6})$/i.test(value) ? value : "");

/**
 * Features of a GeoJSON collection whose coordinates are metres.
 * @param {any} collection @returns {Overlay[]}
 */
export function overlaysOf(collection) {
  const features = Array.isArray(collection?.features) ? collection.features : [];
  return features
    .filter((/** @type {any} */ f) => f?.geometry)
    .map((/** @type {any} */ feature) => {
      const { type, coordinates } = feature.geometry;
      const properties = feature.properties ?? {};
      const lines =
        {
          Point: () => [[coordinates]],
          MultiPoint: () => coordinates.map((/** @type {number[]} */ point) => [point]),
          LineString: () => [coordinates],
          MultiLineString: () => coordinates,
          Polygon: () => coordinates,
          MultiPolygon: () => coordinates.flat(),
        }[/** @type {"Point"} */ (type)]?.() ?? [];
      const minzoom = number(properties.minzoom);
      const maxzoom = number(properties.maxzoom);
      return {
        layer: String(collection.name ?? ""),
        name: String(properties.name ?? properties.title ?? properties.ref ?? ""),
        lines: lines.map((/** @type {number[][]} */ line) =>
          lineOf(new Float32Array(line.flatMap((p) => [p[0], p[1]]))),
        ),
        closed: String(type).endsWith("Polygon"),
        isPoint: String(type).endsWith("Point"),
        minzoom: Number.isFinite(minzoom) ? minzoom : -Infinity,
        maxzoom: Number.isFinite(maxzoom) ? maxzoom : Infinity,
        style: {
          stroke: colour(properties.stroke),
          strokeWidth: number(properties["stroke-width"]),
          strokeOpacity: number(properties["stroke-opacity"]),
          fill: colour(properties.fill),
          fillOpacity: number(properties["fill-opacity"]),
          marker: colour(properties["marker-color"]),
          symbol: String(properties["marker-symbol"] ?? "triangle"),
        },
      };
    });
}

/**
 * Layers from the lowest up: those that the setting names in its order, then all others.
 * @param {string} setting Names separated by "|", a minus before one that is switched off.
 * @param {Overlay[]} overlays
 * @returns {{name: string, isOn: boolean}[]}
 */
export function layersOf(setting, overlays) {
  const there = [LAND, BORDERS, ...new Set(overlays.map(({ layer }) => layer)), RINGS];
  const named = setting
    .split("|")
    .map((word) => ({ name: word.replace(/^-/, ""), isOn: !word.startsWith("-") }))
    .filter(({ name }, k, all) => there.includes(name) && all.findIndex((other) => other.name === name) === k);
  const known = named.map(({ name }) => name);
  return [...named, ...there.filter((name) => !known.includes(name)).map((name) => ({ name, isOn: true }))];
}

/** Setting that makes these layers. @param {{name: string, isOn: boolean}[]} layers */
export function layersText(layers) {
  return layers.map(({ name, isOn }) => (isOn ? name : `-${name}`)).join("|");
}

/**
 * Switches and order of the layers, the uppermost first.
 * @param {string} setting @param {Overlay[]} overlays @param {(patch: {maps: string}) => void} set
 */
export function layersChoice(setting, overlays, set) {
  const layers = layersOf(setting, overlays);
  const rows = layers.map(({ name, isOn }, k) => {
    const control = h("input", { type: "checkbox", checked: isOn, "data-layer": name });
    control.addEventListener("change", () => {
      // A focused control would hold the panel still.
      control.blur();
      set({ maps: layersText(layers.map((layer, other) => (other === k ? { name, isOn: !isOn } : layer))) });
    });
    const up = h("button", { title: `${name} further up`, "data-up": name, disabled: k === layers.length - 1 }, "↑");
    up.addEventListener("click", () => {
      up.blur();
      const moved = [...layers];
      [moved[k], moved[k + 1]] = [moved[k + 1], moved[k]];
      set({ maps: layersText(moved) });
    });
    return h("div.setting", {}, h("label", {}, control, ` ${name}`), up);
  });
  return h("div.pad", {}, h("h2", {}, "Map layers, the uppermost first"), ...rows.reverse());
}

/**
 * Features of one layer, then their names where there is room.
 * @param {CanvasRenderingContext2D} ctx @param {import("./view.js").View} view
 * @param {import("./colours.js").Colours} colours @param {Overlay[]} overlays Of the layer.
 * @param {number} zoom @param {number} dim Opacity of the map.
 * @param {(lines: Line[], closed: boolean) => void} trace Adds lines to the path.
 * @param {[number, number, number, number][]} taken Boxes of names: left, top, width, height; names are added.
 */
export function paintOverlays(ctx, view, colours, overlays, zoom, dim, trace, taken) {
  const shown = overlays.filter(({ minzoom, maxzoom }) => minzoom <= zoom && zoom <= maxzoom);
  const or = (/** @type {number} */ value, /** @type {number} */ usual) => (Number.isFinite(value) ? value : usual);
  for (const { lines, closed, isPoint, style } of shown) {
    ctx.strokeStyle = style.stroke || colours.overlay;
    ctx.lineWidth = or(style.strokeWidth, 1);
    if (isPoint) {
      ctx.strokeStyle = style.marker || style.stroke || colours.overlay;
      ctx.lineWidth = 1.3;
      ctx.globalAlpha = dim;
      ctx.beginPath();
      for (const { points } of lines) symbol(ctx, style.symbol, ...view.toScreen(points[0], points[1]));
      ctx.stroke();
      continue;
    }
    ctx.beginPath();
    trace(lines, closed);
    if (closed) {
      ctx.fillStyle = style.fill || colours.overlay;
      ctx.globalAlpha = dim * or(style.fillOpacity, style.fill ? 0.6 : 0.25);
      ctx.fill("evenodd");
    }
    ctx.globalAlpha = dim * or(style.strokeOpacity, 1);
    if (ctx.lineWidth > 0 && style.strokeWidth !== 0) ctx.stroke();
  }
  ctx.globalAlpha = dim;
  ctx.font = "11px system-ui, 'DejaVu Sans', sans-serif";
  // Points are found by their names alone.
  const points = shown.filter(({ isPoint }) => isPoint);
  for (const overlay of [...points, ...shown.filter(({ isPoint }) => !isPoint)]) {
    const { name, lines, isPoint, style } = overlay;
    if (name === "" || lines.length === 0) continue;
    if (!isPoint && overlay.minzoom === -Infinity && view.scale >= NAMES_UP_TO) continue;
    const [east, north] = isPoint ? lines[0].points : middleOf(lines[0]);
    const [x, y] = view.toScreen(east, north);
    if (x < 0 || y < 0 || x > view.width || y > view.height) continue;
    const width = ctx.measureText(name).width;
    const left = isPoint ? x + 7 : x - width / 2;
    /** @type {[number, number, number, number]} */
    const box = [left, y - 9, width, 12];
    if (taken.some((other) => overlap(box, other))) continue;
    taken.push(box);
    ctx.fillStyle = style.marker || style.stroke || colours.overlay;
    ctx.fillText(name, left, y + (isPoint ? 4 : 0));
  }
  ctx.globalAlpha = dim;
}

/** @param {number[]} a @param {number[]} b Left, top, width, height. */
function overlap(a, b) {
  return a[0] < b[0] + b[2] && b[0] < a[0] + a[2] && a[1] < b[1] + b[3] && b[1] < a[1] + a[3];
}

/** Middle of the box round a line. @param {Line} line */
function middleOf(line) {
  return [(line.west + line.east) / 2, (line.south + line.north) / 2];
}

/** @param {CanvasRenderingContext2D} ctx @param {string} kind @param {number} x @param {number} y */
function symbol(ctx, kind, x, y) {
  if (kind === "circle") {
    ctx.moveTo(x + 4, y);
    ctx.arc(x, y, 4, 0, 2 * Math.PI);
  } else if (kind === "square") ctx.rect(x - 3.5, y - 3.5, 7, 7);
  else if (kind === "cross") {
    ctx.moveTo(x - 4, y);
    ctx.lineTo(x + 4, y);
    ctx.moveTo(x, y - 4);
    ctx.lineTo(x, y + 4);
  } else {
    ctx.moveTo(x, y - 5);
    ctx.lineTo(x + 4.5, y + 3.5);
    ctx.lineTo(x - 4.5, y + 3.5);
    ctx.closePath();
  }
}
