// Shared by all shaders of the picture: the frame's uniforms, and the body's shape and deformation.
// Lengths in m, patient frame.

struct Puncture {
    entry: vec3f,
    depth: f32,
    axis: vec3f,
    blood: f32,
}

struct Scene {
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    light_clip_from_world: mat4x4f,
    // Position of the camera; w is 0 for parallel rays.
    eye: vec4f,
    // Direction of the camera's view; w: width of a pixel at 1 m distance (at any distance for
    // parallel rays).
    forward: vec4f,
    // Middle of the cut on the skin; w: radius of the needle.
    focus: vec4f,
    // Along the cut, to the right; w: half the block's width.
    across: vec4f,
    // Into the block, horizontal; w: depth of the block behind the cut.
    away: vec4f,
    // Down the cut, per metre of depth; w: depth of the lowest boundary.
    down: vec4f,
    // Out of the cut face; w: 1 in the section view.
    cut: vec4f,
    // The needle's axis in the tissue; w: nearness of the needle, 1 in the tissue.
    axis: vec4f,
    // The needle: three axes in the patient frame, tip, and deflection of the tip by bending. w:
    // length; tip to rim; depth of the tip; strength of the needle's shadow, and of the body's.
    needle_x: vec4f,
    needle_y: vec4f,
    needle_z: vec4f,
    tip: vec4f,
    bend: vec4f,
    // Another attempt's needle: three axes and tip.
    ghost_x: vec4f,
    ghost_y: vec4f,
    ghost_z: vec4f,
    ghost: vec4f,
    // Direction to the lamp; w: size of a shadow texel relative to the map.
    lamp: vec4f,
    // Fade of the body; 1 if it is not cut open; radius of the field; half the extent of the skin's
    // shape.
    look: vec4f,
    // Centre of the skin's shape (x, y); index of the touched structure, or -1; height of the
    // ground.
    place: vec4f,
    // The needle in the lamp's clip space: its tip, and the end of the part on its hub. w: half the
    // width of the lamp's map, in m; fraction of the length at which the hub begins.
    shade_tip: vec4f,
    shade_end: vec4f,
    // Blood in the hub, 0 to 1; travel of the plunger; radius of the hanging drop; distance that
    // another has fallen.
    hub: vec4f,
    // Along the needle: beginning of the hub, and its mouth. Position of a hanging drop, off the
    // axis and along it.
    rim: vec4f,
    // Radius of curvature of skin and layers, or 0; for a cylinder, the direction of its line in
    // plan, and 1.
    curve: vec4f,
    // Numbers of layers, punctures, samples of the field along the radius, and loads.
    count: vec4u,
    // Top, bottom, material, and 1 if the tip has opened it.
    layers: array<vec4f, 16>,
    punctures: array<Puncture, 16>,
    // Forces, four to a row.
    loads: array<vec4f, 12>,
    // Displacement of every boundary on the needle's line, four to a row.
    dents: array<vec4f, 4>,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var skin_shape: texture_2d<f32>;
// The bits of a float: every adapter can render to integers, but not every one to floats.
@group(0) @binding(2) var field: texture_2d<u32>;

// Height of the skin above that of the force law at a position of the patient frame, and its slope
// in x and y.
fn skin_at(at: vec2f) -> vec3f {
    let size = vec2f(textureDimensions(skin_shape)) - 1.0;
    let texel = clamp((at - scene.place.xy) / (2.0 * scene.look.w) + 0.5, vec2f(0.0), vec2f(0.9999)) * size;
    let low = vec2i(texel);
    let share = fract(texel);
    let a = textureLoad(skin_shape, low, 0);
    let b = textureLoad(skin_shape, low + vec2i(1, 0), 0);
    let c = textureLoad(skin_shape, low + vec2i(0, 1), 0);
    let d = textureLoad(skin_shape, low + vec2i(1, 1), 0);
    return mix(mix(a, b, share.x), mix(c, d, share.x), share.y).xyz;
}

fn field_at(boundary: u32, sample: i32) -> f32 {
    let last = i32(scene.count.z) - 1;
    return bitcast<f32>(textureLoad(field, vec2i(clamp(abs(sample), 0, last), i32(boundary)), 0).x);
}

// Displacement of a boundary at a distance from the axis, and its derivative. Samples are at the
// radii reach (i/(n-1))².
fn displacement(boundary: u32, radius: f32) -> vec2f {
    if boundary >= scene.count.x {
        return vec2f(0.0);
    }
    let reach = scene.look.z;
    let last = f32(scene.count.z - 1u);
    if radius >= reach {
        let edge = field_at(boundary, i32(last)) * reach / radius;
        return vec2f(edge, -edge / radius);
    }
    let x = last * sqrt(radius / reach);
    let i = i32(x);
    let t = fract(x);
    let low = field_at(boundary, i);
    let high = field_at(boundary, i + 1);
    let before = high - field_at(boundary, i - 1);
    let after = field_at(boundary, i + 2) - low;
    let per_sample = 0.5 * mix(before, after, t);
    // dx/dr of x = last sqrt(r/reach), kept finite on the axis.
    let rate = 0.5 * last / sqrt(reach * max(radius, 0.01 * scene.focus.w));
    return vec2f(mix(low, high, t), per_sample * rate);
}

struct Tissue {
    world: vec3f,
    rest: vec3f,
    normal: vec3f,
    slope: f32,
}

fn depth_of(boundary: u32) -> f32 {
    return select(scene.layers[min(boundary, 15u)].x, scene.down.w, boundary >= scene.count.x);
}

// Lateral distance, relative to the radius, beyond which a layer continues straight.
const TURNED = 0.75;

// Height of a layer at a position in plan, at a depth below the skin, and its slope in x and y.
// `DrawnBend::height_m` does the same for the skin.
fn concentric(at: vec2f, depth: f32) -> vec3f {
    let radius = scene.curve.x - depth;
    if scene.curve.x <= 0.0 {
        return vec3f(-depth, 0.0, 0.0);
    }
    let aside = at - scene.curve.w * scene.curve.yz * dot(at, scene.curve.yz);
    let far = length(aside);
    let arc = min(far, TURNED * radius);
    let up = sqrt(radius * radius - arc * arc);
    let slope = arc / up;
    return vec3f(up - scene.curve.x - (far - arc) * slope, -slope * aside / max(far, 1e-6));
}

// The same, but not below the table, at which a block that bends ends.
fn above_table(at: vec2f, depth: f32) -> vec3f {
    let lies = concentric(at, depth);
    let table = scene.focus.z - scene.down.w;
    let is_on_table = lies.x < table || depth >= scene.down.w;
    return select(lies, vec3f(table, 0.0, 0.0), scene.curve.x > 0.0 && is_on_table);
}

// A position on a boundary, in m across and away from the middle of the cut.
fn boundary_at(plan: vec2f, boundary: u32) -> Tissue {
    let depth = depth_of(boundary);
    let level = vec3f(scene.focus.xy, 0.0) + scene.across.xyz * plan.x + scene.away.xyz * plan.y;
    let share = 1.0 - 0.75 * depth / max(scene.down.w, 1e-3);
    let skin = skin_at(level.xy);
    var tissue: Tissue;
    let below = level + scene.down.xyz * depth;
    let lies = above_table(below.xy, depth);
    tissue.rest = vec3f(below.xy, lies.x + share * skin.x);
    let axis = scene.axis.xyz;
    let off = tissue.rest - scene.focus.xyz;
    let radial = off - axis * dot(off, axis);
    let radius = length(radial);
    let given = displacement(boundary, radius);
    tissue.world = tissue.rest + axis * given.x;
    let outward = radial / max(radius, 1e-6);
    let hill = vec3f(lies.yz + share * skin.yz, 0.0);
    tissue.normal = normalize(vec3f(0.0, 0.0, 1.0) - hill - outward * (axis.z * given.y));
    tissue.slope = abs(given.y);
    return tissue;
}

// Hashes of the plane, and noise computed from them.
fn hash2(cell: vec2i) -> vec2f {
    var v = vec2u(bitcast<u32>(cell.x), bitcast<u32>(cell.y)) * 1664525u + 1013904223u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v = v ^ (v >> vec2u(16u));
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v = v ^ (v >> vec2u(16u));
    return vec2f(v & vec2u(0xffffffu)) / 16777216.0;
}

// Value noise without repetition, in 0..1.
fn grain(at: vec2f) -> f32 {
    let cell = vec2i(floor(at));
    let f = fract(at);
    let s = f * f * (3.0 - 2.0 * f);
    let a = hash2(cell).x;
    let b = hash2(cell + vec2i(1, 0)).x;
    let c = hash2(cell + vec2i(0, 1)).x;
    let d = hash2(cell + 1).x;
    return mix(mix(a, b, s.x), mix(c, d, s.x), s.y);
}
