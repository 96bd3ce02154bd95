// What a narrow screen needs to know of a page, once its formulas are set and whenever its width changes.
window.addEventListener("load", async () => {
  await window.MathJax?.startup?.promise;
  const all = (what) => document.querySelectorAll(`.bd-article ${what}`);
  // A formula within a sentence that is wider than its paragraph scrolls by itself; the page would cut it off.
  // One that stands alone is made smaller if that is enough: by a third at most.
  const fit = () => {
    for (const formula of all('mjx-container:not([display="true"])')) {
      formula.classList.remove("long");
      const room = formula.closest("p, li, dd, td, figcaption");
      if (room && formula.getBoundingClientRect().width > room.clientWidth) formula.classList.add("long");
    }
    for (const formula of all("div.math")) {
      formula.style.fontSize = "";
      const inner = formula.querySelector("mjx-container")?.scrollWidth ?? 0;  // one without a number scrolls in itself
      const share = formula.clientWidth / Math.max(formula.scrollWidth, inner);
      if (share < 1) formula.style.fontSize = `${share > 2 / 3 ? Math.floor(90 * share) : 75}%`;
    }
  };
  // Columns that a program printed, lines with gaps within, keep their places; the sentences around them are wrapped.
  const gap = /\S {3,}\S|\S {2,}\S.* {2,}\S|-{20}/;
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
  fit();
  window.addEventListener("resize", fit);
});
