// Wires a replay: what is fetched, what is drawn, what the hand and the keyboard do.

import { Alignment, ExpertGhost } from './replay-align.js';
import { Clock, SPEEDS } from './replay-clock.js';
import { Comments } from './replay-comments.js';
import { Attempt } from './replay-data.js';
import { listen } from './replay-keys.js';
import { Plots } from './replay-plots.js';
import { Scene } from './replay-scene.js';
import { fixed, onThemeChange, readTheme } from './replay-theme.js';

const root = document.querySelector('#replay');
const part = (name) => root.querySelector(`[data-part=${name}]`);

// The figures at the playhead, ten times a second at most: nobody reads faster.
function figures(attempt, clock) {
  const fields = Object.fromEntries(['time', 'advance', 'depth', 'force', 'lateral', 'layer'].map((name) => [name, part(name)]));
  const live = part('live');
  const unit = (value, digits, word) => `${fixed(value, digits)} ${word}`;
  let last = -1000;
  return (now) => {
    if (clock.playing && now - last < 100) return;
    last = now;
    const row = attempt.frames.at(clock.t);
    const value = (name) => row[attempt.frames.index[name]];
    const layer = attempt.layerAt(value('depth_mm'));
    fields.time.textContent = unit(clock.t, 2, 's');
    fields.advance.textContent = unit(value('advance_mm'), 1, 'mm');
    fields.depth.textContent = unit(value('depth_mm'), 1, 'mm');
    fields.force.textContent = unit(value('force_n'), 2, 'N');
    fields.lateral.textContent = unit(value('lateral_n'), 2, 'N');
    // What only gives way is advanced against and not entered.
    const outside = value('advance_mm') > 0 ? root.dataset.on : root.dataset.above;
    fields.layer.textContent = layer ? layer.name : outside;
    // Read out when it stands: a voice that speaks during play would be behind all the time.
    if (clock.playing) return;
    const event = attempt.stage.events.findLast((one) => Math.abs(one.t_s - clock.t) < 0.015)?.words;
    live.textContent = [event, fields.time.textContent, fields.depth.textContent, fields.force.textContent, fields.layer.textContent].filter(Boolean).join(', ');
  };
}

// The next or the last event seen from the playhead.
function jumper(attempt, clock) {
  const times = [...new Set(attempt.stage.events.map((event) => event.t_s))].sort((a, b) => a - b);
  return (direction) => {
    const next = direction > 0 ? times.find((t) => t > clock.t + 1e-3) : times.findLast((t) => t < clock.t - 1e-3);
    clock.seek(next ?? (direction > 0 ? clock.duration : 0));
  };
}

function wireControls({ clock, plots, jump, scene, draw }) {
  const [play, speed, scrub] = ['play', 'speed', 'scrub'].map(part);
  play.addEventListener('click', () => clock.toggle());
  part('before').addEventListener('click', () => jump(-1));
  part('after').addEventListener('click', () => jump(1));
  part('closer').addEventListener('click', () => { plots.zoom(0.5); draw(); });
  part('farther').addEventListener('click', () => { plots.zoom(2); draw(); });
  speed.addEventListener('change', () => clock.setSpeed(Number(speed.value)));
  scrub.max = clock.duration.toFixed(2);
  scrub.addEventListener('input', () => clock.seek(Number(scrub.value)));
  const view = part('view');
  view.querySelector('[value=patient]').hidden = !scene?.hasPatient;
  if (scene?.hasPatient) {
    view.value = 'patient';
    scene.look('patient');
  }
  view.addEventListener('change', () => { scene?.look(view.value); draw(); });
  clock.addEventListener('moved', () => { scrub.value = clock.t; scrub.ariaValueText = `${fixed(clock.t, 2)} s`; });
  clock.addEventListener('changed', () => {
    play.textContent = clock.playing ? root.dataset.pause : root.dataset.play;
    speed.value = String(clock.speed);
    if (SPEEDS.includes(clock.speed) && clock.speed !== 1) history.replaceState(null, '', `#t=${clock.t.toFixed(2)}&speed=${clock.speed}`);
  });
}

// Dragging along the plots scrubs; the wheel goes closer.
function wirePlots(plots, clock, draw) {
  const { canvas } = plots;
  const to = (event) => clock.seek(plots.time(event.clientX - canvas.getBoundingClientRect().left));
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    to(event);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (event.buttons & 1) to(event);
    const t = plots.time(event.clientX - canvas.getBoundingClientRect().left);
    plots.hover = t >= plots.from && t <= plots.to ? t : null;
    plots.draw();
  });
  canvas.addEventListener('pointerleave', () => { plots.hover = null; plots.draw(); });
  canvas.addEventListener('wheel', (event) => {
    if (!event.ctrlKey && !event.shiftKey) return;
    event.preventDefault();
    plots.zoom(event.deltaY > 0 ? 1.25 : 0.8, plots.time(event.clientX - canvas.getBoundingClientRect().left));
    draw();
  }, { passive: false });
}

// Which event of the list the playhead has come to.
function followEvents(clock) {
  const links = [...root.querySelectorAll('[data-event]')];
  return () => {
    const now = links.findLast((link) => Number(link.dataset.second) <= clock.t + 0.005);
    links.forEach((link) => (link === now ? link.setAttribute('aria-current', 'true') : link.removeAttribute('aria-current')));
  };
}

// Links and rows of the page that name a moment.
function wireMoments(clock) {
  let opened = false;
  const go = () => {
    const wanted = new URLSearchParams(location.hash.slice(1));
    if (wanted.has('speed') && SPEEDS.includes(Number(wanted.get('speed')))) clock.setSpeed(Number(wanted.get('speed')));
    if (wanted.has('t')) clock.seek(Number(wanted.get('t')) || 0);
    else if (root.dataset.at && !opened) clock.seek(Number(root.dataset.at));
    opened = true;
  };
  document.addEventListener('click', (event) => {
    const link = event.target.closest('a[data-second]');
    if (!link || event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    clock.pause();
    clock.seek(Number(link.dataset.second));
    root.scrollIntoView({ block: 'nearest' });
  });
  // A form that loads the page anew leads back to the moment at which it was sent.
  document.querySelectorAll('form input[data-moment]').forEach((field) => {
    field.form.addEventListener('submit', () => {
      field.value = clock.t.toFixed(2);
    });
  });
  addEventListener('hashchange', go);
  go();
}

function openScene(attempt) {
  try {
    return new Scene(part('scene'), part('labels'), attempt);
  } catch (error) {
    part('no-scene').hidden = false;
    part('no-scene').textContent = root.dataset.noScene;
    return null;
  }
}

async function start() {
  const names = JSON.parse(root.dataset.names);
  const attempt = await Attempt.open(root.dataset.address, names);
  const said = JSON.parse(root.dataset.events || '[]');
  attempt.stage.events.forEach((event, i) => { event.words = said[i] ?? ''; });
  const clock = new Clock(attempt.stage.duration_s);
  const comments = new Comments(root, clock);
  root.hidden = false;
  document.querySelectorAll('[data-without-script]').forEach((element) => { element.hidden = true; });
  const plots = new Plots(part('plots'), attempt, clock);
  plots.comments = comments.items;
  plots.draw();
  await attempt.loadFrames();
  plots.rest();
  const scene = openScene(attempt);
  const show = figures(attempt, clock);
  const follow = followEvents(clock);
  const draw = () => {
    plots.follow();
    plots.draw();
    scene?.draw(clock.t);
    show(performance.now());
    comments.reach(clock.t);
    follow();
  };
  if (root.dataset.experts) {
    plots.experts = new ExpertGhost(attempt, JSON.parse(root.dataset.experts));
    if (scene) scene.experts = plots.experts;
    plots.stale = true;
  }
  if (scene) scene.onTurn = draw;
  const jump = jumper(attempt, clock);
  clock.addEventListener('moved', draw);
  wireControls({ clock, plots, jump, scene, draw });
  wirePlots(plots, clock, draw);
  listen({ clock, plots, jump });
  onThemeChange(() => {
    plots.theme = readTheme();
    plots.stale = true;
    scene?.readTheme();
    draw();
  });
  new ResizeObserver(() => { plots.stale = true; draw(); }).observe(root);
  wireMoments(clock);
  draw();
  root.dataset.ready = 'yes';
  if (root.dataset.other) {
    const other = await Attempt.open(root.dataset.other, names);
    await other.loadFrames();
    plots.other = { attempt: other, alignment: new Alignment(attempt, other) };
    if (scene) scene.other = plots.other;
    plots.rest();
    draw();
  }
}

start().catch((error) => {
  const status = document.querySelector('#replay-status');
  status.hidden = false;
  status.textContent = root.dataset.failed;
  root.hidden = true;
  document.querySelectorAll('[data-without-script]').forEach((element) => { element.hidden = false; });
});
