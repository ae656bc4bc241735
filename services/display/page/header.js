/** Line above the map: connection, alarms, what the filter hides, and the time; and the warnings on the map. */

import { standing } from "./alarms.js";
import { byId, clock, day, dayAndClock, grouped, h, setText } from "./dom.js";

/** @typedef {import("./app.js").App} App */
/** @typedef {{word: string, severity: string, act?: string}} Pill */

/** Offset of the data from the clock, apart from what the sources' rhythm explains, that is shown, seconds. */
const DATA_OFF_S = 2;
/** Seconds without a picture, or without news in it, after which the picture is called old. */
const STALE_S = 4;

/** Shows what the line above the map has to say. @param {App} app */
export function showHeader(app) {
  const { picture, settings } = app;
  const isPast = settings.at > 0;
  setText(byId("clock"), picture.time > 0 ? clock(picture.time) : "--:--:--");
  byId("clock").setAttribute("title", picture.time > 0 ? `${dayAndClock(picture.time)} UTC` : "");
  setText(byId("day"), dayText(app));
  const present = app.isReplay ? "REPLAY" : "LIVE";
  setText(byId("mode"), isPast ? (settings.speed > 0 ? `PLAY ×${settings.speed}` : "PAUSED") : present);
  byId("mode").classList.toggle("past", isPast || app.isReplay);
  app.map.classList.toggle("past", isPast);
  showCounts(app);
  showFaults(app);
  const isSilent = app.fusion !== "" && (app.fusion !== "running" || app.fusionSilent);
  const banner = bannerOf(app, isPast, isSilent);
  byId("banner").hidden = banner === "";
  app.map.classList.toggle("stale", banner !== "");
  setText(byId("banner"), banner);
  const pills = pillsOf(app, isPast, isSilent);
  const line = JSON.stringify(pills);
  if (byId("pills").dataset.text !== line) {
    byId("pills").dataset.text = line;
    byId("pills").replaceChildren(
      ...pills.map(({ word, severity, act }) =>
        act ? h(`button.pill.${severity}`, { "data-tab-wanted": act }, word) : h(`span.pill.${severity}`, {}, word),
      ),
    );
  }
}

/** The time zone, with the day of a picture that is not of today. @param {App} app */
function dayText({ picture, isReplay }) {
  if (picture.time <= 0) return "UTC";
  const isToday = day(picture.time) === day(Date.now() / 1000);
  return isToday && !isReplay ? "UTC" : `UTC ${day(picture.time)}`;
}

/** How many tracks there are, and how many of them are hidden. @param {App} app */
function showCounts(app) {
  const states = { confirmed: 0, tentative: 0, coasted: 0 };
  let hidden = 0;
  for (const track of app.picture.system.values()) {
    const state = /** @type {keyof typeof states} */ (track.state);
    states[state] = (states[state] ?? 0) + 1;
    if (!app.shows(track)) hidden++;
  }
  const counts = byId("counts");
  const text = `${app.picture.system.size} ${states.tentative} ${states.coasted}`;
  if (counts.dataset.text !== text) {
    counts.dataset.text = text;
    counts.replaceChildren(
      h("b", {}, grouped(app.picture.system.size)),
      ` tracks`,
      h("span", {}, ` · ${grouped(states.tentative)} tentative · ${grouped(states.coasted)} coasted`),
    );
  }
  const button = byId("hidden");
  button.hidden = hidden === 0;
  setText(button, `${grouped(hidden)} hidden`);
}

/** Words of the filter that do not count, and what may be meant. @param {App} app */
function showFaults(app) {
  const { faults, settings } = app;
  const isEmpty =
    faults.length === 0 &&
    settings.filter !== "" &&
    app.picture.system.size > 0 &&
    ![...app.picture.system.values()].some((track) => app.matches(track));
  byId("filter").setAttribute("aria-invalid", String(faults.length > 0));
  const box = byId("faults");
  const line = JSON.stringify([faults, isEmpty]);
  if (box.dataset.text === line) return;
  box.dataset.text = line;
  box.hidden = faults.length === 0 && !isEmpty;
  box.replaceChildren(
    ...faults.map(({ word, advice }) =>
      h(
        "div",
        {},
        h("b", {}, word),
        advice ? " is not understood, and hides nothing. Meant is perhaps " : " is not understood, and hides nothing.",
        ...(advice ? [h("button", { click: () => app.replaceWord(word, advice) }, advice)] : []),
      ),
    ),
    ...(isEmpty ? [h("div", {}, "No track matches the filter.")] : []),
  );
}

/** @param {App} app @param {boolean} isPast @param {boolean} isSilent Whether fusion says nothing. */
function bannerOf(app, isPast, isSilent) {
  const old = (performance.now() - app.newsAt) / 1000;
  // A page that has just been opened is connecting.
  if (!app.connected && performance.now() < (1000 * STALE_S) / 2) return "";
  if (!app.connected) return "NO CONNECTION TO THE DISPLAY PROCESS: THE PICTURE STANDS STILL";
  if (isPast) return "";
  if (isSilent) return `FUSION ${app.fusion === "absent" ? "ABSENT" : "SILENT"}: THE TRACKS ARE NOT BEING UPDATED`;
  return app.newsAt > 0 && old > STALE_S ? `NO NEW PICTURE FOR ${Math.round(old)} s` : "";
}

/** @param {App} app @param {boolean} isPast @param {boolean} isSilent */
function pillsOf(app, isPast, isSilent) {
  const restarts = app.known.processes
    .filter((process) => process.kind === "fusion")
    .reduce((sum, process) => sum + process.restarts, 0);
  /** @type {Pill[]} */
  const pills = [
    { word: app.connected ? "connected" : "not connected", severity: app.connected ? "good" : "bad" },
    ...alarmPills(app),
  ];
  if (app.fusion !== "") {
    const times = restarts > 0 ? `, ${restarts} restart${restarts > 1 ? "s" : ""}` : "";
    pills.push({
      word: isSilent ? `fusion ${app.fusion === "running" ? "silent" : app.fusion}` : `fusion running${times}`,
      severity: isSilent ? "bad" : "good",
    });
  }
  if (!isPast && Math.abs(app.unexplainedOffset) > DATA_OFF_S)
    pills.push({ word: offsetText(app.dataOffset), severity: "bad" });
  return pills;
}

/** What the line says of the alarms, which their tab repeats. @param {App} app @returns {Pill[]} */
function alarmPills(app) {
  const { shown, open } = standing(app.known.alarms);
  const worst = open.some((alarm) => alarm.severity !== "warning") ? "bad" : open.length > 0 ? "warn" : "";
  const tab = byId("tab-alarms");
  tab.className = worst;
  setText(tab, open.length > 0 ? `Alarms ${open.length}` : "Alarms");
  const word = `${shown.length} alarm${shown.length > 1 ? "s" : ""}`;
  const calm = open.length === 0 ? ", acknowledged" : "";
  return shown.length > 0 ? [{ word: word + calm, severity: worst || "calm", act: "alarms" }] : [];
}

/** Offset of the data in words. @param {number} seconds Positive: they are ahead. */
export function offsetText(seconds) {
  return `data ${Math.abs(seconds).toFixed(1)} s ${seconds > 0 ? "ahead of" : "behind"} the clock`;
}
