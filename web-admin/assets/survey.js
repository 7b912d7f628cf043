// Saves a page of a survey while it is answered. Without it, each page is saved when one goes on.
const form = document.querySelector("form[data-autosave]");
const note = form?.querySelector("[role=status]");
const PAUSE_MS = 600; // after the last key
const RETRY_MS = 4000; // while there is no connection
let timer = 0;

function later(ms) {
  clearTimeout(timer);
  timer = setTimeout(save, ms);
}

async function save() {
  const fields = new URLSearchParams(new FormData(form));
  fields.set("do", "save");
  note.textContent = form.dataset.saving;
  try {
    const answer = await fetch(form.action, { method: "POST", body: fields });
    note.textContent = answer.ok ? form.dataset.saved : form.dataset.refused;
  } catch {
    note.textContent = form.dataset.waiting;
    later(RETRY_MS);
  }
}

if (form) {
  form.addEventListener("change", () => later(0));
  form.addEventListener("input", () => later(PAUSE_MS));
  form.addEventListener("submit", () => clearTimeout(timer));
  addEventListener("online", () => later(0));
}
