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

fn drape(world: vec3f) -> vec3f {
    let at = world.xy;
    let step = 0.004;
    let h = fold(at);
    let slope = vec2f(fold(at + vec2f(step, 0.0)) - h, fold(at + vec2f(0.0, step)) - h) / step;
    var s = Surface(vec3f(0.045, 0.20, 0.23), normalize(vec3f(-slope, 1.0)), 0.85, 0.0, 0.25, 1.0);
    let weave = sin(at.x * 2600.0) * sin(at.y * 2600.0);
    s.base *= 1.0 + 0.05 * weave;
    // The body keeps the light of the room from the cloth close to it.
    let off = vec2f(dot(world - scene.focus.xyz, scene.across.xyz), dot(world - scene.focus.xyz, scene.away.xyz) - 0.5 * scene.away.w);
    let outside = length(max(abs(off) - vec2f(scene.across.w, 0.5 * scene.away.w), vec2f(0.0)));
    s.open = mix(0.35, 1.0, smoothstep(0.0, 0.05, outside));
    return lit(s, towards_eye(world), world, vec3f(0.0, 0.0, 1.0));
}

fn fold(at: vec2f) -> f32 {
    let bent = at + 0.02 * vec2f(sin(at.y * 21.0), sin(at.x * 17.0 + 1.0));
    return 0.006 * noise(bent * vec2f(9.0, 15.0) + 40.0, 4096) + 0.003 * noise(bent.yx * vec2f(16.0, 30.0) + 90.0, 4096);
}

@fragment
fn backdrop_fragment(in: Varying) -> @location(0) vec4f {
    if scene.cut.w > 0.5 {
        let t = 0.5 + 0.5 * in.ndc.y;
        return vec4f(mix(vec3f(0.60, 0.66, 0.70), vec3f(0.80, 0.84, 0.87), t), 1.0);
    }
    let far = scene.world_from_clip * vec4f(in.ndc, 1.0, 1.0);
    let dir = normalize(far.xyz / far.w - scene.eye.xyz);
    let vignette = 1.0 - 0.22 * dot(in.ndc, in.ndc);
    let high = mix(vec3f(0.16, 0.20, 0.235), vec3f(0.050, 0.066, 0.084), smoothstep(0.0, 0.55, dir.z + 0.12));
    var light = high;
    if dir.z < -0.01 {
        let along = (scene.place.w - scene.eye.z) / dir.z;
        let world = scene.eye.xyz + dir * along;
        let far_off = length(world.xy - scene.focus.xy);
        light = mix(drape(world), high, smoothstep(0.22, 0.75, far_off));
    }
    return vec4f(shown(light * vignette), 1.0);
}
