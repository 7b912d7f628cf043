// What a replay draws, fetched from the service: the stage, the frames, and spans of force at the scale on the screen.

async function get(address) {
  const answer = await fetch(address, { credentials: 'same-origin' });
  if (!answer.ok) {
    throw new Error(`${address}: ${answer.status}`);
  }
  return answer;
}

// Rows at even times; between two of them a value is interpolated.
export class Frames {
  constructor(columns, numbers) {
    this.width = columns.length;
    this.numbers = numbers;
    this.count = Math.floor(numbers.length / this.width);
    this.index = Object.fromEntries(columns.map((name, place) => [name, place]));
    this.boundaries = columns.filter((name) => name.startsWith('tent_')).length;
    this.row = new Float32Array(this.width);
  }

  time(row) {
    return this.numbers[row * this.width];
  }

  value(row, name) {
    return this.numbers[row * this.width + this.index[name]];
  }

  // The last row at or before a time.
  before(t) {
    let low = 0;
    let high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time(middle) <= t) low = middle; else high = middle - 1;
    }
    return low;
  }

  // Everything at a time, in one row that is used again by the next call.
  at(t) {
    const low = this.before(t);
    const high = Math.min(low + 1, this.count - 1);
    const span = this.time(high) - this.time(low);
    const share = span > 0 ? Math.min(Math.max((t - this.time(low)) / span, 0), 1) : 0;
    for (let i = 0; i < this.width; i += 1) {
      const a = this.numbers[low * this.width + i];
      this.row[i] = a + share * (this.numbers[high * this.width + i] - a);
    }
    return this.row;
  }
}

// An attempt in the browser.
export class Attempt {
  // Names, where the reader's language has others than the scene, by the scene's.
  constructor(address, stage, names) {
    this.address = address;
    this.names = names;
    this.stage = stage;
    // Events name a layer as its scene does, which is kept as the key.
    [...stage.layers, ...stage.structures].forEach((thing) => {
      thing.key = thing.name;
      thing.name = names[thing.name] ?? thing.name;
    });
    this.frames = null;
    this.spans = [];
  }

  static async open(address, names) {
    const [stage, series] = await Promise.all([
      get(`${address}/replay`).then((answer) => answer.json()),
      get(`${address}/series?points=1500`).then((answer) => answer.json()),
    ]);
    const attempt = new Attempt(address, stage, names);
    attempt.spans = series.spans;
    return attempt;
  }

  async loadFrames() {
    const answer = await get(`${this.address}/replay/frames`);
    this.frames = new Frames(this.stage.columns, new Float32Array(await answer.arrayBuffer()));
  }

  // Spans of a stretch at the scale of the screen.
  async stretch(fromS, toS, points) {
    const query = `points=${points}&from_s=${fromS.toFixed(4)}&to_s=${toS.toFixed(4)}`;
    const answer = await get(`${this.address}/series?${query}`);
    return (await answer.json()).spans;
  }

  // The layer that holds a depth along the needle, or none above the skin.
  layerAt(depth) {
    if (!(depth > 0)) return null;
    const layers = this.stage.layers;
    // A tip that tents the next boundary is at this one's end, but for what a frame's short numbers lose.
    return layers.find((layer) => depth <= layer.along_bottom_mm + 0.02) || layers[layers.length - 1] || null;
  }
}
