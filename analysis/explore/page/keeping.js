/** What a reader may keep: certificates, numbers, the loop as a file, the drawings. */

/** @type {Map<string, string>} */
const held = new Map();

/** @param {string} id @param {string} text @param {string} [type] */
function attach(id, text, type = "application/json") {
  const link = /** @type {HTMLAnchorElement} */ (document.getElementById(id));
  URL.revokeObjectURL(held.get(id) ?? "");
  held.set(id, URL.createObjectURL(new Blob([text], { type })));
  link.href = held.get(id) ?? "";
}

/** Offer a text under a link; none hides it. @param {string} id @param {string} text */
export function offer(id, text) {
  const link = /** @type {HTMLElement} */ (document.getElementById(id));
  link.hidden = !text;
  if (text) attach(id, text);
}

const KEPT = ["fill", "fill-opacity", "fill-rule", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "opacity",
  "font-family", "font-size"];

/** A drawing as a file of its own, in the colours it has now. @param {string} id @param {SVGElement} svg */
export function offerDrawing(id, svg) {
  const copy = /** @type {SVGElement} */ (svg.cloneNode(true));
  const [from, to] = [svg, copy].map((one) => [...one.querySelectorAll("*")]);
  to.forEach((one, i) => {
    const style = getComputedStyle(from[i]);
    for (const name of KEPT) one.setAttribute(name, style.getPropertyValue(name));
    one.removeAttribute("class");
  });
  const [, , width, height] = (svg.getAttribute("viewBox") ?? "").split(" ");
  for (const [name, one] of Object.entries({ xmlns: "http://www.w3.org/2000/svg", width, height })) copy.setAttribute(name, one);
  const back = getComputedStyle(document.body).getPropertyValue("--card");
  copy.insertAdjacentHTML("afterbegin", `<rect width="100%" height="100%" fill="${back}"/>`);
  attach(id, new XMLSerializer().serializeToString(copy), "image/svg+xml");
}
