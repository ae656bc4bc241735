/** The side of the page: its tabs, and the panel of the chosen tab. */

import { COLOURS } from "./colours.js";
import { coverageChoice } from "./coverage.js";
import { byId, h, morph } from "./dom.js";
import { NO_MOTION } from "./labels.js";
import { layersChoice } from "./maps.js";
import { showTrackOrders } from "./orders.js";
import { latencyPanel, sourcesPanel, systemPanel, TrackPanel, viewPanel } from "./panels.js";
import { TrackTable } from "./table.js";
import { controlTabs } from "./tabs.js";
import { NO_REASONS } from "./why.js";

const TABS = /** @type {const} */ ([
  ["tracks", "Tracks"],
  ["track", "Selected"],
  ["sources", "Sources"],
  ["alarms", "Alarms"],
  ["latency", "Latency"],
  ["system", "System"],
  ["view", "View"],
]);

export class Side {
  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.table = new TrackTable(byId("panel"), {
      sortBy: (column) => app.set({ sort: app.settings.sort === column ? `-${column}` : column }),
      select: (number, more) => app.select(number, more),
      goTo: (number) => app.goTo(number),
    });
    /** @type {TrackPanel | null} */
    this.trackPanel = null;
    this.trackOrders = h("div");
    /** Sources, and the choice of the coverage that is shown. */
    this.sourceParts = [h("div"), h("div")];
    this.mounted = "";
    for (const [tab, title] of TABS)
      byId("tabs").append(
        h(
          "button",
          {
            role: "tab",
            id: `tab-${tab}`,
            "data-tab": tab,
            "aria-controls": "panel",
            click: () => app.set({ tab: app.settings.tab === tab ? "" : tab }),
          },
          title,
        ),
      );
    controlTabs(app);
  }

  /** Shows the tab that the settings name. */
  showTab() {
    const { tab } = this.app.settings;
    byId("side").classList.toggle("closed", tab === "");
    byId("panel").hidden = tab === "";
    for (const button of byId("tabs").children) {
      const isShown = button.getAttribute("data-tab") === tab;
      button.setAttribute("aria-selected", String(isShown));
      button.setAttribute("tabindex", isShown || (tab === "" && button === byId("tabs").firstElementChild) ? "0" : "-1");
    }
    if (tab !== "") byId("panel").setAttribute("aria-labelledby", `tab-${tab}`);
    if (this.mounted !== tab) {
      this.mounted = tab;
      this.trackPanel = null;
      byId("panel").replaceChildren();
      byId("panel").scrollTop = 0;
      if (tab === "tracks") this.table.mount();
    }
  }

  /** Tracks that the table lists. */
  listed() {
    const { view, settings } = this.app;
    const tracks = [...this.app.picture.system.values()].filter((track) => this.app.shows(track));
    if (!settings.inview) return tracks;
    return tracks.filter((track) => view.sees(track.east, track.north));
  }

  /** Shows the latest in the panel. */
  show() {
    const { settings, known } = this.app;
    const panel = byId("panel");
    // Figures that the user is marking or changing are left alone.
    const busy = panel.contains(document.activeElement) && ["view", "sources"].includes(settings.tab);
    if (settings.tab === "" || busy || (settings.tab !== "tracks" && !getSelection()?.isCollapsed)) return;
    const scroll = panel.scrollTop;
    if (settings.tab === "tracks") {
      this.table.update(this.listed(), settings.sort, this.app.selected, settings.units, (track) => this.app.mainName(track));
    } else if (settings.tab === "track") this.showTrack(panel);
    else if (settings.tab === "sources") this.showSources(panel);
    else if (settings.tab === "alarms") this.app.alarms.show(panel);
    else if (settings.tab === "latency") panel.replaceChildren(latencyPanel(known.stages));
    else if (settings.tab === "system")
      morph(panel, systemPanel(known.processes, known.orders, known.system, known.time, known.hasOperators));
    else if (settings.tab === "view")
      panel.replaceChildren(
        this.app.kept.panel(),
        viewPanel(settings, (patch) => this.app.set(patch)),
        layersChoice(settings.maps, this.app.overlays, (patch) => this.app.set(patch)),
      );
    if (settings.tab !== "tracks") panel.scrollTop = scroll;
  }

  /** @param {HTMLElement} panel */
  showSources(panel) {
    const { known, settings } = this.app;
    const [list, choice] = this.sourceParts;
    if (!panel.contains(list)) panel.replaceChildren(...this.sourceParts);
    morph(list, sourcesPanel(known.sources, known.time, known.hasOperators));
    if (!choice.contains(document.activeElement))
      choice.replaceChildren(coverageChoice(this.app.coverage, known.sources, settings.pd, (patch) => this.app.set(patch)));
  }

  /** @param {HTMLElement} panel */
  showTrack(panel) {
    const number = [...this.app.selected].at(-1);
    const track = number === undefined ? undefined : this.app.picture.system.get(number);
    if (number === undefined || !track) {
      this.trackPanel = null;
      const text =
        number === undefined ? "Select a track on the map or in the table." : `Track ${number} is not in the picture.`;
      panel.replaceChildren(h("div.pad.soft", {}, text));
      return;
    }
    if (!this.trackPanel) {
      this.trackPanel = new TrackPanel(panel);
      panel.firstElementChild?.append(this.trackOrders);
    }
    showTrackOrders(this.app, this.trackOrders);
    this.trackPanel.update(
      track,
      this.app.shares.get(number) ?? [],
      this.app.historyOf(number),
      this.app.facts.get(number) ?? { stateTime: "", facts: [], rule: "", why: NO_REASONS, motion: NO_MOTION },
      this.app.known,
      this.app.settings.units,
      COLOURS[this.app.settings.theme].sources,
      this.app.settings.at > 0 && !this.app.isRecording,
    );
  }
}
