// Structures inside the body, and the guide's line, cross and target.

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) @interpolate(flat) kind: u32,
    @location(3) @interpolate(flat) which: i32,
}

@vertex
fn solid_vertex(@location(0) at: vec4f, @location(1) normal: vec4f) -> Varying {
    var out: Varying;
    out.world = at.xyz;
    out.normal = normal.xyz;
    out.kind = u32(at.w);
    out.which = i32(normal.w);
    out.clip = scene.clip_from_world * vec4f(at.xyz, 1.0);
    return out;
}

// What lies beside the body is placed as the block is: to the right, away, and up from the drape.
@vertex
fn tray_vertex(@location(0) at: vec4f, @location(1) normal: vec4f) -> Varying {
    var out: Varying;
    let level = vec3f(scene.focus.xy, scene.place.w);
    out.world = level + scene.across.xyz * at.x + scene.away.xyz * at.y + vec3f(0.0, 0.0, at.z);
    out.normal = scene.across.xyz * normal.x + scene.away.xyz * normal.y + vec3f(0.0, 0.0, normal.z);
    out.kind = u32(at.w);
    out.clip = scene.clip_from_world * vec4f(out.world, 1.0);
    return out;
}

// Kinds: 0 target, 1 vessel, 2 nerve, 3 bone, 4 organ.
fn kind_of(kind: u32, world: vec3f) -> Surface {
    var s = Surface(vec3f(0.85, 0.62, 0.10), vec3f(0.0), 0.35, 0.0, 0.15, 1.0);
    let mottle = grain(world.xy * 1400.0 + world.z * 700.0);
    switch kind {
        case 1u: {
            s.base = mix(vec3f(0.46, 0.022, 0.03), vec3f(0.60, 0.05, 0.05), mottle);
            s.rough = 0.26;
            s.soft = 0.25;
        }
        case 2u: {
            s.base = mix(vec3f(0.86, 0.74, 0.26), vec3f(0.92, 0.82, 0.42), mottle);
            s.rough = 0.42;
        }
        case 3u: {
            s.base = mix(vec3f(0.72, 0.64, 0.48), vec3f(0.84, 0.78, 0.64), mottle);
            s.rough = 0.55;
        }
        case 4u: {
            s.base = mix(vec3f(0.38, 0.10, 0.09), vec3f(0.46, 0.15, 0.12), mottle);
            s.rough = 0.30;
        }
        default: {}
    }
    return s;
}

// Kinds: 5 steel, 6 plastic, 7 gauze, 8 antiseptic.
fn tray_kind_of(kind: u32, world: vec3f) -> Surface {
    var s = Surface(vec3f(0.62, 0.64, 0.66), vec3f(0.0), 0.34, 1.0, 0.15, 1.0);
    switch kind {
        case 6u: {
            s = Surface(vec3f(0.66, 0.72, 0.76), vec3f(0.0), 0.22, 0.0, 0.5, 1.0);
        }
        case 7u: {
            let base = vec3f(0.74, 0.74, 0.70) * mix(0.86, 1.0, grain(world.xy * 2600.0));
            s = Surface(base, vec3f(0.0), 0.95, 0.0, 0.4, 1.0);
        }
        case 8u: {
            s = Surface(vec3f(0.20, 0.055, 0.012), vec3f(0.0), 0.08, 0.0, 0.15, 1.0);
        }
        default: {}
    }
    return s;
}

@fragment
fn tray_fragment(in: Varying) -> @location(0) vec4f {
    let view = towards_eye(in.world);
    var s = tray_kind_of(in.kind, in.world);
    s.normal = normalize(in.normal);
    let clear = shadow(lamp_at(in.world, s.normal));
    if s.metal > 0.5 {
        return vec4f(shown(lit_metal(s, view, clear)), 1.0);
    }
    return vec4f(shown(lit(s, view, clear)), 1.0);
}

// Odd where the cut goes through a solid: its inside is counted into the stencil.
@fragment
fn solid_inside(in: Varying) {
    if before_cut(in.world) > 0.0 {
        discard;
    }
}

@fragment
fn solid_fragment(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    if before_cut(in.world) > 0.0 {
        discard;
    }
    let view = towards_eye(in.world);
    var s = kind_of(in.kind, in.world);
    s.normal = normalize(in.normal);
    var world = in.world;
    if !front {
        // The far wall seen through the cut stands for the cut itself: moved into its plane and lit like it.
        s.normal = scene.cut.xyz;
        world += view * (-before_cut(world) / max(dot(view, scene.cut.xyz), 1e-3));
        s.base *= 0.72;
        s.rough = 0.4;
    }
    var light = lit(s, view, shadow(lamp_at(world, s.normal)));
    if scene.place.z == f32(in.which) {
        let rim = pow(1.0 - abs(dot(s.normal, view)), 2.0);
        light += s.base * 0.9 + vec3f(0.9, 0.75, 0.3) * rim;
    }
    return vec4f(shown(light), 1.0);
}

// In a section: what lies behind the cut face, as a shadow of itself.
@fragment
fn solid_behind(in: Varying) -> @location(0) vec4f {
    if before_cut(in.world) > 0.0 {
        discard;
    }
    let s = kind_of(in.kind, in.world);
    let rim = pow(1.0 - abs(dot(normalize(in.normal), scene.cut.xyz)), 3.0);
    return vec4f(encoded(s.base), 0.10 + 0.5 * rim);
}

// Kinds: 0 planned line, 1 entry, 2 target; drawn as light, the same from every side.
fn guide_colour(kind: u32) -> vec3f {
    return select(vec3f(0.10, 0.85, 0.75), vec3f(1.0, 0.78, 0.12), kind > 1u);
}

@fragment
fn guide_fragment(in: Varying) -> @location(0) vec4f {
    return vec4f(encoded(guide_colour(in.kind)), 1.0);
}

@fragment
fn guide_hidden(in: Varying) -> @location(0) vec4f {
    return vec4f(encoded(guide_colour(in.kind)), 0.38);
}
