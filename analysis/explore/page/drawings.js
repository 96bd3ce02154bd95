/** The drawings: Popov plot, Nyquist plot, the bar of what is known, and the counterexample. */

import { Axes, around, element, number, ticks } from "lure/axes.js";

/** @typedef {import("lure/plant.js").Curve} Curve */
/** @typedef {"" | "accepted" | "crossed"} Mood */

const WIDEST = 60;  // how much larger than 1/k a window may grow

/** @param {SVGElement} svg @param {Mood} mood */
function tint(svg, mood) {
  svg.classList.toggle("accepted", mood === "accepted");
  svg.classList.toggle("crossed", mood === "crossed");
}

/** `Re H` against `omega Im H`, and the half plane that the curve must keep out of. */
export class PopovPlot {
  /** @param {SVGElement} svg */
  constructor(svg) {
    this.axes = new Axes(svg, "Re H(iω)", "ω Im H(iω)");
    this.forbidden = element("path", { class: "forbidden" });
    this.curve = element("path", { class: "curve" });
    this.mark = element("circle", { class: "mark", r: 3.5 });
    this.worst = element("circle", { class: "worst", r: 5 });
    this.axes.front.append(this.forbidden, this.curve, this.mark, this.worst);
  }

  /** @param {Curve} curve @param {number} typical a k of the size that is looked at */
  show(curve, typical) {
    this.points = { x: curve.re, y: curve.im.map((y, i) => y * curve.omega[i]) };
    const limit = WIDEST / typical;
    const near = [...this.points.x.keys()].filter((i) => Math.abs(this.points.x[i]) < limit);
    this.axes.show(around(near.map((i) => this.points.x[i]), near.map((i) => this.points.y[i]), [-1.7 / typical]));
    this.curve.setAttribute("d", this.axes.path(this.points.x, this.points.y));
  }

  /** The line through `-1/k` of slope `1/theta`. @param {number} k @param {number} theta @param {number} worst @param {Mood} mood */
  line(k, theta, worst, mood) {
    const { axes } = this, { x: [left, right], y: [low, high] } = axes.window, wide = 10 * (right - left);
    const at = (y) => Math.max(Math.min(theta * y - 1 / k, right + wide), left - wide);
    const corners = [[at(low), low], [at(high), high], [left - 2 * wide, high], [left - 2 * wide, low]];
    this.forbidden.setAttribute("d", `M${corners.map(([x, y]) => `${axes.x(x)} ${axes.y(y)}`).join("L")}Z`);
    this.mark.setAttribute("transform", `translate(${axes.x(-1 / k)} ${axes.y(0)})`);
    if (worst >= 0) this.worst.setAttribute("transform", `translate(${axes.x(this.points.x[worst])} ${axes.y(this.points.y[worst])})`);
    tint(axes.svg, mood);
  }
}

/** `H(i omega)` with its mirror image, and the disk through `-1/lower` and `-1/k`. */
export class NyquistPlot {
  /** @param {SVGElement} svg */
  constructor(svg) {
    this.axes = new Axes(svg, "Re H", "Im H");
    this.forbidden = element("path", { class: "forbidden", "fill-rule": "evenodd" });
    this.mirror = element("path", { class: "mirror" });
    this.curve = element("path", { class: "curve" });
    this.mark = element("circle", { class: "mark", r: 3.5 });
    this.worst = element("circle", { class: "worst", r: 5 });
    this.axes.front.append(this.forbidden, this.mirror, this.curve, this.mark, this.worst);
  }

  /** @param {Curve} curve @param {number} lower @param {number} typical */
  show(curve, lower, typical) {
    this.points = { x: curve.re, y: curve.im };
    const limit = 4 / typical + Math.min(Math.max(...curve.re.map((x, i) => Math.hypot(x, curve.im[i]))), WIDEST / typical);
    const near = [...curve.re.keys()].filter((i) => Math.hypot(curve.re[i], curve.im[i]) < limit);
    const y = near.flatMap((i) => [curve.im[i], -curve.im[i]]);
    const window = around(near.map((i) => curve.re[i]), y, [-1.7 / typical, ...(lower > 0 ? [-1.1 / lower] : [])]);
    const tall = Math.min(window.y[1], window.x[1] - window.x[0]);
    this.axes.show({ x: window.x, y: [-tall, tall] });
    this.curve.setAttribute("d", this.axes.path(curve.re, curve.im));
    this.mirror.setAttribute("d", this.axes.path(curve.re, curve.im.map((one) => -one)));
  }

  /** @param {number} lower @param {number} k @param {number} worst @param {Mood} mood */
  disk(lower, k, worst, mood) {
    const { axes } = this, { left, right, top, bottom } = axes.frame;
    const [a, b] = [axes.x(-1 / k), axes.x(-1 / lower)];
    const [rx, ry] = [Math.abs(a - b) / 2, (Math.abs(1 / k - 1 / lower) / 2) * ((bottom - top) / (axes.window.y[1] - axes.window.y[0]))];
    const round = `M${a} ${axes.y(0)}A${rx} ${ry} 0 1 0 ${b} ${axes.y(0)}A${rx} ${ry} 0 1 0 ${a} ${axes.y(0)}Z`;
    const all = `M${left} ${top}H${right}V${bottom}H${left}Z`;
    const half = `M${a} ${top - 9}H${Math.min(left, a) - 9}V${bottom + 9}H${a}Z`;
    this.forbidden.setAttribute("d", lower === 0 ? half : lower > 0 ? round : all + round);
    this.mark.setAttribute("transform", `translate(${a} ${axes.y(0)})`);
    if (worst >= 0) this.worst.setAttribute("transform", `translate(${axes.x(this.points.x[worst])} ${axes.y(this.points.y[worst])})`);
    tint(axes.svg, mood);
  }
}

/** One bar over k: proved up to its end, refuted from its start on, open between; a mark at the k asked about.
 * @param {SVGElement} svg @param {HTMLElement} below where the ticks go, as text that is not stretched @param {number} lower
 * @param {{proved: number | null, refuted: number | null, k: number}} known @param {string} words what it shows */
export function bar(svg, below, lower, { proved, refuted, k }, words) {
  const ends = [proved, refuted, k].filter((one) => one !== null && Number.isFinite(one));
  const top = lower + Math.max(...ends.map((one) => one - lower), Number.MIN_VALUE) * 1.2;
  const [left, right, y, height] = [0, 1000, 6, 28];
  const x = (value) => left + (right - left) * Math.min(Math.max(value === Infinity ? 1 : (value - lower) / (top - lower), 0), 1);
  const parts = [element("rect", { class: "unknown", x: left, y, width: right - left, height })];
  if (proved !== null) parts.push(element("rect", { class: "proved", x: left, y, width: x(proved) - left, height }));
  if (refuted !== null) parts.push(element("rect", { class: "refuted", x: x(refuted), y, width: right - x(refuted), height }));
  if (Number.isFinite(k)) parts.push(element("line", { class: "asked", x1: x(k), x2: x(k), y1: y - 6, y2: y + height + 6 }));
  svg.replaceChildren(...parts);
  svg.setAttribute("aria-label", words);
  below.replaceChildren(...ticks(lower, top).map((one) => {
    const tick = document.createElement("span");
    tick.textContent = number(one);
    tick.style.left = `${x(one) / 10}%`;
    return tick;
  }));
}

/** @param {SVGElement} svg @param {{t: number[], sigma: number[]}} run @param {boolean} discrete */
export function wave(svg, run, discrete) {
  const axes = new Axes(svg, discrete ? "time" : "time [s]", "σ");
  const top = Math.max(...run.sigma.map(Math.abs)) || 1;
  axes.show({ x: [0, run.t[run.t.length - 1]], y: [-1.1 * top, 1.1 * top] });
  axes.front.append(element("path", { class: "wave", d: axes.path(run.t, run.sigma) }));
}
