"use strict";
// Tables sort by a click on a heading and show the rows that hold the words typed above them.
(() => {
  const MANY = 8; // rows from which on a filter is worth its place
  const words = cell => cell.textContent.trim();
  const number = text => {
    const found = /^[<>≈]?\s*([-+−]?\d[\d.]*(?:e[-+]?\d+)?)/i.exec(text);
    return found ? parseFloat(found[1].replace("−", "-")) : NaN;
  };

  // Numbers first, then words, what is missing last; `sign` -1 turns the first two around.
  function compare(a, b, sign) {
    const [x, y] = [number(a), number(b)];
    const rank = (text, value) => Number.isNaN(value) ? (text === "–" || text === "" ? 2 : 1) : 0;
    const order = rank(a, x) - rank(b, y);
    if (order) return order;
    return sign * (rank(a, x) === 0 ? x - y : a.localeCompare(b));
  }

  function sort(table, heading, column) {
    const falling = heading.getAttribute("aria-sort") === "ascending";
    table.querySelectorAll("[aria-sort]").forEach(other => other.removeAttribute("aria-sort"));
    heading.setAttribute("aria-sort", falling ? "descending" : "ascending");
    const body = table.tBodies[0], rows = [...body.rows];
    rows.sort((a, b) => compare(words(a.cells[column]), words(b.cells[column]), falling ? -1 : 1));
    body.append(...rows);
  }

  function filter(table, text) {
    const wanted = text.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of table.tBodies[0].rows) {
      const held = row.textContent.toLowerCase();
      row.hidden = !wanted.every(word => held.includes(word));
    }
  }

  for (const table of document.querySelectorAll("table.data")) {
    const single = [...table.tHead.rows].at(-1), first = table.tHead.rows.length > 1 ? 1 : 0;
    [...single.cells].forEach((heading, index) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...heading.childNodes);
      heading.append(button);
      button.addEventListener("click", () => sort(table, heading, index + first));
    });
    if (table.tBodies[0].rows.length < MANY || first) continue;
    const field = document.createElement("input");
    field.type = "search";
    field.className = "filter";
    field.placeholder = "filter rows: folding split";
    field.setAttribute("aria-label", `Filter the rows of ${table.caption ? table.caption.textContent : table.dataset.name}`);
    field.addEventListener("input", () => filter(table, field.value));
    (table.closest(".scroll") || table).before(field);
  }
})();
