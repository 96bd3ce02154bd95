// A formula within a sentence that is wider than its paragraph scrolls by itself; the page would cut it off.
window.addEventListener("load", async () => {
  await window.MathJax?.startup?.promise;
  const check = () => {
    for (const formula of document.querySelectorAll('.bd-article mjx-container:not([display="true"])')) {
      formula.classList.remove("long");
      const room = formula.closest("p, li, dd, td, figcaption");
      if (room && formula.getBoundingClientRect().width > room.clientWidth) formula.classList.add("long");
    }
  };
  check();
  window.addEventListener("resize", check);
});
