/**
 * Orders to fusion: a button stands where its subject is shown, names the subject, and opens a dialog in which the kind
 * of order, its parameters and its duration are chosen and confirmed. The kinds come from the server's registry.
 */

import { clock, h, morph } from "./dom.js";
import { buttons, dialogOf, field, show } from "./operator.js";
import { nameOf } from "./picture.js";

/** @typedef {import("./app.js").App} App */
/** @typedef {Record<string, string | number>} Subject Parameters that are known from where the button stands. */
/**
 * @typedef {{kind: string, summary: string, needs: string[], may: string[], range: [number, number], lasts: boolean}} Kind
 */

/** Parameters that only a subject gives: nobody types the number of a track. */
const GIVEN = ["track", "with", "sensor_track", "number", "place"];
/** Parameters that are the name of a source. */
const SOURCES = ["source", "from", "tracker"];
const TITLES = /** @type {Record<string, string>} */ ({
  source: "Source",
  from: "From the source",
  tracker: "Tracker",
  value: "Value",
  name: "Name",
  sigma: "Standard deviation, metres",
});

/**
 * Kinds of orders that a subject allows: each takes all that is known, and asks for nothing that must be known.
 * @param {Kind[]} kinds @param {Subject} subject
 */
export function kindsFor(kinds, subject) {
  return kinds.filter(({ needs, may }) => {
    const takes = Object.keys(subject).every((name) => needs.includes(name) || may.includes(name));
    return takes && needs.every((name) => name in subject || !GIVEN.includes(name));
  });
}

/** Button that opens the dialog of orders on a subject. @param {string} title @param {Subject} subject */
export function orderButton(title, subject) {
  return h("button.order", { type: "button", "data-order": JSON.stringify(subject) }, title);
}

/** Orders on a selected track, on a pair of them, and on its sensor tracks. @param {App} app @param {HTMLElement} parent */
export function showTrackOrders(app, parent) {
  const numbers = [...app.selected];
  const number = numbers.at(-1);
  const track = number === undefined ? undefined : app.picture.system.get(number);
  if (!app.known.hasOperators || number === undefined || !track) return parent.replaceChildren();
  const others = numbers.slice(0, -1).map((other) => {
    const known = app.picture.system.get(other);
    return orderButton(`join with ${known ? nameOf(known) : other} …`, { track: other, with: number });
  });
  const shares = (app.shares.get(number) ?? []).filter((share) => !share.centre);
  const parts = shares.map((share) =>
    orderButton(`split off ${share.name} ${share.track} …`, {
      track: number,
      source: share.name,
      sensor_track: share.track,
    }),
  );
  const place = `${track.east.toFixed(0)}m,${track.north.toFixed(0)}m`;
  const list = h(
    "p.buttons",
    {},
    orderButton("drop, renumber …", { track: number }),
    ...others,
    ...(parts.length > 1 ? parts : []),
    orderButton("designate to a tracker …", { place }),
  );
  morph(parent, h("div", {}, h("h2", {}, "Orders"), list, ...ordersOn(app, number)));
}

/** Orders in force on a track, with their state. @param {App} app @param {number} number */
function ordersOn(app, number) {
  const about = new RegExp(`\\b(track|with)=${number}\\b`);
  return app.known.orders
    .filter(({ order }) => about.test(order))
    .map((order) => h("div.soft", {}, `${order.order}: ${order.state}, ${order.operator}, ${clock(order.changed)}`));
}

/** Opens the dialog for every button of an order on the page. @param {App} app */
export function controlOrders(app) {
  document.addEventListener("click", (event) => {
    const subject = /** @type {Element} */ (event.target).closest("[data-order]")?.getAttribute("data-order");
    if (subject) void ask(app, JSON.parse(subject));
  });
}

/** @type {Kind[]} */
let known = [];

/** @param {App} app @param {Subject} subject */
async function ask(app, subject) {
  if (known.length === 0) known = (await (await fetch("api/orders.json")).json()).kinds;
  const kinds = kindsFor(known, subject);
  if (kinds.length === 0) return;
  const select = /** @type {HTMLSelectElement} */ (
    h("select", { id: "order-kind" }, ...kinds.map(({ kind }) => h("option", {}, kind)))
  );
  const form = h("div");
  const state = h("p", { role: "status" });
  const named = Object.entries(subject).map(([name, value]) => `${name} ${value}`);
  const dialog = dialogOf("Order", h("p", {}, named.join(", ")), h("label.setting", {}, "Order", select), form, state);
  const fill = () => form.replaceChildren(...fieldsOf(app, kinds[select.selectedIndex], subject));
  select.addEventListener("change", fill);
  fill();
  let isGiven = false;
  const give = async () => {
    if (isGiven) return dialog.close();
    const order = orderOf(form, kinds[select.selectedIndex], subject);
    if (typeof order === "string") return void (state.textContent = order);
    state.textContent = "Fusion is asked …";
    const { ok, text, value } = await app.operator.send("api/order", order);
    isGiven = ok;
    state.className = ok ? "good" : "bad";
    state.textContent = ok
      ? `${value.number ? `Order ${value.number}: ` : ""}${value.state}. ${value.order}`
      : refusal(value, text);
    dialog.querySelector(".buttons button")?.replaceChildren(ok ? "Close" : "Give the order");
  };
  dialog.append(buttons(["Give the order", give], ["Cancel", () => dialog.close()]));
  show(dialog);
}

/** @param {any} value Answer of fusion, if it is one. @param {string} text */
function refusal(value, text) {
  return value ? `Refused: ${value.text}` : text;
}

/** Fields of what an order still needs. @param {App} app @param {Kind} kind @param {Subject} subject */
function fieldsOf(app, kind, subject) {
  const open = [...kind.needs, ...kind.may].filter((name) => !(name in subject));
  const fields = open.map((name) => {
    const title = TITLES[name] ?? name;
    const isNeeded = kind.needs.includes(name);
    if (SOURCES.includes(name)) {
      const names = [...(isNeeded ? [] : [""]), ...app.known.sources.map((source) => source.name)];
      const options = names.map((one) => h("option", { value: one }, one || "any"));
      return h("label.setting", {}, title, h("select", { "data-parameter": name }, ...options));
    }
    const [low, high] = kind.range;
    const isNumber = name === "value" || name === "sigma";
    const words = isNumber ? `${title}, ${low} to ${high}` : title;
    return field(`order-${name}`, words, "text", "", {
      "data-parameter": name,
      inputmode: isNumber ? "decimal" : "text",
    }).label;
  });
  const span = field("order-for", "Ends after seconds (empty: never)", "text", "", {
    "data-parameter": "for_s",
    inputmode: "decimal",
  });
  return [h("p.soft", {}, kind.summary), ...fields, ...(kind.lasts ? [span.label] : [])];
}

/**
 * Order that the fields make; a sentence where one of them is wrong.
 * @param {HTMLElement} form @param {Kind} kind @param {Subject} subject
 * @returns {Record<string, string | number> | string}
 */
function orderOf(form, kind, subject) {
  /** @type {Record<string, string | number>} */
  const order = { kind: kind.kind, ...subject };
  for (const input of /** @type {NodeListOf<HTMLInputElement>} */ (form.querySelectorAll("[data-parameter]"))) {
    const name = input.getAttribute("data-parameter") ?? "";
    const text = input.value.trim();
    if (text === "") {
      if (!kind.needs.includes(name)) continue;
      input.focus();
      return `${TITLES[name] ?? name} is missing.`;
    }
    const isNumber = name === "value" || name === "sigma" || name === "for_s";
    if (isNumber && !Number.isFinite(Number(text))) {
      input.focus();
      return `${text} is no number.`;
    }
    order[name] = isNumber ? Number(text) : text;
  }
  return order;
}
