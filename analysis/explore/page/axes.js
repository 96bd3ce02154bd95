/** Axes in SVG: a frame, round ticks, and the map from numbers to places. */

/** @param {string} name @param {Record<string, string | number>} [attributes] @param {string} [text] */
export function element(name, attributes = {}, text = "") {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, one] of Object.entries(attributes)) made.setAttribute(key, String(one));
  if (text) made.textContent = text;
  return made;
}

/** About five round numbers of an interval. @param {number} low @param {number} high */
export function ticks(low, high) {
  const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((c) => c * power).find((c) => c >= raw) ?? raw;
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(Number((i * step).toPrecision(12)));
  return found;
}

const RAISED = { "−": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/** A formula with its exponents raised. @param {string} text */
export const raised = (text) => text.replace(/\^(\d+)/g, (_, digits) => [...digits].map((c) => RAISED[c]).join(""));

/** A power of ten. @param {string} exponent */
const power = (exponent) => `10${[...exponent.replace("-", "−")].map((c) => RAISED[c]).join("")}`;

/** A number for a reader. @param {number} x @param {number} [digits] */
export function number(x, digits = 4) {
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  const rounded = Number(x.toPrecision(digits));
  const written = Math.abs(rounded) < 1e7 ? String(rounded) : rounded.toExponential();  // String would write 21 digits
  const [mantissa, exponent] = written.replaceAll("-", "−").replace("+", "").split("e");
  return exponent === undefined ? mantissa : `${mantissa}·${power(exponent)}`;
}

/** A coordinate that SVG takes, however far away. @param {number} x */
const place = (x) => Number(Math.max(-1e5, Math.min(1e5, x)).toFixed(2));

/** @typedef {{x: [number, number], y: [number, number]}} Window */

export class Axes {
  /** @param {SVGElement} svg @param {string} xLabel @param {string} yLabel */
  constructor(svg, xLabel, yLabel) {
    this.svg = svg;
    this.labels = [xLabel, yLabel];
    const [, , width, height] = (svg.getAttribute("viewBox") ?? "").split(" ").map(Number);
    this.frame = { left: 62, top: 10, right: width - 12, bottom: height - 44 };
    this.id = `${svg.id}-inside`;
    const { left, top, right, bottom } = this.frame;
    const clip = element("clipPath", { id: this.id });
    clip.append(element("rect", { x: left, y: top, width: right - left, height: bottom - top }));
    this.back = element("g");
    this.front = element("g", { "clip-path": `url(#${this.id})` });
    svg.replaceChildren(clip, this.back, this.front);
    this.window = /** @type {Window} */ ({ x: [0, 1], y: [0, 1] });
  }

  /** Show a window of the plane. @param {Window} window */
  show(window) {
    this.window = window;
    const { left, top, right, bottom } = this.frame;
    const lines = [];
    const unit = ([low, high]) => {  // a power of ten that the ticks are counted in
      const size = Math.floor(Math.log10(Math.max(Math.abs(low), Math.abs(high))));
      return size > 3 || size < -2 ? 10 ** size : 1;
    };
    const [ux, uy] = [unit(window.x), unit(window.y)];
    const label = (text, one) => (one === 1 ? text : `${text}, in ${power(String(Math.round(Math.log10(one))))}`);
    for (const x of ticks(...window.x)) {
      lines.push(element("line", { class: x ? "grid" : "axis", x1: this.x(x), x2: this.x(x), y1: top, y2: bottom }),
        element("text", { class: "tick", x: this.x(x), y: bottom + 17, "text-anchor": "middle" }, number(x / ux)));
    }
    for (const y of ticks(...window.y)) {
      lines.push(element("line", { class: y ? "grid" : "axis", x1: left, x2: right, y1: this.y(y), y2: this.y(y) }),
        element("text", { class: "tick", x: left - 6, y: this.y(y) + 4, "text-anchor": "end" }, number(y / uy)));
    }
    lines.push(element("text", { x: (left + right) / 2, y: bottom + 38, "text-anchor": "middle" }, label(this.labels[0], ux)));
    lines.push(element("text", { x: 14, y: (top + bottom) / 2, "text-anchor": "middle",
      transform: `rotate(-90 14 ${(top + bottom) / 2})` }, label(this.labels[1], uy)));
    this.back.replaceChildren(...lines);
  }

  /** @param {number} x */
  x(x) {
    const { left, right } = this.frame, [low, high] = this.window.x;
    return place(left + ((x - low) / (high - low)) * (right - left));
  }

  /** @param {number} y */
  y(y) {
    const { top, bottom } = this.frame, [low, high] = this.window.y;
    return place(bottom - ((y - low) / (high - low)) * (bottom - top));
  }

  /** A polyline, broken where it leaps. @param {ArrayLike<number>} xs @param {ArrayLike<number>} ys */
  path(xs, ys) {
    const far = 40 * (this.window.x[1] - this.window.x[0]), tall = 40 * (this.window.y[1] - this.window.y[0]);
    let text = "", pen = "M";
    for (let i = 0; i < xs.length; i++) {
      const near = Math.abs(xs[i] - this.window.x[0]) < far && Math.abs(ys[i] - this.window.y[0]) < tall;
      if (near) text += `${pen}${this.x(xs[i])} ${this.y(ys[i])}`;
      pen = near ? "L" : "M";
    }
    return text;
  }
}

/** A window that holds the points, with some room; far points count less than the many near ones.
 * @param {number[]} xs @param {number[]} ys @param {number[]} wanted x that must be seen @returns {Window} */
export function around(xs, ys, wanted) {
  const span = (values, must, low = 0, high = 1) => {
    const sorted = [...values].sort((a, b) => a - b);
    const at = (part) => sorted[Math.round(part * (sorted.length - 1))] ?? 0;
    let [a, b] = [Math.min(at(low), ...must), Math.max(at(high), ...must)];
    if (!(b - a > 1e-12 * Math.max(Math.abs(a), Math.abs(b)))) [a, b] = [a - 1, b + 1];
    const room = 0.07 * (b - a);
    return /** @type {[number, number]} */ ([a - room, b + room]);
  };
  return { x: span(xs, [0, ...wanted]), y: span(ys, [0]) };
}
