// Saves a page of a survey while it is answered. Without it, each page is saved when one goes on.
const form = document.querySelector("form[data-autosave]");
const note = form?.querySelector("[role=status]");
const PAUSE_MS = 600; // after the last key
const RETRY_MS = 4000; // while there is no connection
let timer = 0;
let unsaved = false;

function later(ms) {
  clearTimeout(timer);
  timer = setTimeout(save, ms);
}

async function save() {
  const fields = new URLSearchParams(new FormData(form));
  fields.set("do", "save");
  note.textContent = form.dataset.saving;
  unsaved = false;
  try {
    // It goes on though the tab is closed meanwhile.
    const answer = await fetch(form.action, { method: "POST", body: fields, keepalive: true });
    note.textContent = answer.ok ? form.dataset.saved : form.dataset.refused;
  } catch {
    note.textContent = form.dataset.waiting;
    unsaved = true;
    later(RETRY_MS);
  }
}

if (form) {
  const changed = (ms) => {
    unsaved = true;
    later(ms);
  };
  form.addEventListener("change", () => changed(0));
  form.addEventListener("input", () => changed(PAUSE_MS));
  form.addEventListener("submit", () => {
    clearTimeout(timer);
    unsaved = false;
  });
  addEventListener("online", () => later(0));
  addEventListener("pagehide", () => unsaved && save());
}
