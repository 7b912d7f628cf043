// The needle: stylet, cannula and hub, in the needle's frame (+z from hub to tip, tip at the
// origin), bent and placed in the patient frame.

// Radius of a falling drop, in m, as in `hub.rs`.
const DROP: f32 = 0.0023;

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) own: vec3f,
    @location(3) @interpolate(flat) part: u32,
}

fn placed(own: vec3f) -> vec3f {
    // A cantilever clamped at the hub and loaded at the tip bends by s²(3 - s)/2.
    let s = clamp(1.0 + own.z / scene.needle_x.w, 0.0, 1.0);
    return scene.tip.xyz + turned(own) + scene.bend.xyz * (0.5 * s * s * (3.0 - s));
}

fn turned(own: vec3f) -> vec3f {
    return scene.needle_x.xyz * own.x + scene.needle_y.xyz * own.y + scene.needle_z.xyz * own.z;
}

// Part 5, the plunger, moves in.
@vertex
fn needle_vertex(@location(0) at: vec4f, @location(1) normal: vec4f) -> Varying {
    var out: Varying;
    out.world = placed(at.xyz + vec3f(0.0, 0.0, select(0.0, scene.hub.y, at.w == 5.0)));
    out.normal = turned(normal.xyz);
    out.own = at.xyz;
    out.part = u32(at.w);
    out.clip = scene.clip_from_world * vec4f(out.world, 1.0);
    return out;
}

// Parts: 0 polished stylet, 1 brushed cannula, 2 bore, 3 hub, 4 knob, 5 plunger.
fn part_of(in: Varying) -> Surface {
    var s = Surface(vec3f(0.84, 0.845, 0.85), normalize(in.normal), 0.20, 1.0, 0.0, 1.0);
    switch in.part {
        case 1u: {
            // Brushed around the shaft: fine grooves, and an engraved ring every centimetre.
            let groove = grain(vec2f(in.own.z * 9000.0, 3.0)) - 0.5;
            s.base = vec3f(0.74, 0.75, 0.765);
            s.rough = 0.30 + 0.10 * groove;
            s.normal = normalize(s.normal + scene.needle_z.xyz * (0.10 * groove));
            let centimetre = abs(fract(-in.own.z * 100.0 + 0.5) - 0.5) * 0.01;
            let ring = smoothstep(3.2e-4, 2.0e-4, centimetre) * step(0.006, -in.own.z);
            s.base = mix(s.base, vec3f(0.05), 0.85 * ring);
            s.rough = mix(s.rough, 0.6, ring);
        }
        case 2u: {
            s.base = vec3f(0.10);
            s.rough = 0.5;
            s.open = 0.4;
        }
        case 3u: {
            s.base = hub_base(s.normal, in);
            s.metal = 0.0;
            s.rough = 0.32;
            s.soft = 0.15;
        }
        case 4u, 5u: {
            s.base = vec3f(0.80, 0.80, 0.76);
            s.metal = 0.0;
            s.rough = 0.38;
            s.soft = 0.15;
        }
        default: {}
    }
    return s;
}

// Clear tinted plastic: its content is visible where the view is perpendicular to it.
fn hub_base(normal: vec3f, in: Varying) -> vec3f {
    let facing = abs(dot(normal, towards_eye(in.world)));
    let inside = smoothstep(0.15, 0.65, facing);
    let plastic = mix(vec3f(0.05, 0.22, 0.42), vec3f(0.16, 0.38, 0.58), inside);
    // It fills from the needle to its mouth.
    let filled = mix(scene.rim.x, scene.rim.y, scene.hub.x);
    let blood = inside * smoothstep(-3e-4, 3e-4, in.own.z - filled) * step(1e-3, scene.hub.x);
    return mix(plastic, vec3f(0.26, 0.008, 0.008), 0.96 * blood);
}

// The drop that hangs at the rim of the hub, and one that has fallen from it.
@vertex
fn drop_vertex(@location(0) at: vec4f, @location(1) normal: vec4f, @builtin(instance_index) instance: u32) -> Varying {
    let falls = instance == 1u;
    let whole = DROP * select(0.0, 1.0, scene.hub.w > 0.0);
    let radius = select(scene.hub.z, whole, falls);
    let rim = placed(vec3f(0.0, 0.0, scene.rim.w)) + scene.across.xyz * scene.rim.z;
    var out: Varying;
    // Down in the picture, along -z: the body is prone.
    out.world = rim + at.xyz * radius - vec3f(0.0, 0.0, radius + select(0.0, scene.hub.w, falls));
    out.normal = normal.xyz;
    out.own = vec3f(0.0);
    out.part = 7u;
    out.clip = scene.clip_from_world * vec4f(out.world, 1.0);
    return out;
}

// Glass and water: clear where the view is perpendicular, bright at edges and where they mirror the
// lamp.
@fragment
fn glass_fragment(in: Varying) -> @location(0) vec4f {
    let view = towards_eye(in.world);
    let normal = normalize(in.normal);
    let facing = abs(dot(normal, view));
    let rim = pow(1.0 - facing, 2.0);
    // In a section: a pale body with a dark outline, like the needle.
    if scene.cut.w > 0.5 {
        return vec4f(mix(vec3f(0.62, 0.74, 0.84), vec3f(0.10, 0.12, 0.15), smoothstep(0.3, 0.8, rim)), 0.30 + 0.65 * smoothstep(0.3, 0.8, rim));
    }
    let shine = min(glint(normal, 0.14, view, scene.lamp.xyz), 3.0);
    let light = room(reflect(-view, normal), 0.1) + shine;
    // Marks around the barrel, every half centimetre.
    let half = abs(fract(in.own.z * 200.0) - 0.5);
    let mark = select(0.0, smoothstep(0.44, 0.47, half) * smoothstep(0.45, 0.75, facing), in.part == 6u);
    let water = select(0.0, 0.14, in.part == 7u);
    let clear = min(0.12 + water + 0.62 * rim + 0.3 * shine, 1.0);
    let colour = mix(light * vec3f(0.86, 0.95, 1.0), vec3f(0.03, 0.04, 0.06), 0.8 * mark);
    return vec4f(shown(colour), max(clear, 0.7 * mark));
}

// Another attempt's needle: the same shape, straight and transparent.
@vertex
fn ghost_vertex(@location(0) at: vec4f, @location(1) normal: vec4f) -> Varying {
    let axes = mat3x3f(scene.ghost_x.xyz, scene.ghost_y.xyz, scene.ghost_z.xyz);
    var out: Varying;
    out.world = scene.ghost.xyz + axes * at.xyz;
    out.normal = axes * normal.xyz;
    out.own = at.xyz;
    out.part = u32(at.w);
    out.clip = scene.clip_from_world * vec4f(out.world, 1.0);
    return out;
}

@fragment
fn ghost_fragment(in: Varying) -> @location(0) vec4f {
    let rim = 1.0 - abs(dot(normalize(in.normal), towards_eye(in.world)));
    return vec4f(encoded(vec3f(0.35, 0.62, 1.0)), 0.22 + 0.5 * rim * rim);
}

// In a section: flat, with a dark outline.
fn profile(s: Surface, view: vec3f) -> vec3f {
    let rim = 1.0 - abs(dot(s.normal, view));
    let own = select(encoded(s.base), vec3f(0.60, 0.635, 0.67) * (0.35 + 0.65 * s.base.x / 0.74), s.metal > 0.5);
    return mix(own, vec3f(0.10, 0.12, 0.15), smoothstep(0.50, 0.95, rim));
}

@fragment
fn needle_fragment(in: Varying) -> @location(0) vec4f {
    let view = towards_eye(in.world);
    let s = part_of(in);
    if scene.cut.w > 0.5 {
        return vec4f(profile(s, view), 1.0);
    }
    let clear = shadow(lamp_at(in.world, normalize(in.normal)));
    if s.metal > 0.5 {
        return vec4f(shown(lit_metal(s, view, clear)), 1.0);
    }
    return vec4f(shown(lit(s, view, clear)), 1.0);
}
