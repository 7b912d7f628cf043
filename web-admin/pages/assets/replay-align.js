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
