/** Tabs of the panels: arrows go from one to the next, and a pill in the line above the map may open one. */

import { byId } from "./dom.js";

/** @param {import("./app.js").App} app */
export function controlTabs(app) {
  const list = byId("tabs");
  list.addEventListener("keydown", (event) => {
    const tabs = /** @type {HTMLElement[]} */ ([...list.children]);
    const at = tabs.findIndex((tab) => tab === document.activeElement);
    const places = { ArrowRight: at + 1, ArrowDown: at + 1, ArrowLeft: at - 1, ArrowUp: at - 1, Home: 0, End: -1 };
    const place = event.shiftKey ? undefined : /** @type {Record<string, number>} */ (places)[event.key];
    if (at < 0 || place === undefined) return;
    const tab = tabs[(place + tabs.length) % tabs.length];
    app.set({ tab: /** @type {any} */ (tab.dataset.tab) });
    tab.focus();
    event.preventDefault();
  });
  byId("pills").addEventListener("click", (event) => {
    const wanted = /** @type {Element} */ (event.target).closest("[data-tab-wanted]")?.getAttribute("data-tab-wanted");
    if (!wanted) return;
    app.set({ tab: wanted });
    byId(`tab-${wanted}`).focus();
  });
}
