// What is at the needle's hub and at its wounds: hub, knob or syringe, blood, and fluid that drips. How much of each is told by the service,
// which takes it from where the simulator's own picture does.

import { add, cross, scale, unit } from './replay-gl.js';

// Forms and colours as in the simulator's own picture, in mm.
const MOUTH = 0.53;
const BARREL = 7.2;
const NOZZLE = 8;
const LONG = 50;
const ROD = 26;
const TRAVEL = 18;
const DROP = 2.3;
const PLASTIC = [0.33, 0.6, 0.82];
const IVORY = [0.91, 0.91, 0.88];
const GLASS = [0.8, 0.9, 0.94];
const BLOOD = [0.55, 0.05, 0.05];
const WATER = [0.72, 0.86, 0.94];
const SIDES = 24;

// A needle's own place and directions in the picture; a place of it is so far behind the tip and off the axis.
class Axis {
  constructor(tip, axis) {
    this.tip = tip;
    this.axis = axis;
    this.u = unit(cross(axis, [0.3, 0.9, 0.2]));
    this.v = cross(axis, this.u);
  }

  out(angle) {
    return add(scale(this.u, Math.cos(angle)), scale(this.v, Math.sin(angle)));
  }

  at(back, radius, angle) {
    return add(add(this.tip, scale(this.axis, -back)), scale(this.out(angle), radius));
  }

  // A profile of [radius, back] turned around the needle.
  turn(mesh, profile, colour, alpha = 1) {
    profile.slice(1).forEach(([to, far], i) => {
      const [from, near] = profile[i];
      const flat = unit([far - near, to - from, 0]);
      for (let k = 0; k < SIDES; k += 1) {
        const [a, b] = [k, k + 1].map((side) => (2 * Math.PI * side) / SIDES);
        const normal = add(scale(this.out((a + b) / 2), flat[0]), scale(this.axis, flat[1]));
        mesh.quad(this.at(near, from, a), this.at(near, from, b), this.at(far, to, b), this.at(far, to, a), normal, colour, alpha);
      }
    });
  }
}

function mix(a, b, share) {
  return a.map((part, i) => part + share * (b[i] - part));
}

// How far behind the tip a needle's hub begins, which is the length of its shaft, and the room for it and the stylet's knob, in mm.
export function hubOf({ length_mm: begins }) {
  return { begins, room: 30 };
}

// Hub and what is on it: what hides and what is seen through, each into its mesh. `state` is what a frame says of it.
export function drawHub({ solid, clear }, { tip, axis }, needle, state) {
  const { begins, room } = hubOf(needle);
  const wide = Math.max(4.6, 1.1 * needle.diameter_mm);
  const needleAxis = new Axis(tip, axis);
  const form = (profile) => profile.map(([radius, share]) => [radius * wide, begins + share * room]);
  const chamber = form([[0.3, -0.1], [0.42, 0], [0.55, 0.12], [0.58, 0.34], [1, 0.4]]);
  needleAxis.turn(solid, chamber, mix(PLASTIC, BLOOD, 0.92 * state.blood));
  needleAxis.turn(solid, form([[1, 0.4], [1.55, 0.42], [1.55, 0.5], [0.9, MOUTH], [0, MOUTH]]), PLASTIC);
  if (!state.open && needle.hub === 'syringe') {
    drawSyringe({ solid, clear }, needleAxis, begins + MOUTH * room, state.plunger);
  } else if (!state.open) {
    needleAxis.turn(solid, form([[0.62, MOUTH], [0.66, 0.6], [0.98, 0.66], [1.1, 0.74], [1.1, 0.84], [0.98, 0.93], [0.7, 0.985], [0, 1]]), IVORY);
  }
}

// The loss of resistance is felt with it: its plunger yields then.
function drawSyringe({ solid, clear }, needleAxis, mouth, yielded) {
  const [end, head] = [NOZZLE + LONG, NOZZLE + 2 + TRAVEL * (1 - yielded)];
  const tail = NOZZLE + LONG + ROD - TRAVEL * yielded;
  const back = (profile) => profile.map(([radius, behind]) => [radius, mouth + behind]);
  const [wide, thin, thumb] = [0.93, 0.55, 1.35].map((share) => share * BARREL);
  needleAxis.turn(solid, back([[0, head], [wide, head], [wide, head + 7], [thin, head + 8], [thin, tail - 3], [thumb, tail - 2.5], [thumb, tail], [0, tail]]), IVORY);
  const barrel = [[2.4, 0], [2.8, 0.6 * NOZZLE], [BARREL, NOZZLE], [BARREL, end - 2], [1.7 * BARREL, end - 2], [1.7 * BARREL, end]];
  needleAxis.turn(clear, back(barrel), GLASS, 0.35);
}

// The drop that hangs at the hub's rim and the one that falls from it, beside the needle along `aside`.
export function drawDrops(mesh, { tip, axis }, needle, state, aside) {
  const { begins, room } = hubOf(needle);
  const wide = Math.max(4.6, 1.1 * needle.diameter_mm);
  const rim = add(add(tip, scale(axis, -(begins + 0.42 * room))), scale(aside, 1.5 * wide));
  const ball = (radius, down) => {
    const middle = new Axis(add(rim, [0, 0, -(radius + down)]), [0, 0, -1]);
    const around = Array.from({ length: 9 }, (_, i) => [radius * Math.sin((Math.PI * i) / 8), -radius * Math.cos((Math.PI * i) / 8)]);
    middle.turn(mesh, around, WATER);
  };
  if (state.drop > 0) ball(DROP * state.drop, 0);
  if (state.fallen > 0) ball(DROP, state.fallen);
}

// A pool around a hole and what trickles from it, on a skin that gives the place at so many mm along the picture's x and y from the hole. Amounts
// as in the simulator's own picture: 1 is as much as there can be.
export function drawBlood(mesh, skin, blood, radius) {
  if (blood <= 0) return;
  const edge = (angle) => {
    const ragged = 0.16 * Math.sin(3 * angle + 0.7) + 0.09 * Math.sin(5 * angle + 2.1);
    const far = radius + 5.2 * blood * (1 + ragged);
    return skin(far * Math.cos(angle), far * Math.sin(angle));
  };
  const up = [0, 0, 1];
  for (let k = 0; k < SIDES; k += 1) {
    const [a, b] = [k, k + 1].map((side) => (2 * Math.PI * side) / SIDES);
    mesh.triangle(skin(0, 0), edge(a), edge(b), up, BLOOD);
  }
  const [end, half] = [34 * blood * blood, 1.2 * (0.5 + blood)];
  const steps = 12;
  const side = (k, sign) => {
    const along = (end * k) / steps;
    const narrow = k === steps ? 0.4 : 1;
    return skin(-along, 1.3 * Math.sin(along * 0.21) + 0.22 * along + sign * half * narrow);
  };
  for (let k = 0; k < steps; k += 1) {
    mesh.quad(side(k, 1), side(k + 1, 1), side(k + 1, -1), side(k, -1), up, BLOOD);
  }
}
