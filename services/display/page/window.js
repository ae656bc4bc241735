/**
 * Name of this window in requests. Windows on a recording have a moment each, and the server knows them by their names.
 */

const NAME = [...crypto.getRandomValues(new Uint8Array(8))].map((octet) => octet.toString(16).padStart(2, "0")).join("");

/** Path of a request about what this window shows. @param {string} path */
export function ofWindow(path) {
  return `${path}${path.includes("?") ? "&" : "?"}window=${NAME}`;
}
