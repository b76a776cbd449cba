"use strict";
// Sorting: numbers by their data-v, text as text, "n/a" last in either direction.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => head.querySelector("button")?.addEventListener("click", () => {
    const up = head.getAttribute("aria-sort") !== "ascending";
    heads.forEach(h => h.setAttribute("aria-sort", "none"));
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const body = table.tBodies[0];
    const key = row => {
      const cell = row.cells[column];
      if (cell.classList.contains("na")) return null;
      return cell.dataset.v === undefined ? cell.textContent.trim() : Number(cell.dataset.v);
    };
    const rows = [...body.rows].map((row, i) => ({ row, i, k: key(row) }));
    rows.sort((a, b) => {
      if (a.k === null || b.k === null) return (a.k === null) - (b.k === null) || a.i - b.i;
      const order = typeof a.k === "number" && typeof b.k === "number"
        ? a.k - b.k : String(a.k).localeCompare(String(b.k), "en", { numeric: true });
      return (up ? order : -order) || a.i - b.i;
    });
    body.append(...rows.map(r => r.row));
  }));
}
// Choosing: in each view, and over all of them by the worst view, the smallest error within the budget.
const budget = document.querySelector(".budget");
if (budget) {
  const views = [...budget.querySelectorAll("tr[data-view]")].length;
  const offer = row => ({
    row, view: row.dataset.view, setting: row.dataset.setting, error: Number(row.dataset.error),
    ms: row.dataset.ms === undefined ? Infinity : Number(row.dataset.ms), bytes: Number(row.dataset.bytes),
  });
  const offers = [...document.querySelectorAll("#cells tr[data-view]")].map(offer);
  const worst = new Map();
  for (const o of offers) {
    const w = worst.get(o.setting) ?? { ...o, error: 0, ms: 0, bytes: 0, seen: new Set() };
    w.seen.add(o.view);
    for (const key of ["error", "ms", "bytes"]) w[key] = Math.max(w[key], o[key]);
    worst.set(o.setting, w);
  }
  const everywhere = [...worst.values()].filter(w => w.seen.size === views);
  const [time, memory] = [budget.querySelector("[name=ms]"), budget.querySelector("[name=bytes]")];
  const limit = field => field.value === "" ? Infinity : Number(field.value);
  const digits = value => Number.isFinite(value) ? String(Number(value.toPrecision(3))) : "n/a";
  const choose = () => {
    for (const line of budget.querySelectorAll("tbody tr")) {
      const all = line.dataset.view === undefined ? everywhere : offers.filter(o => o.view === line.dataset.view);
      const fits = all.filter(o => o.ms <= limit(time) && o.bytes <= limit(memory));
      const best = fits.reduce((a, b) => a && a.error <= b.error ? a : b, undefined);
      const put = (name, ...what) => line.querySelector(name).replaceChildren(...what);
      put(".what", best ? best.row.querySelector(".method").cloneNode(true) : "nothing fits");
      put(".with", best ? best.row.querySelector(".setting").cloneNode(true) : "");
      put(".error", best ? digits(best.error) : "");
      put(".ms", best ? digits(best.ms) : "");
      const size = best && [...memory.options].find(o => Number(o.value) === best.bytes && o.value !== "");
      put(".bytes", size ? size.textContent : "");
    }
  };
  for (const field of [time, memory]) field.addEventListener("input", choose);
  budget.hidden = false;
  choose();
}
// Comparing: the chosen cell's picture beside the truth.
for (const article of document.querySelectorAll("article.case")) {
  const box = article.querySelector(".compare");
  if (!box) continue;
  const source = (cell, kind) => {
    const stored = box.querySelector(`.stored[data-cell="${cell}"] .${kind}`);
    if (stored) return { src: stored.dataset.src, why: stored.dataset.missing };
    const shown = article.querySelector(`figure[data-cell="${cell}"] img.${kind}`);
    return { src: shown?.getAttribute("src"), why: "see the notice on the sheet above" };
  };
  const put = (img, { src, why }) => {
    const figure = img.parentElement;
    figure.querySelector(".notice")?.remove();
    img.hidden = !src;
    if (src) { img.src = src; return; }
    img.removeAttribute("src");
    const notice = document.createElement("p");
    notice.className = "notice missing";
    notice.textContent = `Picture missing. ${why}.`;
    img.before(notice);
  };
  const select = box.querySelector("select");
  const show = () => {
    const cell = select.value;
    const stored = box.querySelector(`.stored[data-cell="${cell}"]`);
    put(box.querySelector("img.right"), source(cell, "picture"));
    put(box.querySelector("img.delta"), source(cell, "diff"));
    box.querySelector(".chosen").replaceChildren(stored.dataset.title, stored.querySelector("dl").cloneNode(true));
  };
  const truth = article.querySelector("img.truth")?.getAttribute("src");
  put(box.querySelector("img.left"), { src: truth, why: "see the notice on the sheet above" });
  select.addEventListener("change", show);
  box.hidden = false;
  show();
}
