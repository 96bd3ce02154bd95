/** The rod on the page: closed forms drawn at once, verdicts from the checkers a moment later. */

import { more, remember } from "lure/address.js";
import { around, Axes, element, number } from "lure/axes.js";
import { offer } from "lure/keeping.js";

const FIELDS = ["youngs_modulus", "density", "length", "area", "damping", "cells"];
/** @param {string} id @returns {any} */
const $ = (id) => document.getElementById(id);

/** The constants of the rod in doubles; nan where a field is no plain number. @param {number} impedance of the last answer */
function constants(impedance) {
  const [E, rho, L, A] = FIELDS.slice(0, 4).map((name) => Number($(name).value));
  const Z = A * Math.sqrt(rho * E);
  const multiple = /^\s*(-?[\d.]*)\s*\*?\s*Z(?:\s*\/\s*([\d.]+))?\s*$/.exec($("damping").value);
  const k = multiple ? (Z || impedance) * Number(multiple[1] === "-" ? -1 : multiple[1] || 1) / Number(multiple[2] ?? 1) : Number($("damping").value);
  return { T: L * Math.sqrt(rho / E), d: 1 / Math.sqrt(rho * E), Z, k, a: (k - Z) / (k + Z), N: Math.round(Number($("cells").value)) };
}

/** `H = (d/s)(1 - a Q)/(1 + a Q)` at `s = i omega`: `Re H` and `omega Im H`. */
function value(d, a, omega, size, angle) {
  const [x, y] = [a * size * Math.cos(angle), -a * size * Math.sin(angle)];  // a Q
  const below = (1 + x) ** 2 + y * y;
  const [re, im] = [(1 - x * x - y * y) / below, (-2 * y) / below];
  return [(d * im) / omega, -d * re];
}

/** @param {any} rod @param {boolean} scheme */
function curve(rod, scheme) {
  const points = [];
  for (let i = 1; i <= 3000; i++) {
    const omega = (i / 3000) * (7 * Math.PI / rod.T), step = (omega * rod.T) / rod.N;
    points.push(scheme
      ? value(rod.d, rod.a, omega, (1 + step * step) ** -rod.N, 2 * rod.N * Math.atan(step))
      : value(rod.d, rod.a, omega, 1, 2 * omega * rod.T));
  }
  return points;
}

/** Poles of the first modes and their partners in the scheme. @param {any} rod */
function poles(rod) {
  const [exact, scheme] = [[], []], growth = Math.log(Math.abs(rod.a)), rate = rod.N / rod.T;
  for (let m = 0; m <= 8; m++) {
    const turn = rod.a < 0 ? m : m - 0.5;
    if (turn < 0 || m > rod.N) continue;
    const size = Math.exp(growth / (2 * rod.N)), angle = (Math.PI * turn) / rod.N;
    const pairs = [[exact, growth / (2 * rod.T), (Math.PI * turn) / rod.T],
      [scheme, rate * (size * Math.cos(angle) - 1), rate * size * Math.sin(angle)]];
    for (const [list, x, y] of pairs) list.push([x, y], [x, -y]);
  }
  return { exact, scheme };
}

/** @param {import("lure/asking.js").Asking} asking */
export function open(asking) {
  const spectrum = new Axes($("rod-spectrum"), "Re s [1/s]", "Im s [rad/s]"), popov = new Axes($("rod-popov"), "Re H [m/Pa]", "ω Im H [m/(Pa s)]");
  let impedance = 1, theta = /** @type {number | null} */ (null), proved = false, newest = 0;

  function redraw() {
    const rod = constants(impedance);
    if (![rod.T, rod.d, rod.a].every(Number.isFinite) || !(rod.T > 0 && rod.d > 0 && rod.N >= 1)) return;
    if (rod.a === 0) spectrum.front.replaceChildren(element("text", { x: 80, y: 40 }, "k = Z: every wave leaves, and there are no modes"));
    else {
      const { exact, scheme } = poles(rod);
      const all = [...exact, ...scheme];
      spectrum.show(around(all.map(([x]) => x), all.map(([, y]) => y), [0]));
      const at = ([x, y]) => `translate(${spectrum.x(x)} ${spectrum.y(y)})`;
      spectrum.front.replaceChildren(...exact.map((one) => element("circle", { class: "worst", r: 5, transform: at(one) })),
        ...scheme.map((one) => element("path", { class: "cross", d: "M-4 -4L4 4M-4 4L4 -4", transform: at(one) })));
    }
    const [own, other] = [curve(rod, false), curve(rod, true)];
    const near = [...own, ...other].sort((p, q) => Math.hypot(...p) - Math.hypot(...q)).slice(0, 5400);
    popov.show(around(near.map(([x]) => x), near.map(([, y]) => y), []));
    const drawn = (points, kind) => element("path", { class: kind, d: popov.path(points.map(([x]) => x), points.map(([, y]) => y)) });
    const parts = [drawn(own, "curve"), drawn(other, "mirror")];
    if (theta !== null) {
      const { x: [left], y: [low, high] } = popov.window, far = left - 1e3 * (popov.window.x[1] - left);
      const corners = [[theta * low, low], [theta * high, high], [far, high], [far, low]].map(([x, y]) => `${popov.x(Math.max(Math.min(x, -far), far))} ${popov.y(y)}`);
      parts.unshift(element("path", { class: "forbidden", d: `M${corners.join("L")}Z` }));
    }
    popov.front.replaceChildren(...parts);
    $("rod-popov").classList.toggle("accepted", proved);
    $("rod-about").textContent = `Impedance Z = ${number(rod.Z)} N s/m, k/Z = ${number(rod.k / rod.Z)}, a wave comes back as ${number(-rod.a)} of itself after ${number(2 * rod.T)} s.`;
    const slider = $("damping-slider");
    if (rod.k > 0 && document.activeElement !== slider) slider.value = String(100 * Math.log10(rod.k / rod.Z));
    slider.setAttribute("aria-valuetext", `${number(rod.k)} N s/m`);
  }

  function show(id, model) {
    const badge = document.createElement("b");
    badge.className = badge.textContent = model.verdict;
    $(`${id}-verdict`).replaceChildren(badge, ` ${model.sentence}${model.second ? " Both checkers accept it." : ""}`);
    $(`${id}-circle`).textContent = `Circle criterion: ${model.circle}`;
    offer(`get-${id}`, model.certificate);
  }

  async function changed() {
    const of = ++newest;
    redraw();
    remember(FIELDS, Object.fromEntries(FIELDS.filter((name) => name === "damping" || $(name).value !== $(name).defaultValue)
      .map((name) => [name, $(name).value])));
    const answer = await asking.ask({ ask: "rod", ...Object.fromEntries(FIELDS.map((name) => [name, $(name).value])) });
    if (of !== newest) return;
    for (const name of FIELDS) {
      $(`${name}-error`).textContent = answer.field === name ? answer.error : "";
      $(name).setAttribute("aria-invalid", String(answer.field === name));
    }
    for (const id of ["rod", "scheme"]) $(`${id}-verdict`).dataset.verdict = answer.error ? "" : answer[id].verdict;
    if (answer.error) {
      for (const id of ["rod-verdict", "scheme-verdict", "rod-circle", "scheme-circle", "scheme-popov"]) $(id).textContent = "";
      for (const id of ["get-rod", "get-scheme", "get-rod-report"]) offer(id, "");
      return;
    }
    impedance = answer.impedance;
    theta = answer.scheme.theta;
    proved = answer.scheme.popov.includes("(popov, certified)");
    show("rod", answer.rod);
    show("scheme", answer.scheme);
    $("scheme-popov").textContent = `Popov's criterion: ${answer.scheme.popov}`;
    offer("get-rod-report", JSON.stringify({ rod: answer.rod.report, scheme: answer.scheme.report }, null, 2) + "\n");
    redraw();
  }

  /** The rod of the address, if it names one. */
  function take() {
    const given = FIELDS.some((name) => more.has(name));
    if (given) {
      for (const name of FIELDS) $(name).value = more.get(name) ?? $(name).defaultValue;
      changed();
      $("rod").scrollIntoView();
    }
    $("rod").open = given;
  }

  for (const name of FIELDS) $(name).addEventListener("input", changed);
  $("damping-slider").addEventListener("input", () => {
    const { Z } = constants(impedance);
    $("damping").value = String(Number((Z * 10 ** (Number($("damping-slider").value) / 100)).toPrecision(4)));
    changed();
  });
  $("rod").addEventListener("toggle", () => { if ($("rod").open && !newest) changed(); });
  window.addEventListener("hashchange", take);
  take();
}
