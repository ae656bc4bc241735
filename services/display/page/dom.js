/** Elements and texts for people. */

/**
 * Makes an element: its tag with classes ("td.num"), its attributes, what is in it.
 * @param {string} tag
 * @param {Record<string, string | number | boolean | EventListener>} [attributes]
 * @param {...(Node | string | number)} children
 * @returns {HTMLElement}
 */
export function h(tag, attributes = {}, ...children) {
  const [name, ...classes] = tag.split(".");
  const element = document.createElement(name);
  element.classList.add(...classes.filter((word) => word !== ""));
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key, value);
    else if (value === true) element.setAttribute(key, "");
    else if (value !== false) element.setAttribute(key, String(value));
  }
  element.append(...children.map((child) => (typeof child === "number" ? String(child) : child)));
  return element;
}

/** Element of the page that must be there. @param {string} id @returns {HTMLElement} */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element ${id}`);
  return element;
}

/**
 * Sets a text only where it differs, so that an unchanged page costs nothing.
 * @param {Element | Text} element @param {string} text
 */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * Shows `fresh` as the only child of `parent`, and changes no more than what differs: what has the focus keeps it, and a
 * button that is being pressed stays. Listeners of `fresh` are lost where an element stays; its buttons say in attributes
 * what they do.
 * @param {Element} parent @param {Element} fresh
 */
export function morph(parent, fresh) {
  const old = parent.firstElementChild;
  if (old && parent.childNodes.length === 1 && old.nodeName === fresh.nodeName) patch(old, fresh);
  else parent.replaceChildren(fresh);
}

/** @param {Element} old @param {Element} fresh */
function patch(old, fresh) {
  for (const name of old.getAttributeNames()) if (!fresh.hasAttribute(name)) old.removeAttribute(name);
  for (const name of fresh.getAttributeNames()) {
    const value = fresh.getAttribute(name) ?? "";
    if (old.getAttribute(name) !== value) old.setAttribute(name, value);
  }
  const [had, wanted] = [[...old.childNodes], [...fresh.childNodes]];
  wanted.forEach((child, k) => {
    const own = had[k];
    if (!own) old.append(child);
    else if (own instanceof Element && child instanceof Element && isSame(own, child)) patch(own, child);
    else if (own instanceof Text && child instanceof Text) setText(own, child.data);
    else own.replaceWith(child);
  });
  for (const rest of had.slice(wanted.length)) rest.remove();
}

/** @param {Element} one @param {Element} other */
function isSame(one, other) {
  return one.nodeName === other.nodeName && one.getAttribute("data-key") === other.getAttribute("data-key");
}

const two = (/** @type {number} */ value) => String(value).padStart(2, "0");

/** Time of day, UTC: 12:03:11. @param {number} seconds since 1970 */
export function clock(seconds) {
  const date = new Date(seconds * 1000);
  return `${two(date.getUTCHours())}:${two(date.getUTCMinutes())}:${two(date.getUTCSeconds())}`;
}

/** Day, UTC. @param {number} seconds since 1970 */
export function day(seconds) {
  return new Date(seconds * 1000).toISOString().slice(0, 10);
}

/** Day and time, UTC. @param {number} seconds since 1970 */
export function dayAndClock(seconds) {
  return `${day(seconds)} ${clock(seconds)}`;
}

/** Duration: 4 s, 3 min, 2.1 h. @param {number} seconds */
export function span(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (Math.abs(seconds) < 10) return `${seconds.toFixed(1)} s`;
  if (Math.abs(seconds) < 120) return `${seconds.toFixed(0)} s`;
  if (Math.abs(seconds) < 7200) return `${(seconds / 60).toFixed(0)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

/** Latency from microseconds: 12.4 µs, 3.1 ms. @param {number} micros */
export function latency(micros) {
  if (!Number.isFinite(micros)) return "–";
  if (micros < 1000) return `${micros.toFixed(1)} µs`;
  if (micros < 1e6) return `${(micros / 1000).toFixed(1)} ms`;
  return `${(micros / 1e6).toFixed(2)} s`;
}

/** Number with its digits in groups of three. @param {number} value */
export function grouped(value) {
  return Math.round(value)
    .toString()
    .replace(/\B(?=(\d{3})+$)/g, "\u202f");
}
