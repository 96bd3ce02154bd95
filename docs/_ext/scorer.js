// Who looks for a criterion finds its page before notes on how it was programmed: the scores of Sphinx's search, by folder and title.
// Sphinx takes this file in the place of its own `Scorer`; the numbers below `score` are Sphinx's.
var Scorer = {
  score: ([docname, title, , , score]) => {
    const plain = (text) => text.toLowerCase().replaceAll("\u2019", "'").replaceAll(/<[^>]*>/g, "");
    const words = plain(new URLSearchParams(window.location.search).get("q") ?? "").split(/\s+/).filter(Boolean);
    const folders = { theory: 6, "how-to": 4, notes: -8, project: -12 };
    const named = words.length && words.every((word) => plain(title).includes(word));
    return score + (folders[docname.split("/")[0]] ?? 0) + (named ? 20 : 0) - plain(title).length / 100;
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
