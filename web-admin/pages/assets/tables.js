// What a table on a page can do besides: its rows are sorted by a click on a heading, and all its boxes are ticked by one.

const text = (cell) => cell.dataset.sort ?? cell.querySelector("time")?.dateTime ?? cell.textContent.trim();
const collator = new Intl.Collator(document.documentElement.lang, { numeric: true, sensitivity: "base" });

/** Whether a cell says that there is nothing: it stays at the end, whichever way a table is sorted. */
const isEmpty = (said) => said === "" || said === "–";

function compare(one, other) {
  const [a, b] = [one, other].map((said) => Number(said.replace(/^(-?\d+),(\d+)$/, "$1.$2")));
  return Number.isFinite(a) && Number.isFinite(b) ? a - b : collator.compare(one, other);
}

function sortBy(table, column, down) {
  const body = table.tBodies[0];
  const rows = [...body.rows].map((row) => ({ row, said: text(row.cells[column]) }));
  rows.sort((one, other) => {
    if (isEmpty(one.said) || isEmpty(other.said)) return isEmpty(one.said) - isEmpty(other.said);
    return down ? compare(other.said, one.said) : compare(one.said, other.said);
  });
  body.append(...rows.map(({ row }) => row));
}

/** Makes a heading a button that sorts. A column without a word of its own sorts nothing. */
function makeSortable(table, heading, column) {
  if (!heading.textContent.trim() || heading.hasAttribute("data-unsorted")) return;
  const button = document.createElement("button");
  button.type = "button";
  button.className = "sort";
  // A link in a heading stays one: what sorts stands behind it.
  if (heading.querySelector("a")) {
    button.setAttribute("aria-label", `${table.dataset.sorts}: ${heading.querySelector("a").textContent}`);
    button.textContent = "\u00a0⇅";
  } else button.append(...heading.childNodes);
  const arrow = document.createElement("span");
  arrow.setAttribute("aria-hidden", "true");
  button.append(arrow);
  heading.append(button);
  button.addEventListener("click", () => {
    const down = heading.getAttribute("aria-sort") === "ascending";
    for (const other of table.tHead.rows[0].cells) {
      other.removeAttribute("aria-sort");
      other.querySelector(".sort > span:last-child")?.replaceChildren();
    }
    heading.setAttribute("aria-sort", down ? "descending" : "ascending");
    arrow.textContent = down ? " ▼" : " ▲";
    sortBy(table, column, down);
  });
}

for (const table of document.querySelectorAll("table[data-sorts]")) {
  [...table.tHead.rows[0].cells].forEach((heading, column) => makeSortable(table, heading, column));
}

for (const table of document.querySelectorAll("table[data-ticks]")) {
  const boxes = [...table.tBodies[0].querySelectorAll("input[type=checkbox]")];
  const all = document.createElement("input");
  all.type = "checkbox";
  all.setAttribute("aria-label", table.dataset.ticks);
  const show = () => {
    const ticked = boxes.filter((box) => box.checked).length;
    all.checked = ticked > 0 && ticked === boxes.length;
    all.indeterminate = ticked > 0 && ticked < boxes.length;
  };
  all.addEventListener("change", () => {
    for (const box of boxes) box.checked = all.checked;
  });
  table.tBodies[0].addEventListener("change", show);
  table.tHead.rows[0].cells[0].replaceChildren(all);
  show();
}
