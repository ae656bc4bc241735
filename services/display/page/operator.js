/**
 * The operator at this page: name, token, and requests that need the operator's right. The token is shown to the server
 * once, which answers with a cookie that scripts cannot read; the browser keeps the name alone.
 */

import { h } from "./dom.js";

const NAME = "koseki.operator";

/** @typedef {{ok: boolean, text: string, value: any}} Answer */

export class Operator {
  constructor() {
    this.name = localStorage.getItem(NAME) ?? "";
  }

  /**
   * Sends a request in the operator's name. Where the right is missing, the operator is asked for it once.
   * @param {string} path @param {Record<string, unknown>} body
   * @returns {Promise<Answer>}
   */
  async send(path, body) {
    if (this.name === "" && !(await this.signIn()))
      return { ok: false, text: "No operator has signed in.", value: null };
    const first = await post(path, { ...body, operator: this.name });
    if (first.status !== 403) return first;
    if (!(await this.signIn())) return { ok: false, text: "No operator has signed in.", value: null };
    return post(path, { ...body, operator: this.name });
  }

  /** Asks for name and token. Whether the server admits them. @returns {Promise<boolean>} */
  signIn() {
    const name = field("operator-name", "Name, for the records", "text", this.name);
    const token = field("operator-token", "Operator's token", "password", "");
    const error = h("p.bad", { role: "alert" });
    const dialog = dialogOf("Operator", name.label, token.label, error);
    return new Promise((resolve) => {
      let isAdmitted = false;
      const admit = async () => {
        if (name.input.value.trim() === "") return name.input.focus();
        const headers = { Authorization: `Bearer ${token.input.value}` };
        const answer = await fetch("api/operator", { method: "POST", headers }).catch(() => null);
        isAdmitted = answer?.ok ?? false;
        error.textContent = answer === null ? "The display does not answer." : "The display does not admit this token.";
        if (!isAdmitted) return token.input.focus();
        this.name = name.input.value.trim();
        localStorage.setItem(NAME, this.name);
        dialog.close();
      };
      dialog.append(buttons(["Sign in", admit], ["Not now", () => dialog.close()]));
      dialog.addEventListener("keydown", (event) => {
        if (event.key === "Enter" && event.target instanceof HTMLInputElement) void admit();
      });
      dialog.addEventListener("close", () => resolve(isAdmitted));
      show(dialog);
    });
  }
}

/** @param {string} path @param {Record<string, unknown>} body @returns {Promise<Answer & {status: number}>} */
async function post(path, body) {
  const headers = { "Content-Type": "application/json" };
  try {
    const answer = await fetch(path, { method: "POST", headers, body: JSON.stringify(body) });
    const text = (await answer.text()).trim();
    const isJson = answer.headers.get("Content-Type")?.startsWith("application/json");
    return { ok: answer.ok, status: answer.status, text, value: isJson ? JSON.parse(text) : null };
  } catch {
    return { ok: false, status: 0, text: "The display does not answer.", value: null };
  }
}

/** @param {string} title @param {...Node} parts @returns {HTMLDialogElement} */
export function dialogOf(title, ...parts) {
  const heading = h("h2", { id: "dialog-title" }, title);
  return /** @type {HTMLDialogElement} */ (h("dialog", { "aria-labelledby": "dialog-title" }, heading, ...parts));
}

/** Shows a dialog, and takes it out of the page when it closes. @param {HTMLDialogElement} dialog */
export function show(dialog) {
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}

/**
 * @param {string} id @param {string} title @param {string} type @param {string} value
 * @param {Record<string, string | number>} [more] Further attributes.
 */
export function field(id, title, type, value, more = {}) {
  const input = /** @type {HTMLInputElement} */ (h("input", { id, type, value, autocomplete: "off", ...more }));
  return { input, label: h("label.setting", {}, title, input) };
}

/** @param {...[string, () => unknown]} acts What the buttons do; the first is the likeliest. */
export function buttons(...acts) {
  return h(
    "p.buttons",
    {},
    ...acts.map(([title, click]) => h("button", { type: "button", click: () => void click() }, title)),
  );
}
