// Force above, depth below, over one axis of time: layers, events, comments, the moment that is shown.

import { FONT, fit, fixed, readTheme, textureColour } from './replay-theme.js';

const LEFT = 46;
const RIGHT = 12;
const RIBBON = { top: 4, height: 18 };
const COMMENTS = 20;
const AXIS = 34;

// What stands for an event: as in the drawings on the server.
const EVENT_MARKS = {
  tip_rupture: (pen, x, y) => pen.fill(new Path2D(`M${x - 5} ${y + 4}L${x + 5} ${y + 4}L${x} ${y - 5}Z`)),
  rim_rupture: (pen, x, y) => pen.fill(new Path2D(`M${x - 6} ${y}L${x} ${y - 6}L${x + 6} ${y}L${x} ${y + 6}Z`)),
  structure_hit: (pen, x, y) => pen.stroke(new Path2D(`M${x - 5} ${y - 5}l10 10M${x + 5} ${y - 5}l-10 10`)),
  confirm: (pen, x, y) => pen.stroke(new Path2D(`M${x - 5} ${y}a5 5 0 1 0 10 0a5 5 0 1 0 -10 0`)),
};
const EVENT_COLOURS = { tip_rupture: 'lead', rim_rupture: 'bad', structure_hit: 'bad', confirm: 'good' };
// What stands for a comment of a kind, beside its colour.
export const COMMENT_SIGNS = { praise: '+', error: '!', question: '?', teaching: 'T' };

// About so many even ticks between two values.
function ticks(from, to, most) {
  const rough = (to - from) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= rough) || rough;
  const made = [];
  for (let k = Math.ceil(from / step); k * step <= to + step * 1e-6; k += 1) made.push(k * step);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return made.map((value) => [value, fixed(value, digits)]);
}

export class Plots {
  constructor(canvas, attempt, clock) {
    Object.assign(this, { canvas, words: canvas.dataset, attempt, clock, other: null, experts: null, comments: [], hover: null });
    this.from = 0;
    this.to = Math.max(clock.duration, 0.1);
    this.spans = attempt.spans;
    this.still = document.createElement('canvas');
    this.theme = readTheme();
    this.rest();
  }

  // Scales that stay while the stretch of time changes: a peak keeps its height.
  rest() {
    const forces = this.attempt.spans.concat(this.other ? this.other.attempt.spans : []);
    this.low = Math.min(0, ...forces.map((span) => span.force_min_n)) * 1.05;
    this.high = Math.max(0.1, ...forces.map((span) => span.force_max_n)) * 1.1;
    let deepest = Math.max(this.attempt.stage.target_depth_mm, 1);
    const { frames } = this.attempt;
    for (let row = 0; frames && row < frames.count; row += 1) deepest = Math.max(deepest, frames.value(row, 'advance_mm'));
    this.deepest = deepest * 1.08;
    this.stale = true;
  }

  // Shows a stretch of time, and asks for its detail.
  show(from, to) {
    const span = Math.min(Math.max(to - from, 0.05), this.clock.duration || 0.1);
    this.from = Math.min(Math.max(from, 0), Math.max(this.clock.duration - span, 0));
    this.to = this.from + span;
    this.stale = true;
    clearTimeout(this.asking);
    this.asking = setTimeout(() => this.refine(), 120);
  }

  zoom(factor, around = this.clock.t) {
    const share = (around - this.from) / (this.to - this.from || 1);
    const span = (this.to - this.from) * factor;
    this.show(around - share * span, around + (1 - share) * span);
  }

  async refine() {
    const [from, to] = [this.from, this.to];
    const whole = to - from >= this.clock.duration * 0.999;
    try {
      const spans = whole ? this.attempt.spans : await this.attempt.stretch(from, to, 1200);
      if (this.from !== from || this.to !== to) return;
      this.spans = spans;
      this.stale = true;
      this.draw();
    } catch {
      // The coarse spans stay on the screen: they show the same, with less detail.
    }
  }

  // The playhead stays in the picture while it moves.
  follow() {
    const span = this.to - this.from;
    if (this.clock.t < this.from || this.clock.t > this.to) this.show(this.clock.t - span * 0.1, this.clock.t + span * 0.9);
  }

  x(t) {
    return LEFT + ((t - this.from) / (this.to - this.from)) * (this.width - LEFT - RIGHT);
  }

  time(x) {
    return this.from + ((x - LEFT) / (this.width - LEFT - RIGHT)) * (this.to - this.from);
  }

  force(n) {
    return this.forceTop + (1 - (n - this.low) / (this.high - this.low)) * this.forceHeight;
  }

  depth(mm) {
    return this.depthTop + ((mm + 4) / (this.deepest + 4)) * this.depthHeight;
  }

  draw() {
    if (this.canvas.clientWidth === 0) return;
    if (fit(this.canvas) || this.stale) this.drawStill();
    const pen = this.canvas.getContext('2d');
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.still, 0, 0);
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.drawHover(pen);
    const x = this.x(this.clock.t);
    if (x < LEFT - 1 || x > this.width - RIGHT + 1) return;
    pen.strokeStyle = this.theme.ink;
    pen.lineWidth = 2;
    pen.stroke(new Path2D(`M${x} ${RIBBON.top}V${this.depthTop + this.depthHeight}`));
    pen.fillStyle = this.theme.ink;
    pen.fill(new Path2D(`M${x - 6} ${RIBBON.top - 4}h12l-6 8Z`));
  }

  drawStill() {
    this.stale = false;
    this.ratio = this.canvas.width / this.canvas.clientWidth;
    [this.still.width, this.still.height] = [this.canvas.width, this.canvas.height];
    this.width = this.canvas.clientWidth;
    const room = this.canvas.clientHeight - RIBBON.top - RIBBON.height - COMMENTS - AXIS - 22;
    this.forceTop = RIBBON.top + RIBBON.height + 14;
    this.forceHeight = room * 0.5;
    this.depthTop = this.forceTop + this.forceHeight + 8;
    this.depthHeight = room * 0.5;
    const pen = this.still.getContext('2d');
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.font = FONT;
    this.drawBands(pen);
    this.drawAxes(pen);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, 0, this.width - LEFT - RIGHT, this.canvas.clientHeight);
    pen.clip();
    this.drawRibbon(pen);
    this.drawEvents(pen);
    if (this.other) this.drawOther(pen);
    if (this.experts) this.drawExperts(pen);
    this.drawForce(pen, this.spans, 0, this.theme.ink);
    this.drawDepth(pen, this.attempt, 0, this.theme.ink);
    this.drawComments(pen);
    pen.restore();
  }

  drawBands(pen) {
    const layers = this.attempt.stage.layers.filter((layer) => layer.along_top_mm <= this.deepest);
    const bands = layers.map(({ name, texture, along_top_mm: from, along_bottom_mm: to }) => (
      { name, texture, top: this.depth(from), bottom: this.depth(Math.min(to, this.deepest)) }
    ));
    bands.forEach(({ texture, top, bottom }) => {
      pen.fillStyle = textureColour(this.theme, texture);
      pen.fillRect(LEFT, top, this.width - LEFT - RIGHT, bottom - top);
    });
    // Over all of them, since a thin layer's name reaches into the next. One that would lie on another is left out.
    let last = -Infinity;
    pen.fillStyle = this.theme.ink;
    pen.textAlign = 'right';
    bands.forEach(({ name, top, bottom }) => {
      if (bottom - top < 4 || (top + bottom) / 2 < last + 13) return;
      last = (top + bottom) / 2;
      pen.fillText(name, this.width - RIGHT - 5, last + 4);
    });
    const y = this.depth(this.attempt.stage.target_depth_mm);
    pen.strokeStyle = this.theme.good;
    pen.setLineDash([7, 4]);
    pen.stroke(new Path2D(`M${LEFT} ${y}H${this.width - RIGHT}`));
    pen.setLineDash([]);
    pen.fillStyle = this.theme.good;
    pen.textAlign = 'left';
    pen.fillText(this.words.target, LEFT + 5, y - 4);
  }

  drawAxes(pen) {
    const right = this.width - RIGHT;
    const bottom = this.depthTop + this.depthHeight;
    const grid = (path, x, y, text, align) => {
      pen.strokeStyle = this.theme.line;
      pen.lineWidth = 1;
      pen.stroke(new Path2D(path));
      pen.fillStyle = this.theme.muted;
      pen.textAlign = align;
      pen.fillText(text, x, y);
    };
    ticks(this.low, this.high, 4).forEach(([n, text]) => grid(`M${LEFT} ${this.force(n)}H${right}`, LEFT - 5, this.force(n) + 4, text, 'right'));
    ticks(0, this.deepest, 4).forEach(([mm, text]) => grid(`M${LEFT} ${this.depth(mm)}H${right}`, LEFT - 5, this.depth(mm) + 4, text, 'right'));
    const most = Math.max(2, Math.floor(this.width / 90));
    ticks(this.from, this.to, most).forEach(([t, text]) => grid(`M${this.x(t)} ${bottom}v5`, this.x(t), bottom + COMMENTS + 16, text, 'center'));
    pen.textAlign = 'right';
    pen.fillText(this.words.time, right, bottom + COMMENTS + 31);
    [[this.words.force, this.forceTop, this.forceHeight], [this.words.depth, this.depthTop, this.depthHeight]].forEach(([text, top, height]) => {
      pen.save();
      pen.translate(12, top + height / 2);
      pen.rotate(-Math.PI / 2);
      pen.textAlign = 'center';
      pen.fillText(text, 0, 0);
      pen.restore();
    });
  }

  // In which layer the tip was, above the force.
  drawRibbon(pen) {
    const { frames } = this.attempt;
    if (!frames?.count) return;
    const layerAt = (px) => this.attempt.layerAt(frames.value(frames.before(this.time(px)), 'depth_mm'));
    let start = LEFT;
    let layer = layerAt(LEFT);
    for (let px = LEFT + 1; px <= this.width - RIGHT; px += 1) {
      const next = layerAt(px);
      if (next !== layer || px === this.width - RIGHT) {
        pen.fillStyle = layer ? textureColour(this.theme, layer.texture) : this.theme.surface;
        pen.fillRect(start, RIBBON.top, px - start, RIBBON.height);
        pen.fillStyle = this.theme.ink;
        pen.textAlign = 'left';
        if (layer && pen.measureText(layer.name).width + 6 < px - start) pen.fillText(layer.name, start + 3, RIBBON.top + 13);
        [start, layer] = [px, next];
      }
    }
  }

  // What is under the pointer, in words: the values there, an event, a comment.
  wordsAt(t) {
    const { frames } = this.attempt;
    if (!frames?.count) return [];
    const row = frames.at(t);
    const value = (name, digits, unit) => `${fixed(row[frames.index[name]], digits)} ${unit}`;
    const near = (at) => Math.abs(this.x(at) - this.x(t)) < 7;
    const events = this.attempt.stage.events.filter((event) => near(event.t_s)).map((event) => event.words);
    const said = this.comments.filter((comment) => near(comment.from_s) || (t >= comment.from_s && t <= (comment.to_s ?? -1)));
    const layer = this.attempt.layerAt(row[frames.index.depth_mm]);
    return [`${fixed(t, 2)} s${layer ? ` · ${layer.name}` : ''}`, `${value('force_n', 2, 'N')} · ${value('advance_mm', 1, 'mm')}`,
      ...new Set(events), ...said.map((comment) => `${COMMENT_SIGNS[comment.kind]} ${comment.who}: ${comment.said}`)]
      .filter(Boolean).map((line) => (line.length > 48 ? `${line.slice(0, 47)}…` : line));
  }

  drawHover(pen) {
    if (this.hover === null) return;
    const lines = this.wordsAt(this.hover);
    if (lines.length === 0) return;
    const x = this.x(this.hover);
    pen.strokeStyle = this.theme.muted;
    pen.lineWidth = 1;
    pen.stroke(new Path2D(`M${x} ${this.forceTop}V${this.depthTop + this.depthHeight}`));
    pen.font = FONT;
    const width = Math.max(...lines.map((line) => pen.measureText(line).width)) + 16;
    const height = lines.length * 16 + 8;
    const left = x + 10 + width > this.width ? Math.max(x - 10 - width, 0) : x + 10;
    const top = this.forceTop + 6;
    pen.fillStyle = this.theme.surface;
    pen.strokeStyle = this.theme['strong-line'];
    pen.fillRect(left, top, width, height);
    pen.strokeRect(left, top, width, height);
    pen.fillStyle = this.theme.ink;
    pen.textAlign = 'left';
    lines.forEach((line, i) => pen.fillText(line, left + 8, top + 16 + i * 16));
  }

  // The words of an event beside its sign, where the next one leaves room; pointing at a sign, and the list below, say the others.
  drawEventWords(pen) {
    const shown = this.attempt.stage.events.filter((event) => EVENT_MARKS[event.kind]);
    let free = LEFT;
    shown.forEach((event, i) => {
      const x = this.x(event.t_s) + 9;
      const next = i + 1 < shown.length ? this.x(shown[i + 1].t_s) - 9 : this.width - RIGHT;
      if (x < free || x + pen.measureText(event.words).width > next) return;
      pen.fillStyle = this.theme.ink;
      pen.textAlign = 'left';
      pen.fillText(event.words, x, this.forceTop - 1);
      free = next;
    });
  }

  drawEvents(pen) {
    this.drawEventWords(pen);
    this.attempt.stage.events.forEach((event) => {
      const x = this.x(event.t_s);
      if (x < LEFT - 8 || x > this.width) return;
      pen.strokeStyle = this.theme['strong-line'];
      pen.lineWidth = 1;
      pen.setLineDash([1, 3]);
      pen.stroke(new Path2D(`M${x} ${this.forceTop}V${this.depthTop + this.depthHeight}`));
      pen.setLineDash([]);
      const mark = EVENT_MARKS[event.kind];
      if (!mark) return;
      pen.fillStyle = this.theme[EVENT_COLOURS[event.kind]];
      pen.strokeStyle = pen.fillStyle;
      pen.lineWidth = 2;
      mark(pen, x, this.forceTop - 5);
      mark(pen, x, this.depth(event.advance_mm));
    });
  }

  drawForce(pen, spans, shift, colour) {
    const band = new Path2D();
    spans.forEach((span, i) => {
      const x = this.x(span.t_s - shift);
      if (i === 0) band.moveTo(x, this.force(span.force_max_n));
      band.lineTo(x, this.force(span.force_max_n));
      band.lineTo(x, this.force(span.force_min_n));
    });
    pen.strokeStyle = colour;
    pen.lineWidth = 1.3;
    pen.stroke(band);
  }

  drawDepth(pen, attempt, shift, colour, stretched = (mm) => mm) {
    const { frames } = attempt;
    if (!frames?.count) return;
    const path = new Path2D();
    const first = Math.max(frames.before(this.from + shift) - 1, 0);
    const last = Math.min(frames.before(this.to + shift) + 1, frames.count - 1);
    const stride = Math.max(1, Math.floor((last - first) / (2 * this.width)));
    for (let row = first; row <= last; row += stride) {
      path.lineTo(this.x(frames.time(row) - shift), this.depth(Math.max(stretched(frames.value(row, 'advance_mm')), -4)));
    }
    pen.strokeStyle = colour;
    pen.lineWidth = 1.5;
    pen.stroke(path);
  }

  // Another attempt, dashed: together with this one at each layer.
  drawOther(pen) {
    const { attempt, alignment } = this.other;
    alignment.stretches().forEach(({ from, to, shift }) => {
      pen.save();
      pen.beginPath();
      pen.rect(this.x(from - shift), 0, this.x(to - shift) - this.x(from - shift), this.canvas.clientHeight);
      pen.clip();
      pen.setLineDash([6, 4]);
      const spans = attempt.spans.filter((span) => span.t_s >= from - 0.2 && span.t_s <= to + 0.2);
      this.drawForce(pen, spans, shift, this.theme['part-4']);
      this.drawDepth(pen, attempt, shift, this.theme['part-4'], (mm) => alignment.depth(mm));
      pen.restore();
    });
  }

  // The experts' median, dashed: together with this attempt at each layer.
  drawExperts(pen) {
    pen.setLineDash([6, 4]);
    pen.strokeStyle = this.theme['part-4'];
    pen.lineWidth = 1.5;
    this.experts.lines().forEach((places) => {
      const [force, depth] = [new Path2D(), new Path2D()];
      places.forEach(([t, advance, newtons]) => {
        force.lineTo(this.x(t), this.force(newtons));
        depth.lineTo(this.x(t), this.depth(advance));
      });
      pen.stroke(force);
      pen.stroke(depth);
    });
    pen.setLineDash([]);
  }

  drawComments(pen) {
    const y = this.depthTop + this.depthHeight + 6;
    this.comments.forEach((comment) => {
      const x = this.x(comment.from_s);
      const end = Math.max(this.x(comment.to_s ?? comment.from_s), x);
      pen.fillStyle = this.theme[{ praise: 'good', error: 'bad', question: 'warn' }[comment.kind] || 'lead'];
      if (end > x + 1) pen.fillRect(x, y + 6, end - x, 4);
      pen.beginPath();
      pen.arc(x, y + 8, 8, 0, 2 * Math.PI);
      pen.fill();
      pen.fillStyle = this.theme.surface;
      pen.textAlign = 'center';
      pen.fillText(COMMENT_SIGNS[comment.kind] || 'T', x, y + 12);
    });
  }
}
