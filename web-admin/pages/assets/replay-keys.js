// The keyboard. What each key does is listed on the page.

const STEP_S = 0.02;
const LONG_STEP_S = 1;

// Keys that belong to a field or a control while it has the focus.
function isTaken(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return true;
  const control = event.target.closest('input, select, textarea, button, summary, a');
  if (!control) return false;
  return control.matches('textarea, select, input:not([type=range])') || event.key === ' ' || event.key === 'Enter';
}

export function listen({ clock, plots, jump }) {
  const keys = {
    ' ': () => clock.toggle(),
    ArrowLeft: (event) => clock.seek(clock.t - (event.shiftKey ? LONG_STEP_S : STEP_S)),
    ArrowRight: (event) => clock.seek(clock.t + (event.shiftKey ? LONG_STEP_S : STEP_S)),
    '[': () => jump(-1),
    ']': () => jump(1),
    Home: () => clock.seek(0),
    End: () => clock.seek(clock.duration),
    ',': () => clock.slower(),
    '.': () => clock.faster(),
    '+': () => plots.zoom(0.5),
    '=': () => plots.zoom(0.5),
    '-': () => plots.zoom(2),
  };
  document.addEventListener('keydown', (event) => {
    const act = keys[event.key];
    if (!act || isTaken(event)) return;
    event.preventDefault();
    act(event);
    plots.draw();
  });
}
