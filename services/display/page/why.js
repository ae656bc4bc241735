/**
 * Why a selected track is as it is: each contributor with its reason, what other rules would give, and the latest
 * decisions of fusion. The sentences come from the server.
 */

import { clock, h } from "./dom.js";

/**
 * A contributor; a number is NaN where it is unknown.
 * @typedef {object} Reasoned
 * @property {number} source @property {string} name @property {number} track @property {number} weight
 * @property {number} accuracy @property {boolean} fresh @property {boolean} centre
 * @property {number} age Seconds at the state's time.
 * @property {number} sigmaLong @property {number} sigmaShort Ellipse of the report, scaled, metres.
 * @property {number} learnedSigma Of its measurements, as fusion has learned it, metres.
 * @property {number} residual Distance of the moved report from the state, metres.
 * @property {number} residualSigmas The same in standard deviations.
 * @property {number} inflation Covariance scaling. @property {number} bias Taken off, horizontally, metres; 0: none.
 * @property {string} reason Sentences; "": a moment of the past.
 */

/** @typedef {{rule: string, summary: string, inForce: boolean, shares: [number, string, number][], apart: number}} Rule */
/** @typedef {{time_s: number, kind: string, text: string}} Decision */
/** @typedef {{decisions: Decision[], decisionsMissing: string, rules: Rule[], rulesMissing: string}} Why */

/** @type {Readonly<Why>} */
export const NO_REASONS = Object.freeze({ decisions: [], decisionsMissing: "", rules: [], rulesMissing: "" });

/** Reasons from the server's details of a track. @param {any} track @returns {Why} */
export function whyOf(track) {
  return {
    decisions: track.decisions ?? [],
    decisionsMissing: track.decisions_missing ?? "",
    rules: (track.rules ?? []).map((/** @type {any} */ rule) => ({
      rule: rule.rule,
      summary: rule.summary,
      inForce: rule.in_force,
      shares: rule.shares,
      apart: rule.apart_m ?? NaN,
    })),
    rulesMissing: track.rules_missing ?? "",
  };
}

/** Reasons of a contributor from the server's details. @param {any} share */
export function reasonOf(share) {
  const [east, north] = share.residual_m ?? [NaN, NaN];
  const bias = share.bias_m ?? [0, 0];
  return {
    age: share.age_s ?? NaN,
    sigmaLong: share.sigma_m?.[0] ?? NaN,
    sigmaShort: share.sigma_m?.[1] ?? NaN,
    learnedSigma: share.learned_sigma_m ? Math.sqrt(share.learned_sigma_m[0] * share.learned_sigma_m[1]) : NaN,
    residual: Math.hypot(east, north),
    residualSigmas: share.residual_sigmas ?? NaN,
    inflation: share.inflation ?? NaN,
    bias: Math.hypot(bias[0], bias[1]),
    reason: share.reason ?? "",
  };
}

/** @param {number} value @param {(value: number) => string} text */
const known = (value, text) => (Number.isFinite(value) ? text(value) : "–");

/** Metres as exactly as they are needed. @param {number} metres */
const metres = (metres) => (metres < 10 ? metres.toFixed(1) : metres.toFixed(0));

/** What a contributor's last report is like, in words. @param {Reasoned} share */
function reportText(share) {
  return [
    Number.isFinite(share.sigmaLong) ? `σ ${metres(share.sigmaLong)} × ${metres(share.sigmaShort)} m` : "",
    Number.isFinite(share.learnedSigma) ? `measurements ± ${metres(share.learnedSigma)} m` : "",
    Number.isFinite(share.residual) ? `${metres(share.residual)} m off` : "",
    share.inflation > 1.05 ? `covariance × ${share.inflation.toFixed(1)}` : "",
    share.bias > 0.05 ? `bias of ${metres(share.bias)} m taken off` : "",
  ]
    .filter((text) => text !== "")
    .join(" · ");
}

/** @param {Reasoned[]} shares @returns {HTMLElement} */
export function contributorsTable(shares) {
  const titles = ["Source", "", ">share", ">age", ">off"];
  // A column without a title is no heading.
  const head = titles.map((title) => {
    const text = title.replace(">", "");
    return h(`${text === "" ? "td" : "th"}${title.startsWith(">") ? ".num" : ""}`, {}, text);
  });
  const rows = shares.flatMap((share) => {
    const bar = h("i");
    bar.style.width = `${100 * share.weight}%`;
    const far = share.residualSigmas > 3 ? "td.num.warn" : "td.num";
    const row = h(
      "tr",
      {
        "data-source": share.source,
        "data-weight": share.weight,
        "data-track": share.track,
        "data-accuracy": share.accuracy,
      },
      h("td", {}, share.name, share.centre ? h("span.soft", {}, share.fresh ? " centre" : " centre, silent") : ""),
      h("td", {}, h("span.bar", {}, bar)),
      h("td.num", {}, share.weight.toFixed(2)),
      h("td.num", {}, known(share.age, (age) => `${age.toFixed(1)} s`)),
      h(
        far,
        { title: "Its last report, moved to the time of the state, minus the state, in standard deviations" },
        known(share.residualSigmas, (sigmas) => `${sigmas.toFixed(1)} σ`),
      ),
    );
    if (share.reason === "") return [row];
    return [row, h("tr.reason", {}, h("td", { colspan: 5 }, share.reason, h("div.soft", {}, reportText(share))))];
  });
  return h("table.why", {}, h("thead", {}, h("tr", {}, ...head)), h("tbody", {}, ...rows));
}

/**
 * What each rule would give now. @param {Why} why @param {string} rule Rule in force.
 * @returns {HTMLElement[]}
 */
export function rulesPart(why, rule) {
  if (why.rules.length === 0 && why.rulesMissing === "") return [];
  const title = h("h2", {}, "Other rules would give");
  if (why.rules.length === 0) return [title, h("p.soft", {}, why.rulesMissing)];
  const head = h("tr", {}, h("th", {}, "Rule"), h("th", {}, "shares"), h("th.num", {}, "moved by"));
  const rows = why.rules.map((row) => {
    const shares = row.shares.filter(([, , share]) => share >= 0.005);
    const text = shares.map(([, name, share]) => `${name} ${share.toFixed(2)}`).join(" · ");
    return h(
      "tr",
      { title: row.summary, "data-rule": row.rule },
      h("td", {}, row.inForce ? h("b", {}, `${row.rule} ✓`) : row.rule),
      h("td.soft", {}, text || "none usable"),
      h("td.num", {}, known(row.apart, (apart) => `${metres(apart)} m`)),
    );
  });
  const inForce = why.rules.some((row) => row.inForce) ? "" : `In force: ${rule}, one filter over all measurements. `;
  const note = `${inForce}Without the memory of earlier choices.`;
  return [title, h("table", {}, h("thead", {}, head), h("tbody", {}, ...rows)), h("p.soft", {}, note)];
}

/** Latest decisions of fusion, or why there are none. @param {Why} why @returns {HTMLElement[]} */
export function decisionsPart({ decisions, decisionsMissing }) {
  const title = h("h2", {}, "Decisions");
  if (decisions.length > 0) {
    const rows = decisions.map(({ time_s, kind, text }) =>
      h("tr", { "data-decision": kind }, h("td.num.soft", {}, clock(time_s)), h("td", {}, text)),
    );
    return [title, h("table", {}, h("tbody", {}, ...rows))];
  }
  return [title, h("p.soft", {}, decisionsMissing || "None while the display has been running.")];
}
