// What is behind: the drape that the body lies on, and a softly lit room.

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) ndc: vec2f,
}

@vertex
fn backdrop_vertex(@builtin(vertex_index) index: u32) -> Varying {
    let ndc = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return Varying(vec4f(ndc, 1.0, 1.0), ndc);
}

const TRAY: vec2f = vec2f(0.130, 0.115);

// Slope of the cloth's soft folds.
fn fold_slope(at: vec2f) -> vec2f {
    let a = 23.0 * at.x + 9.0 * at.y + 1.6 * sin(11.0 * at.y + 0.4);
    let b = 31.0 * at.y - 13.0 * at.x + 1.9 * sin(8.0 * at.x + 2.0);
    let c = 61.0 * at.x + 44.0 * at.y + 2.3 * sin(15.0 * at.x - 9.0 * at.y);
    let sharp = cos(a) * (0.6 + 0.4 * cos(a));
    return 0.20 * sharp * vec2f(1.0, 0.4) + 0.15 * cos(b) * vec2f(-0.4, 1.0) + 0.05 * cos(c) * vec2f(0.8, 0.6);
}

// The tray keeps light from the cloth, too: its middle, turn and half extent are those of `tray.rs`.
fn beside_tray(off: vec2f) -> f32 {
    let from_middle = off + vec2f(0.0, 0.5 * scene.away.w) - TRAY;
    let turned = vec2f(0.976 * from_middle.x - 0.218 * from_middle.y, 0.218 * from_middle.x + 0.976 * from_middle.y);
    return mix(0.40, 1.0, smoothstep(-0.002, 0.022, length(max(abs(turned) - vec2f(0.058, 0.042), vec2f(0.0)))));
}

fn drape(world: vec3f) -> vec3f {
    let at = world.xy;
    let normal = normalize(vec3f(-fold_slope(at), 1.0));
    let off = vec2f(dot(world - scene.focus.xyz, scene.across.xyz), dot(world - scene.focus.xyz, scene.away.xyz) - 0.5 * scene.away.w);
    let beyond = abs(off) - vec2f(scene.across.w, 0.5 * scene.away.w);
    let outside = length(max(beyond, vec2f(0.0)));
    // The body keeps the light of the room from the cloth close to it.
    let close = max(0.30, scene.look.x);
    let open = mix(close, 1.0, smoothstep(-0.004, 0.05, outside)) * beside_tray(off);
    let clear = shadow(world, vec3f(0.0, 0.0, 1.0));
    let nl = dot(normal, scene.lamp.xyz);
    // Under a body that is seen through the cloth would turn red tissue grey: what is deeper in the body shows instead.
    let deeper = scene.look.x * smoothstep(0.0, -0.001, max(beyond.x, beyond.y));
    let base = mix(vec3f(0.030, 0.098, 0.118), vec3f(0.34, 0.105, 0.095), deeper);
    return base * (0.62 * (LAMP * clear * wrapped(nl, 0.25) + open * (FILL * 0.6 + ambient(normal))));
}

@fragment
fn backdrop_fragment(in: Varying) -> @location(0) vec4f {
    let far = scene.world_from_clip * vec4f(in.ndc, 1.0, 1.0);
    let dir = normalize(far.xyz / far.w - scene.eye.xyz);
    let vignette = 1.0 - 0.20 * dot(in.ndc, in.ndc);
    let high = mix(vec3f(0.105, 0.135, 0.158), vec3f(0.032, 0.043, 0.056), smoothstep(-0.10, 0.45, dir.z));
    var light = high;
    if dir.z < -0.01 {
        let along = (scene.place.w - scene.eye.z) / dir.z;
        let world = scene.eye.xyz + dir * along;
        let far_off = length(world.xy - scene.focus.xy);
        if far_off < 0.62 {
            light = mix(drape(world), high, smoothstep(0.16, 0.62, far_off));
        }
    }
    return vec4f(shown(light * vignette), 1.0);
}

// Behind a section: paper.
@fragment
fn paper_fragment(in: Varying) -> @location(0) vec4f {
    return vec4f(mix(vec3f(0.80, 0.835, 0.86), vec3f(0.90, 0.925, 0.94), 0.5 + 0.5 * in.ndc.y), 1.0);
}
