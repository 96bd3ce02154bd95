/** The loop in the address: `#num=1&den=1,3,2,0&k=5` is a page that can be sent to somebody. */

/** @typedef {{form: string, num: string, den: string, dt: string, transfer: string, system: string, class: string, lower: string, k: string, theta: string}} State */

export const FIELDS = ["num", "den", "dt", "transfer", "system", "class", "lower", "k", "theta"];

/** What further parts of the page keep in the address. @type {Map<string, string>} */
export const more = new Map();

const FURTHER = () => [...more].map(([name, value]) => `${name}=${encodeURIComponent(value).replace(/%(2F|2A)/g, decodeURIComponent)}`);

let due = 0;     // the timer of a change of the address
let last = -1e9;  // when it changed
let wanted = "";  // what it is, or is about to be

/** The address follows the fields five times a second at most: browsers refuse 200 changes in half a minute, a drag of some
 * seconds.  One that somebody gives meanwhile stays. @param {string} address */
export function follow(address) {
  clearTimeout(due);
  wanted = address;
  const before = location.hash;
  const change = () => {
    if (location.hash !== before) return;
    last = performance.now();
    history.replaceState(null, "", address);
  };
  const wait = last + 200 - performance.now();
  if (wait > 0) due = setTimeout(change, wait);
  else change();
}

/** Keep what the fields of a further part of the page hold; other keys stay. @param {string[]} own @param {Record<string, string>} fields */
export function remember(own, fields) {
  for (const name of own) more.delete(name);
  for (const [name, value] of Object.entries(fields)) more.set(name, value);
  const loop = wanted.replace(/^#/, "").split("&").filter((part) => FIELDS.includes(part.split("=")[0]));
  follow(`#${[...loop, ...FURTHER()].join("&")}`);
}

/** The state of an address; null where it names no block. @param {string} hash @returns {State | null} */
export function stateOf(hash) {
  wanted = hash;
  const given = new URLSearchParams(hash.replace(/^#/, "").replace(/\+/g, "%2B"));
  more.clear();
  for (const [name, value] of given) if (value !== "" && !FIELDS.includes(name)) more.set(name, value);
  const form = ["system", "transfer", "num"].find((name) => given.has(name));
  if (!form && !given.has("den")) return null;
  const state = /** @type {State} */ (Object.fromEntries(FIELDS.map((name) => [name, given.get(name) ?? ""])));
  return { ...state, form: form ?? "num", class: state.class || "sector" };
}

/** The address of a state. @param {State} state */
export function addressOf(state) {
  const given = { num: ["num", "den", "dt"], transfer: ["transfer", "dt"], system: ["system"] }[state.form] ?? [];
  const fields = [...given, ...(state.class === "sector" ? [] : ["class"]), "lower", "k", "theta"];
  const parts = fields.filter((name) => state[name] !== "" && !(name === "lower" && state[name] === "0"));
  const written = (text) => encodeURIComponent(text.trim().replace(/[\s,]+/g, ",")).replace(/%2C/g, ",").replace(/%2F/g, "/");
  const plain = (text) => encodeURIComponent(text).replace(/%(2F|28|29|2A)/g, decodeURIComponent);
  const loop = parts.map((name) => `${name}=${["num", "den"].includes(name) ? written(state[name]) : plain(state[name])}`);
  return `#${[...loop, ...FURTHER()].join("&")}`;
}
