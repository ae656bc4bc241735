/**
 * The display: settings, picture and selection, and what happens when something of them changes.
 *
 * What comes from the server is put in through `hello`, `changes`, `details` and `learn`; nothing here knows how it
 * travels. What is on the screen follows: the map in the next frame, the panels about twice a second.
 */

import { Alarms } from "./alarms.js";
import { COLOURS } from "./colours.js";
import { Coverage } from "./coverage.js";
import { byId, setText } from "./dom.js";
import { readFilter } from "./filter.js";
import { paintGround } from "./ground.js";
import { showHeader } from "./header.js";
import { KeptViews, keepHabits } from "./kept.js";
import { LABEL_LINES, labelOf } from "./labels.js";
import { layersOf } from "./maps.js";
import { controlsOn } from "./nudge.js";
import { Operator } from "./operator.js";
import { controlOrders } from "./orders.js";
import { Painter } from "./painter.js";
import { forgetMains, HAND_OVER_AFTER_S, noteMain, Picture, Trail } from "./picture.js";
import { read, write } from "./settings.js";
import { Side } from "./side.js";
import { showLegend, showScale } from "./surround.js";
import { View } from "./view.js";

/** @typedef {import("./picture.js").Track} Track */
/** @typedef {import("./settings.js").Settings} Settings */
/** @typedef {import("./panels.js").Known} Known */
/** @typedef {import("./panels.js").History} History */
/** @typedef {import("./picture.js").Spot} Spot */
/** @typedef {Partial<Omit<Track, "trail" | "mains">> & {number: number}} Change */

/** Time for which a page that has just been opened follows the tracks that appear, seconds. */
const FIT_AT_FIRST_S = 30;
/** Points that the plots of a selected track keep. */
const HISTORY_MAX = 3000;

export class App {
  /** @param {() => void} asked What is wanted of the server has changed. */
  constructor(asked) {
    this.asked = asked;
    this.settings = read(location.hash);
    this.view = new View();
    this.picture = new Picture();
    this.painter = new Painter();
    this.coverage = new Coverage();
    /** @type {Set<number>} */
    this.selected = new Set();
    /** @type {Map<number, import("./panels.js").Share[]>} */
    this.shares = new Map();
    /** @type {Map<number, History>} */
    this.histories = new Map();
    /** @type {Map<number, import("./panels.js").Facts>} */
    this.facts = new Map();
    /** @type {Known} */
    this.known = {
      origin: { latitude_deg: 0, longitude_deg: 0, height_m: 0 },
      sources: [],
      alarms: [],
      alarmEvents: 0,
      hasOperators: false,
      orders: [],
      stages: [],
      processes: [],
      system: [],
      declination: NaN,
      time: 0,
    };
    /** @type {Map<number, import("./panels.js").Source>} */
    this.sourceOf = new Map();
    /** @type {import("./ground.js").Ground} */
    this.ground = { land: [], borders: [] };
    /** @type {import("./maps.js").Overlay[]} */
    this.overlays = [];
    /** Measuring lines; none: null. @type {import("./measuring.js").Measuring | null} */
    this.measure = null;
    /** What labels say and which come first, by the configuration. */
    this.labelling = { lines: LABEL_LINES, prefer: "" };
    this.prefers = /** @type {(track: Track) => boolean} */ (() => false);
    /** Track under the pointer; -1: none. */
    this.hovered = -1;
    /** MMSI of the station under the pointer; -1: none. */
    this.pointed = -1;
    /** Where no label may lie: names on the map; controls upon it. @type {import("./placement.js").Box[][]} */
    this.chrome = [[], []];
    this.matches = /** @type {(track: Track) => boolean} */ (() => true);
    /** @type {import("./filter.js").Fault[]} Words of the filter that cannot be read. */
    this.faults = [];
    /** State of the connection, and when the last picture came (milliseconds of the page's clock). */
    this.connected = false;
    this.pictureAt = 0;
    this.newsAt = 0;
    this.liveTime = 0;
    this.historyFrom = 0;
    /** Whether it is a recording that is shown: it has an end, and no present. */
    this.isRecording = false;
    /** Fusion as the server sees it: running, silent, absent. */
    this.fusion = "";
    this.fusionSilent = false;
    /** Offset of the newest states from the clock, seconds, positive: they are ahead; NaN: unknown. */
    this.dataOffset = NaN;
    /** The part of it that the sources' rhythm does not explain. */
    this.unexplainedOffset = NaN;
    /** Whether the deployment replays recordings. */
    this.isReplay = false;
    /** Rises when another time is wanted. */
    this.pastEdition = 0;
    /** Called when the origin of the frame is known. */
    this.onOrigin = () => {};
    /** Called when the picture has leapt to another time, seconds UTC. @type {(time: number) => void} */
    this.onLeap = () => {};
    /** Figures that tests and curious people read. */
    this.stats = { pictures: 0, frames: 0, sounds: 0, frameMs: /** @type {number[]} */ ([]) };
    this.pendingFit = this.settings.scale === 0;
    /** Whether the page has shown all tracks yet, and the time of its first picture with tracks, seconds. */
    this.hasFitted = false;
    this.firstTime = /** @type {number | undefined} */ (undefined);
    this.groundKey = "";
    this.dirty = true;
    this.panelDue = 0;
    this.hashDue = 0;

    this.map = byId("map");
    this.groundCanvas = /** @type {HTMLCanvasElement} */ (byId("ground"));
    this.trackCanvas = /** @type {HTMLCanvasElement} */ (byId("tracks"));
    this.groundContext = context(this.groundCanvas, false);
    this.trackContext = context(this.trackCanvas, true);
    this.operator = new Operator();
    this.alarms = new Alarms(this);
    this.kept = new KeptViews(this);
    controlOrders(this);
    this.side = new Side(this);
    this.readSettings();
    window.addEventListener("hashchange", () => {
      this.settings = read(location.hash);
      this.pendingFit = this.settings.scale === 0;
      Object.assign(this, { hasFitted: false, firstTime: undefined });
      this.pastEdition++;
      this.readSettings();
      this.asked();
    });
    new ResizeObserver(() => this.resize()).observe(this.map);
    this.resize();
    const frame = () => {
      this.frame();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  // ---- Settings

  /** Takes over what the settings say, after they were read from the address. */
  readSettings() {
    const { settings, view } = this;
    view.east = settings.e;
    view.north = settings.n;
    view.up = (settings.up * Math.PI) / 180;
    if (settings.scale > 0) view.scale = settings.scale;
    this.selected = new Set(
      settings.sel
        .split(",")
        .filter((word) => /^\d{1,9}$/.test(word))
        .map(Number),
    );
    this.settled();
  }

  /** Changes settings. @param {Partial<Settings>} patch */
  set(patch) {
    const units = this.settings.units;
    Object.assign(this.settings, patch);
    if (patch.at !== undefined || patch.speed !== undefined) this.pastEdition++;
    if (patch.up !== undefined) this.view.up = (patch.up * Math.PI) / 180;
    if (this.settings.units !== units) for (const track of this.picture.system.values()) this.relabel(track);
    this.settled();
    this.asked();
  }

  settled() {
    const { settings } = this;
    document.body.dataset.theme = settings.theme;
    settings.size = Math.min(400, Math.max(50, settings.size));
    document.body.style.setProperty("zoom", String(settings.size / 100));
    this.readFilter();
    const field = /** @type {HTMLInputElement} */ (byId("filter"));
    if (document.activeElement !== field) field.value = settings.filter;
    this.side.showTab();
    showLegend(this);
    this.keepAddress();
    this.dirty = true;
    this.panelDue = 0;
  }

  readFilter() {
    const names = this.known.sources.map((source) => source.name);
    Object.assign(this, readFilter(this.settings.filter, (source) => this.sourceName(source), names));
  }

  /** Puts another word into the filter. @param {string} word @param {string} other */
  replaceWord(word, other) {
    const words = this.settings.filter.split(/\s+/).map((one) => (one === word ? other : one));
    byId("filter").focus();
    /** @type {HTMLInputElement} */ (byId("filter")).value = words.join(" ");
    this.set({ filter: words.join(" ") });
  }

  /**
   * Whether a track is shown. What is selected passes every filter, and so does what has an alert.
   * @param {Track} track
   */
  shows(track) {
    if (this.selected.has(track.number) || track.alerts !== 0) return true;
    return !(this.settings.isolate && this.selected.size > 0) && this.matches(track);
  }

  /** Writes the address soon: not with every pixel that the map is moved. */
  keepAddress() {
    if (this.hashDue === 0) this.hashDue = performance.now() + 250;
  }

  writeAddress() {
    const { view, settings } = this;
    if (!this.pendingFit) {
      settings.e = Math.round(view.east);
      settings.n = Math.round(view.north);
      settings.scale = Number(view.scale.toPrecision(4));
    }
    settings.up = Number(((view.up * 180) / Math.PI).toFixed(1));
    settings.sel = [...this.selected].join(",");
    const address = write(settings);
    if (address !== location.hash) history.replaceState(null, "", address);
    keepHabits(settings);
  }

  // ---- Messages of the server

  /**
   * @param {{instance: string, origin: import("./geodesy.js").Place | null, declination_deg?: number | null,
   *   recording?: {name: string, from_s: number, to_s: number, time_s: number, speed: number, shares_moment?: boolean} | null,
   *   labels?: {lines: readonly (readonly string[])[], prefer: string}}} what
   *   An origin that is not known yet is said later.
   */
  hello({ instance, origin, recording, labels, declination_deg }) {
    if (labels) this.labelBy(labels);
    this.known.declination = declination_deg ?? NaN;
    setText(byId("instance"), recording ? `recording ${recording.name}` : instance);
    document.title = `Koseki ${recording?.name ?? instance}`;
    setText(byId("live"), recording ? "END" : "LIVE");
    this.isRecording = Boolean(recording);
    if (recording?.shares_moment) this.notice("Too many windows show this recording: this one shares its moment with others");
    if (recording) {
      this.historyFrom = recording.from_s;
      this.liveTime = recording.to_s;
      // A recording continues at its position, unless the address names another.
      if (this.settings.at === 0) Object.assign(this.settings, { at: recording.time_s, speed: recording.speed });
    }
    if (origin && JSON.stringify(origin) !== JSON.stringify(this.known.origin)) {
      this.known.origin = origin;
      this.onOrigin();
    }
    this.dirty = true;
  }

  /** Labels tracks by a configuration. @param {{lines: readonly (readonly string[])[], prefer: string}} labelling */
  labelBy(labelling) {
    this.labelling = labelling;
    const { matches } = readFilter(labelling.prefer, (source) => this.sourceName(source));
    this.prefers = labelling.prefer === "" ? () => false : matches;
    for (const track of this.picture.system.values()) this.relabel(track);
  }

  /**
   * Puts a picture in: all of it, or what has changed.
   * @param {{time: number, full: boolean, tracks: Change[], removed: number[], identities?: Change[], sensor?: Spot[],
   *   marks?: Record<string, import("./layers.js").Mark[]>, stations?: import("./stations.js").Station[],
   *   layerAge?: number, stationAge?: number}} what
   *   `layerAge`: seconds for which sensor tracks and detections are shown; `stationAge`: those of stations.
   */
  changes({ time, full, tracks, removed, identities, sensor, marks, stations, layerAge = 15, stationAge = 600 }) {
    const { picture } = this;
    const before = picture.time;
    const hadStations = picture.stations.size > 0;
    picture.time = time;
    if (full) {
      const present = new Set(tracks.map((track) => track.number));
      for (const number of picture.system.keys()) if (!present.has(number)) picture.system.delete(number);
    }
    if (full) picture.clearLayers();
    // After a jump through time, earlier values do not apply.
    const leap = full || time < before || time - before > HAND_OVER_AFTER_S;
    if (leap) for (const track of picture.system.values()) forgetMains(track, time);
    for (const number of removed) picture.remove(number);
    for (const change of tracks) {
      let track = picture.system.get(change.number);
      if (!track) {
        track = picture.appear(change.number);
        forgetMains(track, time);
      }
      const main = track.source;
      Object.assign(track, change);
      noteMain(track, main, time);
      track.trail.add(track.time, track.east, track.north);
      this.relabel(track);
    }
    for (const identity of identities ?? []) {
      const track = picture.system.get(identity.number);
      if (track) this.relabel(Object.assign(track, identity));
    }
    if (leap) this.onLeap(time);
    picture.addLayers(time - layerAge, sensor ?? [], marks ?? {});
    picture.addStations(time - stationAge, stations ?? []);
    if (hadStations !== picture.stations.size > 0) showLegend(this);
    this.stats.pictures++;
    this.pictureAt = performance.now();
    if (tracks.length > 0 || time > before) this.newsAt = this.pictureAt;
    if (this.settings.at === 0) this.liveTime = time;
    else if (this.settings.speed > 0) this.played(time);
    if (this.pendingFit) this.fitAtFirst(time);
    if (this.settings.follow) this.follow();
    this.dirty = true;
  }

  /** Keeps up with a past that is played, to where it is the present. @param {number} time */
  played(time) {
    if (this.liveTime > 0 && time >= this.liveTime - (this.isRecording ? 0 : 0.5)) return this.goToEnd();
    this.settings.at = time;
    this.keepAddress();
  }

  /** Shows the present, or the last moment of a recording. */
  goToEnd() {
    this.set({ at: this.isRecording ? this.liveTime : 0, speed: 0 });
  }

  /**
   * Details of a selected track.
   * @param {number} number @param {string} stateTime Time of the state that they belong to, nanoseconds UTC.
   * @param {import("./panels.js").Share[]} shares @param {number} nis NaN: unknown.
   * @param {Omit<import("./panels.js").Facts, "stateTime">} facts
   */
  details(number, stateTime, shares, nis, facts) {
    this.shares.set(number, shares);
    this.facts.set(number, { stateTime, ...facts });
    const track = this.picture.system.get(number);
    if (track) this.remember(number, track.time, track.height, Math.hypot(track.speedEast, track.speedNorth), shares, nis);
    // Map and panel show the same instant.
    if (this.settings.tab === "track") this.panelDue = 0;
    this.dirty = true;
  }

  /**
   * What the server remembers of a track that has just been selected.
   * @param {number} number
   * @param {{time: number, east: number, north: number, height: number, speed: number, nis: number,
   *   weights: {source: number, name: string, weight: number}[]}[]} rows
   */
  past(number, rows) {
    this.histories.delete(number);
    for (const row of rows) this.remember(number, row.time, row.height, row.speed, row.weights, row.nis);
    const track = this.picture.system.get(number);
    if (track && rows.length > 0) {
      track.trail = new Trail();
      for (const row of rows) track.trail.add(row.time, row.east, row.north);
    }
    this.dirty = true;
  }

  /**
   * @param {number} number @param {number} time @param {number} height @param {number} speed
   * @param {{source: number, name: string, weight: number}[]} shares @param {number} nis
   */
  remember(number, time, height, speed, shares, nis) {
    const history = this.historyOf(number);
    const last = history.times.at(-1) ?? -Infinity;
    if (time <= last) return;
    history.times.push(time);
    history.heights.push(height);
    history.speeds.push(speed);
    history.nis.push(nis);
    for (const share of shares)
      if (!history.weights.has(share.source))
        history.weights.set(share.source, { name: share.name, weights: history.times.slice(1).map(() => NaN) });
    for (const [source, { weights }] of history.weights)
      weights.push(shares.find((share) => share.source === source)?.weight ?? NaN);
    if (history.times.length > HISTORY_MAX) {
      for (const list of [history.times, history.heights, history.speeds, history.nis]) list.shift();
      for (const { weights } of history.weights.values()) weights.shift();
    }
  }

  /** @param {number} number @returns {History} */
  historyOf(number) {
    let history = this.histories.get(number);
    if (!history) {
      history = { times: [], heights: [], speeds: [], nis: [], weights: new Map() };
      this.histories.set(number, history);
    }
    return history;
  }

  /** What is known of the system besides its tracks. @param {Partial<Known>} what */
  learn(what) {
    Object.assign(this.known, what);
    if (what.sources) {
      const fewer = this.sourceOf.size !== what.sources.length;
      this.sourceOf = new Map(what.sources.map((source) => [source.number, source]));
      if (fewer) {
        showLegend(this);
        this.readFilter();
      }
    }
    this.dirty = true;
  }

  /** Site of a source, which only the greeting says. @param {number} number */
  siteOf(number) {
    const known = this.sourceOf.get(number);
    return { east: known?.east ?? NaN, north: known?.north ?? NaN };
  }

  /** @param {number} source -1: none. */
  sourceName(source) {
    return source < 0 ? "" : (this.sourceOf.get(source)?.name ?? `source ${source + 1}`);
  }

  /** @param {Track} track */
  mainName(track) {
    return this.sourceName(track.source);
  }

  /** @param {Track} track */
  relabel(track) {
    track.label = labelOf(track, this.settings.units, this.mainName(track), this.labelling.lines);
  }

  // ---- Selection and view

  /** Selects a track; none by -1. @param {number} number @param {boolean} [more] Beside those that are selected. */
  select(number, more = false) {
    if (!more) this.selected = new Set(number >= 0 ? [number] : []);
    else if (!this.selected.delete(number)) this.selected.add(number);
    for (const map of [this.shares, this.histories, this.facts])
      for (const known of map.keys()) if (!this.selected.has(known)) map.delete(known);
    this.settings.sel = [...this.selected].join(",");
    // From then on, a map that moves by itself would disturb.
    if (number >= 0 && this.hasFitted) this.pendingFit = false;
    if (this.selected.size === 0) this.settings.follow = false;
    if (number >= 0 && this.selected.has(number) && this.settings.tab === "tracks" && !more)
      this.settings.tab = "track";
    this.settled();
    this.asked();
  }

  /** Puts a track into the middle. @param {number} number */
  centre(number) {
    const track = this.picture.system.get(number);
    if (track) this.moved(() => Object.assign(this.view, { east: track.east, north: track.north }));
  }

  /** Selects a track and puts it into the middle. @param {number} number */
  goTo(number) {
    this.settings.follow = false;
    this.select(number);
    this.centre(number);
    this.trackCanvas.focus();
    const track = this.picture.system.get(number);
    // For screen readers, which cannot read the map.
    if (track) setText(byId("spoken"), `Selected: ${track.label.join(", ")}, ${track.state}`);
  }

  /** Shows a source in the list of sources, and gives it the focus. @param {number} number */
  showSource(number) {
    this.set({ tab: "sources" });
    this.side.show();
    const row = /** @type {HTMLElement | null} */ (byId("panel").querySelector(`[data-source="${number}"]`));
    row?.focus();
  }

  /** Says something that stays until something else is said. @param {string} text "": nothing any more. */
  notice(text) {
    byId("notice").hidden = text === "";
    setText(byId("notice"), text);
  }

  follow() {
    const track = this.picture.system.get([...this.selected].at(-1) ?? -1);
    if (track) Object.assign(this.view, { east: track.east, north: track.north });
  }

  /**
   * Shows all tracks of a page that has just been opened, until somebody moves the map: tracks come one after another.
   * @param {number} time Of the picture, seconds.
   */
  fitAtFirst(time) {
    const tracks = [...this.picture.system.values()];
    if (tracks.length === 0) return;
    this.firstTime ??= time;
    const isOut = tracks.filter((track) => !this.view.sees(track.east, track.north)).length > tracks.length * 0.04;
    if (isOut || !this.hasFitted) this.fit();
    this.hasFitted = true;
    this.pendingFit = Math.abs(time - this.firstTime) < FIT_AT_FIRST_S;
  }

  /** Shows all tracks. */
  fit() {
    const tracks = [...this.picture.system.values()];
    if (tracks.length === 0) return;
    const east = tracks.map((track) => track.east).sort((a, b) => a - b);
    const north = tracks.map((track) => track.north).sort((a, b) => a - b);
    // A few distant tracks must not make all others small.
    const [low, high] = [Math.floor(tracks.length * 0.02), Math.ceil(tracks.length * 0.98) - 1];
    this.moved(() => this.view.show(east[low], north[low], east[high], north[high]));
  }

  /** Does what moves the view. @param {() => void} action */
  moved(action) {
    action();
    this.pendingFit = false;
    this.keepAddress();
    this.dirty = true;
    this.asked();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.map;
    const ratio = ((window.devicePixelRatio || 1) * this.settings.size) / 100;
    Object.assign(this.view, { width: Math.max(1, width), height: Math.max(1, height) });
    for (const [canvas, ctx] of /** @type {const} */ ([
      [this.groundCanvas, this.groundContext],
      [this.trackCanvas, this.trackContext],
    ])) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.groundKey = "";
    this.dirty = true;
  }

  // ---- Frame

  frame() {
    const now = performance.now();
    if (this.hashDue > 0 && now >= this.hashDue) {
      this.hashDue = 0;
      this.writeAddress();
    }
    if (now >= this.panelDue) {
      this.panelDue = now + 500;
      this.side.show();
      showHeader(this);
      this.alarms.sound(now);
      this.chrome[1] = controlsOn(this.map);
    }
    if (this.settings.coverage || this.settings.pd !== "")
      void this.coverage.refresh(now, () => (this.dirty = true)).catch((error) => console.error(error));
    if (!this.dirty) return;
    this.dirty = false;
    this.paint();
    this.stats.frames++;
    this.stats.frameMs.push(performance.now() - now);
    if (this.stats.frameMs.length > 240) this.stats.frameMs.shift();
  }

  paint() {
    const { view, settings } = this;
    const colours = COLOURS[settings.theme];
    const key = [
      view.east,
      view.north,
      view.scale,
      view.up,
      view.width,
      view.height,
      settings.theme,
      settings.rings,
      settings.siterings,
      settings.units,
      settings.dim,
      settings.maps,
    ]
      .concat([this.ground.land.length, this.overlays.length])
      .join();
    if (key !== this.groundKey) {
      this.groundKey = key;
      this.chrome[0] = paintGround(this.groundContext, view, colours, {
        ground: this.ground,
        overlays: this.overlays,
        layers: layersOf(settings.maps, this.overlays),
        sites: this.known.sources,
        settings,
        latitude: this.known.origin.latitude_deg,
      });
      showScale(this);
    }
    this.painter.paint(this.trackContext, {
      view,
      settings,
      colours,
      picture: this.picture,
      selected: this.selected,
      shares: this.shares,
      shows: (track) => this.shows(track),
      prefers: this.prefers,
      hovered: this.hovered,
      pointed: this.pointed,
      nameOf: (source) => this.sourceOf.get(source)?.name ?? "",
      chrome: this.chrome.flat(),
      kindOf: (source) => this.sourceOf.get(source)?.kind ?? "tracker",
      sites: this.known.sources,
      coverage: this.coverage,
      measure: this.measure,
      origin: this.known.origin,
      declination: this.known.declination,
    });
  }
}

/** @param {HTMLCanvasElement} canvas @param {boolean} alpha */
function context(canvas, alpha) {
  const ctx = canvas.getContext("2d", { alpha });
  if (!ctx) throw new Error("this browser has no canvas");
  return ctx;
}
