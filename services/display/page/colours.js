/**
 * Colour sets: day, night and print. Each says by lightness what matters (system tracks bright, all else dim) and by
 * hues that people with any colour vision can tell apart (Okabe and Ito, Color Universal Design, 2008); shapes say the
 * same a second time.
 */

/**
 * @typedef {object} Colours
 * @property {string} water @property {string} land @property {string} coast @property {string} border
 * @property {string} grid Range rings and their figures.
 * @property {string} overlay
 * @property {string} confirmed @property {string} tentative @property {string} coasted
 * @property {string} alert @property {string} selected
 * @property {string} measure
 * @property {string} halo Behind labels.
 * @property {string} unknown Where no value is known.
 * @property {string[]} scale Heights, low to high.
 * @property {string[]} sources Main source, by number.
 * @property {Record<string, string>} sensor Sensor tracks, by the kind of their source.
 */

/** @type {Record<string, Colours>} */
export const COLOURS = {
  night: {
    water: "#0b1016",
    land: "#151f29",
    coast: "#3f586e",
    border: "#2a3a49",
    grid: "#304557",
    overlay: "#7289a0",
    confirmed: "#eef4f8",
    tentative: "#7fb8e6",
    coasted: "#e7ab18",
    alert: "#ff7a45",
    selected: "#ffe45c",
    measure: "#87dabe",
    halo: "rgba(11,16,22,0.72)",
    unknown: "#aeb8c0",
    scale: ["#e69f00", "#efc949", "#faeb44", "#a9d96c", "#4fc99a", "#7ccdfc", "#8da7f4", "#cc9ad6"],
    sources: ["#4ea6d2", "#e69f00", "#4fc99a", "#f0e442", "#cc79a7", "#9fb6ff", "#ff9a6b", "#c8d0d6"],
    sensor: {
      radar: "#35755a",
      multilateration: "#935c3f",
      "ads-b": "#376e98",
      tracker: "#6b6685",
      detection: "#606b74",
    },
  },
  day: {
    water: "#d5e0e8",
    land: "#f1eee5",
    coast: "#8498a6",
    border: "#b9b4a4",
    grid: "#9aa8b2",
    overlay: "#546370",
    confirmed: "#10181e",
    tentative: "#0b5f94",
    coasted: "#672600",
    alert: "#bb2700",
    selected: "#7a0e6d",
    measure: "#00624a",
    halo: "rgba(240,240,234,0.78)",
    unknown: "#50585e",
    scale: ["#6d3500", "#755f00", "#43692d", "#0d6c43", "#00695f", "#026099", "#3d4db0", "#7a287e"],
    sources: ["#106198", "#6b3400", "#16634f", "#6b6200", "#9a3373", "#3d4db0", "#a03f31", "#374650"],
    sensor: {
      radar: "#538872",
      multilateration: "#9f7459",
      "ads-b": "#5e8299",
      tracker: "#697da9",
      detection: "#757f85",
    },
  },
  print: {
    water: "#ffffff",
    land: "#f4f4f4",
    coast: "#9a9a9a",
    border: "#cfcfcf",
    grid: "#b5b5b5",
    overlay: "#6a6a6a",
    confirmed: "#000000",
    tentative: "#0b5f94",
    coasted: "#672600",
    alert: "#bb2700",
    selected: "#7a0e6d",
    measure: "#00624a",
    halo: "rgba(255,255,255,0.8)",
    unknown: "#505050",
    scale: ["#6d3500", "#755f00", "#43692d", "#0d6c43", "#00695f", "#026099", "#3d4db0", "#7a287e"],
    sources: ["#106198", "#6b3400", "#16634f", "#6b6200", "#9a3373", "#3d4db0", "#a03f31", "#374650"],
    sensor: {
      radar: "#749382",
      multilateration: "#a6866d",
      "ads-b": "#6890b6",
      tracker: "#848ba3",
      detection: "#868d94",
    },
  },
};

/** Height, metres, at which the scale reaches its last colour. */
export const SCALE_TOP_M = 12_200;

/**
 * Colour of a height; that of "unknown" where there is none.
 * @param {Colours} colours @param {number} height metres
 */
export function heightColour(colours, height) {
  if (!Number.isFinite(height)) return colours.unknown;
  const step = Math.floor((Math.max(0, height) / SCALE_TOP_M) * colours.scale.length);
  return colours.scale[Math.min(colours.scale.length - 1, step)];
}

/**
 * Colour of a number of contributing sources.
 * @param {Colours} colours @param {number} count
 */
export function countColour(colours, count) {
  return count === 0 ? colours.unknown : colours.scale[Math.min(colours.scale.length - 1, 2 * count - 2)];
}
