/**
 * Stations that are no targets: base stations and aids to navigation, as a layer beneath the tracks.
 *
 * A station stays where it is between its reports, which may be minutes apart: the picture keeps the latest of each
 * until it is too old. An aid is a diamond with a crosshair, dashed if it is virtual, and has the colour of alerts
 * where it is off its position (SN.1/Circ.243/Rev.2 of the International Maritime Organization); a base station is a
 * box with the letters BS. Names stand beside the marks at close scales, where there is room; all that is known of a
 * station stands beside it while the pointer is there.
 */

import { FONT } from "./labels.js";
import { AID_KIND, PICTURE_STATION } from "./wire.js";

/**
 * @typedef {object} Station
 * @property {number} mmsi
 * @property {number} source Source that received its latest report.
 * @property {number} time Of its latest report, seconds UTC.
 * @property {number} east @property {number} north metres
 * @property {string} name "": unknown.
 * @property {string} aid Kind of an aid to navigation. @property {boolean} isBase Whether it is a base station.
 * @property {boolean} isVirtual @property {boolean} isOff Whether it is off its position.
 * @property {number} length @property {number} width metres; 0: unknown.
 */

/** Metres a pixel up to which names are shown. */
const NAME_SCALE = 25;
/** Most names on the screen. */
const NAMES_MAX = 200;
/** Distance of the pointer at which a station is meant, pixels. */
const REACH = 10;
const NAME_HEIGHT = 13;
const SIGN_FONT = '8px "DejaVu Sans Mono", ui-monospace, Menlo, Consolas, monospace';

/** @typedef {import("./painter.js").Scene} Scene */

/** @type {import("./layers.js").Layer<Station>} */
export const STATIONS = {
  key: "stations",
  title: "Base stations and aids to navigation",
  isOn: true,
  mark: (record) => ({
    mmsi: record.mmsi,
    source: record.source,
    east: record.east_m,
    north: record.north_m,
    name: record.name.trim(),
    aid: (AID_KIND[record.aid] ?? "unknown").replaceAll("-", " "),
    isBase: (record.flags & PICTURE_STATION.BASE) !== 0,
    isVirtual: (record.flags & PICTURE_STATION.VIRTUAL) !== 0,
    isOff: (record.flags & PICTURE_STATION.OFF_POSITION) !== 0,
    length: record.length_m,
    width: record.width_m,
  }),
  paint(ctx, { view, colours, picture }) {
    const seen = [];
    for (const station of picture.stations.values()) {
      const [x, y] = view.toScreen(station.east, station.north);
      if (x > -20 && y > -20 && x < view.width + 20 && y < view.height + 20) seen.push({ station, x, y });
    }
    // Those off their position are painted last, and have the first names.
    seen.sort((a, b) => Number(a.station.isOff) - Number(b.station.isOff) || a.station.mmsi - b.station.mmsi);
    ctx.lineWidth = 1.3;
    for (const { station, x, y } of seen) {
      ctx.strokeStyle = ctx.fillStyle = station.isOff ? colours.alert : colours.overlay;
      if (station.isBase) paintBase(ctx, x, y);
      else paintAid(ctx, x, y, station.isVirtual);
    }
    ctx.font = FONT;
    /** @type {[number, number, number][]} Left, right and base of the names. */
    const boxes = [];
    for (const { station, x, y } of seen.reverse()) {
      const text = [view.scale <= NAME_SCALE ? station.name : "", station.isOff ? "OFF POSITION" : ""];
      const line = text.filter((part) => part !== "").join(" ");
      if (line === "" || boxes.length === NAMES_MAX) continue;
      const [left, base] = [x + 10, y + 4];
      const right = left + ctx.measureText(line).width;
      if (boxes.some(([from, to, at]) => left < to && from < right && Math.abs(at - base) < NAME_HEIGHT)) continue;
      boxes.push([left, right, base]);
      ctx.fillStyle = station.isOff ? colours.alert : colours.overlay;
      ctx.fillText(line, left, base);
    }
  },
  legend: [
    ["◇", (colours) => colours.overlay, "aid to navigation (virtual: dashed)"],
    ["◇", (colours) => colours.alert, "aid off its position"],
    ["▭", (colours) => colours.overlay, "base station"],
  ],
};

/** @param {CanvasRenderingContext2D} ctx @param {number} x @param {number} y @param {boolean} isVirtual */
function paintAid(ctx, x, y, isVirtual) {
  if (isVirtual) ctx.setLineDash([2.5, 2]);
  ctx.beginPath();
  ctx.moveTo(x, y - 7);
  ctx.lineTo(x + 7, y);
  ctx.lineTo(x, y + 7);
  ctx.lineTo(x - 7, y);
  ctx.closePath();
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.beginPath();
  ctx.moveTo(x - 3, y);
  ctx.lineTo(x + 3, y);
  ctx.moveTo(x, y - 3);
  ctx.lineTo(x, y + 3);
  ctx.stroke();
}

/** @param {CanvasRenderingContext2D} ctx @param {number} x @param {number} y */
function paintBase(ctx, x, y) {
  ctx.strokeRect(x - 7, y - 5.5, 14, 11);
  ctx.font = SIGN_FONT;
  ctx.fillText("BS", x - 5, y + 3);
}

/**
 * MMSI of the station at a pixel; -1: none is near.
 * @param {Iterable<Station>} stations @param {import("./view.js").View} view @param {number} x @param {number} y
 */
export function stationAt(stations, view, x, y) {
  let [found, least] = [-1, REACH];
  for (const { mmsi, east, north } of stations) {
    const [ownX, ownY] = view.toScreen(east, north);
    const distance = Math.hypot(ownX - x, ownY - y);
    if (distance < least) [found, least] = [mmsi, distance];
  }
  return found;
}

/**
 * What is known of a station, a fact a line.
 * @param {Station} station @param {number} time Of the picture, seconds. @param {string} sourceName
 */
export function stationLines(station, time, sourceName) {
  const kind = station.isBase ? "base station" : `${station.isVirtual ? "virtual " : ""}aid to navigation`;
  const lines = [
    station.name,
    `MMSI ${String(station.mmsi).padStart(9, "0")}`,
    station.isBase || station.aid === "unknown" ? kind : `${kind}: ${station.aid}`,
    station.isOff ? "OFF POSITION" : "",
    station.length > 0 ? `${station.length.toFixed(0)} × ${station.width.toFixed(0)} m` : "",
    // What has not changed comes once a minute: a later report may be known to the source.
    `at most ${Math.max(0, Math.round(time - station.time))} s ago${sourceName && ` by ${sourceName}`}`,
  ];
  return lines.filter((line) => line !== "");
}

/**
 * All that is known of the station under the pointer, above everything else.
 * @param {CanvasRenderingContext2D} ctx @param {Scene} scene
 */
export function paintPointed(ctx, { view, colours, picture, settings, pointed, nameOf }) {
  const station = settings.stations ? picture.stations.get(pointed) : undefined;
  if (!station) return;
  const [x, y] = view.toScreen(station.east, station.north);
  const lines = stationLines(station, picture.time, nameOf(station.source));
  ctx.font = FONT;
  const width = Math.max(...lines.map((line) => ctx.measureText(line).width));
  const height = lines.length * NAME_HEIGHT;
  const left = Math.max(0, Math.min(x + 12, view.width - width - 4));
  const top = Math.max(0, Math.min(y - 8, view.height - height - 4));
  ctx.fillStyle = colours.halo;
  // Twice, so that what it covers cannot be seen.
  for (let k = 0; k < 2; k++) ctx.fillRect(left - 4, top - 2, width + 8, height + 4);
  lines.forEach((line, k) => {
    ctx.fillStyle = line === "OFF POSITION" ? colours.alert : colours.confirmed;
    ctx.fillText(line, left, top + (k + 1) * NAME_HEIGHT - 3);
  });
}
