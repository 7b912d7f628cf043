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
