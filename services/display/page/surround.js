/** What surrounds the map: its scale, the legend, and the place under the pointer. */

import { COLOURS, countColour, SCALE_TOP_M } from "./colours.js";
import { PROBABILITY_LEGEND } from "./coverage.js";
import { byId, grouped, h, setText } from "./dom.js";
import { bearing, magneticText, pathBetween, placeOf, sexagesimal } from "./geodesy.js";
import { lengthText, roundLength } from "./ground.js";
import { levelOf, levelText } from "./labels.js";
import { LAYERS } from "./layers.js";
import { bearingText, distanceText } from "./measuring.js";

/** @typedef {import("./app.js").App} App */

/** @param {App} app */
export function showScale(app) {
  const { length, unit } = roundLength(110 * app.view.scale, app.settings.units);
  const bar = /** @type {HTMLElement} */ (byId("scale").firstElementChild);
  bar.style.width = `${length / app.view.scale}px`;
  setText(/** @type {Element} */ (byId("scale").lastElementChild), lengthText(length, unit));
}

/** @param {App} app */
export function showLegend(app) {
  const { settings } = app;
  const colours = COLOURS[settings.theme];
  /** @type {[string, string, string][]} Sign, its colour, what it says. */
  const lines = [];
  if (settings.colour === "height") {
    const step = SCALE_TOP_M / colours.scale.length;
    const metric = settings.units === "metric";
    colours.scale.forEach((colour, k) => {
      const from = metric
        ? `${Math.round(k * step)} m`
        : `FL ${levelText(levelOf({ height: k * step }))}`;
      lines.unshift(["■", colour, from]);
    });
  } else if (settings.colour === "main") {
    for (const { number, name } of app.known.sources)
      lines.push(["■", colours.sources[number % colours.sources.length], name]);
  } else if (settings.colour === "source") {
    for (const count of [1, 2, 3, 4])
      lines.push(["■", countColour(colours, count), `${count} source${count > 1 ? "s" : ""}`]);
  }
  const state = settings.colour === "state";
  lines.push(
    ["◉", state ? colours.confirmed : colours.unknown, "confirmed"],
    ["○", state ? colours.tentative : colours.unknown, "tentative"],
    ["⊗", state ? colours.coasted : colours.unknown, "coasted"],
    ["⬡", state ? colours.confirmed : colours.unknown, "group"],
    ["□", state ? colours.confirmed : colours.unknown, "on ground"],
  );
  if (settings.sensors)
    lines.push(
      ["+", colours.sensor.radar, "radar"],
      ["△", colours.sensor.multilateration, "multilateration"],
      ["□", colours.sensor["ads-b"], "ADS-B"],
      ["◇", colours.sensor.tracker, "other sensor"],
    );
  if (settings.pd !== "") lines.push(...PROBABILITY_LEGEND);
  const layers = LAYERS.filter(({ key }) => settings[key] && (key !== "stations" || app.picture.stations.size > 0));
  for (const { legend } of layers)
    for (const [sign, colour, text] of legend ?? []) lines.push([sign, colour(colours), text]);
  if (settings.at > 0 && !app.isRecording && layers.length > 0)
    lines.push(["–", colours.unknown, "detections, bearings, counts: not kept"]);
  const legend = byId("legend");
  legend.replaceChildren(
    ...lines.flatMap(([sign, colour, text]) => {
      const mark = h("b", {}, sign);
      mark.style.color = colour;
      return [mark, h("span", {}, text)];
    }),
  );
}

/** Where the cursor is. @param {App} app @param {number} x @param {number} y */
export function showCursor(app, x, y) {
  const [east, north] = app.view.toGround(x, y);
  const place = placeOf(app.known.origin, east, north);
  const path = pathBetween(app.known.origin, { east: 0, north: 0 }, { east, north });
  const fromOrigin = path ? `${bearingText(path.there)}  ${distanceText(path.range, app.settings.units)}` : "";
  const signed = (/** @type {number} */ v) => `${v < 0 ? "−" : "+"}${grouped(Math.abs(v))}`;
  const variation = app.known.declination;
  const magnetic = Number.isFinite(variation) ? ` ${magneticText(bearing(east, north), variation)}` : "";
  const where = place
    ? `${sexagesimal(place.latitude_deg, "N", "S")} ${sexagesimal(place.longitude_deg, "E", "W")}`
    : "beyond the horizon";
  setText(byId("cursor"), `${where}\nE ${signed(east)} m  N ${signed(north)} m  ${fromOrigin}${magnetic}`);
}
