// Another attempt beside this one: together at each layer, then each at its own pace. Where the other is through a layer before this one is, it
// waits at the next boundary. Layers of another thickness are stretched to those of this one.

// When the needle touched the skin, and when its tip came through each layer, from the skin down; none after the first that stayed closed.
function crossings(stage) {
  const first = (kind, name) => stage.events.find((event) => event.kind === kind && (!name || event.name === name))?.t_s;
  const times = [first('contact')];
  for (const layer of stage.layers) {
    if (times.at(-1) === undefined) break;
    times.push(first('tip_rupture', layer.key));
  }
  const end = times.indexOf(undefined);
  return end < 0 ? times : times.slice(0, end);
}

export class Alignment {
  constructor(attempt, other) {
    const [own, theirs] = [crossings(attempt.stage), crossings(other.stage)];
    const shared = Math.min(own.length, theirs.length);
    this.own = shared ? own.slice(0, shared) : [0];
    this.theirs = shared ? theirs.slice(0, shared) : [0];
    this.next = theirs[shared] ?? Infinity;
    this.end = other.stage.duration_s;
    this.edges = [attempt.stage, other.stage].map((stage) => stage.layers.flatMap((layer) => [layer.along_top_mm, layer.along_bottom_mm]));
  }

  // The time of the other that stands beside a time of this attempt.
  beside(t) {
    const at = this.own.findLastIndex((time) => time <= t);
    if (at < 0) return Math.max(this.theirs[0] + t - this.own[0], 0);
    return Math.min(this.theirs[at] + t - this.own[at], this.theirs[at + 1] ?? this.next, this.end);
  }

  // Stretches of the other, each with how much later it is than beside what it stands.
  stretches() {
    const made = [{ from: 0, to: this.theirs[0], shift: this.theirs[0] - this.own[0] }];
    this.theirs.forEach((from, i) => {
      const room = (this.own[i + 1] ?? Infinity) - this.own[i];
      made.push({ from, to: Math.min(this.theirs[i + 1] ?? this.next, from + room, this.end), shift: from - this.own[i] });
    });
    return made;
  }

  // A depth of the other in this one's layers, in mm.
  depth(mm) {
    const [own, theirs] = this.edges;
    if (!(mm > 0) || own.length !== theirs.length) return mm;
    const at = theirs.findIndex((edge) => edge >= mm);
    if (at < 1) return at < 0 ? mm + own.at(-1) - theirs.at(-1) : mm;
    const span = theirs[at] - theirs[at - 1];
    return own[at - 1] + (span > 0 ? (mm - theirs[at - 1]) / span : 1) * (own[at] - own[at - 1]);
  }
}

// The experts' median, which has a depth and a force and no other movement: together with this attempt at each layer, as the service made it.
export class ExpertGhost {
  constructor(attempt, stretches) {
    const { entry_mm: entry, target_mm: target } = attempt.stage;
    const way = target.map((part, i) => part - entry[i]);
    const length = Math.hypot(...way) || 1;
    this.entry = entry;
    this.axis = way.map((part) => part / length);
    this.stretches = stretches;
  }

  // Where the needle of the median is beside a time of this attempt; none before the first touch.
  pose(t) {
    const at = this.stretches.findLast((stretch) => stretch.from_s <= t);
    if (!at) return null;
    const after = t - at.from_s;
    const next = at.places.findIndex(([time]) => time >= after);
    const [to, from] = next < 0 ? [at.places.at(-1), at.places.at(-1)] : [at.places[next], at.places[Math.max(next - 1, 0)]];
    const share = to[0] > from[0] ? (after - from[0]) / (to[0] - from[0]) : 1;
    const advance = from[1] + share * (to[1] - from[1]);
    return { tip: this.entry.map((part, i) => part + advance * this.axis[i]), axis: this.axis };
  }

  // Stretches of time, advance and force as a plot draws them: each ends where this attempt comes to the next layer.
  lines() {
    return this.stretches.map(({ from_s: from, places }, i) => {
      const end = this.stretches[i + 1]?.from_s ?? Infinity;
      return places.map(([after, advance, force]) => [from + after, advance, force]).filter(([time]) => time <= end);
    });
  }
}
