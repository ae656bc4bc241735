/**
 * The upper canvas: tracks with their symbols, vectors, trails, ellipses and labels, and what is known of the selected.
 *
 * What has one colour is one path, so that thousands of tracks cost a handful of strokes; only the texts are drawn one
 * by one. Nothing needs WebGL. Order is that of meaning: sensor tracks and detections beneath, dim; system tracks
 * above, bright; the selected last.
 */

import { countColour, heightColour } from "./colours.js";
import { paintCoverage } from "./coverage.js";
import { bearing, NAUTICAL_MILE_M } from "./geodesy.js";
import { FONT } from "./labels.js";
import { LAYERS } from "./layers.js";
import { Lettering, VECTOR_MIN } from "./lettering.js";
import { isGrave } from "./picture.js";
import { paintPointed } from "./stations.js";

/** Seconds for which a change of the main source is shown. */
const HAND_OVER_S = 3;
/** How many times longer than they are learned offsets are drawn. */
const OFFSETS_ENLARGED = 100;

/** Width and height of a symbol's image, pixels. */
const SYMBOL_SIZE = 20;

/** @typedef {import("./picture.js").Track} Track */

/**
 * One source's part in the selected track.
 * @typedef {object} Share
 * @property {number} source @property {string} name @property {string} kind
 * @property {number} track Number of the sensor track at its source.
 * @property {number} weight @property {number} accuracy NaN: the rule has none.
 * @property {boolean} fresh The source has reported lately.
 * @property {boolean} centre It is a system track of another centre.
 * @property {number} east @property {number} north Where its sensor track is, metres; NaN: unknown.
 */

/**
 * @typedef {object} Scene
 * @property {import("./view.js").View} view
 * @property {import("./settings.js").Settings} settings
 * @property {import("./colours.js").Colours} colours
 * @property {import("./picture.js").Picture} picture
 * @property {Set<number>} selected Numbers of system tracks.
 * @property {Map<number, Share[]>} shares Contributors of the selected tracks.
 * @property {(track: Track) => boolean} shows Whether the filter lets a track pass.
 * @property {(track: Track) => boolean} prefers Whether its label comes before others.
 * @property {number} hovered Track under the pointer; -1: none.
 * @property {number} pointed MMSI of the station under the pointer; -1: none.
 * @property {(source: number) => string} nameOf
 * @property {import("./placement.js").Box[]} chrome Where no label may lie: controls, and names on the map.
 * @property {(source: number) => string} kindOf
 * @property {import("./panels.js").Source[]} sites Sensors.
 * @property {import("./coverage.js").Coverage} coverage
 * @property {import("./measuring.js").Measuring | null} measure Measuring lines.
 * @property {import("./geodesy.js").Place} origin
 * @property {number} declination Of magnetic north, degrees east; NaN: unknown.
 */

/** Collects, by colour, what is stroked together. */
class Batch {
  constructor() {
    /** @type {Map<string, Path2D>} */
    this.paths = new Map();
  }

  /** @param {string} colour */
  of(colour) {
    let path = this.paths.get(colour);
    if (!path) this.paths.set(colour, (path = new Path2D()));
    return path;
  }

  /** @param {CanvasRenderingContext2D} ctx */
  stroke(ctx) {
    for (const [colour, path] of this.paths) {
      ctx.strokeStyle = colour;
      ctx.stroke(path);
    }
  }
}

export class Painter {
  constructor() {
    this.lettering = new Lettering();
    /** @type {Map<string, ImageBitmap>} */
    this.symbols = new Map();
    /** @type {{track: Track, x: number, y: number}[]} What was drawn last, for finding what was clicked. */
    this.drawn = [];
  }

  /**
   * Colour of a system track under the settings.
   * @param {Scene} scene @param {Track} track
   */
  colourOf({ settings, colours, selected }, track) {
    if (selected.has(track.number)) return colours.selected;
    if (isGrave(track)) return colours.alert;
    if (settings.colour === "height") return heightColour(colours, track.height);
    if (settings.colour === "main")
      return track.source < 0 ? colours.unknown : colours.sources[track.source % colours.sources.length];
    if (settings.colour === "source") return countColour(colours, track.sourceCount);
    if (track.state === "tentative") return colours.tentative;
    return track.state === "confirmed" ? colours.confirmed : colours.coasted;
  }

  /**
   * Paints the scene.
   * @param {CanvasRenderingContext2D} ctx @param {Scene} scene
   */
  paint(ctx, scene) {
    const { view, settings, picture, selected } = scene;
    ctx.clearRect(0, 0, view.width, view.height);
    ctx.lineCap = "butt";
    for (const { key, paint } of LAYERS) if (settings[key]) paint(ctx, scene, picture.marks[key] ?? []);
    if (settings.sensors) this.paintSensorTracks(ctx, scene);
    if (settings.coverage || settings.pd !== "") {
      ctx.font = FONT;
      paintCoverage(ctx, view, scene.colours.sources, scene.coverage, settings.pd);
    }
    if (settings.biases) this.paintSites(ctx, scene);

    this.drawn = [];
    const m = view.matrix();
    const margin = 40;
    for (const track of picture.system.values()) {
      const isSelected = selected.has(track.number);
      if (!scene.shows(track)) continue;
      const x = m.a * track.east + m.c * track.north + m.x0;
      const y = m.b * track.east + m.d * track.north + m.y0;
      if (settings.trails || isSelected) this.drawn.push({ track, x, y });
      else if (x > -margin && y > -margin && x < view.width + margin && y < view.height + margin)
        this.drawn.push({ track, x, y });
    }
    this.paintTrails(ctx, scene);
    this.drawn = this.drawn.filter(
      ({ x, y }) => x > -margin && y > -margin && x < view.width + margin && y < view.height + margin,
    );
    if (settings.sigma > 0) this.paintEllipses(ctx, scene);
    if (settings.vector > 0) this.paintVectors(ctx, scene);
    this.paintShares(ctx, scene);
    this.paintSymbols(ctx, scene);
    scene.measure?.layOut(ctx, scene);
    this.lettering.paint(ctx, scene, this.drawn, (track) => this.colourOf(scene, track));
    scene.measure?.paint(ctx, scene.colours);
    paintPointed(ctx, scene);
  }

  /**
   * Sensor tracks: a cross for radars, a triangle for multilateration, a square for ADS-B, a rhomb for the rest.
   * @param {CanvasRenderingContext2D} ctx @param {Scene} scene
   */
  paintSensorTracks(ctx, { view, picture, colours, kindOf }) {
    const m = view.matrix();
    const batch = new Batch();
    for (const track of picture.sensor.values()) {
      const x = m.a * track.east + m.c * track.north + m.x0;
      const y = m.b * track.east + m.d * track.north + m.y0;
      if (x < -9 || y < -9 || x > view.width + 9 || y > view.height + 9) continue;
      const kind = kindOf(track.source);
      sensorSymbol(batch.of(colours.sensor[kind] ?? colours.sensor.tracker), kind, x, y);
    }
    ctx.lineWidth = 1.2;
    batch.stroke(ctx);
  }

  /**
   * Sensors' sites, and their learned offsets a hundred times enlarged.
   * @param {CanvasRenderingContext2D} ctx @param {Scene} scene
   */
  paintSites(ctx, { view, colours, sites }) {
    ctx.lineWidth = 1.5;
    ctx.font = FONT;
    sites.forEach((site) => {
      if (!Number.isFinite(site.east)) return;
      const [x, y] = view.toScreen(site.east, site.north);
      const [tipX, tipY] = view.toScreen(site.east + site.offset[0], site.north + site.offset[1]);
      const toX = x + (tipX - x) * OFFSETS_ENLARGED;
      const toY = y + (tipY - y) * OFFSETS_ENLARGED;
      ctx.strokeStyle = ctx.fillStyle = colours.sources[site.number % colours.sources.length];
      ctx.strokeRect(x - 4, y - 4, 8, 8);
      arrow(ctx, x, y, toX, toY);
      const length = Math.hypot(site.offset[0], site.offset[1]);
      ctx.fillText(`${site.name} ${length.toFixed(1)} m`, x + 8, y + 14 + 13 * (site.number % 3));
    });
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Scene} scene */
  paintTrails(ctx, scene) {
    const { view, settings, picture } = scene;
    if (settings.trail === 0) return;
    const m = view.matrix();
    const since = settings.trail < 0 ? -Infinity : picture.time - settings.trail;
    const batch = new Batch();
    for (const { track, x, y } of this.drawn) {
      const trail = track.trail;
      if (trail.length === 0) continue;
      const path = batch.of(this.colourOf(scene, track));
      path.moveTo(x, y);
      let lastX = x;
      let lastY = y;
      let next = track.time;
      for (let k = trail.length - 1; k >= 0; k--) {
        const at = trail.at(k);
        const time = trail.timeOf(at);
        if (time < since) break;
        if (time > picture.time + 1) continue;
        const pointX = m.a * trail.east[at] + m.c * trail.north[at] + m.x0;
        const pointY = m.b * trail.east[at] + m.d * trail.north[at] + m.y0;
        if (Math.abs(pointX - lastX) + Math.abs(pointY - lastY) < 1.5) continue;
        // A gap of half a minute interrupts the trail.
        if (next - time > 30) path.moveTo(pointX, pointY);
        else path.lineTo(pointX, pointY);
        lastX = pointX;
        lastY = pointY;
        next = time;
      }
    }
    ctx.globalAlpha = 0.42;
    ctx.lineWidth = 1.3;
    batch.stroke(ctx);
    ctx.globalAlpha = 1;
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Scene} scene */
  paintEllipses(ctx, scene) {
    const { view, settings } = scene;
    const batch = new Batch();
    for (const { track, x, y } of this.drawn) {
      const major = (track.sigmaMajor * settings.sigma) / view.scale;
      const minor = (track.sigmaMinor * settings.sigma) / view.scale;
      if (!(major > 1.5)) continue;
      const path = batch.of(this.colourOf(scene, track));
      const turn = track.sigmaBearing - view.up - Math.PI / 2;
      path.moveTo(x + major * Math.cos(turn), y + major * Math.sin(turn));
      path.ellipse(x, y, major, Math.max(0.5, minor), turn, 0, 2 * Math.PI);
    }
    ctx.globalAlpha = 0.7;
    ctx.lineWidth = 1;
    batch.stroke(ctx);
    ctx.globalAlpha = 1;
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Scene} scene */
  paintVectors(ctx, scene) {
    const { view, settings } = scene;
    const m = view.matrix();
    const batch = new Batch();
    for (const { track, x, y } of this.drawn) {
      if (!track.knowsVelocity) continue;
      const dx = (m.a * track.speedEast + m.c * track.speedNorth) * settings.vector;
      const dy = (m.b * track.speedEast + m.d * track.speedNorth) * settings.vector;
      if (Math.abs(dx) + Math.abs(dy) < VECTOR_MIN) continue;
      const path = batch.of(this.colourOf(scene, track));
      path.moveTo(x, y);
      path.lineTo(x + dx, y + dy);
    }
    ctx.globalAlpha = 0.8;
    ctx.lineWidth = 1.2;
    batch.stroke(ctx);
    ctx.globalAlpha = 1;
  }

  /**
   * Lines from the selected tracks to the sensor tracks that make them, each as wide as its weight.
   * @param {CanvasRenderingContext2D} ctx @param {Scene} scene
   */
  paintShares(ctx, { view, picture, colours, shares, selected }) {
    ctx.font = FONT;
    for (const number of selected) {
      const track = picture.system.get(number);
      if (!track) continue;
      const [x, y] = view.toScreen(track.east, track.north);
      for (const share of shares.get(number) ?? []) {
        if (!Number.isFinite(share.east)) continue;
        const [toX, toY] = view.toScreen(share.east, share.north);
        ctx.strokeStyle = ctx.fillStyle = colours.measure;
        ctx.lineWidth = 0.8 + 4 * share.weight;
        ctx.beginPath();
        ctx.moveTo(x, y);
        ctx.lineTo(toX, toY);
        ctx.stroke();
        const symbol = new Path2D();
        sensorSymbol(symbol, share.kind, toX, toY);
        ctx.lineWidth = 1.4;
        ctx.stroke(symbol);
        if (Math.hypot(toX - x, toY - y) > 30) {
          const text = `${share.name} ${share.weight.toFixed(2)}`;
          ctx.fillText(text, toX + 7, toY + 4);
        }
      }
    }
  }

  /**
   * Symbols of the system tracks. Each form in each colour is drawn once and then copied to whole pixels, which costs a
   * third of drawing thousands of circles.
   * @param {CanvasRenderingContext2D} ctx @param {Scene} scene
   */
  paintSymbols(ctx, scene) {
    const { colours, picture, selected, settings } = scene;
    const ratio = ctx.getTransform().a;
    const marks = new Batch();
    for (const { track, x, y } of this.drawn) {
      const symbol = this.symbolOf(track, this.colourOf(scene, track), ratio);
      const [left, top] = [x - SYMBOL_SIZE / 2, y - SYMBOL_SIZE / 2];
      ctx.drawImage(
        symbol,
        Math.round(left * ratio) / ratio,
        Math.round(top * ratio) / ratio,
        SYMBOL_SIZE,
        SYMBOL_SIZE,
      );
      if (settings.handovers && track.handOver > 0 && picture.time - track.handOver < HAND_OVER_S) {
        const path = marks.of(colours.measure);
        path.moveTo(x + 11, y);
        path.arc(x, y, 11, 0, 2 * Math.PI);
      }
      if (selected.has(track.number)) brackets(marks.of(colours.selected), x, y, 11);
      if (isGrave(track)) marks.of(colours.alert).rect(x - 10, y - 10, 20, 20);
    }
    ctx.lineWidth = 1.5;
    marks.stroke(ctx);
  }

  /**
   * Image of a track's symbol.
   * @param {Track} track @param {string} colour @param {number} ratio Pixels of the screen in one of CSS.
   */
  symbolOf(track, colour, ratio) {
    const key = `${track.state} ${track.kind} ${track.onGround} ${colour} ${ratio}`;
    let image = this.symbols.get(key);
    if (!image) {
      const size = Math.ceil(SYMBOL_SIZE * ratio);
      const canvas = new OffscreenCanvas(size, size);
      const ctx = canvas.getContext("2d");
      if (!ctx) throw new Error("this browser has no canvas");
      ctx.scale(size / SYMBOL_SIZE, size / SYMBOL_SIZE);
      const [line, dot] = [new Path2D(), new Path2D()];
      systemSymbol(line, dot, track, SYMBOL_SIZE / 2, SYMBOL_SIZE / 2);
      ctx.strokeStyle = ctx.fillStyle = colour;
      ctx.lineWidth = 1.5;
      ctx.stroke(line);
      ctx.fill(dot);
      this.symbols.set(key, (image = canvas.transferToImageBitmap()));
    }
    return image;
  }

  /**
   * System track nearest to a pixel, its symbol or label; `null` if none is near.
   * @param {number} x @param {number} y
   */
  at(x, y) {
    return this.symbolAt(x, y) ?? this.lettering.at(x, y)?.track ?? null;
  }

  /** System track whose symbol is nearest to a pixel. @param {number} x @param {number} y @returns {Track | null} */
  symbolAt(x, y) {
    let best = null;
    let least = 14;
    for (const { track, x: ownX, y: ownY } of this.drawn) {
      const distance = Math.hypot(ownX - x, ownY - y);
      if (distance < least) [best, least] = [track, distance];
    }
    return best;
  }
}

/**
 * @param {Path2D} line @param {Path2D} dot @param {Track} track @param {number} x @param {number} y
 */
function systemSymbol(line, dot, track, x, y) {
  const radius = track.state === "tentative" ? 3.5 : 5;
  if (track.kind === "group") {
    for (let k = 0; k <= 6; k++) {
      const angle = (k * Math.PI) / 3;
      const [cornerX, cornerY] = [x + 8 * Math.cos(angle), y + 8 * Math.sin(angle)];
      if (k === 0) line.moveTo(cornerX, cornerY);
      else line.lineTo(cornerX, cornerY);
    }
  } else if (track.onGround) {
    line.rect(x - radius + 0.5, y - radius + 0.5, 2 * radius - 1, 2 * radius - 1);
  } else {
    line.moveTo(x + radius, y);
    line.arc(x, y, radius, 0, 2 * Math.PI);
  }
  if (track.state === "coasted") {
    line.moveTo(x - 7, y - 7);
    line.lineTo(x + 7, y + 7);
    line.moveTo(x + 7, y - 7);
    line.lineTo(x - 7, y + 7);
  } else if (track.state !== "tentative") {
    dot.moveTo(x + 2.2, y);
    dot.arc(x, y, 2.2, 0, 2 * Math.PI);
  }
}

/** @param {Path2D} path @param {string} kind @param {number} x @param {number} y */
function sensorSymbol(path, kind, x, y) {
  if (kind === "radar") {
    path.moveTo(x - 4, y);
    path.lineTo(x + 4, y);
    path.moveTo(x, y - 4);
    path.lineTo(x, y + 4);
  } else if (kind === "multilateration") {
    path.moveTo(x, y - 4);
    path.lineTo(x + 4, y + 3);
    path.lineTo(x - 4, y + 3);
    path.closePath();
  } else if (kind === "ads-b") {
    path.rect(x - 3.5, y - 3.5, 7, 7);
  } else {
    path.moveTo(x, y - 4.5);
    path.lineTo(x + 4.5, y);
    path.lineTo(x, y + 4.5);
    path.lineTo(x - 4.5, y);
    path.closePath();
  }
}

/** @param {Path2D} path @param {number} x @param {number} y @param {number} size */
function brackets(path, x, y, size) {
  for (const [right, down] of [
    [-1, -1],
    [1, -1],
    [1, 1],
    [-1, 1],
  ]) {
    path.moveTo(x + right * size, y + down * (size - 5));
    path.lineTo(x + right * size, y + down * size);
    path.lineTo(x + right * (size - 5), y + down * size);
  }
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x @param {number} y @param {number} toX @param {number} toY
 */
function arrow(ctx, x, y, toX, toY) {
  const angle = Math.atan2(toY - y, toX - x);
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(toX, toY);
  for (const side of [-1, 1]) {
    ctx.moveTo(toX, toY);
    ctx.lineTo(toX - 8 * Math.cos(angle + side * 0.4), toY - 8 * Math.sin(angle + side * 0.4));
  }
  ctx.stroke();
}
