// What a narrow screen needs to know of a page, once its formulas are set and whenever its width changes.
window.addEventListener("load", async () => {
  await window.MathJax?.startup?.promise;
  const all = (what) => document.querySelectorAll(`.bd-article ${what}`);
  // A formula that is wider than its paragraph is made smaller: within a sentence by a quarter, alone by a third at most.
  // If that is not enough it scrolls by itself; the page would cut it off.
  const fit = () => {
    for (const formula of all('mjx-container:not([display="true"])')) {
      const own = (formula.dataset.size ??= parseFloat(formula.style.fontSize) || 100);
      formula.style.fontSize = `${own}%`;
      formula.classList.remove("long");
      const room = formula.closest("p, li, dd, td, figcaption");
      const whole = formula.closest(".joined") ?? formula;
      const share = room ? room.clientWidth / whole.getBoundingClientRect().width : 1;
      if (share < 1) formula.style.fontSize = `${Math.floor(own * Math.max(0.97 * share, 0.75))}%`;
      if (share < 0.77) formula.classList.add("long");
    }
    for (const formula of all("div.math")) {
      formula.style.fontSize = "";
      const inner = formula.querySelector("mjx-container")?.scrollWidth ?? 0;  // one without a number scrolls in itself
      const share = formula.clientWidth / Math.max(formula.scrollWidth, inner);
      if (share < 1) formula.style.fontSize = `${share > 2 / 3 ? Math.floor(90 * share) : 75}%`;
    }
  };
  // Columns that a program printed, lines with gaps within, keep their places; the sentences around them are wrapped.
  const gap = /\S {3,}\S|\S {2,}\S.* {2,}\S|[-.]{20}/;
  for (const text of all(".cell_output pre")) {
    if ([...text.children].some((part) => part.textContent) || (text.textContent.match(new RegExp(gap, "g")) ?? []).length < 2) continue;
    text.replaceChildren(...text.textContent.split(/(?<=\n)/).map((line) => {
      const part = document.createElement("span");
      part.textContent = line;
      return part;
    }));
  }
  for (const line of all(":is(.cell_output pre > span, .highlight-console .go)")) {
    line.classList.toggle("columns", gap.test(line.textContent) && line.textContent.length < 100);
  }
  // Figures of several panels keep their size.
  for (const image of all(".cell_output img")) {
    if (image.naturalWidth > 1.8 * image.naturalHeight) image.closest(".cell_output").classList.add("wide");
  }
  // No line begins with the comma after a formula, or ends with the bracket before it.
  for (const formula of all("span.math")) {
    const [before, after] = [formula.previousSibling, formula.nextSibling];
    const opening = before?.nodeType === Node.TEXT_NODE ? before.data.match(/[(“]*$/)[0].length : 0;
    const closing = after?.nodeType === Node.TEXT_NODE ? after.data.match(/^[.,;:)”?]*/)[0].length : 0;
    if (!opening && !closing) continue;
    const joined = document.createElement("span");
    joined.className = "joined";
    formula.before(joined);
    joined.append(opening ? before.splitText(before.length - opening) : "", formula);
    if (closing) {
      after.splitText(closing);
      joined.append(after);
    }
  }
  fit();
  window.addEventListener("resize", fit);
});
