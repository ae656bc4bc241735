/**
 * Views that are kept: named ones in this browser and at the server, and the settings of the last page in this browser.
 * A view is the address of a page, what follows `#`. A page that is opened without one has the start view of the
 * configuration, and over it the settings that this browser had last.
 */

import { h } from "./dom.js";
import { nearest } from "./filter.js";
import { buttons, field } from "./operator.js";
import { DEFAULTS, read, write } from "./settings.js";

/** @typedef {import("./settings.js").Settings} Settings */
/** @typedef {{name: string, address: string, operator: string}} View */

const SETTINGS = "koseki.settings";
const VIEWS = "koseki.views";
/** What belongs to one moment or place, and is no habit. */
const PASSING = ["e", "n", "scale", "up", "sel", "at", "speed", "filter", "follow", "isolate"];

/** What the browser keeps under a key, an object; damaged text counts as none. @param {string} key @returns {any} */
function keptOf(key) {
  try {
    const value = JSON.parse(localStorage.getItem(key) ?? "{}");
    return typeof value === "object" && value !== null ? value : {};
  } catch {
    return {};
  }
}

/** @type {Settings} Settings of a page without an address and without habits. */
let base = { ...DEFAULTS };

/**
 * Address of a page that is opened without one.
 * @param {string} start Start view of the configuration.
 */
export function openingAddress(start) {
  base = read(start);
  const habits = new URLSearchParams(start);
  for (const [key, text] of Object.entries(keptOf(SETTINGS))) habits.set(key, String(text));
  return write(read(String(habits)));
}

/** What a start view has that no page knows, as a sentence; "": nothing. @param {string} start */
export function unknownIn(start) {
  const keys = Object.keys(DEFAULTS);
  const unknown = [...new URLSearchParams(start).keys()].filter((key) => !keys.includes(key));
  const words = unknown.map((key) => {
    const meant = nearest(key, keys);
    return meant ? `${key} (perhaps ${meant})` : key;
  });
  return words.length > 0 ? `display.views.start: a page does not know ${words.join(", ")}.` : "";
}

/** Keeps the settings that differ from the start view. @param {Settings} settings */
export function keepHabits(settings) {
  /** @type {Record<string, string>} */
  const habits = {};
  for (const [key, value] of Object.entries(settings)) {
    if (PASSING.includes(key) || value === /** @type {Record<string, unknown>} */ (base)[key]) continue;
    habits[key] = typeof value === "boolean" ? (value ? "1" : "0") : String(value);
  }
  const text = JSON.stringify(habits);
  if (localStorage.getItem(SETTINGS) !== text) localStorage.setItem(SETTINGS, text);
}

/** Address of the present view as it is kept: without a moment and without what is selected. @param {Settings} settings */
export function addressOf(settings) {
  return write({ ...settings, sel: "", at: 0, speed: 0, follow: false, isolate: false }).replace(/^#/, "");
}

export class KeptViews {
  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    /** @type {View[]} */
    this.shared = [];
    this.isKept = false;
    this.name = field("view-name", "Name of this view", "text", "", { maxlength: 40 });
    this.list = h("div");
    this.note = h("p.soft", { role: "status" });
    void this.fetch();
  }

  /** Part of the panel with the views, made once. */
  panel() {
    this.show();
    const acts = [
      /** @type {[string, () => unknown]} */ (["Keep in this browser", () => this.keep()]),
      ...(this.isKept && this.app.known.hasOperators
        ? [/** @type {[string, () => unknown]} */ (["Keep for all", () => this.keepForAll()])]
        : []),
    ];
    return h("div.pad", {}, h("h2", {}, "Named views"), this.list, this.name.label, buttons(...acts), this.note);
  }

  async fetch() {
    const answer = await fetch("api/views.json").catch(() => null);
    if (!answer?.ok) return;
    const { views, is_kept } = await answer.json();
    Object.assign(this, { shared: views, isKept: is_kept });
    this.show();
  }

  /** @returns {View[]} */
  own() {
    const views = Object.entries(keptOf(VIEWS));
    return views.map(([name, address]) => ({ name, address: String(address), operator: "" }));
  }

  show() {
    const rows = [...this.shared, ...this.own()].map((view) => {
      const whose = view.operator ? `for all, by ${view.operator}` : "in this browser";
      const mayRemove = view.operator === "" || (this.isKept && this.app.known.hasOperators);
      const remove = () => (view.operator ? this.change(view.name, null) : this.store(view.name, null));
      return h(
        "div.view",
        {},
        h("button", { click: () => this.open(view) }, view.name),
        h("span.soft", {}, whose),
        ...(mayRemove
          ? [h("button", { "aria-label": `Remove ${view.name}, ${whose}`, click: () => void remove() }, "×")]
          : []),
      );
    });
    this.list.replaceChildren(...(rows.length > 0 ? rows : [h("p.soft", {}, "None is kept.")]));
  }

  /** @param {View} view */
  open(view) {
    location.hash = view.address;
  }

  keep() {
    const name = this.wanted();
    if (name) this.store(name, addressOf(this.app.settings));
  }

  async keepForAll() {
    const name = this.wanted();
    if (name) await this.change(name, addressOf(this.app.settings));
  }

  wanted() {
    const name = this.name.input.value.trim();
    this.note.textContent = name === "" ? "A view needs a name." : "";
    if (name === "") this.name.input.focus();
    return name;
  }

  /** Keeps a view in this browser, or removes it. @param {string} name @param {string | null} address */
  store(name, address) {
    const views = keptOf(VIEWS);
    if (address === null) delete views[name];
    else views[name] = address;
    localStorage.setItem(VIEWS, JSON.stringify(views));
    this.note.textContent = address === null ? `${name} is removed.` : `${name} is kept in this browser.`;
    this.show();
  }

  /** Keeps a view for all, or removes it. @param {string} name @param {string | null} address */
  async change(name, address) {
    const { ok, text } = await this.app.operator.send("api/views", { name, address });
    this.note.textContent = ok ? `${name} is ${address === null ? "removed" : "kept for all"}.` : text;
    await this.fetch();
  }
}
