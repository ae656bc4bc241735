/**
 * Search for a track by what people call it: callsign, code, address, number. The first letter that is typed opens it.
 */

import { byId, h } from "./dom.js";
import { heightText } from "./labels.js";
import { nameOf } from "./picture.js";

/** @typedef {import("./picture.js").Track} Track */

/** Most suggestions that are shown. */
const SUGGESTIONS_MAX = 8;

/**
 * Tracks that a text may mean, the likeliest first: equal names, then names that begin with it, then names that contain
 * it; callsigns before codes, addresses and numbers.
 * @param {Iterable<Track>} tracks @param {string} text
 * @returns {Track[]}
 */
export function found(tracks, text) {
  const wanted = text.trim().toLowerCase();
  if (wanted === "") return [];
  /** @type {[number, string, Track][]} */
  const ranked = [];
  for (const track of tracks) {
    let rank = Infinity;
    [track.callsign, track.code, track.address, `#${track.number}`].forEach((name, k) => {
      const own = name.toLowerCase();
      const place = own === wanted ? 0 : own.startsWith(wanted) ? 4 : own.includes(wanted) ? 8 : Infinity;
      if (own !== "") rank = Math.min(rank, place + k);
    });
    if (rank < Infinity) ranked.push([rank, nameOf(track), track]);
  }
  ranked.sort((a, b) => a[0] - b[0] || (a[1] < b[1] ? -1 : a[1] > b[1] ? 1 : a[2].number - b[2].number));
  return ranked.slice(0, SUGGESTIONS_MAX).map(([, , track]) => track);
}

/** Whether a key that is pressed on the map begins a name. @param {string} key */
export function isNameKey(key) {
  return /^[a-z0-9#]$/i.test(key);
}

export class SearchBox {
  /** @param {import("./app.js").App} app @param {HTMLElement} parent */
  constructor(app, parent) {
    this.app = app;
    this.input = /** @type {HTMLInputElement} */ (
      h("input", {
        id: "find",
        type: "text",
        role: "combobox",
        autocomplete: "off",
        spellcheck: "false",
        placeholder: "callsign, code, address, #number",
        "aria-label": "Find a track",
        "aria-autocomplete": "list",
        "aria-controls": "found",
        "aria-expanded": "false",
      })
    );
    this.list = h("ul", { id: "found", role: "listbox", "aria-label": "Tracks found" });
    this.note = h("p.soft", { role: "status" });
    this.box = h("div", { id: "search", role: "search", hidden: true }, this.input, this.list, this.note);
    parent.append(this.box);
    /** @type {Track[]} */
    this.tracks = [];
    this.chosen = 0;
    this.input.addEventListener("input", () => this.show(0));
    this.input.addEventListener("keydown", (event) => this.key(event));
    this.input.addEventListener("blur", () => this.close());
    // The field keeps the focus while a suggestion is pressed.
    this.list.addEventListener("pointerdown", (event) => event.preventDefault());
    this.list.addEventListener("click", (event) => {
      const item = /** @type {Element} */ (event.target).closest("[data-place]");
      if (item) this.go(Number(item.getAttribute("data-place")));
    });
  }

  /** @param {string} text What has been typed. */
  open(text) {
    this.box.hidden = false;
    this.input.value = text;
    this.input.focus();
    this.show(0);
  }

  close() {
    this.box.hidden = true;
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    event.stopPropagation();
    if (event.key === "Enter") this.go(this.chosen);
    else if (event.key === "Escape") this.app.trackCanvas.focus();
    else if (event.key === "ArrowDown") this.show(this.chosen + 1);
    else if (event.key === "ArrowUp") this.show(this.chosen - 1);
    else return;
    event.preventDefault();
  }

  /** Shows what is found, and marks one of it. @param {number} chosen */
  show(chosen) {
    const { app, input, list } = this;
    this.tracks = found(app.picture.system.values(), input.value);
    const count = this.tracks.length;
    this.chosen = count > 0 ? (chosen + count) % count : 0;
    list.replaceChildren(
      ...this.tracks.map((track, k) =>
        h(
          "li",
          { id: `found-${k}`, role: "option", "aria-selected": String(k === this.chosen), "data-place": k },
          h("b", {}, nameOf(track)),
          ` ${[track.code, track.address, `#${track.number}`].filter((name) => name !== "").join(" ")} `,
          h("span.soft", {}, heightText(track, app.settings.units)),
        ),
      ),
    );
    input.setAttribute("aria-expanded", String(count > 0));
    if (count > 0) input.setAttribute("aria-activedescendant", `found-${this.chosen}`);
    else input.removeAttribute("aria-activedescendant");
    const none = input.value.trim() === "" ? "" : "No track is called so.";
    this.note.textContent = count > 0 ? "Enter: select and centre" : none;
  }

  /** Selects and centres a suggestion. @param {number} place */
  go(place) {
    const track = this.tracks[place];
    if (!track) return;
    this.app.goTo(track.number);
  }
}
