// The body cut open along the needle: layers as bands, boundaries with their tents, structures, the needle.

import { Mesh, PLAIN, Painter, add, cross, dot, facing, lookAt, normalOf, project, scale, unit } from './replay-gl.js';
import { drawBlood, drawDrops, drawHub, hubOf } from './replay-hub.js';
import { FONT, fit, readTheme, rgb, textureColour } from './replay-theme.js';

// Half the width of the block of tissue, and how far a tent reaches sideways, in mm. Where the boundaries stand beside the needle is told by
// the service, which settles them as the simulator's own picture does.
const HALF_WIDTH = 34;
const TENT_REACH = 7;
const STEPS = 48;
// Ways to look: how far around and above, in radians, and how far away beside the block's size.
// The cut follows the needle when its tip is this close to the skin, and no farther than this from the plan, in mm.
const NEAR = 12;
const FOLLOWS = 30;
// So far aside, in radii, a layer goes straight on, as in the simulator's own picture.
const TURNED = 0.75;
const VIEWS = {
  whole: { turn: 0.32, rise: 0.24, distance: 1.75 },
  side: { turn: 0, rise: 0.04, distance: 1.65 },
  tip: { turn: 0.18, rise: 0.12, distance: 0.6 },
  patient: { turn: 0.5, rise: 0.78, distance: 1 },
};
// The angle of view, in radians, and half the height that the view of the patient shows, in mm, as in the simulator's own picture.
const ANGLE = 0.62;
const PATIENT = 165;
// How far the patient is faded with the tip at the target, as in the simulator's own picture, and from where on names are written inside.
const FADED = 0.8;
const NAMED = 0.3;
// A surface of so many triangles is round; one of fewer has edges.
const ROUND = 100;

export class Scene {
  constructor(canvas, labels, attempt) {
    this.canvas = canvas;
    this.labels = labels;
    this.attempt = attempt;
    this.painter = new Painter(canvas);
    this.moving = { solid: new Mesh(), lines: new Mesh(), ghost: new Mesh(), blood: new Mesh(), clear: new Mesh() };
    this.other = null;
    this.experts = null;
    this.still = { solid: new Mesh(), glass: new Mesh(), patient: new Mesh() };
    this.measure();
    this.look('whole');
    this.readTheme();
    this.turnByHand();
  }

  // The plane of the cut: through the planned entry, along the way the needle leans.
  measure() {
    const { entry_mm: entry, target_mm: target, layers, target_depth_mm: depth } = this.attempt.stage;
    const lean = [target[0] - entry[0], target[1] - entry[1], 0];
    this.entry = entry;
    this.along = Math.hypot(...lean) > 0.5 ? unit(lean) : [1, 0, 0];
    this.away = cross([0, 0, 1], this.along);
    this.cut = { off: 0, slope: 0 };
    const deepest = layers.length ? layers[layers.length - 1].bottom_mm : 40;
    this.bottom = Math.min(deepest, Math.max(depth * 1.5, 25));
    this.centres = this.attempt.stage.structures.map(({ vertices_mm: corners }) => {
      const sum = (axis) => corners.reduce((total, value, i) => (i % 3 === axis ? total + value : total), 0);
      return corners.length ? scale([sum(0), sum(1), sum(2)], 3 / corners.length) : null;
    });
  }

  readTheme() {
    const theme = readTheme();
    this.theme = theme;
    this.colours = this.attempt.stage.layers.map((layer) => rgb(textureColour(theme, layer.texture)));
    Object.values(this.still).forEach((mesh) => mesh.clear());
    this.drawStructures();
    if (this.hasPatient) this.drawSurface(this.still.patient, this.attempt.stage.skin, rgb(theme.skin), 1);
  }

  get hasPatient() {
    return Boolean(this.attempt.stage.skin);
  }

  // Whether the whole patient is shown and not the block cut open.
  get isClosed() {
    return this.hasPatient && this.view === 'patient';
  }

  // How far the patient is faded: as far as the needle has come.
  get faded() {
    return FADED * Math.min(Math.max(this.advance / this.attempt.stage.target_depth_mm, 0), 1);
  }

  look(view) {
    this.view = view;
    ({ turn: this.turn, rise: this.rise, distance: this.distance } = VIEWS[view]);
  }

  // Dragging turns the picture; the buttons beside it bring it back.
  turnByHand() {
    this.labels.addEventListener('pointerdown', (down) => {
      this.labels.setPointerCapture(down.pointerId);
      const start = { x: down.clientX, y: down.clientY, turn: this.turn, rise: this.rise };
      const move = (at) => {
        this.turn = Math.min(Math.max(start.turn + (start.x - at.clientX) * 0.006, -1.3), 1.3);
        this.rise = Math.min(Math.max(start.rise + (at.clientY - start.y) * 0.005, -0.2), 1.2);
        this.onTurn?.();
      };
      this.labels.addEventListener('pointermove', move);
      const end = () => this.labels.removeEventListener('pointermove', move);
      this.labels.addEventListener('pointerup', end, { once: true });
      this.labels.addEventListener('pointercancel', end, { once: true });
    });
  }

  // A place by its way along the cut, behind it, and down, in mm. The cut leans with the needle, which so lies in it.
  place(across, behind, down) {
    const away = behind + this.cut.off + this.cut.slope * down;
    const [x, y] = add(add(this.entry, scale(this.along, across)), scale(this.away, away));
    return [x, y, this.height([x, y], down)];
  }

  // How high a place so far below the skin lies, in mm: layers are concentric with a skin that bends, as far as a picture goes and down to the
  // table that the block lies on.
  height([x, y], down) {
    const { bend } = this.attempt.stage;
    if (!bend) return this.entry[2] - down;
    const along = bend.line ? x * bend.line[0] + y * bend.line[1] : 0;
    const radius = bend.radius_mm - down;
    const aside = Math.sqrt(Math.max(x ** 2 + y ** 2 - along ** 2, 0));
    const round = Math.min(aside, TURNED * radius);
    const up = Math.sqrt(radius ** 2 - round ** 2);
    return Math.max(up - bend.radius_mm - ((aside - round) * round) / up, this.entry[2] - this.bottom);
  }

  // What the picture shows of a frame: where the needle is, and how far each boundary is pressed in.
  read(row) {
    const index = this.attempt.frames.index;
    const at = (name) => row[index[name]];
    this.tip = [at('x_mm'), at('y_mm'), at('z_mm')];
    this.axis = [at('axis_x'), at('axis_y'), at('axis_z')];
    this.advance = at('advance_mm');
    const count = this.attempt.frames.boundaries;
    this.tents = this.attempt.stage.layers.map((_, i) => (i < count ? row[index[`tent_${i}_mm`]] : 0));
    this.hub = { open: at('hub_open') > 0.5, blood: at('hub_blood'), plunger: at('plunger'), drop: at('drop'), fallen: at('fallen_mm') };
    this.blood = this.attempt.stage.entries_mm.map((_, i) => at(`blood_${i}`));
    this.cut = this.cutAlong();
    this.crossing = this.crossings();
  }

  // Where the needle's line is at a depth below the skin: across, and away from the planned entry, in mm.
  line(down) {
    const at = (height) => add(this.tip, scale(this.axis, (height - this.tip[2]) / this.axis[2]));
    let met = at(this.entry[2] - down);
    for (let k = 0; k < 4; k += 1) met = at(this.height(met, down));
    const from = add(met, scale(this.entry, -1));
    return [dot(from, this.along), dot(from, this.away)];
  }

  // How far the cut is off the planned entry, and how it leans: through the needle where that is in the tissue.
  cutAlong() {
    if (Math.abs(this.axis[2]) < 0.1) return { off: 0, slope: 0 };
    const near = Math.min(Math.max(1 - (this.tip[2] - this.height(this.tip, 0)) / NEAR, 0), 1);
    const off = Math.min(Math.max(this.line(0)[1], -FOLLOWS), FOLLOWS);
    return { off: near * off, slope: (near * dot(this.axis, this.away)) / -this.axis[2] };
  }

  // Where the needle's line meets each boundary: across, and behind the cut, in mm.
  crossings() {
    return this.attempt.stage.layers.map((layer) => {
      if (Math.abs(this.axis[2]) < 0.1) return null;
      const [across, away] = this.line(layer.top_mm);
      return [across, away - this.cut.off - this.cut.slope * layer.top_mm];
    });
  }

  // A point of a boundary, displaced along the needle by its tent.
  point(index, across, behind, down) {
    const rest = this.place(across, behind, down);
    const crossing = this.crossing[index];
    if (!crossing || !this.tents[index]) return rest;
    const squared = (across - crossing[0]) ** 2 + (behind - crossing[1]) ** 2;
    return add(rest, scale(this.axis, this.tents[index] / (1 + squared / TENT_REACH ** 2)));
  }

  draw(t) {
    if (!this.attempt.frames?.count || this.canvas.clientWidth === 0) return;
    fit(this.canvas);
    this.read(this.attempt.frames.at(t));
    Object.values(this.moving).forEach((mesh) => mesh.clear());
    if (!this.isClosed) {
      this.drawLayers();
      this.drawSkin();
    }
    this.drawPlan();
    this.drawNeedle(this.moving.solid, this, this.attempt.stage.needle, rgb(this.theme.ink).map((part) => part * 0.55 + 0.3), 1);
    this.drawHub();
    this.drawWounds();
    this.drawGhost(t);
    const camera = this.camera();
    this.painter.begin(camera, rgb(this.theme.sunken));
    [this.moving.solid, this.still.solid].forEach((mesh) => this.painter.draw(mesh));
    this.painter.draw(this.moving.lines, 'LINES');
    this.painter.draw(this.still.glass, 'TRIANGLES', false);
    if (this.isClosed) this.painter.drawDraped(this.still.patient, 1 - this.faded, this.entry, this.along);
    this.painter.draw(this.moving.blood);
    this.painter.draw(this.moving.clear, 'TRIANGLES', false);
    this.painter.draw(this.moving.ghost, 'TRIANGLES', false);
    this.drawLabels(camera);
  }

  camera() {
    const aspect = this.canvas.width / this.canvas.height;
    const patient = (PATIENT * Math.max(1.6 / aspect, 1)) / Math.tan(ANGLE / 2);
    const size = this.isClosed ? patient : Math.max(HALF_WIDTH + this.bottom * 0.7, this.bottom * 1.5);
    const closest = this.view === 'tip' ? this.tip : this.place(0, 0, this.isClosed ? 0 : this.bottom * 0.22);
    const flat = add(scale(this.away, -Math.cos(this.turn)), scale(this.along, Math.sin(this.turn)));
    const towards = add(scale(flat, Math.cos(this.rise)), [0, 0, Math.sin(this.rise)]);
    const eye = add(closest, scale(towards, size * this.distance));
    return lookAt(eye, closest, { aspect, angle: ANGLE });
  }

  drawLayers() {
    const layers = this.attempt.stage.layers;
    const ink = rgb(this.theme['strong-line']);
    const nearer = scale(this.away, -0.06);
    layers.forEach((layer, i) => {
      if (layer.top_mm >= this.bottom) return;
      const bottom = Math.min(layer.bottom_mm, this.bottom);
      let [a, d] = [this.point(i, -HALF_WIDTH, 0, layer.top_mm), this.point(i + 1, -HALF_WIDTH, 0, bottom)];
      for (const right of this.columns(i)) {
        const [b, c] = [this.point(i, right, 0, layer.top_mm), this.point(i + 1, right, 0, bottom)];
        this.moving.solid.quad(a, b, c, d, PLAIN, this.colours[i]);
        this.moving.lines.line(add(a, nearer), add(b, nearer), ink);
        [a, d] = [b, c];
      }
      const end = (behind, down) => this.place(HALF_WIDTH, behind, down);
      const [top, deep] = [layer.top_mm, bottom];
      this.moving.solid.quad(end(0, top), end(HALF_WIDTH, top), end(HALF_WIDTH, deep), end(0, deep), this.along, this.colours[i]);
    });
  }

  // How far along the cut a layer has corners, from its left end on: at even steps, and where the needle meets its boundaries, so that a tent
  // ends at the tip and not beside it.
  columns(index) {
    const even = Array.from({ length: STEPS }, (_, k) => -HALF_WIDTH + ((k + 1) * 2 * HALF_WIDTH) / STEPS);
    const needle = [index, index + 1].map((i) => this.crossing[i]?.[0] ?? 0).filter((across) => Math.abs(across) < HALF_WIDTH);
    return [...even, ...needle].sort((a, b) => a - b);
  }

  // The skin behind the cut, pressed in around the needle.
  drawSkin() {
    if (this.colours.length === 0) return;
    const step = (2 * HALF_WIDTH) / STEPS;
    const row = (across) => Array.from({ length: STEPS / 4 + 1 }, (_, k) => this.point(0, across, k * step * 2, 0));
    let left = row(-HALF_WIDTH);
    for (const across of this.columns(0)) {
      const right = row(across);
      for (let k = 0; k < STEPS / 4; k += 1) {
        const [a, b, c, d] = [left[k], right[k], right[k + 1], left[k + 1]];
        const normal = unit(normalOf(a, b, d));
        this.moving.solid.quad(a, b, c, d, normal, this.colours[0]);
      }
      left = right;
    }
  }

  drawStructures() {
    this.attempt.stage.structures.forEach((structure) => {
      const colour = rgb(this.theme[structure.kind === 'target' ? 'good' : structure.kind] || this.theme.muted);
      const bone = structure.kind === 'bone';
      this.drawSurface(bone ? this.still.solid : this.still.glass, structure, colour, bone ? 1 : 0.42);
    });
  }

  drawSurface(mesh, { vertices_mm: numbers, triangles }, colour, alpha) {
    const corners = Array.from({ length: numbers.length / 3 }, (_, i) => numbers.slice(3 * i, 3 * i + 3));
    const round = triangles.length >= 3 * ROUND ? facing(corners, triangles) : null;
    for (let i = 0; i + 2 < triangles.length; i += 3) {
      const three = triangles.slice(i, i + 3);
      const [a, b, c] = three.map((corner) => corners[corner]);
      const flat = round ? null : unit(normalOf(a, b, c));
      three.forEach((corner, k) => mesh.vertex([a, b, c][k], round ? round[corner] : flat, colour, alpha));
    }
  }

  // The way that was planned, on the cut: a dashed line with a cross at its end.
  drawPlan() {
    const good = rgb(this.theme.good);
    const way = add(this.attempt.stage.target_mm, scale(this.entry, -1));
    const onCut = (share) => {
      const [x, y] = this.place(share * dot(way, this.along), -0.3, -share * way[2]);
      return [x, y, this.entry[2] + share * way[2]];
    };
    for (let k = 0; k < 12; k += 1) this.moving.lines.line(onCut(k / 12), onCut((k + 0.55) / 12), good);
    const target = onCut(1);
    [this.along, [0, 0, 1]].forEach((direction) => this.moving.lines.line(
      add(target, scale(direction, 2.2)), add(target, scale(direction, -2.2)), good,
    ));
  }

  // The needle of another attempt where it was in this one's layers, beside this one.
  drawGhost(t) {
    const median = this.experts?.pose(t);
    if (median) this.drawNeedle(this.moving.ghost, median, this.attempt.stage.needle, rgb(this.theme['part-4']), 0.55);
    if (!this.other?.attempt.frames?.count) return;
    const { attempt, alignment } = this.other;
    const row = attempt.frames.at(alignment.beside(t));
    const at = (name) => row[attempt.frames.index[name]];
    const axis = [at('axis_x'), at('axis_y'), at('axis_z')];
    const deeper = alignment.depth(at('advance_mm')) - at('advance_mm');
    const tip = add([at('x_mm'), at('y_mm'), at('z_mm')], scale(axis, deeper));
    this.drawNeedle(this.moving.ghost, { tip, axis }, attempt.stage.needle, rgb(this.theme['part-4']), 0.55);
  }

  // Where the needle is seen: in front of the cut by its own radius, so that it is seen where it is inside.
  get inFront() {
    return scale(this.away, -this.attempt.stage.needle.diameter_mm / 2 - 0.2);
  }

  drawHub() {
    const pose = { tip: add(this.tip, this.inFront), axis: this.axis };
    const { needle } = this.attempt.stage;
    drawHub(this.moving, pose, needle, this.hub);
    drawDrops(this.moving.solid, pose, needle, this.hub, this.along);
  }

  // Blood on the skin: of the block, as far as there is skin behind the cut, or of the patient.
  drawWounds() {
    this.attempt.stage.entries_mm.forEach((entry, i) => {
      const off = add(entry, scale(this.entry, -1));
      const skin = (x, y) => {
        const from = add(off, [x, y, 0]);
        // Over a skin that is not flat.
        if (this.isClosed) return add(add(this.entry, from), [0, 0, 0.8 + 0.06 * Math.hypot(x, y)]);
        const behind = Math.max(dot(from, this.away) - this.cut.off, -0.05);
        return add(this.point(0, dot(from, this.along), behind, 0), [0, 0, 0.15]);
      };
      drawBlood(this.moving.blood, skin, this.blood[i], this.attempt.stage.needle.diameter_mm / 2);
    });
  }

  // As far as its hub.
  drawNeedle(mesh, { tip, axis }, needle, steel, alpha) {
    const { diameter_mm: diameter, tip_to_rim_mm: rim } = needle;
    const length = hubOf(needle).begins;
    const stylet = alpha < 1 ? steel : rgb(this.theme.lead);
    const near = this.inFront;
    const at = (back, radius, angle, u, v) => add(add(add(tip, scale(axis, -back)), near),
      add(scale(u, radius * Math.cos(angle)), scale(v, radius * Math.sin(angle))));
    const u = unit(cross(axis, [0.3, 0.9, 0.2]));
    const v = cross(axis, u);
    const taper = Math.min(rim > 0 ? rim : diameter * 1.5, 6);
    const parts = [[0, 0.02, taper, diameter * 0.42, stylet], [taper, diameter / 2, Math.max(length, taper + 1), diameter / 2, steel]];
    parts.forEach(([from, thin, to, thick, colour]) => {
      for (let k = 0; k < 12; k += 1) {
        const [a, b] = [(k * Math.PI) / 6, ((k + 1) * Math.PI) / 6];
        const normal = add(scale(u, Math.cos((a + b) / 2)), scale(v, Math.sin((a + b) / 2)));
        mesh.quad(at(from, thin, a, u, v), at(from, thin, b, u, v), at(to, thick, b, u, v), at(to, thick, a, u, v), normal, colour, alpha);
      }
    });
  }

  // Names beside the bands and the structures, on a canvas of their own.
  drawLabels(camera) {
    fit(this.labels);
    const pen = this.labels.getContext('2d');
    const ratio = this.labels.width / this.labels.clientWidth;
    const [width, height] = [this.labels.clientWidth, this.labels.clientHeight];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = FONT;
    const write = (text, place, dx) => {
      const at = project(camera, place, width, height);
      if (!at) return;
      pen.lineWidth = 3;
      pen.strokeStyle = this.theme.sunken;
      pen.fillStyle = this.theme.ink;
      const x = Math.min(Math.max(at[0] + dx, 4), width - pen.measureText(text).width - 4);
      pen.strokeText(text, x, at[1] + 4);
      pen.fillText(text, x, at[1] + 4);
    };
    let last = -Infinity;
    const bands = this.isClosed ? [] : this.attempt.stage.layers;
    bands.forEach((layer) => {
      const place = this.place(-HALF_WIDTH, 0, (layer.top_mm + Math.min(layer.bottom_mm, this.bottom)) / 2);
      const at = project(camera, place, width, height);
      if (layer.top_mm >= this.bottom || !at || at[1] < last + 13) return;
      last = at[1];
      write(layer.name, place, 6);
    });
    write(this.attempt.names.target ?? 'target', this.attempt.stage.target_mm, 8);
    // A name that would lie on another is left out; on a whole patient all of them lie close together.
    const taken = [project(camera, this.attempt.stage.target_mm, width, height)];
    const isFree = (at) => taken.every((other) => !other || Math.abs(other[0] - at[0]) > 90 || Math.abs(other[1] - at[1]) > 13);
    this.attempt.stage.structures.forEach((structure, i) => {
      const at = this.centres[i] && project(camera, this.centres[i], width, height);
      if (!at || !isFree(at) || (this.isClosed && this.faded <= NAMED)) return;
      taken.push(at);
      write(structure.name, this.centres[i], 8);
    });
  }
}
