/**
 * Panels beside the map: the selected track, sources, latency, the processes, and the settings of the view.
 */

import { clock, grouped, h, latency, span } from "./dom.js";
import { bearing, courseText, placeOf, sexagesimal } from "./geodesy.js";
import { climbText, heightText, levelOf, modesText, speedText, turnText } from "./labels.js";
import { LAYERS } from "./layers.js";
import { ALERTS, nameOf } from "./picture.js";
import { orderButton } from "./orders.js";
import { histogram, plot } from "./plots.js";
import { CHOICES } from "./settings.js";
import { contributorsTable, decisionsPart, rulesPart } from "./why.js";

/** @typedef {import("./painter.js").Share & import("./why.js").Reasoned} Share */

/**
 * @typedef {object} Source
 * @property {number} number @property {string} name @property {string} kind
 * @property {string} adapter Process that receives its reports; "": unknown.
 * @property {number} rate Reports a second. @property {number} lastHeard Seconds UTC; 0: never.
 * @property {number} lost @property {[string, number][]} rejected Count by reason, those that are not 0.
 * @property {string} refused The latest refusals in words.
 * @property {[string, number][]} dependsOn Sources with errors that depend on its errors, with the correlation.
 * @property {string} errors Sentence on the learned errors. @property {number} clockOffset Seconds; NaN: unknown.
 * @property {number} east @property {number} north Its site, metres; NaN: unknown.
 * @property {[number, number]} offset Learned offset, east and north, metres.
 */

/**
 * What else is known of the selected track; `stateTime`: time of the state that it belongs to, nanoseconds UTC.
 * @typedef {{stateTime: string, facts: [string, string][], rule: string, why: import("./why.js").Why,
 *   motion: import("./labels.js").Motion}} Facts
 */

/**
 * @typedef {object} Stage
 * @property {string} name @property {number} count
 * @property {number} p50 @property {number} p99 @property {number} p999 @property {number} max microseconds
 * @property {[number, number][]} buckets Upper edge in microseconds, count.
 */

/**
 * @typedef {object} Order
 * @property {number} number 0: refused before fusion gave a number.
 * @property {string} state @property {string} text @property {string} order @property {string} operator
 * @property {number} changed Seconds UTC. @property {number} ends Seconds UTC; 0: never.
 */

/**
 * @typedef {object} Process
 * @property {string} name @property {string} kind @property {string} state @property {number} pid
 * @property {number} restarts @property {number} heard Seconds UTC; 0: never.
 * @property {string} note @property {[string, string][]} figures
 */

/**
 * @typedef {object} History
 * @property {number[]} times seconds UTC
 * @property {number[]} heights @property {number[]} speeds @property {number[]} nis
 * @property {Map<number, {name: string, weights: number[]}>} weights By source; NaN where it does not contribute.
 */

/**
 * What the panels show.
 * @typedef {object} Known
 * @property {import("./geodesy.js").Place} origin
 * @property {Source[]} sources @property {import("./alarms.js").Alarm[]} alarms
 * @property {number} alarmEvents How many events of alarms there have been.
 * @property {boolean} hasOperators Whether the display admits operators.
 * @property {Order[]} orders @property {Stage[]} stages
 * @property {Process[]} processes
 * @property {[string, string][]} system Figures of the instance as a whole.
 * @property {number} declination Magnetic declination, degrees, east positive; NaN: not given.
 * @property {number} time When this was said, seconds UTC.
 */

/** @param {string} label @param {string} value */
function figure(label, value) {
  return h("div", {}, h("small", {}, label), h("span", {}, value));
}

/** @param {string[]} titles @param {Node[]} rows */
function tableOf(titles, rows) {
  const head = h(
    "tr",
    {},
    // A column without a title is no heading.
    ...titles.map((title) => {
      const text = title.replace(">", "");
      return h(`${text === "" ? "td" : "th"}${title.startsWith(">") ? ".num" : ""}`, {}, text);
    }),
  );
  return h("table", {}, h("thead", {}, head), h("tbody", {}, ...rows));
}

/** @param {string} name */
function css(name) {
  return getComputedStyle(document.body).getPropertyValue(name).trim();
}

export class TrackPanel {
  /** @param {HTMLElement} parent */
  constructor(parent) {
    this.head = h("div");
    this.shares = h("div");
    this.plots = ["Height", "Speed", "Weight of each source", "NIS"].map((title) => ({
      title: h("h2", {}, title),
      canvas: /** @type {HTMLCanvasElement} */ (h("canvas.plot")),
    }));
    this.facts = h("div");
    this.details = /** @type {HTMLDetailsElement} */ (h("details"));
    const parts = this.plots.flatMap(({ title, canvas }) => [title, canvas]);
    parent.replaceChildren(h("div.pad", {}, this.head, this.shares, this.facts, ...parts, this.details));
  }

  /**
   * @param {import("./picture.js").Track} track
   * @param {Share[]} shares @param {History} history @param {Facts} facts
   * @param {Known} known @param {string} units @param {string[]} palette
   * @param {boolean} isPast Whether it is a moment of the past that is shown.
   */
  update(track, shares, history, facts, known, units, palette, isPast) {
    const place = placeOf(known.origin, track.east, track.north);
    const speed = track.knowsVelocity ? Math.hypot(track.speedEast, track.speedNorth) : 0;
    const alerts = ALERTS.filter(([bit]) => (track.alerts & bit) !== 0).map(([, word]) => word);
    const unit = units === "metric" ? "" : " kt";
    this.head.replaceChildren(
      h("h1", {}, nameOf(track), track.kind === "group" ? ` ×${track.members}` : ""),
      h("div.soft.under", {}, `${track.state}${track.onGround ? " · on ground" : ""} `),
      h("div.bad", {}, alerts.join(" ")),
      h(
        "div.grid",
        {},
        figure("callsign", track.callsign || "–"),
        figure("address", track.address || "–"),
        figure("code", track.code || "–"),
        figure("type", track.type || "–"),
        figure(units === "metric" ? "height" : "level", heightText(track, units) || "–"),
        figure("speed", track.knowsVelocity ? `${speedText(track, units)}${unit}` : "–"),
        figure(
          "track angle",
          speed > 0.5 ? courseText(bearing(track.speedEast, track.speedNorth), known.declination) : "–",
        ),
        figure("climb ± σ", climbText(track, facts.motion)),
        figure("turn rate", turnText(facts.motion)),
        figure("motion", modesText(facts.motion)),
        figure("latitude", place ? sexagesimal(place.latitude_deg, "N", "S") : "–"),
        figure("longitude", place ? sexagesimal(place.longitude_deg, "E", "W") : "–"),
        figure(
          "accuracy 1σ",
          track.sigmaMajor > 0 ? `${track.sigmaMajor.toFixed(1)} × ${track.sigmaMinor.toFixed(1)} m` : "–",
        ),
        figure("state of", clock(track.time)),
      ),
    );
    this.shares.replaceChildren(
      h("h2", {}, "Contributors"),
      contributorsTable(shares),
      ...(isPast ? [h("p.soft", {}, "Reasons, decisions and rules are those of the present: press Home.")] : []),
    );
    const until = history.times.at(-1) ?? track.time;
    const since = Math.max(until - 300, Math.min(history.times[0] ?? until, until - 30));
    const [text, line, accent] = [css("--soft"), css("--line"), css("--accent")];
    const axes = { since, until, text, line, end: isPast ? clock(until) : "now" };
    const one = (/** @type {number[]} */ values) => [{ name: "", colour: accent, times: history.times, values }];
    const speeds = units === "metric" ? 1 : 3600 / 1852;
    const heights = history.heights.map((height) => (units === "metric" ? height : levelOf({ height })));
    const canvases = this.plots.map(({ canvas }) => canvas);
    // Noise of level flight must not look like climbing.
    plot(canvases[0], one(heights), {
      ...axes,
      unit: units === "metric" ? "m" : "FL",
      least: units === "metric" ? 150 : 5,
    });
    plot(canvases[1], one(history.speeds.map((v) => v * speeds)), {
      ...axes,
      unit: units === "metric" ? "m/s" : "kt",
      low: 0,
    });
    const weights = [...history.weights.entries()].map(([source, own]) => ({
      name: own.name,
      colour: palette[source % palette.length],
      times: history.times,
      values: own.weights,
    }));
    plot(canvases[2], weights, { ...axes, unit: "η", low: 0, high: 1 });
    const known95 = history.nis.some(Number.isFinite);
    this.plots[3].title.hidden = canvases[3].hidden = !known95;
    if (known95) plot(canvases[3], one(history.nis), { ...axes, unit: "χ²", low: 0, bands: [[5.99, "95 %"]] });
    this.shares.dataset.stateTime = facts.stateTime;
    const open = this.details.open;
    this.facts.replaceChildren(
      ...(isPast ? [] : [...decisionsPart(facts.why), ...rulesPart(facts.why, facts.rule)]),
    );
    this.details.replaceChildren(
      h("summary", {}, "Details"),
      h(
        "div.grid",
        {},
        figure("system track", String(track.number)),
        ...facts.facts.map(([label, value]) => figure(label, value)),
        ...shares.map((share) => figure(`${share.name}, its track`, String(share.track))),
      ),
    );
    this.details.open = open;
  }
}

/**
 * @param {Source[]} sources @param {number} now seconds UTC
 * @param {boolean} hasOperators Whether orders can be given.
 */
export function sourcesPanel(sources, now, hasOperators) {
  const rows = sources.flatMap((source) => {
    const silent = source.lastHeard > 0 ? now - source.lastHeard : Infinity;
    const late = silent > 10 ? "bad" : silent > 5 ? "warn" : "";
    const rejected = source.rejected.map(([reason, count]) => `${reason} ${grouped(count)}`).join(", ");
    const told = [
      source.errors.replace(/, depends on source.*/, ""),
      ...source.dependsOn.map(([name, correlation]) => `errors follow those of ${name} (${correlation.toFixed(1)})`),
      Number.isFinite(source.clockOffset) ? `clock ${(source.clockOffset * 1000).toFixed(0)} ms` : "",
      rejected ? `rejected: ${rejected}` : "",
      source.refused ? `refused: ${source.refused}` : "",
    ].filter((text) => text !== "");
    return [
      h(
        "tr",
        { "data-source": source.number, tabindex: -1 },
        h("td", {}, h("b", {}, source.name), ` `, h("span.soft", {}, source.kind)),
        h("td.num", {}, source.rate.toFixed(1)),
        h(`td.num.${late}`, {}, silent === Infinity ? "never" : span(silent)),
        h(source.lost > 0 ? "td.num.warn" : "td.num", {}, grouped(source.lost)),
      ),
      h(
        "tr",
        {},
        h(
          "td.soft",
          { colspan: 4 },
          told.join(" · "),
          ...(hasOperators ? [h("p.buttons", {}, orderButton(`order on ${source.name} …`, { source: source.name }))] : []),
        ),
      ),
    ];
  });
  return h("div.pad", {}, h("h2", {}, "Sources"), tableOf(["Source", ">reports/s", ">heard", ">lost"], rows));
}

/** @param {Stage[]} stages */
export function latencyPanel(stages) {
  const rows = stages.map((stage) =>
    h(
      "tr",
      {},
      h("td", {}, stage.name),
      h("td.num", {}, grouped(stage.count)),
      h("td.num", {}, latency(stage.p50)),
      h("td.num", {}, latency(stage.p99)),
      h("td.num", {}, latency(stage.p999)),
      h("td.num", {}, latency(stage.max)),
    ),
  );
  const panel = h(
    "div.pad",
    {},
    h("h2", {}, "Latency by stage"),
    tableOf(["Stage", ">n", ">p50", ">p99", ">p99.9", ">max"], rows),
  );
  const [bar, text, line] = [css("--accent"), css("--soft"), css("--line")];
  for (const stage of stages.filter((one) => one.buckets.length > 0)) {
    const canvas = /** @type {HTMLCanvasElement} */ (h("canvas.plot"));
    panel.append(h("h2", {}, stage.name), canvas);
    requestAnimationFrame(() => histogram(canvas, stage.buckets, { bar, text, line }));
  }
  return panel;
}

/** @param {Order[]} orders @param {boolean} hasOperators */
function ordersOf(orders, hasOperators) {
  const give = hasOperators ? [h("p.buttons", {}, orderButton("order …", {}))] : [];
  if (orders.length === 0) return give.length > 0 ? [h("h2", {}, "Orders"), ...give] : [];
  const rows = orders.map((order) =>
    h(
      "tr",
      {},
      h("td.num", {}, order.number || "–"),
      h(order.state === "in-force" ? "td" : "td.soft", {}, order.state === "refused" ? "refused" : order.text),
      h(
        "td",
        {},
        order.order,
        h(
          "div.soft",
          {},
          [
            order.operator,
            `since ${clock(order.changed)}`,
            order.ends > 0 ? `until ${clock(order.ends)}` : "",
            order.state === "refused" ? order.text : "",
          ]
            .filter((word) => word !== "")
            .join(" · "),
        ),
        ...(hasOperators && order.state === "in-force"
          ? [h("p.buttons", {}, orderButton(`cancel ${order.number} …`, { number: order.number }))]
          : []),
      ),
    ),
  );
  return [h("h2", {}, "Orders"), ...give, tableOf([">number", "state", "order"], rows)];
}

/**
 * @param {Process[]} processes @param {Order[]} orders @param {[string, string][]} system
 * @param {number} now seconds UTC @param {boolean} hasOperators
 */
export function systemPanel(processes, orders, system, now, hasOperators) {
  const rows = processes.flatMap((process) => {
    const bad = !/^(running|ok|alive|healthy|ready)$/i.test(process.state);
    return [
      h(
        "tr",
        {},
        h(
          "td",
          {},
          h("b", {}, process.name),
          " ",
          h("span.soft", {}, process.kind === process.name ? "" : process.kind),
        ),
        h(`td.${bad ? "bad" : "good"}`, {}, process.state),
        h(process.restarts > 0 ? "td.num.warn" : "td.num", {}, process.restarts),
        h("td.num", {}, process.heard > 0 ? span(now - process.heard) : "–"),
      ),
      ...(process.figures.length > 0 || process.note
        ? [
            h(
              "tr",
              {},
              h(
                "td.soft",
                { colspan: 4 },
                [process.note, ...process.figures.map(([name, value]) => `${name} ${value}`)]
                  .filter(Boolean)
                  .join(" · "),
              ),
            ),
          ]
        : []),
    ];
  });
  return h(
    "div.pad",
    {},
    h("h2", {}, "Processes"),
    tableOf(["Process", "State", ">restarts", ">heard"], rows),
    ...ordersOf(orders, hasOperators),
    h("h2", {}, "System"),
    h("div.grid", {}, ...system.map(([label, value]) => figure(label, value))),
  );
}

/** @type {[keyof import("./settings.js").Settings, string][]} */
const VIEW_SETTINGS = [
  ["theme", "Colours"],
  ["size", "Size of text and symbols, %"],
  ["letters", "A letter alone"],
  ["sound", "Alarms sound from"],
  ["colour", "Tracks coloured by"],
  ["units", "Units"],
  ["labels", "Label lines (0–3)"],
  ["declutter", "Labels keep clear of each other"],
  ["vector", "Speed vector, seconds"],
  ["trails", "Trails of all tracks"],
  ["trail", "Trail, seconds (−1: all)"],
  ["sigma", "Accuracy ellipse, sigmas (0: none)"],
  ["sensors", "Sensor tracks"],
  .../** @type {[keyof import("./settings.js").Settings, string][]} */ (LAYERS.map(({ key, title }) => [key, title])),
  ["biases", "Sites and learned offsets × 100"],
  ["coverage", "Coverage of each source"],
  ["rings", "Range rings"],
  ["handovers", "Rings at a change of the main source"],
  ["siterings", "Range rings of each sensor"],
  ["dim", "Map dimmed"],
  ["up", "Bearing that points up, degrees"],
  ["isolate", "Selected tracks only"],
  ["follow", "Follow the selected track"],
  ["inview", "Table shows the map's tracks only"],
];

/**
 * @param {import("./settings.js").Settings} settings
 * @param {(patch: Partial<import("./settings.js").Settings>) => void} set
 */
export function viewPanel(settings, set) {
  const rows = VIEW_SETTINGS.map(([key, title]) => {
    const value = settings[key];
    const choices = /** @type {Record<string, string[]>} */ (CHOICES)[key];
    let control;
    if (choices) {
      control = h("select", { "data-setting": key }, ...choices.map((c) => h("option", { selected: c === value }, c)));
      control.addEventListener("change", (event) =>
        set({ [key]: /** @type {HTMLSelectElement} */ (event.target).value }),
      );
    } else if (typeof value === "boolean") {
      control = h("input", { type: "checkbox", checked: value, "data-setting": key });
      control.addEventListener("change", (event) =>
        set({ [key]: /** @type {HTMLInputElement} */ (event.target).checked }),
      );
    } else {
      control = h("input", { type: "number", value: String(value), "data-setting": key, step: "any" });
      control.addEventListener("change", (event) => {
        const number = /** @type {HTMLInputElement} */ (event.target).valueAsNumber;
        if (Number.isFinite(number)) set({ [key]: number });
      });
    }
    return h("label.setting", {}, title, control);
  });
  return h("div.pad", {}, h("h2", {}, "View"), ...rows);
}
