// Comments that the page lists anyway: shown as the playhead reaches them, and the form's seconds taken from it.

const SHOWN_S = 4;

export class Comments {
  constructor(root, clock) {
    this.clock = clock;
    this.now = root.querySelector('[data-now]');
    this.items = [...document.querySelectorAll('[data-comment]')].map((element) => ({
      element,
      from_s: Number(element.dataset.from),
      to_s: element.dataset.to ? Number(element.dataset.to) : null,
      kind: element.dataset.kind,
      said: element.querySelector('[data-said]').textContent.trim(),
      who: element.querySelector('[data-who]').textContent.trim(),
    }));
    this.shown = '';
    this.fillForm();
  }

  // A comment on an interval is shown throughout it, one on a moment for some seconds of the attempt.
  reach(t) {
    const reached = this.items.filter((item) => t >= item.from_s && t <= (item.to_s ?? item.from_s + SHOWN_S));
    this.items.forEach((item) => item.element.classList.toggle('reached', reached.includes(item)));
    const words = reached.map((item) => `${item.who}: ${item.said}`).join(' · ');
    if (words === this.shown || !this.now) return;
    this.shown = words;
    this.now.textContent = words;
    this.now.hidden = words === '';
  }

  fillForm() {
    const form = document.querySelector('form[data-comment-form]');
    if (!form) return;
    form.querySelectorAll('[data-take]').forEach((button) => {
      button.hidden = false;
      button.addEventListener('click', () => {
        form.elements[button.dataset.take].value = this.clock.t.toFixed(2);
      });
    });
  }
}
