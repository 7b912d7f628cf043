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

// Objects next to the body are placed relative to the block: to the right, away, and up from the
// drape.
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

// Kinds: 0 target, 1 vessel, 2 nerve, 3 bone, 4 organ. Users who confuse red and green must
// distinguish them too, from the surrounding tissue and from each other: no structure in yellow fat
// is yellow, and an organ is bluer than muscle.
fn kind_of(kind: u32, world: vec3f) -> Surface {
    var s = Surface(vec3f(0.05, 0.42, 0.72), vec3f(0.0), 0.35, 0.0, 0.15, 1.0);
    let mottle = grain(world.xy * 1400.0 + world.z * 700.0);
    switch kind {
        case 1u: {
            s.base = mix(vec3f(0.46, 0.022, 0.03), vec3f(0.60, 0.05, 0.05), mottle);
            s.rough = 0.26;
            s.soft = 0.25;
        }
        case 2u: {
            s.base = mix(vec3f(0.58, 0.70, 0.82), vec3f(0.70, 0.80, 0.88), mottle);
            s.rough = 0.42;
        }
        case 3u: {
            s.base = mix(vec3f(0.72, 0.64, 0.48), vec3f(0.84, 0.78, 0.64), mottle);
            s.rough = 0.55;
        }
        case 4u: {
            s.base = mix(vec3f(0.34, 0.09, 0.20), vec3f(0.42, 0.14, 0.27), mottle);
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

struct Skin {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
}

// The skin of a whole patient and the drape on it, which covers the block's edge.
@vertex
fn patient_vertex(@location(0) at: vec4f, @location(1) normal: vec4f) -> Skin {
    let world = at.xyz + 0.0015 * normal.xyz;
    return Skin(scene.clip_from_world * vec4f(world, 1.0), world, normal.xyz);
}

@vertex
fn patient_shadow(@location(0) at: vec4f, @location(1) normal: vec4f) -> Skin {
    return Skin(scene.light_clip_from_world * vec4f(at.xyz, 1.0), at.xyz, normal.xyz);
}

// The patient's skin casts no shadow where the block's own skin replaces it.
@fragment
fn patient_shadow_beside(in: Skin) {
    if beside_block(in) < 0.0 {
        discard;
    }
}

// Distance of a position on the back from the block in plan, in m; negative where the block's own
// skin, which deforms under the needle, replaces the patient's.
fn beside_block(in: Skin) -> f32 {
    let off = in.world - scene.focus.xyz;
    let away = dot(off, scene.away.xyz);
    let aside = vec2f(abs(dot(off, scene.across.xyz)) - scene.across.w, max(away - scene.away.w, -away - 0.7 * scene.away.w));
    return select(max(aside.x, aside.y), 1.0, in.normal.z < 0.0);
}

// A drape with the block as its window covers the back up to this distance from the block, in m.
const DRAPED: f32 = 0.062;

// The same as skin from above in `tissue.wgsl`, with its texture projected from above or from a
// side; or the drape.
fn patient_surface(in: Skin, beside: f32) -> Surface {
    let normal = normalize(in.normal);
    let size = abs(normal);
    var at = in.world.xy;
    if size.x > max(size.y, size.z) {
        at = in.world.yz;
    } else if size.y > size.z {
        at = in.world.xz;
    }
    let colour = textureSample(albedos, tiles, at / 0.036, 0);
    let k = in.world * 60.0;
    let broad = 0.98 + 0.06 * sin(k.x + 1.7 * sin(0.7 * k.y)) + 0.05 * sin(1.3 * k.y - k.z + 1.9 * sin(0.8 * k.x));
    let skin = Surface(colour.rgb * colour.rgb * broad, normal, 0.5, 0.0, 0.42, mix(0.55, 1.0, colour.w));
    if beside > DRAPED {
        // Darker where the drape's edge blocks the light.
        return Surface(skin.base, skin.normal, skin.rough, 0.0, skin.soft, skin.open * smoothstep(-0.006, 0.008, beside - DRAPED));
    }
    let folds = vec3f(0.10 * sin(41.0 * in.world.x + 13.0 * in.world.y), 0.10 * sin(37.0 * in.world.y - 17.0 * in.world.x), 0.0);
    let hem = 0.72 + 0.28 * smoothstep(0.0025, 0.0040, min(beside, DRAPED - beside));
    let thread = 0.94 + 0.06 * grain(in.world.xy * 1900.0);
    return Surface(vec3f(0.055, 0.19, 0.235) * hem * thread, normalize(normal + folds), 0.9, 0.0, 0.25, 1.0);
}

@fragment
fn patient_fragment(in: Skin) -> @location(0) vec4f {
    let beside = beside_block(in);
    let s = patient_surface(in, beside);
    if beside < -0.002 {
        discard;
    }
    let lamp = lamp_at(in.world, s.normal);
    return vec4f(shown(lit(s, towards_eye(in.world), shadow(lamp) * beside_needle(lamp))), 1.0);
}

@fragment
fn patient_faded(in: Skin) -> @location(0) vec4f {
    let beside = beside_block(in);
    let s = patient_surface(in, beside);
    if beside < 0.0 {
        discard;
    }
    let view = towards_eye(in.world);
    let lamp = lamp_at(in.world, s.normal);
    let light = lit(s, view, shadow(lamp) * beside_needle(lamp));
    return seen_through(s, view, light, 0.10);
}

// The far side of a transparent patient: flesh, darker with depth.
@fragment
fn patient_inside(in: Skin) -> @location(0) vec4f {
    let s = Surface(vec3f(0.50, 0.19, 0.155), -normalize(in.normal), 0.9, 0.0, 0.4, 1.0);
    return vec4f(shown(matte(s, 0.5)), 1.0);
}

// The count is odd where the cut passes through a solid: its inside is counted into the stencil.
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
        // The far wall, seen through the cut, represents the cut face: it is moved into its plane
        // and lit like it.
        s.normal = scene.cut.xyz;
        world += view * (-before_cut(world) / max(dot(view, scene.cut.xyz), 1e-3));
        s.base *= 0.72;
        s.rough = 0.4;
    }
    if world.z < scene.place.w {
        discard;
    }
    var light = lit(s, view, shadow(lamp_at(world, s.normal)));
    if scene.place.z == f32(in.which) {
        let rim = pow(1.0 - abs(dot(s.normal, view)), 2.0);
        light += s.base * 0.9 + vec3f(0.9, 0.75, 0.3) * rim;
    }
    return vec4f(shown(light), 1.0);
}

// In a section: structures behind the cut face, as silhouettes.
@fragment
fn solid_behind(in: Varying) -> @location(0) vec4f {
    if before_cut(in.world) > 0.0 || in.world.z < scene.place.w {
        discard;
    }
    let s = kind_of(in.kind, in.world);
    let rim = pow(1.0 - abs(dot(normalize(in.normal), scene.cut.xyz)), 3.0);
    return vec4f(encoded(s.base), 0.10 + 0.5 * rim);
}

// Kinds: 0 planned line, 1 entry, 2 target; unlit, the same from every side.
fn guide_colour(kind: u32) -> vec3f {
    return select(vec3f(0.10, 0.85, 0.75), vec3f(0.16, 0.42, 1.0), kind > 1u);
}

@fragment
fn guide_fragment(in: Varying) -> @location(0) vec4f {
    return vec4f(encoded(guide_colour(in.kind)), 1.0);
}

@fragment
fn guide_hidden(in: Varying) -> @location(0) vec4f {
    return vec4f(encoded(guide_colour(in.kind)), 0.38);
}
