// Keeps the verdict beside a draft up with what is typed. Without it, "Save and check" shows the same.

const form = document.querySelector("form[data-preview]");
const verdict = document.querySelector("[data-verdict]");
/** How long typing must rest, in ms. */
const REST_MS = 700;
let resting;
let asked = 0;

async function preview() {
  const question = ++asked;
  verdict.setAttribute("aria-busy", "true");
  try {
    const body = new URLSearchParams(new FormData(form));
    const answer = await fetch(form.dataset.preview, { method: "POST", body });
    const part = await answer.text();
    // An answer that a newer question has overtaken says nothing any more.
    if (answer.ok && question === asked) verdict.innerHTML = part;
  } catch {
    // Offline: what was drawn last stays, and saving will say so.
  }
  if (question === asked) verdict.removeAttribute("aria-busy");
}

form.addEventListener("input", () => {
  clearTimeout(resting);
  resting = setTimeout(preview, REST_MS);
});
