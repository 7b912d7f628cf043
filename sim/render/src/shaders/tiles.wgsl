// The materials' tiles, generated once from noise: colour and openness; slope in x and y and
// roughness. They repeat without a seam.

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
}

@vertex
fn tile_vertex(@builtin(vertex_index) index: u32) -> Varying {
    let ndc = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return Varying(vec4f(ndc, 0.0, 1.0), ndc * 0.5 + 0.5);
}

// Wraps a cell's number in a periodic plane. Uses division of floats: software rendering divides
// integers one by one.
fn wrapped(cell: vec2f, period: vec2f) -> vec2i {
    return vec2i(cell - period * floor((cell + 0.5) / period));
}

// Value noise with a period along x and one along y, in 0..1.
fn periodic(at: vec2f, period: vec2i, seed: i32) -> f32 {
    let cell = floor(at);
    let f = at - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let low = wrapped(cell, vec2f(period)) + seed;
    let high = wrapped(cell + 1.0, vec2f(period)) + seed;
    let a = hash2(low).x;
    let b = hash2(vec2i(high.x, low.y)).x;
    let c = hash2(vec2i(low.x, high.y)).x;
    let d = hash2(high).x;
    return mix(mix(a, b, s.x), mix(c, d, s.x), s.y);
}

// Octaves of noise, in 0..1.
fn octaves(uv: vec2f, first: i32, count: i32) -> f32 {
    var total = 0.0;
    var weight = 0.5;
    var period = first;
    for (var i = 0; i < count; i++) {
        total += weight * periodic(uv * f32(period), vec2i(period), 0);
        weight *= 0.5;
        period *= 2;
    }
    return total;
}

// Stretched noise: long along x.
fn fibres(uv: vec2f, along: i32, across: i32) -> f32 {
    return periodic(uv * vec2f(f32(along), f32(across)), vec2i(along, across), 7);
}

// Cells around scattered points: distance to the nearest, additional distance to the second, and a
// random number of the cell.
fn cells(uv: vec2f, period: i32) -> vec3f {
    // Unknown to the compiler, so that it keeps the loop: unrolled everywhere, it takes seconds to
    // compile.
    let one = min(period, 1);
    let at = uv * f32(period);
    let cell = vec2i(floor(at));
    var nearest = 9.0;
    var second = 9.0;
    var own = 0.0;
    for (var y = -1; y <= one; y++) {
        for (var x = -1; x <= one; x++) {
            let other = cell + vec2i(x, y);
            let same = wrapped(vec2f(other), vec2f(f32(period)));
            let point = vec2f(other) + 0.15 + 0.7 * hash2(same + period);
            let far = distance(at, point);
            if far < nearest {
                second = nearest;
                nearest = far;
                own = hash2(same + 3 * period).y;
            } else {
                second = min(second, far);
            }
        }
    }
    return vec3f(nearest, second - nearest, own);
}

fn bent(uv: vec2f, by: f32) -> vec2f {
    return uv + by * (vec2f(octaves(uv, 5, 3), octaves(uv.yx + 0.5, 5, 3)) - 0.45);
}

struct Tile {
    colour: vec3f,
    height: f32,
    rough: f32,
}

fn skin(uv: vec2f) -> Tile {
    let lines = cells(bent(uv, 0.02), 46);
    let fine = cells(uv, 95);
    let pore = cells(uv + 0.31, 23);
    let hollow = smoothstep(0.15, 0.04, pore.x) * step(0.35, pore.z);
    let mottle = octaves(uv, 3, 4);
    let height = 0.55 * smoothstep(0.0, 0.35, lines.y) + 0.18 * smoothstep(0.0, 0.3, fine.y) - 0.8 * hollow;
    var colour = mix(vec3f(0.545, 0.295, 0.205), vec3f(0.605, 0.350, 0.250), smoothstep(0.25, 0.7, mottle));
    colour = mix(colour, vec3f(0.58, 0.250, 0.190), 0.30 * smoothstep(0.5, 0.75, octaves(uv + 0.7, 6, 3)));
    let freckle = cells(uv + 0.13, 9);
    colour *= 1.0 - 0.20 * smoothstep(0.12, 0.05, freckle.x) * step(0.8, freckle.z);
    colour *= 0.90 + 0.12 * height;
    return Tile(colour, height * 0.0045, 0.50 + 0.10 * mottle - 0.05 * height);
}

fn fat(uv: vec2f) -> Tile {
    let lobes = cells(bent(uv, 0.06), 9);
    let inner = cells(bent(uv + 0.2, 0.03), 26);
    let septum = smoothstep(0.13, 0.03, lobes.y);
    let dome = smoothstep(0.0, 0.55, lobes.y);
    let small = smoothstep(0.0, 0.4, inner.y);
    var colour = mix(vec3f(0.60, 0.345, 0.070), vec3f(0.74, 0.510, 0.165), 0.6 * lobes.z + 0.4 * inner.z);
    colour *= 0.86 + 0.14 * small;
    colour = mix(colour, vec3f(0.76, 0.60, 0.42), 0.75 * septum);
    let thread = smoothstep(0.030, 0.010, abs(octaves(bent(uv, 0.1), 4, 4) - 0.47));
    colour = mix(colour, vec3f(0.62, 0.14, 0.08), 0.45 * thread * septum);
    return Tile(colour, 0.020 * dome + 0.0022 * small, 0.28 + 0.16 * septum);
}

fn muscle(uv: vec2f) -> Tile {
    let wave = uv + vec2f(0.0, 0.020 * sin(6.2831853 * uv.x) + 0.025 * (octaves(uv, 3, 3) - 0.45));
    let bundle = fibres(wave, 3, 13);
    let strand = fibres(wave + 0.3, 5, 56);
    let fine = fibres(wave + 0.6, 9, 170);
    let edge = smoothstep(0.05, 0.008, abs(bundle - 0.5));
    var colour = mix(vec3f(0.125, 0.012, 0.012), vec3f(0.390, 0.080, 0.066), 0.35 * bundle + 0.40 * strand + 0.25 * fine);
    colour = mix(colour, vec3f(0.52, 0.27, 0.21), 0.55 * edge * smoothstep(0.25, 0.7, fine));
    let height = 0.010 * smoothstep(0.0, 0.3, abs(bundle - 0.5)) + 0.0045 * strand + 0.0016 * fine;
    return Tile(colour, height, 0.34 + 0.18 * fine);
}

fn fascia(uv: vec2f) -> Tile {
    let wave = uv + vec2f(0.0, 0.012 * sin(6.2831853 * uv.x * 2.0) + 0.02 * octaves(uv, 4, 2));
    let a = fibres(wave, 3, 60);
    let b = fibres(wave + 0.4, 5, 150);
    let cross_wise = fibres(wave.yx, 3, 30);
    var colour = mix(vec3f(0.48, 0.45, 0.40), vec3f(0.72, 0.70, 0.66), 0.5 * a + 0.3 * b + 0.2 * cross_wise);
    return Tile(colour, 0.004 * a + 0.0015 * b, 0.22 + 0.16 * a);
}

fn bone(uv: vec2f) -> Tile {
    let web = cells(bent(uv, 0.05), 20);
    let hole = smoothstep(0.15, 0.38, web.y);
    let colour = mix(vec3f(0.86, 0.80, 0.66), vec3f(0.50, 0.28, 0.19), 0.8 * hole);
    return Tile(colour * (0.9 + 0.2 * octaves(uv, 8, 3)), -0.012 * hole, 0.55);
}

fn fluid(uv: vec2f) -> Tile {
    return Tile(mix(vec3f(0.42, 0.58, 0.66), vec3f(0.50, 0.66, 0.72), octaves(uv, 4, 3)), 0.0, 0.12);
}

fn dermis(uv: vec2f) -> Tile {
    let fibre = fibres(bent(uv, 0.05), 14, 30);
    let knot = octaves(uv, 10, 4);
    let vessel = cells(uv + 0.2, 11);
    var colour = mix(vec3f(0.58, 0.31, 0.245), vec3f(0.72, 0.50, 0.42), 0.5 * fibre + 0.5 * knot);
    colour = mix(colour, vec3f(0.52, 0.07, 0.06), 0.8 * smoothstep(0.13, 0.07, vessel.x) * step(0.5, vessel.z));
    return Tile(colour, 0.004 * fibre + 0.004 * knot, 0.40);
}

struct Painted {
    // The square root of the colour, which eight bits represent more precisely; openness.
    @location(0) colour: vec4f,
    // Height in widths of the tile, roughness.
    @location(1) height: vec4f,
}

fn painted(here: Tile) -> Painted {
    let open = clamp(0.72 + 26.0 * here.height, 0.0, 1.0);
    return Painted(vec4f(sqrt(here.colour), open), vec4f(here.height, here.rough, 0.0, 1.0));
}

// Each material has its own entry point: software rendering would compute all of them at every
// texel.
@fragment
fn paint_skin(in: Varying) -> Painted {
    return painted(skin(in.uv));
}

@fragment
fn paint_fat(in: Varying) -> Painted {
    return painted(fat(in.uv));
}

@fragment
fn paint_muscle(in: Varying) -> Painted {
    return painted(muscle(in.uv));
}

@fragment
fn paint_fascia(in: Varying) -> Painted {
    return painted(fascia(in.uv));
}

@fragment
fn paint_bone(in: Varying) -> Painted {
    return painted(bone(in.uv));
}

@fragment
fn paint_fluid(in: Varying) -> Painted {
    return painted(fluid(in.uv));
}

@fragment
fn paint_dermis(in: Varying) -> Painted {
    return painted(dermis(in.uv));
}

@group(0) @binding(0) var heights: texture_2d<f32>;

@fragment
fn relief_fragment(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let size = vec2i(textureDimensions(heights));
    let texel = vec2i(at.xy);
    let here = textureLoad(heights, texel, 0);
    // Rows run down, the tile's y runs up.
    let right = textureLoad(heights, vec2i((texel.x + 1) % size.x, texel.y), 0).x;
    let up = textureLoad(heights, vec2i(texel.x, (texel.y + size.y - 1) % size.y), 0).x;
    let slope = clamp(vec2f(here.x - right, here.x - up) * f32(size.x), vec2f(-1.0), vec2f(1.0));
    return vec4f(0.5 + 0.5 * slope, here.y, 1.0);
}
