// Superposition: the displacement of every boundary (rows) at every radius (columns) under the frame's loads. Drawn once a frame into
// a small texture, which every corner of the body then reads.

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

// Boundaries must not pass through each other: a layer keeps an eighth of its thickness however hard it is pressed.
@fragment
fn superpose(@builtin(position) at: vec4f) -> @location(0) u32 {
    let sample = i32(at.x);
    let boundary = u32(at.y);
    var given = 0.0;
    for (var k = 0u; k <= boundary; k++) {
        let own = sum(k, sample);
        let thickness = scene.layers[k].x - scene.layers[max(k, 1u) - 1u].x;
        given = select(own, max(own, given - 0.875 * thickness), k > 0u);
    }
    return bitcast<u32>(given);
}
