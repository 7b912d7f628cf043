// Copies a picture drawn at a lower resolution onto one of full size, and a mip level of a texture
// onto the next smaller one.

@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var smooth_sampler: sampler;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
}

@vertex
fn enlarge_vertex(@builtin(vertex_index) index: u32) -> Varying {
    let ndc = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return Varying(vec4f(ndc, 0.0, 1.0), ndc * vec2f(0.5, -0.5) + 0.5);
}

@fragment
fn enlarge_fragment(in: Varying) -> @location(0) vec4f {
    return textureSample(source, smooth_sampler, in.uv);
}
