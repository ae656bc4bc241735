/** Mouse, fingers, keyboard, and the bar of time. */

import { byId, clock, h, setText } from "./dom.js";
import { Measuring, measureSelected } from "./measuring.js";
import { giveBack, nudge } from "./nudge.js";
import { isNameKey, SearchBox } from "./search.js";
import { CHOICES, DEFAULTS } from "./settings.js";
import { stationAt } from "./stations.js";
import { showCursor } from "./surround.js";

/** @typedef {import("./app.js").App} App */

/**
 * Keys as tar1090 has them, as far as it has them. A letter is pressed with Alt; alone, if the setting `letters` is
 * `keys`.
 * @type {[string, string, (app: App) => void][]} */
const KEYS = [
  ["l", "labels on and off", (app) => app.set({ labels: app.settings.labels > 0 ? 0 : DEFAULTS.labels })],
  ["o", "labels longer, in turn", (app) => app.set({ labels: (app.settings.labels + 1) % 4 })],
  ["k", "labels may cover each other", (app) => app.set({ declutter: !app.settings.declutter })],
  ["t", "trails of all tracks", (app) => app.set({ trails: !app.settings.trails })],
  ["y", "trails: 60 s, 300 s, all, none", (app) => app.set({ trail: next([60, 300, -1, 0], app.settings.trail) })],
  [
    "u",
    "speed vectors: 60 s, 120 s, 180 s, 6 min, 15 min, none",
    (app) => app.set({ vector: next([60, 120, 180, 360, 900, 0], app.settings.vector) }),
  ],
  ["g", "accuracy ellipses: 1, 2, 3 sigmas, none", (app) => app.set({ sigma: next([1, 2, 3, 0], app.settings.sigma) })],
  ["n", "sensor tracks", (app) => app.set({ sensors: !app.settings.sensors })],
  ["j", "detections", (app) => app.set({ detections: !app.settings.detections })],
  [
    "m",
    "bearings, wide-area counts and cues",
    (app) => app.set({ bearings: !app.settings.bearings, areas: !app.settings.bearings }),
  ],
  ["'", "base stations and aids to navigation", (app) => app.set({ stations: !app.settings.stations })],
  ["z", "sites and learned offsets", (app) => app.set({ biases: !app.settings.biases })],
  [",", "coverage of each source", (app) => app.set({ coverage: !app.settings.coverage })],
  ["x", "range rings", (app) => app.set({ rings: !app.settings.rings })],
  ["b", "map dimmed", (app) => app.set({ dim: !app.settings.dim })],
  ["p", "colours: night, day, print", (app) => app.set({ theme: next(CHOICES.theme, app.settings.theme) })],
  [
    ";",
    "tracks coloured by state, height, sources, main source",
    (app) => app.set({ colour: next(CHOICES.colour, app.settings.colour) }),
  ],
  ["v", "table shows the map's tracks only", (app) => app.set({ inview: !app.settings.inview })],
  ["i", "selected tracks only", (app) => app.set({ isolate: !app.settings.isolate })],
  ["f", "follow the selected track", (app) => app.set({ follow: !app.settings.follow && app.selected.size > 0 })],
  ["r", "follow a track at random", followAny],
  ["h", "show all tracks", (app) => app.fit()],
  ["c", "select nothing (also Escape)", clear],
  ["+", "", (app) => zoomMiddle(app, 1.25)],
  ["=", "", (app) => zoomMiddle(app, 1.25)],
  ["-", "", (app) => zoomMiddle(app, 1 / 1.25)],
  ["w", "", (app) => app.moved(() => app.view.pan(0, 80))],
  ["s", "", (app) => app.moved(() => app.view.pan(0, -80))],
  ["a", "", (app) => app.moved(() => app.view.pan(80, 0))],
  ["d", "", (app) => app.moved(() => app.view.pan(-80, 0))],
  ["q", "", (app) => zoomMiddle(app, 1 / 1.25)],
  ["e", "", (app) => zoomMiddle(app, 1.25)],
  ["[", "", (app) => app.moved(() => app.view.turn(-Math.PI / 36))],
  ["]", "", (app) => app.moved(() => app.view.turn(Math.PI / 36))],
  ["\\", "north up", (app) => app.moved(() => Object.assign(app.view, { up: 0 }))],
  [".", "measure between the selected tracks", measureSelected],
  ["/", "to the filter", () => byId("filter").focus()],
  ["?", "this help", () => toggleHelp()],
];

const ENTRIES = KEYS.filter(([, about]) => about !== "").map(([key, about]) => `${key} ${about}`);
const HALF = Math.ceil(ENTRIES.length / 2);

const HELP = `${ENTRIES.slice(0, HALF)
  .map((entry, k) => `${entry.padEnd(48)}${ENTRIES[HALF + k] ?? ""}`)
  .join("\n")}

Letters need Alt: a letter alone begins a search. View, "A letter alone" = keys turns that round.

BAW12     find and centre: type callsign, code or address (also Ctrl+F), then Enter
← ↑ → ↓   move the map (w a s d)    + −       smaller, larger (q e)
[ ]       turn                      Esc       close, select nothing, end the filter
space     pause, play; presses the button that has the focus
shift ← → a second back, ahead      Home      back to live, or to the end
Tab       to the next control       ↑ ↓       in the table; Enter there selects and centres

drag      move the map              shift+drag   turn it
wheel     smaller, larger           right drag   measure; right click on a line: away with it
click     select                    ctrl+click   select one more
double click: put a track into the middle and follow it
drag a label  put it elsewhere (Ctrl+arrows, selected tracks); double click on it, or Ctrl+Backspace: give it back

filter    BAW  fl>100  kt<200  sources>2  state=coasted  kind=group
          main=NAME  source=NAME  type=A320  /^EC/  -word: not so`;

/** @template T @param {readonly T[]} list @param {T} value @returns {T} */
function next(list, value) {
  return list[(list.indexOf(value) + 1) % list.length];
}

/** @param {App} app @param {number} factor */
function zoomMiddle(app, factor) {
  app.moved(() => app.view.zoom(factor, app.view.width / 2, app.view.height / 2));
}

/** @param {App} app */
function followAny(app) {
  const numbers = [...app.picture.system.keys()];
  if (numbers.length === 0) return;
  const number = numbers[Math.floor(Math.random() * numbers.length)];
  app.select(number);
  app.centre(number);
  app.set({ follow: true });
}

/** Ends one thing: the help, then selection and measuring, then the filter. @param {App} app */
function escape(app) {
  if (!byId("help").hidden) return toggleHelp();
  if (app.selected.size > 0 || app.measure || app.settings.isolate) return clear(app);
  if (app.settings.filter !== "") app.set({ filter: "" });
}

/** @param {App} app */
function clear(app) {
  app.measure = null;
  app.settings.isolate = false;
  app.select(-1);
}

function toggleHelp() {
  const help = byId("help");
  help.textContent = HELP;
  help.hidden = !help.hidden;
  if (help.hidden) byId("tracks").focus();
  else help.focus();
}

/** Makes the page answer. @param {App} app */
export function control(app) {
  const search = new SearchBox(app, app.map);
  controlKeys(app, search);
  controlPointer(app);
  controlTime(app);
  controlFilter(app);
  const tools = /** @type {[string, string][]} */ ([
    ["e", "+"],
    ["q", "−"],
    ["h", "⌂"],
    ["o", "L"],
    ["t", "T"],
    ["n", "S"],
    ["g", "σ"],
    ["p", "◐"],
    ["?", "?"],
  ]);
  for (const [key, sign] of tools) {
    const entry = KEYS.find(([own]) => own === key);
    if (!entry) continue;
    const pressed = /[a-z]/.test(key) ? `Alt+${key.toUpperCase()}` : key;
    const title = `${entry[1] || (key === "e" ? "larger" : "smaller")} (${pressed})`;
    byId("tools").append(h("button", { title, "aria-label": title, click: () => entry[2](app) }, sign));
  }
  const title = "find a track: type its callsign, code or address (Ctrl+F)";
  const find = h("button", { title, "aria-label": title }, "⌕");
  find.addEventListener("click", () => search.open(""));
  byId("tools").prepend(find);
}

/** @param {App} app */
function controlFilter(app) {
  const filter = /** @type {HTMLInputElement} */ (byId("filter"));
  const end = () => {
    filter.value = "";
    app.set({ filter: "", isolate: false });
    app.trackCanvas.focus();
  };
  filter.addEventListener("input", () => app.set({ filter: filter.value.trim() }));
  filter.addEventListener("keydown", (event) => {
    event.stopPropagation();
    if (event.key === "Escape") end();
    if (event.key === "Enter") {
      const passing = app.settings.filter === "" ? [] : [...app.picture.system.values()].filter(app.matches);
      if (passing.length === 1) app.goTo(passing[0].number);
      else app.trackCanvas.focus();
    }
  });
  byId("hidden").addEventListener("click", end);
}

/** What keys do that the map alone takes. @type {Record<string, (app: App) => void>} */
const MAP_KEYS = {
  " ": togglePlay,
  Home: (app) => app.goToEnd(),
  ArrowLeft: (app) => pan(app, 80, 0),
  ArrowRight: (app) => pan(app, -80, 0),
  ArrowUp: (app) => pan(app, 0, 80),
  ArrowDown: (app) => pan(app, 0, -80),
};

/** @param {App} app @param {number} dx @param {number} dy */
function pan(app, dx, dy) {
  app.settings.follow = false;
  app.moved(() => app.view.pan(dx, dy));
}

/** @param {App} app @param {SearchBox} search */
function controlKeys(app, search) {
  document.addEventListener("keydown", (event) => {
    const act = event.defaultPrevented ? undefined : actOf(app, search, event);
    if (!act) return;
    act(app);
    event.preventDefault();
  });
}

/**
 * What a pressed key does; nothing where it belongs to what has the focus.
 * @param {App} app @param {SearchBox} search @param {KeyboardEvent} event
 * @returns {((app: App) => void) | undefined}
 */
function actOf(app, search, event) {
  const { key, target } = event;
  if (!(target instanceof Element) || target.closest("dialog")) return undefined;
  const isText = target instanceof HTMLInputElement && target.type !== "range" && target.type !== "checkbox";
  if (isText || target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement) return undefined;
  const isAltGraph = event.getModifierState("AltGraph");
  if (!isAltGraph && (event.ctrlKey || event.metaKey))
    return event.ctrlKey && key.toLowerCase() === "f" ? () => search.open("") : undefined;
  const letter = /^Key[A-Z]$/.test(event.code) ? event.code.at(-1)?.toLowerCase() : "";
  if (event.altKey && !isAltGraph) return actOfKey(/^[a-z]$/i.test(key) ? key.toLowerCase() : letter);
  if (key === "Escape") return escape;
  if (event.shiftKey && key === "ArrowLeft") return () => step(app, -1);
  if (event.shiftKey && key === "ArrowRight") return () => step(app, 1);
  const isMap = target === app.trackCanvas || target === document.body;
  if (key in MAP_KEYS) return isMap ? MAP_KEYS[key] : undefined;
  const isKey = /^[a-z]$/.test(key) && app.settings.letters === "keys";
  return isNameKey(key) && !isKey ? () => search.open(key) : actOfKey(key);
}

/** @param {string | undefined} key */
function actOfKey(key) {
  return KEYS.find(([own]) => own === key)?.[2];
}

/** @param {App} app */
function controlPointer(app) {
  const canvas = app.trackCanvas;
  /** @type {Map<number, [number, number]>} */
  const fingers = new Map();
  let action = "";
  let moved = 0;
  /** Label that is dragged. @type {import("./lettering.js").Label | null} */
  let label = null;
  const where = (/** @type {MouseEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    const size = app.settings.size / 100;
    return /** @type {[number, number]} */ ([(event.clientX - box.left) / size, (event.clientY - box.top) / size]);
  };
  /** Point under the cursor, or the track there. @param {number} x @param {number} y */
  const target = (x, y) => {
    const track = app.painter.at(x, y);
    const [east, north] = track ? [track.east, track.north] : app.view.toGround(x, y);
    return { east, north, track: track?.number ?? -1 };
  };
  const point = (/** @type {number} */ mmsi) => {
    if (app.pointed !== mmsi) app.dirty = true;
    app.pointed = mmsi;
  };
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    const [x, y] = where(event);
    fingers.set(event.pointerId, [x, y]);
    moved = 0;
    label = app.painter.symbolAt(x, y) ? null : app.painter.lettering.at(x, y);
    action = event.button === 2 ? "measure" : event.shiftKey ? "turn" : label ? "label" : "pan";
    if (action === "measure") {
      app.measure ??= new Measuring();
      app.measure.begin(target(x, y));
    }
  });
  canvas.addEventListener("pointermove", (event) => {
    const [x, y] = where(event);
    showCursor(app, x, y);
    const last = fingers.get(event.pointerId);
    if (!last) {
      const track = app.painter.at(x, y);
      canvas.style.cursor = track ? "pointer" : "crosshair";
      if (app.hovered !== (track?.number ?? -1)) app.dirty = true;
      app.hovered = track?.number ?? -1;
      point(track ? -1 : stationAt(app.picture.stations.values(), app.view, x, y));
      return;
    }
    const [dx, dy] = [x - last[0], y - last[1]];
    moved += Math.abs(dx) + Math.abs(dy);
    if (fingers.size === 2) {
      const [other] = [...fingers.entries()].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const before = Math.hypot(last[0] - other[0], last[1] - other[1]);
      const after = Math.hypot(x - other[0], y - other[1]);
      if (before > 0) app.moved(() => app.view.zoom(after / before, (x + other[0]) / 2, (y + other[1]) / 2));
    } else if (action === "measure" && app.measure) {
      app.measure.lead(target(x, y));
      app.dirty = true;
    } else if (action === "turn") {
      const [middleX, middleY] = [app.view.width / 2, app.view.height / 2];
      const angle = Math.atan2(y - middleY, x - middleX) - Math.atan2(last[1] - middleY, last[0] - middleX);
      app.moved(() => app.view.turn(angle));
    } else if (action === "label" && label) {
      if (moved > 3) nudge(app, [label], dx, dy);
    } else if (moved > 3) {
      app.settings.follow = false;
      app.moved(() => app.view.pan(dx, dy));
    }
    fingers.set(event.pointerId, [x, y]);
  });
  const ended = (/** @type {PointerEvent} */ event) => {
    fingers.delete(event.pointerId);
    const [x, y] = where(event);
    if (action === "measure" && moved <= 3) {
      app.measure?.drop();
      app.measure?.dropAt(x, y);
      if (app.measure?.lines.length === 0) app.measure = null;
      app.dirty = true;
    }
    if ((action !== "pan" && action !== "label") || moved > 3 || event.type === "pointercancel") return;
    const track = app.painter.at(x, y);
    if (!track) point(stationAt(app.picture.stations.values(), app.view, x, y));
    app.select(track ? track.number : -1, event.ctrlKey || event.metaKey);
  };
  canvas.addEventListener("pointerleave", () => {
    if (app.hovered >= 0) app.dirty = true;
    app.hovered = -1;
    point(-1);
  });
  canvas.addEventListener("pointerup", ended);
  canvas.addEventListener("pointercancel", ended);
  canvas.addEventListener("dblclick", (event) => {
    const track = app.painter.at(...where(event));
    if (!track) return;
    const own = app.painter.lettering.at(...where(event));
    if (own?.wish.spot.pinned && !app.painter.symbolAt(...where(event))) return giveBack(app, [own]);
    app.centre(track.number);
    app.set({ follow: true });
  });
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const [x, y] = where(event);
      const lines = event.deltaMode === 1 ? event.deltaY * 16 : event.deltaY;
      app.moved(() => app.view.zoom(Math.exp(-lines / 400), x, y));
      showCursor(app, x, y);
    },
    { passive: false },
  );
}

// ---- Time

const SPEEDS = [0.5, 1, 2, 5, 10, 30];

/** @param {App} app */
function togglePlay(app) {
  const { settings } = app;
  if (settings.at === 0) app.set({ at: app.picture.time, speed: 0 });
  else app.set({ speed: settings.speed > 0 ? 0 : Number(/** @type {HTMLSelectElement} */ (byId("speed")).value) });
}

/** @param {App} app @param {number} seconds */
function step(app, seconds) {
  const at = (app.settings.at || app.picture.time) + seconds;
  if (at >= app.liveTime) app.goToEnd();
  else app.set({ at: Math.max(app.historyFrom, at), speed: 0 });
}

/** @param {App} app */
function controlTime(app) {
  const scrub = /** @type {HTMLInputElement} */ (byId("scrub"));
  const speed = /** @type {HTMLSelectElement} */ (byId("speed"));
  for (const times of SPEEDS) speed.append(h("option", { value: times, selected: times === 1 }, `×${times}`));
  byId("play").addEventListener("click", () => togglePlay(app));
  byId("live").addEventListener("click", () => app.goToEnd());
  speed.addEventListener("change", () => {
    if (app.settings.speed > 0) app.set({ speed: Number(speed.value) });
  });
  let held = false;
  scrub.addEventListener("pointerdown", () => (held = true));
  scrub.addEventListener("pointerup", () => (held = false));
  scrub.addEventListener("input", () => {
    const at = Number(scrub.value);
    if (at >= Math.floor(app.liveTime)) app.goToEnd();
    else app.set({ at, speed: 0 });
  });
  setInterval(() => {
    const { settings, picture } = app;
    const paused = settings.at > 0 && settings.speed === 0;
    setText(byId("play"), paused ? "▶" : "❚❚");
    scrub.min = String(Math.floor(app.historyFrom || app.liveTime));
    scrub.max = String(Math.floor(app.liveTime));
    if (!held) scrub.value = String(Math.floor(settings.at > 0 ? picture.time : app.liveTime));
    const behind = settings.at > 0 ? ` (−${Math.max(0, Math.round(app.liveTime - picture.time))} s)` : "";
    setText(byId("shown"), picture.time > 0 ? `${clock(picture.time)}${behind}` : "");
  }, 200);
}
