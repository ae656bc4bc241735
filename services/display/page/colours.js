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
    overlay: "#4a6278",
    confirmed: "#eef4f8",
    tentative: "#7fb8e6",
    coasted: "#f0b43c",
    alert: "#ff7a45",
    selected: "#ffe45c",
    measure: "#8be0c4",
    halo: "rgba(11,16,22,0.72)",
    unknown: "#aeb8c0",
    scale: ["#e69f00", "#f0c53a", "#f0e442", "#a9d96c", "#4fc99a", "#56b4e9", "#8fa8f5", "#cc9ad6"],
    sources: ["#56b4e9", "#e69f00", "#4fc99a", "#f0e442", "#cc79a7", "#9fb6ff", "#ff9a6b", "#c8d0d6"],
    sensor: {
      radar: "#2b6a50",
      multilateration: "#7d4a2e",
      "ads-b": "#2c5f86",
      tracker: "#5d5878",
      detection: "#55606a",
    },
  },
  day: {
    water: "#c9d6df",
    land: "#e9e6dc",
    coast: "#8498a6",
    border: "#b9b4a4",
    grid: "#9aa8b2",
    overlay: "#6f7f8c",
    confirmed: "#10181e",
    tentative: "#0b5f94",
    coasted: "#8a4b00",
    alert: "#c22f00",
    selected: "#7a0f6e",
    measure: "#00624a",
    halo: "rgba(240,240,234,0.78)",
    unknown: "#50585e",
    scale: ["#8a4b00", "#7a6400", "#4f6d00", "#1f6f3f", "#00695f", "#0b5f94", "#3d4db0", "#7a2f8a"],
    sources: ["#0b5f94", "#8a4b00", "#00695f", "#6d6400", "#9a2f6e", "#3d4db0", "#a8400f", "#50585e"],
    sensor: {
      radar: "#6fa38d",
      multilateration: "#bf9076",
      "ads-b": "#7aa2bf",
      tracker: "#9994b0",
      detection: "#9aa2a8",
    },
  },
  print: {
    water: "#ffffff",
    land: "#f4f4f4",
    coast: "#9a9a9a",
    border: "#cfcfcf",
    grid: "#b5b5b5",
    overlay: "#8a8a8a",
    confirmed: "#000000",
    tentative: "#0b5f94",
    coasted: "#8a4b00",
    alert: "#c22f00",
    selected: "#7a0f6e",
    measure: "#00624a",
    halo: "rgba(255,255,255,0.8)",
    unknown: "#505050",
    scale: ["#8a4b00", "#7a6400", "#4f6d00", "#1f6f3f", "#00695f", "#0b5f94", "#3d4db0", "#7a2f8a"],
    sources: ["#0b5f94", "#8a4b00", "#00695f", "#6d6400", "#9a2f6e", "#3d4db0", "#a8400f", "#505050"],
    sensor: {
      radar: "#8fb5a5",
      multilateration: "#cfab97",
      "ads-b": "#9bb8cd",
      tracker: "#b3afc4",
      detection: "#b4babf",
    },
  },
};

/** Height, metres, at which the scale reaches its last colour. */
export const SCALE_TOP_M = 12_200;

/**
 * Colour of a height; that of "unknown" where there is none.
 * @param {Colours} colours @param {number} up metres
 */
export function heightColour(colours, up) {
  if (!Number.isFinite(up)) return colours.unknown;
  const step = Math.floor((Math.max(0, up) / SCALE_TOP_M) * colours.scale.length);
  return colours.scale[Math.min(colours.scale.length - 1, step)];
}

/**
 * Colour of a number of contributing sources.
 * @param {Colours} colours @param {number} count
 */
export function countColour(colours, count) {
  return count === 0 ? colours.unknown : colours.scale[Math.min(colours.scale.length - 1, 2 * count - 2)];
}
