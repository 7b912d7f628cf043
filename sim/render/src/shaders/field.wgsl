// Superposition: the displacement of every boundary (rows) at every radius (columns) under the
// frame's loads. Rendered once per frame into a small texture, which every vertex of the body then
// reads.

@group(1) @binding(0) var responses: texture_2d<f32>;

@vertex
fn whole(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn sum(boundary: u32, sample: i32) -> f32 {
    var total = 0.0;
    for (var load = 0u; load < scene.count.w; load++) {
        let row = i32(boundary * scene.count.w + load);
        total += scene.loads[load / 4u][load % 4u] * textureLoad(responses, vec2i(sample, row), 0).x;
    }
    return total;
}

// Displacement of a boundary at a distance from the axis, relative to that on the axis, under a
// load on the boundary itself; without a field a smooth hill.
fn shape(boundary: u32, sample: i32) -> f32 {
    if boundary < scene.count.w {
        let row = i32(boundary * scene.count.w + boundary);
        let on_axis = textureLoad(responses, vec2i(0, row), 0).x;
        if on_axis > 0.0 {
            return textureLoad(responses, vec2i(sample, row), 0).x / on_axis;
        }
    }
    let share = f32(sample) / f32(scene.count.z - 1u);
    let radius = scene.look.z * share * share / 0.007;
    return 1.0 / (1.0 + radius * radius);
}

fn dent(boundary: u32) -> f32 {
    return scene.dents[boundary / 4u][boundary % 4u];
}

// The field, adjusted to the boundary's displacement on the axis: scaled down as a whole, or
// increased by a load on the boundary itself. Neither changes a field that already has this
// displacement.
fn brought(boundary: u32, sample: i32) -> f32 {
    let own = sum(boundary, sample);
    let on_axis = sum(boundary, 0);
    let wanted = dent(boundary);
    if on_axis * wanted <= 0.0 {
        return wanted * shape(boundary, sample);
    }
    if abs(wanted) <= abs(on_axis) {
        return own * (wanted / on_axis);
    }
    return own + (wanted - on_axis) * shape(boundary, sample);
}

// Boundaries must not pass through each other: a layer keeps an eighth of its thickness, or its
// thickness on the axis if that is less.
@fragment
fn superpose(@builtin(position) at: vec4f) -> @location(0) u32 {
    let sample = i32(at.x);
    let boundary = u32(at.y);
    var given = brought(0u, sample);
    for (var k = 1u; k <= boundary; k++) {
        let thickness = scene.layers[k].x - scene.layers[k - 1u].x;
        let pressed = max(0.875 * thickness, dent(k - 1u) - dent(k));
        given = max(brought(k, sample), given - pressed);
    }
    return bitcast<u32>(given);
}
