/** Alarms: those that stand, what operators have done about them, what has happened, and their sound. */

import { clock, dayAndClock, h, morph, span } from "./dom.js";
import { ofWindow } from "./window.js";

/** @typedef {import("./app.js").App} App */

/**
 * @typedef {object} Alarm
 * @property {string} id @property {number} code @property {string} severity @property {string} text
 * @property {number} raised seconds UTC
 * @property {string} process @property {number} times @property {boolean} cleared @property {string} remedy
 * @property {number} source -1: none.
 * @property {{operator: string, time: number} | null} acknowledged
 * @property {{operator: string, until: number} | null} shelved
 */

/** @typedef {{time_s: number, event: string, operator: string, severity: string, text: string, process: string}} PastEvent */

const CLASSES = /** @type {Record<string, string>} */ ({ critical: "bad", major: "bad", warning: "warn" });
/** Severities, the worst first. */
const SEVERITIES = ["critical", "major", "warning"];
/** Pitches of the sounds in hertz, and how many. @type {Record<string, [number, number]>} */
const SOUNDS = { critical: [880, 3], major: [660, 2], warning: [440, 1] };
/** Time after which the sound of an alarm that nobody has acknowledged comes again, milliseconds. */
const AGAIN_MS = 10_000;
/** Times for which an alarm can be shelved: words, seconds. @type {[string, number][]} */
const SHELVES = [
  ["15 min", 900],
  ["1 h", 3600],
  ["8 h", 28_800],
];

/** Alarms that stand and are not shelved; of these, those that nobody has acknowledged. @param {Alarm[]} alarms */
export function standing(alarms) {
  const shown = alarms.filter((alarm) => !alarm.cleared && !alarm.shelved);
  return { shown, open: shown.filter((alarm) => !alarm.acknowledged) };
}

/**
 * Severity of the sound that is due; "": none.
 * @param {Alarm[]} alarms @param {string} least Severity from which alarms sound; off: none.
 */
export function soundOf(alarms, least) {
  const loud = SEVERITIES.slice(0, SEVERITIES.indexOf(least) + 1);
  return loud.find((severity) => standing(alarms).open.some((alarm) => alarm.severity === severity)) ?? "";
}

export class Alarms {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {PastEvent[]} */
    this.past = [];
    this.pastCount = -1;
    this.soundDue = 0;
    this.lastSound = "";
    /** @type {AudioContext | null} */
    this.audio = null;
    document.addEventListener("click", (event) => this.click(/** @type {Element} */ (event.target)));
  }

  /** @param {Element} target */
  click(target) {
    const button = target.closest("[data-alarm]");
    if (!button) return;
    const [alarm, act] = [button.getAttribute("data-alarm"), button.getAttribute("data-act")];
    if (act === "system") return this.app.set({ tab: "system" });
    if (act === "source") return this.app.showSource(Number(alarm));
    const time = Number(button.getAttribute("data-for"));
    void this.app.operator
      .send("api/alarm", { alarm, act, ...(time > 0 ? { for_s: time } : {}) })
      .then(({ ok, text }) => {
        this.app.notice(ok ? "" : text);
        this.app.panelDue = 0;
      });
  }

  /** @param {HTMLElement} panel */
  show(panel) {
    const { known } = this.app;
    if (this.pastCount !== known.alarmEvents) void this.fetchPast(known.alarmEvents);
    const all = known.alarms.filter((alarm) => !alarm.cleared);
    const { shown, open } = standing(known.alarms);
    const calm = [...open, ...shown.filter((alarm) => alarm.acknowledged)];
    const shelved = all.filter((alarm) => alarm.shelved);
    const hint =
      known.hasOperators || all.length === 0
        ? []
        : [h("p.soft", {}, "Operators acknowledge and shelve alarms; this display has none (display.operator_token).")];
    morph(
      panel,
      h(
        "div.pad",
        {},
        h("h2", {}, "Alarms"),
        ...(calm.length === 0 ? [h("p.good", {}, "No alarm stands.")] : []),
        ...calm.map((alarm) => this.entry(alarm)),
        ...hint,
        ...(shelved.length > 0 ? [h("h2", {}, "Shelved"), ...shelved.map((alarm) => this.entry(alarm))] : []),
        h("h2", {}, "History"),
        this.history(),
      ),
    );
  }

  /** @param {Alarm} alarm */
  entry(alarm) {
    const { known } = this.app;
    // An alarm about the adapter of a source concerns the source.
    const source = known.sources.find(({ number, adapter }) =>
      alarm.source >= 0 ? number === alarm.source : adapter !== "" && adapter === alarm.process,
    );
    const subject = source
      ? [h("button", { "data-alarm": source.number, "data-act": "source" }, `Show ${source.name}`)]
      : alarm.process !== ""
        ? [h("button", { "data-alarm": alarm.id, "data-act": "system" }, "Show processes")]
        : [];
    const treated = [
      alarm.acknowledged && `acknowledged by ${alarm.acknowledged.operator} ${clock(alarm.acknowledged.time)}`,
      alarm.shelved && `shelved by ${alarm.shelved.operator} until ${clock(alarm.shelved.until)}`,
    ].filter((word) => word !== null);
    const facts = [
      `alarm ${alarm.code}`,
      alarm.process,
      `since ${clock(alarm.raised)} (${span(known.time - alarm.raised)})`,
      alarm.times > 1 ? `${alarm.times} times` : "",
    ].filter((word) => word !== "");
    const act = (/** @type {string} */ title, /** @type {string} */ word, time = 0) =>
      h("button", { "data-alarm": alarm.id, "data-act": word, "data-for": time }, title);
    const acts =
      treated.length > 0
        ? [act("Restore", "restore")]
        : [
            act("Acknowledge", "acknowledge"),
            ...SHELVES.map(([title, time]) => act(`Shelve ${title}`, "shelve", time)),
          ];
    const loud = treated.length > 0 ? "soft" : (CLASSES[alarm.severity] ?? "warn");
    return h(
      `div.alarm.${loud}`,
      { "data-key": alarm.id },
      h(`b.${loud}`, {}, alarm.severity),
      h("div", {}, alarm.text),
      ...(alarm.remedy ? [h("div", {}, "→ ", alarm.remedy)] : []),
      h("div.soft", {}, facts.join(" · ")),
      ...(treated.length > 0 ? [h("div", {}, treated.join(" · "))] : []),
      h("p.buttons", {}, ...(known.hasOperators ? acts : []), ...subject),
    );
  }

  history() {
    if (this.past.length === 0) return h("p.soft", {}, "Nothing since the display started.");
    const rows = this.past.map((event) => {
      const calm =
        event.event === "cleared" ? "good" : event.event === "raised" ? (CLASSES[event.severity] ?? "warn") : "soft";
      return h(
        "tr",
        {},
        h("td.num", { title: dayAndClock(event.time_s) }, clock(event.time_s)),
        h(`td.${calm}`, {}, event.event, ...(event.operator ? [h("div.soft.told", {}, event.operator)] : [])),
        h("td.told", {}, event.text),
      );
    });
    const head = ["UTC", "Event", "Alarm"].map((title) => h("th", {}, title));
    return h("table", {}, h("thead", {}, h("tr", {}, ...head)), h("tbody", {}, ...rows));
  }

  /** @param {number} count Number of events that the server has. */
  async fetchPast(count) {
    this.pastCount = count;
    const answer = await fetch(ofWindow("api/alarms.json")).catch(() => null);
    if (answer?.ok) this.past = (await answer.json()).events;
    this.app.panelDue = 0;
  }

  /** Sounds what is due. @param {number} now Milliseconds of the page's clock. */
  sound(now) {
    const { settings, known, stats } = this.app;
    const severity = settings.at > 0 ? "" : soundOf(known.alarms, settings.sound);
    const isWorse = SEVERITIES.indexOf(severity) < SEVERITIES.indexOf(this.lastSound) || this.lastSound === "";
    if (severity !== "" && (isWorse || now >= this.soundDue)) {
      this.soundDue = now + AGAIN_MS;
      stats.sounds++;
      this.play(...SOUNDS[severity]);
    }
    this.lastSound = severity;
  }

  /** @param {number} pitch @param {number} times */
  play(pitch, times) {
    // Browsers let a page sound after the first click or key alone.
    this.audio ??= new AudioContext();
    const { audio } = this;
    for (let k = 0; k < times; k++) {
      const [tone, volume] = [audio.createOscillator(), audio.createGain()];
      const from = audio.currentTime + 0.25 * k;
      tone.frequency.value = pitch;
      volume.gain.setValueAtTime(0.2, from);
      volume.gain.exponentialRampToValueAtTime(0.001, from + 0.2);
      tone.connect(volume).connect(audio.destination);
      tone.start(from);
      tone.stop(from + 0.2);
    }
  }
}
