// The needle: stylet, cannula and hub, in the needle's frame (+z from hub to tip, tip at the origin), bent and set into the patient frame.

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) own: vec3f,
    @location(3) @interpolate(flat) part: u32,
}

fn placed(own: vec3f) -> vec3f {
    // A cantilever held at the hub and pushed at the tip bends by s²(3 - s)/2.
    let s = clamp(1.0 + own.z / scene.needle_x.w, 0.0, 1.0);
    return scene.tip.xyz + turned(own) + scene.bend.xyz * (0.5 * s * s * (3.0 - s));
}

fn turned(own: vec3f) -> vec3f {
    return scene.needle_x.xyz * own.x + scene.needle_y.xyz * own.y + scene.needle_z.xyz * own.z;
}

@vertex
fn needle_vertex(@location(0) at: vec4f, @location(1) normal: vec4f) -> Varying {
    var out: Varying;
    out.world = placed(at.xyz);
    out.normal = turned(normal.xyz);
    out.own = at.xyz;
    out.part = u32(at.w);
    out.clip = scene.clip_from_world * vec4f(out.world, 1.0);
    return out;
}

@vertex
fn needle_shadow(@location(0) at: vec4f, @location(1) normal: vec4f) -> @builtin(position) vec4f {
    return scene.light_clip_from_world * vec4f(placed(at.xyz), 1.0);
}

// Parts: 0 polished stylet, 1 brushed cannula, 2 bore, 3 hub, 4 knob.
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
            s.base = vec3f(0.10, 0.30, 0.52);
            s.metal = 0.0;
            s.rough = 0.32;
            s.soft = 0.15;
        }
        case 4u: {
            s.base = vec3f(0.80, 0.80, 0.76);
            s.metal = 0.0;
            s.rough = 0.38;
            s.soft = 0.15;
        }
        default: {}
    }
    return s;
}

// Another attempt's needle: the same shape, straight, seen through.
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
