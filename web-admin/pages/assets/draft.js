// Keeps the verdict beside a draft up with what is typed. Without it, "Save and check" shows the same.

const form = document.querySelector("form[data-preview]");
const verdict = document.querySelector("[data-verdict]");
/** How long typing must rest, in ms. */
const REST_MS = 700;
let resting;
let asked = 0;

/** What is being asked. */
let asking;

async function preview() {
  // What was asked before is of no use any more: whoever computes it stops.
  asking?.abort();
  asking = new AbortController();
  const question = ++asked;
  let again;
  verdict.setAttribute("aria-busy", "true");
  try {
    const body = new URLSearchParams(new FormData(form));
    const answer = await fetch(form.dataset.preview, { method: "POST", body, signal: asking.signal });
    const part = await answer.text();
    // Others are before it: it is said when to ask again.
    if (answer.status === 503) again = 1000 * Number(answer.headers.get("retry-after"));
    // An answer that a newer question has overtaken says nothing any more.
    if (answer.ok && question === asked) verdict.innerHTML = part;
  } catch {
    // Offline: what was drawn last stays, and saving will say so.
  }
  if (question !== asked) return;
  if (again) {
    clearTimeout(resting);
    resting = setTimeout(preview, again);
  } else verdict.removeAttribute("aria-busy");
}

form.addEventListener("input", () => {
  clearTimeout(resting);
  resting = setTimeout(preview, REST_MS);
});

/** Rows that somebody has opened stay open when the page comes back: until then their ids are kept here. */
const OPEN_ROWS = `open rows of ${location.pathname}`;

form.addEventListener("submit", () => {
  const open = [...form.querySelectorAll("details.folded[open]")].map((row) => row.id);
  sessionStorage.setItem(OPEN_ROWS, JSON.stringify(open));
});

for (const id of JSON.parse(sessionStorage.getItem(OPEN_ROWS) ?? "[]")) {
  const row = document.getElementById(id);
  if (row?.matches("details.folded")) row.open = true;
}
sessionStorage.removeItem(OPEN_ROWS);

/** Opens the row that the address leads to, or in which that place is. */
function openTarget() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const row = target?.closest("details.folded");
  if (!row) return;
  row.open = true;
  target.scrollIntoView();
}

addEventListener("hashchange", openTarget);
openTarget();
