/** A rational block in doubles, for drawings only: its poles, and its values on the frequency axis. */

/** @typedef {{num: number[], den: number[], discrete: boolean, period: number | null}} Plant */
/** @typedef {{omega: Float64Array, re: Float64Array, im: Float64Array}} Curve */
/** @typedef {[number, number]} Complex */

/** Value of a polynomial, highest power first. @param {number[]} p @param {Complex} z @returns {Complex} */
function value(p, [x, y]) {
  let [re, im] = [0, 0];
  for (const c of p) [re, im] = [re * x - im * y + c, re * y + im * x];
  return [re, im];
}

/** @param {Complex} a @param {Complex} b @returns {Complex} */
function quotient([a, b], [c, d]) {
  const size = Math.max(Math.abs(c), Math.abs(d));
  [c, d] = [c / size, d / size];
  const square = (c * c + d * d) * size;
  return [(a * c + b * d) / square, (b * c - a * d) / square];
}

/** All roots of a polynomial by Aberth's iteration, to a few digits. @param {number[]} given @returns {Complex[]} */
export function roots(given) {
  const p = given.slice(given.findIndex((c) => c !== 0));
  const zeros = /** @type {Complex[]} */ ([]);
  while (p.length > 1 && p[p.length - 1] === 0) { p.pop(); zeros.push([0, 0]); }
  const n = p.length - 1;
  if (n < 1 || !given.some((c) => c !== 0)) return zeros;
  const derivative = p.slice(0, -1).map((c, i) => c * (n - i));
  const size = Math.max(...p.slice(1).map((c, i) => Math.abs(c / p[0]) ** (1 / (i + 1))));
  let z = /** @type {Complex[]} */ (Array.from({ length: n }, (_, i) => {
    const angle = (2 * Math.PI * (i + 0.35)) / n;
    return [size * Math.cos(angle), size * Math.sin(angle)];
  }));
  for (let round = 0; round < 200; round++) {
    let moved = 0;
    z = z.map((one, i) => {
      const top = value(p, one);
      if (top[0] === 0 && top[1] === 0) return one;
      const [a, b] = quotient(top, value(derivative, one));
      let [s, t] = [0, 0];
      z.forEach((other, j) => {
        if (j === i) return;
        const [u, v] = quotient([1, 0], [one[0] - other[0] || 1e-300, one[1] - other[1]]);
        [s, t] = [s + u, t + v];
      });
      const [dx, dy] = quotient([a, b], [1 - (a * s - b * t), -(a * t + b * s)]);
      if (!Number.isFinite(dx + dy)) return one;
      moved = Math.max(moved, Math.hypot(dx, dy) / (Math.hypot(...one) || 1));
      return [one[0] - dx, one[1] - dy];
    });
    if (moved < 1e-13) break;
  }
  return [...zeros, ...z];
}

/** The block `H/(1 + lower H)`, whose sector begins at 0. @param {Plant} plant @param {number} lower @returns {Plant} */
export function shifted(plant, lower) {
  if (lower === 0) return plant;
  const gap = plant.den.length - plant.num.length;
  return { ...plant, den: plant.den.map((c, i) => c + lower * (plant.num[i - gap] ?? 0)) };
}

/** Frequencies [rad/s] at which a drawing shows every mode, ascending. @param {Plant} plant @returns {number[]} */
function frequencies(plant) {
  const period = plant.period ?? 1;
  const all = [...roots(plant.den), ...roots(plant.num)];
  const modes = plant.discrete
    ? all.filter(([x, y]) => x || y).map(([x, y]) => [Math.log(Math.hypot(x, y)) / period, Math.abs(Math.atan2(y, x)) / period])
    : all.map(([x, y]) => [x, Math.abs(y)]);
  const sizes = modes.map(([x, y]) => Math.hypot(x, y)).filter((size) => size > 1e-12);
  const top = plant.discrete ? Math.PI / period : 300 * Math.max(...sizes, 1e-6, sizes.length ? 0 : 1);
  const bottom = Math.min(...sizes, top) / 1000;
  const found = Array.from({ length: 600 }, (_, i) => bottom * (top / bottom) ** (i / 599));
  if (plant.discrete) for (let i = 1; i <= 300; i++) found.push((top * i) / 300);
  for (const [x, y] of modes) {
    if (y <= 1e-7 * Math.abs(x)) continue;  // a real pole, but for rounding
    for (let i = -40; i <= 40; i++) found.push(y + (Math.abs(x) || 1e-6 * y) * Math.tan((i / 40) * 1.55));
  }
  return found.filter((omega) => omega > 0 && omega <= top).sort((a, b) => a - b);
}

/** The response at the frequencies of {@link frequencies}; points near a pole are left out. @param {Plant} plant @returns {Curve} */
export function sampled(plant) {
  const kept = frequencies(plant).map((omega) => {
    const angle = omega * (plant.period ?? 1);
    const at = /** @type {Complex} */ (plant.discrete ? [Math.cos(angle), Math.sin(angle)] : [0, omega]);
    return [omega, ...quotient(value(plant.num, at), value(plant.den, at))];
  }).filter((point) => point.every(Number.isFinite));
  const column = (i) => Float64Array.from(kept, (point) => point[i]);
  return { omega: column(0), re: column(1), im: column(2) };
}

/** Least of `1/k + Re[(1 + i omega theta) H]` over a curve, and where: what the drawing sees, no proof.
 * @param {Curve} curve @param {number} k @param {number} theta */
export function popovSeen(curve, k, theta) {
  let [least, at] = [Infinity, -1];
  for (let i = 0; i < curve.omega.length; i++) {
    const room = curve.re[i] - theta * curve.omega[i] * curve.im[i];
    if (room < least) [least, at] = [room, i];
  }
  return { margin: least + 1 / k, at };
}

/** Least distance of a curve from the disk that the circle criterion forbids, negative inside, and where.
 * @param {Curve} curve @param {number} lower @param {number} k */
export function circleSeen(curve, lower, k) {
  let [least, at] = [Infinity, -1];
  const [a, b] = [-1 / k, -1 / lower];
  for (let i = 0; i < curve.omega.length; i++) {
    const [x, y] = [curve.re[i], curve.im[i]];
    const room = lower === 0 ? x - a
      : lower > 0 ? Math.hypot(x - (a + b) / 2, y) - (a - b) / 2
        : (b - a) / 2 - Math.hypot(x - (a + b) / 2, y);
    if (room < least) [least, at] = [room, i];
  }
  return { margin: least, at };
}

/** How the loop with the gain `g` moves after an impulse, `sigma` at even times over about eight swings.
 * @param {Plant} plant @param {number} g @returns {{t: number[], sigma: number[]}} */
export function impulse(plant, g) {
  const closed = shifted(plant, g);
  const lead = closed.den[0];
  const den = closed.den.map((c) => c / lead);
  const n = den.length - 1;
  const num = [...Array(n + 1 - plant.num.length).fill(0), ...plant.num].map((c) => c / lead);
  const row = num.slice(1).map((c, i) => c - num[0] * den[i + 1]);  // of H/(1 + g H), its direct term left out
  const step = plant.discrete ? plant.period ?? 1 : 0;
  const poles = roots(closed.den);
  const rates = poles.map(([x, y]) => (plant.discrete ? Math.log(Math.hypot(x, y) || 1e-9) / step : x));
  const slowest = poles[rates.indexOf(Math.max(...rates))] ?? [0, 0];
  const [rate, swing] = [Math.max(...rates), plant.discrete ? Math.abs(Math.atan2(slowest[1], slowest[0])) / step : Math.abs(slowest[1])];
  const size = Math.max(...poles.map(([x, y]) => Math.hypot(x, y)), 1e-9);
  let span = swing > 1e-9 ? (16 * Math.PI) / swing : rate > 0 ? 6 / rate : 20 / size;
  if (rate * span > 12) span = 12 / rate;
  const steps = plant.discrete ? Math.min(Math.max(Math.round(span / step), 20), 600) : 600;
  const h = plant.discrete ? step : span / steps;
  const inner = plant.discrete ? 1 : Math.min(Math.max(Math.ceil(h * size * 4), 1), 400);
  /** x' = A x in companion form @param {number[]} x */
  const rhs = (x) => [-den.slice(1).reduce((sum, c, i) => sum + c * x[i], 0), ...x.slice(0, -1)];
  const along = (x, v, s) => x.map((one, i) => one + s * v[i]);
  let x = Array.from({ length: n }, (_, i) => (i === 0 ? 1 : 0));
  const [t, sigma] = [/** @type {number[]} */ ([]), /** @type {number[]} */ ([])];
  for (let i = 0; i <= steps; i++) {
    t.push(i * h);
    sigma.push(row.reduce((sum, c, j) => sum + c * x[j], 0));
    for (let j = 0; j < inner; j++) {
      if (plant.discrete) { x = rhs(x); continue; }
      const d = h / inner;
      const a = rhs(x), b = rhs(along(x, a, d / 2)), c = rhs(along(x, b, d / 2)), e = rhs(along(x, c, d));
      x = x.map((one, l) => one + (d / 6) * (a[l] + 2 * b[l] + 2 * c[l] + e[l]));
    }
  }
  return { t, sigma };
}
