/** The page: what is written and dragged, what the drawings see at once, what the checkers say a moment later. */

import { addressOf, FIELDS, follow, more, stateOf } from "lure/address.js";
import { Asking } from "lure/asking.js";
import { number, raised } from "lure/axes.js";
import { bar, NyquistPlot, PopovPlot, wave } from "lure/drawings.js";
import { offer, offerDrawing } from "lure/keeping.js";
import { circleSeen, impulse, popovSeen, sampled, shifted } from "lure/plant.js";

/** @param {string} id @returns {any} */
const $ = (id) => document.getElementById(id);
const start = JSON.parse($("start").textContent);
const systems = JSON.parse($("systems").textContent);
/** @type {import("lure/address.js").State} */
let state = { form: "num", num: "", den: "", dt: "", transfer: "", system: "", class: "sector", lower: "0", k: "", theta: "" };

const popov = new PopovPlot($("popov")), nyquist = new NyquistPlot($("nyquist"));
const asking = new Asking((share, text) => {
  $("loading").firstElementChild.value = share;
  $("loading").lastElementChild.textContent = `${text}.`;
});

/** What is known of the plant and the class at hand; each null until its answer has arrived. */
const known = {
  plant: /** @type {import("lure/plant.js").Plant | null} */ (null),
  curve: /** @type {import("lure/plant.js").Curve | null} */ (null),
  shifted: /** @type {import("lure/plant.js").Curve | null} */ (null),
  largest: /** @type {any} */ (null),
  class: /** @type {any} */ (null),
  line: /** @type {any} */ (null),
  current: false,  // whether the plant is that of the fields
};
let asked = 0;     // changes of the question so far: an answer to an older one is not shown
let chosen = false;  // whether k is the reader's, who keeps it when the plant changes, and not one that the page took
let typical = 1;   // a k of the size that the drawings show

/** A number as this page's fields take them, in doubles; nan for anything else. @param {string} text */
function parsed(text) {
  const match = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)(?:\/(\d+\.?\d*|\.\d+))?\s*$/i.exec(text);
  if (/^\s*inf(inity)?\s*$/.test(text)) return Infinity;
  return match ? Number(match[1]) / Number(match[2] ?? 1) : NaN;
}

const lower = () => parsed(state.lower || "0");
const varying = () => state.class === "time-varying";
const hasLine = () => known.plant !== null && !known.plant.discrete;
const theta = () => (varying() || !hasLine() ? 0 : parsed(state.theta || (known.largest ? "" : "0")));  // 0 until one is found

// What the fields say.

/** Sentences of refusal stand beside their fields, and the drawings, of an older question then, fade. @param {string} [field] @param {string} [sentence] */
function refuse(field = "", sentence = "") {
  document.body.classList.toggle("refused", sentence !== "");
  offerDrawings();
  for (const name of [...FIELDS, "plant"]) {
    $(`${name}-error`).textContent = name === field ? sentence : "";
    $(name)?.setAttribute("aria-invalid", String(name === field));
  }
}

/** The drawings may be kept as long as they are of the loop in the fields. */
function offerDrawings() {
  const none = known.curve === null || document.body.classList.contains("refused");
  $("get-nyquist").hidden = none;
  $("get-popov").hidden = none || !hasLine();
}

/** The fields show the state. */
function write() {
  for (const radio of document.querySelectorAll("input[name=form]")) radio.checked = radio.value === state.form;
  for (const part of document.querySelectorAll("[data-form]")) part.hidden = !part.dataset.form.split(" ").includes(state.form);
  if (state.dt) $("discrete").open = true;
  if (lower()) $("lower").closest("details").open = true;
  for (const name of FIELDS) if ($(name).value !== state[name]) $(name).value = state[name];
  slide();
  const at = systems.find((one) => one.name === state.system);
  $("system-about").textContent = at ? `${at.title}. Source: ${at.source}.` : "";
  const bySlope = state.class === "slope" || state.class === "odd";
  $("class-about").textContent = ABOUT[state.class] ?? "";
  $("k-label").textContent = bySlope ? "Greatest slope" : "Upper end";
  unread();
}

/** Keys of the address that no field of the page has are named. */
function unread() {
  const keys = [...more.keys()].filter((name) => !$(name)?.matches("input, select"));
  $("unread").textContent = keys.length ? `The address has ${keys.join(", ")}, which no field of this page is called: that changes nothing.` : "";
}

const ABOUT = {
  sector: "k₁σ ≤ φ(σ) ≤ kσ for σ > 0, and the reverse for σ < 0.",
  "time-varying": "k₁σ ≤ φ(σ, t) ≤ kσ for σ > 0, and the reverse for σ < 0: a gain that is scheduled, or oscillates.",
  slope: "Every chord of φ has a slope between k₁ and k. A rectifier: k₁ = 0, k its gain.",
  odd: "Every chord of φ has a slope between k₁ and k, and φ(−σ) = −φ(σ). Saturation, dead zone, tanh: k₁ = 0, k the slope where it is steepest.",
};

/** Range of the sliders: k over two decades around what is known, theta of both signs. */
const range = { low: 0.1, high: 10, theta: 1 };

function slide() {
  const k = parsed(state.k) - lower();
  if (k > 0) $("k-slider").value = String((1000 * Math.log(k / range.low)) / Math.log(range.high / range.low));
  $("theta-slider").value = String((1000 * Math.asinh(theta() / range.theta)) / 4);
  for (const [id, text] of [["k-slider", state.k], ["theta-slider", state.theta]]) $(id).setAttribute("aria-valuetext", text);
  const none = varying() || !hasLine();
  for (const id of ["theta", "theta-slider"]) $(id).disabled = none;
}

const short = (x) => (x === 0 ? "0" : String(Number(x.toPrecision(4))));

/** The upper end at this distance above the lower one, in so many digits that it stays above. @param {number} distance */
function above(distance) {
  const k = lower() + distance;
  const digits = [4, 6, 9, 12].find((one) => Math.abs(Number(k.toPrecision(one)) - k) < distance / 20);
  return String(Number(k.toPrecision(digits ?? 17)));
}

// What the drawings see: at every event, before anything is asked.

/** Nothing is said of a question that cannot be drawn. */
function silent() {
  for (const [id, title] of [["popov", "Popov plot"], ["nyquist", "Nyquist plot"]]) {
    $(`${id}-caption`).textContent = "";
    $(id).setAttribute("aria-label", title);
    $(id).classList.remove("accepted", "crossed");
  }
  measure(NaN);
}

/** The bar, with a mark at k. @param {number} k */
function measure(k) {
  const { largest } = known;
  const end = (x) => (x === "inf" ? Infinity : x === "-inf" ? -Infinity : x ?? null);
  if (largest) {
    bar($("bar"), $("bar-ticks"), lower(), { proved: end(largest.proved), refuted: end(largest.refuted), k },
      `Proved ${largest.reach ? `up to ${largest.reach}` : "nowhere"}, refuted ${largest.refuted_text ? `from ${largest.refuted_text}` : "nowhere"}`
      + (Number.isNaN(k) ? "" : `; asked about ${state.k}`));
  }
  $("bar-k").textContent = Number.isNaN(k) ? "–" : state.k;
}

function redraw() {
  const { curve, shifted: own, plant } = known;
  const [k, low] = [parsed(state.k), lower()];
  if (!curve || !own || !plant || !(k > low) || !Number.isFinite(theta())) {
    silent();
    return;
  }
  const line = known.line?.asked === asked ? known.line : null;
  const seen = popovSeen(own, k - low, theta());
  const crossed = seen.margin < 0;
  const mood = line?.accepted ? "accepted" : crossed ? "crossed" : "";
  popov.line(k - low, theta(), seen.at, mood);
  const disk = circleSeen(curve, low, k);
  const byCircle = line?.accepted && theta() === 0;
  nyquist.disk(low, k, disk.at, byCircle ? "accepted" : disk.margin < 0 ? "crossed" : "");
  const said = line === null ? "" : line.accepted ? " Both checkers accept this line: it proves the class."
    : ` The checkers do not accept it: ${line.reason.replace("F > 0", "the inequality").replace("d + l n", "the denominator of H/(1 + k₁H)")}.`;
  const sentence = (margin, omega, crosses, keeps, most) => (Number.isFinite(margin) && Number.isFinite(omega)
    ? `Drawn: the curve ${margin < 0 ? crosses : `keeps ${number(margin, 3)} from ${keeps}`}, ${margin < 0 ? most : "least"} at ${number(omega)} rad/s.` : "");
  $("popov-caption").textContent = sentence(seen.margin, own.omega[seen.at], "crosses the line", "the line", "most").concat(said).trim();
  const by = known.class?.asked === asked && known.class.verdict === "PROVED" && disk.margin < 0 && !byCircle
    ? ` The class is proved all the same, by the criterion ${known.class.theorem}.` : "";
  $("nyquist-caption").textContent = sentence(disk.margin, curve.omega[disk.at], "enters what the circle criterion forbids",
    "what the circle criterion forbids", "deepest").concat(by);
  $("popov").setAttribute("aria-label", `Popov plot. ${$("popov-caption").textContent}`);
  $("nyquist").setAttribute("aria-label", `Nyquist plot. ${$("nyquist-caption").textContent}`);
  measure(k);
}

/** @param {any} plant the answer about the block */
function showPlant(plant) {
  known.plant = plant;
  known.current = true;
  known.curve = sampled(plant);
  known.shifted = lower() === 0 ? known.curve : sampled(shifted(plant, lower()));
  $("popov-figure").hidden = $("theta-row").hidden = plant.discrete;
  offerDrawings();
  $("formula").textContent = plant.formula ? `${state.form === "system" ? "" : "Read as "}H(${plant.discrete ? "z" : "s"}) = ${raised(plant.formula)}` : "";
  $("dropped").textContent = plant.dropped ?? "";
  if (known.largest === null) {
    const sizes = [...known.shifted.re].map(Math.abs).sort((a, b) => a - b);
    typical = 1 / (sizes[Math.round(0.8 * (sizes.length - 1))] || 1);
  }
  show();
}

function show() {
  if (!known.curve || !known.shifted) return;
  popov.show(known.shifted, typical);
  nyquist.show(known.curve, lower(), typical);
  redraw();
}

// What the checkers say.

/** @param {string} verdict @param {string} sentence */
function showVerdict(verdict, sentence) {
  const badge = document.createElement("b");
  badge.className = verdict;
  badge.textContent = verdict;
  $("verdict").replaceChildren(badge, sentence);
  $("verdict").dataset.verdict = verdict;
  $("verdict").classList.remove("old");
}

/** On a phone the verdict, or what is waited for, stays in sight while its card is not, nor a panel with verdicts of its own. */
function brief() {
  const { verdict } = $("verdict").dataset;
  $("brief").className = `${verdict ?? ""} ${$("verdict").classList.contains("old") ? "old" : ""}`;
  $("brief").textContent = verdict ? `${verdict}, k = ${state.k}` : $("verdict").textContent;
}
new MutationObserver(brief).observe($("verdict"), { attributes: true, childList: true });
const inSight = new Map();
const watch = new IntersectionObserver((cards) => {
  for (const card of cards) inSight.set(card.target, card.isIntersecting);
  $("brief").hidden = [...inSight.values()].includes(true);
});
for (const card of [$("verdict-card"), ...document.querySelectorAll(".results > details")]) watch.observe(card);
brief();

/** Nothing is known of this plant and class, yet or at all: no number of another one stays. @param {string} text */
function forget(text) {
  known.largest = known.class = null;
  for (const id of ["reach", "refuted", "multiplier", "worst", "checkers"]) $(id).textContent = text;
  $("bar").replaceChildren();
  $("bar-ticks").replaceChildren();
  $("bar").removeAttribute("aria-label");
  $("note").textContent = "";
  $("wave-figure").hidden = true;
  offer("get-refutation", "");
}

/** @param {any} found */
function showLargest(found) {
  const [proved, refuted] = [found.proved, found.refuted].map((one) => (one === "inf" ? Infinity : one));
  const least = 1e-6 * Math.max(Math.abs(lower()), typical);  // an end that is the lower one but for rounding is none
  const finite = [proved, refuted].filter((one) => one !== null && Number.isFinite(one) && one - lower() > least).map((one) => one - lower());
  if (finite.length) typical = Math.max(...finite);
  [range.low, range.high] = [Math.min(...finite, typical) / 20, typical * (finite.length ? 4 : 400)];
  const time = found.worst ? 1 / found.worst : known.curve ? 1 / known.curve.omega[known.curve.omega.length >> 1] : 1;
  range.theta = Math.max(Math.abs(found.line ?? 0) / 4, time / 10);
  if (!state.k) {
    const reach = proved !== null && Number.isFinite(proved) && proved - lower() > least ? proved - lower() : null;
    state.k = above(reach !== null ? 0.8 * reach : finite.length ? 1.25 * finite[0] : typical);
  }
  if (!state.theta) state.theta = String(found.line ?? 0);
  $("reach").textContent = found.reach || "nothing is proved";
  $("refuted").textContent = refuted !== null && refuted <= lower() ? "every k" : found.refuted_text || "nothing is refuted";
  $("reach").title = found.sentence;
  const multiplier = found.multiplier ? `, ${found.multiplier.replaceAll("theta", "θ")}` : "";
  const size = found.theta !== null && found.multiplier?.includes("theta") ? `, θ = ${number(found.theta, 6)} s` : "";
  $("multiplier").textContent = found.reach ? `${found.criterion}${multiplier}${size}` : "none";
  $("worst").textContent = found.reach && found.worst !== null ? `${number(found.worst / (known.plant?.period || 1))} rad/s` : "none that is finite";
  $("wave-figure").hidden = found.gain === null || known.plant === null;
  if (found.gain !== null && known.plant) {
    wave($("wave"), impulse(known.plant, found.gain), known.plant.discrete);
    $("wave-caption").textContent = `${found.witness}. Drawn: σ after an impulse.`;
    $("wave").setAttribute("aria-label", $("wave-caption").textContent);
  }
  offer("get-refutation", found.refutation);
  write();
  show();
}

function showClass() {
  const { class: found, line, largest } = known;
  if (!found || !line) return;
  showVerdict(found.verdict, found.sentence);
  const own = line.accepted && found.verdict === "PROVED";
  const size = found.line === null ? `the criterion ${found.theorem} does, whose multiplier${
    largest?.criterion === found.theorem && largest.multiplier ? `, ${largest.multiplier},` : ""} is no line`
    : `the one of θ = ${number(found.line, 6)} s does`;
  const better = !own && found.verdict === "PROVED" && hasLine() && !varying() ? `This line does not prove it; ${size}.` : "";
  const missing = found.left_out || largest?.left_out
    ? "Some searches need numpy, which a browser does not have, and were left out. They are made by the command " : "";
  const reason = found.verdict === "REFUTED" ? largest?.reason ?? "" : "";
  const advice = reason && `${reason[0].toUpperCase()}${reason.slice(1)}${reason.includes("give a lower gain") ? ", under Lower end k₁" : ""}.`;
  const most = largest?.proved === "inf" ? Infinity : largest?.proved ?? -Infinity;
  const only = found.verdict === "INCONCLUSIVE" && parsed(state.k) <= most ? `What is proved: ${largest.sentence}` : "";
  const whole = document.createElement("code");
  whole.textContent = missing && command();
  $("note").replaceChildren([better, advice, only, missing].filter(Boolean).join(" "), ...(missing ? [whole] : []));
  $("checkers").textContent = found.second === null ? "there is nothing to check" : found.second ? "both" : "the first only";
  offer("get-certificate", own ? line.certificate : found.certificate);
  offer("get-report", JSON.stringify({ largest: largest?.report ?? null, class: found.report }, null, 2) + "\n");
  offer("get-toml", found.toml);
  redraw();
}

/** The command that asks the same. */
function command() {
  const quoted = (text) => `"${text.replace(/[\s,[\]()]+/g, " ").trim()}"`;
  const plant = { num: `--num ${quoted(state.num)} --den ${quoted(state.den)}`, transfer: `--transfer "${state.transfer}"`,
    system: `--system ${state.system}` }[state.form];
  const slope = state.class === "slope" || state.class === "odd";
  const more = [state.dt && state.form !== "system" ? `--dt ${state.dt}` : "", lower() ? `--lower=${state.lower}` : "",
    varying() ? "--time-varying" : "", state.class === "odd" ? "--odd" : ""].filter(Boolean).join(" ");
  return `lure ${slope ? "max-slope" : "max-sector"} ${plant} ${more}`.trim();
}

function showCommand() {
  $("command").textContent = `${command()}\nlure certify plant.toml -o certificate.json  # the TOML file above`;
}

const question = (kind) => ({ ask: kind, ...Object.fromEntries(FIELDS.map((name) => [name, ""])),
  ...Object.fromEntries(({ num: ["num", "den", "dt"], transfer: ["transfer", "dt"], system: ["system"] })[state.form]
    .map((name) => [name, state[name]])),
  class: state.class, lower: state.lower, k: state.k, theta: state.theta });

/** Ask; nothing where the question was overtaken, a sentence beside its field where it was refused.
 * @param {string} kind @param {number} of */
async function ask(kind, of) {
  const answer = await asking.ask(question(kind));
  if (of !== asked) return null;
  if (!answer.error) return { ...answer, asked: of };
  refuse(answer.field, answer.error);
  silent();
  for (const id of ["get-certificate", "get-report", "get-toml"]) offer(id, "");
  $("note").textContent = "";
  $("checkers").textContent = "–";
  if (kind === "plant" || kind === "largest") forget("–");
  if (kind === "plant") $("formula").textContent = $("dropped").textContent = "";
  $("verdict").classList.remove("old");
  $("verdict").textContent = "Correct the field that is marked.";
  delete $("verdict").dataset.verdict;
  return null;
}

let pending = 0;  // what asks a little after the last key

/** The question has changed: `plant`, `class` or `line` says how far down; what is shown is old from now on.
 * @param {"plant" | "class" | "line"} what */
function outdated(what) {
  clearTimeout(pending);
  pending = 0;
  asked++;
  document.body.dataset.state = "checking";
  $("verdict").classList.add("old");
  if (what === "plant") [known.current, known.curve] = [false, null];
  refuse();
  for (const id of ["get-certificate", "get-report", "get-toml"]) $(id).removeAttribute("href");
  if (what !== "line") forget("…");
  follow(addressOf(state));
  showCommand();
  redraw();
}

/** Ask what has changed. @param {"plant" | "class" | "line"} what */
async function changed(what) {
  outdated(what);
  const of = asked;
  try {
    await asking.ready;
    if (!known.current) {
      const plant = await ask("plant", of);
      if (!plant) return;
      showPlant(plant);
    }
    if (what !== "line" || known.largest === null) {
      const largest = await ask("largest", of);
      if (!largest) return;
      known.largest = largest;
      showLargest(largest);
      follow(addressOf(state));
    }
    const line = await ask("line", of);
    if (!line) return;
    known.line = line;
    redraw();
    const found = await ask("class", of);
    if (!found) return;
    known.class = found;
    showClass();
  } catch (error) {
    forget("–");
    $("verdict").textContent = `The checkers could not be started: ${error instanceof Error ? error.message : error}.`;
  } finally {
    if (of === asked) document.body.dataset.state = "done";
    $("loading").hidden = true;
  }
}

// From the fields, the sliders and the address to a question.

for (const name of ["num", "den", "dt", "transfer", "lower"]) {
  const taken = () => {
    state = { ...state, [name]: $(name).value, theta: "" };
    if (!chosen || !(parsed(state.k) > lower())) state.k = "";
  };
  $(name).addEventListener("input", () => {
    taken();
    outdated("plant");
    pending = setTimeout(changed, 300, "plant");
  });
  $(name).addEventListener("change", () => {
    if ($(name).value === state[name] && !pending) return;
    taken();
    changed("plant");
  });
}
$("system").addEventListener("change", () => { chosen = false; state = { ...state, system: $("system").value, ...systemClass(), k: "", theta: "" }; write(); changed("plant"); });
$("class").addEventListener("change", () => { state = { ...state, class: $("class").value, theta: "" }; write(); changed("class"); });
for (const name of ["k", "theta"]) {
  $(name).addEventListener("input", () => {
    chosen ||= name === "k";
    state = { ...state, [name]: $(name).value };
    slide();
    changed("line");
  });
}
$("k-slider").addEventListener("input", () => {
  const k = range.low * (range.high / range.low) ** (Number($("k-slider").value) / 1000);
  state = { ...state, k: above(k) };
  chosen = true;
  $("k").value = state.k;
  changed("line");
});
$("theta-slider").addEventListener("input", () => {
  state = { ...state, theta: short(range.theta * Math.sinh((4 * Number($("theta-slider").value)) / 1000)) };
  $("theta").value = state.theta;
  changed("line");
});
$("best").addEventListener("click", () => {
  const { largest } = known;
  if (!largest) return;
  chosen = false;
  state = { ...state, k: parsed(largest.reach) > lower() && largest.proved !== "inf" ? largest.reach : state.k,
    theta: String(largest.line ?? 0) };
  write();
  changed("line");
});
for (const radio of document.querySelectorAll("input[name=form]")) {
  radio.addEventListener("change", () => {
    const form = radio.value, { plant } = known;
    state = { ...state, form };
    if (form === "system" && !state.system) state = { ...state, system: systems[0].name, k: "", theta: "" };
    if (form === "transfer" && !state.transfer && plant?.formula) state.transfer = plant.formula;
    if (form === "num" && !state.den && plant) state = { ...state, num: plant.num.join(", "), den: plant.den.join(", ") };
    write();
    changed("plant");
  });
}
$("controls").addEventListener("submit", (event) => event.preventDefault());
window.addEventListener("hashchange", () => {
  const given = stateOf(location.hash);
  if (!given) {  // the address stays that of the loop
    follow(addressOf(state));
    unread();
    return;
  }
  state = given;
  chosen = state.k !== "";
  write();
  changed("plant");
});
for (const name of ["popov", "nyquist"]) $(`get-${name}`).addEventListener("click", () => offerDrawing(`get-${name}`, $(name)));

/** The class that a built-in system is about. */
function systemClass() {
  return systems.find((one) => one.name === $("system").value)?.asked ?? {};
}

$("system").append(...systems.map((one) => new Option(`${one.name}: ${one.title}`, one.name)));
state = { ...state, ...(stateOf(location.hash) ?? start.state) };
chosen = state.k !== "";
write();
showCommand();
const at = systems.find((one) => one.name === state.system);
const quick = { num: state.num.split(/[\s,]+/).map(parsed), den: state.den.split(/[\s,]+/).map(parsed), discrete: state.dt.trim() !== "",
  period: parsed(state.dt || "0") };
if (at && state.form === "system") showPlant(at.plant);
else if (state.form === "num" && [...quick.num, ...quick.den].every(Number.isFinite)) showPlant(quick);
asking.ready.then(() => { $("loaded").textContent = `Loaded in ${(performance.now() / 1000).toFixed(1)} s.`; document.body.dataset.ready = ""; }, () => {});
known.current = false;
changed(known.curve ? "class" : "plant");
for (const panel of start.panels) import(`lure/${panel}`).then((module) => module.open(asking), console.error);
