// The block of the body: boundaries seen from above, and the faces where it is cut.

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) rest: vec3f,
    @location(2) normal: vec3f,
    @location(3) tangent: vec3f,
    // Undeformed depth below the layer's top; 1 on a cut face; slope of the tent; tone.
    @location(4) more: vec4f,
    // Position on the material's tile, in tiles.
    @location(5) at: vec2f,
    // The layer's material, and its texture: the vertices provide them, since looking them up per
    // pixel is slow in software rendering.
    @location(6) @interpolate(flat) made: vec2u,
    // Position in the lamp's clip space.
    @location(7) lamp: vec3f,
    // Distance from the needle's axis, in its radii, and distance below the tip. Linear along every
    // ray of vertices.
    @location(8) needle: vec2f,
}

// Whether objects behind show through.
override faded: bool = false;

// A body that is not cut open also has a part in front of the cut: the same vertices, mirrored,
// with instances numbered from here on.
const BEFORE: u32 = 16u;
// Its extent relative to the part behind.
const NEARER: f32 = 0.7;

struct Placed {
    tissue: Tissue,
    boundary: u32,
    layer: u32,
    // 1 behind the cut, -1 in front of it.
    side: f32,
}

// plan: end of a ray from the middle of the cut, in m, and distance along it; wall: outward normal,
// 1 at the layer's bottom, 1 on a face.
fn placed(plan: vec3f, wall: vec4f, instance: u32) -> Placed {
    let before = instance >= BEFORE;
    let layer = instance % BEFORE;
    let boundary = layer + u32(wall.z);
    let mirror = vec2f(1.0, select(1.0, -NEARER, before));
    let at = plan.xy * mirror * (plan.z * (0.02 + 0.98 * plan.z * plan.z));
    return Placed(boundary_at(at, boundary), boundary, layer, select(1.0, -1.0, before));
}

@vertex
fn tissue_vertex(@location(0) plan: vec3f, @location(1) wall: vec4f, @builtin(instance_index) instance: u32) -> Varying {
    let at = placed(plan, wall, instance);
    let tissue = at.tissue;
    var out: Varying;
    out.world = tissue.world;
    out.rest = tissue.rest;
    let outward = scene.across.xyz * wall.x + scene.away.xyz * (wall.y * at.side);
    let face = select(outward, scene.cut.xyz, wall.y < -0.5);
    out.normal = select(tissue.normal, face, wall.w > 0.5);
    out.tangent = select(vec3f(1.0, 0.0, 0.0), scene.away.xyz * wall.x - scene.across.xyz * (wall.y * at.side), wall.w > 0.5);
    // Broad differences in tone, which hide the repetition of a tile.
    let k = tissue.rest * 60.0;
    let broad = 0.98 + 0.06 * sin(k.x + 1.7 * sin(0.7 * k.y)) + 0.05 * sin(1.3 * k.y - k.z + 1.9 * sin(0.8 * k.x));
    let depth = depth_of(at.boundary);
    let layer = scene.layers[at.layer];
    out.more = vec4f(depth - layer.x, wall.w, tissue.slope, broad);
    out.made = vec2u(u32(layer.z));
    var tile = tissue.rest.xy;
    if wall.w > 0.5 {
        tile = vec2f(dot(tissue.rest, out.tangent), -depth);
        out.made.y = select(out.made.x, 6u, out.made.x == 0u);
    }
    out.at = tile / tile_width(out.made.y);
    out.clip = scene.clip_from_world * vec4f(out.world, 1.0);
    out.lamp = lamp_at(out.world, out.normal);
    let off = tissue.rest - scene.focus.xyz;
    let down = dot(off, scene.axis.xyz);
    out.needle = vec2f(length(off - scene.axis.xyz * down) / scene.focus.w, down - max(scene.needle_z.w, 0.0));
    return out;
}

@vertex
fn tissue_shadow(@location(0) plan: vec3f, @location(1) wall: vec4f, @builtin(instance_index) instance: u32) -> @builtin(position) vec4f {
    return scene.light_clip_from_world * vec4f(placed(plan, wall, instance).tissue.world, 1.0);
}

// Textures of the materials: skin, fat, muscle, fascia, bone, fluid, skin cut through. Width of a
// tile, in m.
fn tile_width(material: u32) -> f32 {
    switch material {
        case 0u: { return 0.036; }
        case 1u: { return 0.026; }
        case 2u: { return 0.030; }
        case 3u: { return 0.024; }
        case 6u: { return 0.016; }
        default: { return 0.020; }
    }
}

// Depth of blood at a position on the skin, relative to its full depth: a pool with a ragged edge,
// and a trickle to the side.
fn blood_depth(off: vec2f, blood: f32) -> f32 {
    let angle = atan2(off.y, off.x);
    let ragged = 0.16 * sin(3.0 * angle + 0.7) + 0.09 * sin(5.0 * angle + 2.1) + 0.05 * sin(9.0 * angle);
    let pool = scene.focus.w + 0.0052 * blood * (1.0 + ragged) - length(off);
    let along = -off.x;
    let meander = 0.0013 * sin(along * 210.0) + 0.0006 * sin(along * 530.0 + 1.0) + 0.22 * along;
    let end = 0.034 * blood * blood;
    let width = 0.0012 * (0.5 + blood) * (1.0 + 0.55 * smoothstep(0.006, 0.0, end - along)) * smoothstep(-0.002, 0.002, along);
    let trickle = width - length(vec2f(max(along - end, 0.0), off.y - meander));
    let dome = clamp(max(pool * 0.55, trickle) / 0.0017, 0.0, 1.0);
    return dome * (2.0 - dome);
}

// Depth of blood and darkness of a hole at a position on the skin.
fn wet(rest: vec3f) -> vec2f {
    var out = vec2f(0.0);
    for (var i = 0u; i < scene.count.y; i++) {
        let puncture = scene.punctures[i];
        let off = rest.xy - puncture.entry.xy;
        // Beyond the reach of pool and trickle there is nothing to add.
        if abs(off.y - 0.003) < 0.010 && off.x < 0.008 && off.x > -0.040 {
            out.y = max(out.y, smoothstep(0.85, 0.45, length(off) / scene.focus.w));
            if puncture.blood > 0.0 {
                out.x = max(out.x, blood_depth(off, puncture.blood));
            }
        }
    }
    return out;
}

// A normal tilted by a height that is known at neighbouring pixels (Mikkelsen, 2010).
fn tilted(normal: vec3f, along_x: vec3f, along_y: vec3f, rise: vec2f) -> vec3f {
    let a = cross(along_y, normal);
    let b = cross(normal, along_x);
    let area = dot(along_x, a);
    return normalize(abs(area) * normal - sign(area) * (rise.x * a + rise.y * b));
}

// How much a position inside the body belongs to a track, and how bloody it is.
fn track(rest: vec3f) -> vec2f {
    var out = vec2f(0.0);
    for (var i = 0u; i < scene.count.y; i++) {
        let puncture = scene.punctures[i];
        let off = rest - puncture.entry;
        let along = dot(off, puncture.axis);
        let aside = length(off - puncture.axis * along) / scene.focus.w;
        if aside > 4.0 {
            continue;
        }
        let within = smoothstep(puncture.depth + 2e-4, puncture.depth - 2e-4, along);
        out.x = max(out.x, within * smoothstep(1.0, 0.55, aside));
        let seep = puncture.blood * smoothstep(1.0 + 2.6 * puncture.blood, 0.9, aside) * exp(-max(along, 0.0) * 45.0);
        out.y = max(out.y, within * max(seep, puncture.blood * smoothstep(1.7, 0.9, aside)));
    }
    return out;
}

// Colours of the section view's bands, by material.
fn band(material: u32) -> vec3f {
    switch material {
        case 1u: { return vec3f(0.98, 0.84, 0.48); }
        case 2u: { return vec3f(0.66, 0.20, 0.18); }
        case 3u: { return vec3f(0.86, 0.84, 0.78); }
        case 4u: { return vec3f(0.86, 0.80, 0.64); }
        case 5u: { return vec3f(0.45, 0.66, 0.80); }
        default: { return vec3f(0.76, 0.45, 0.38); }
    }
}

// The material at a position of the body, from the tiles.
struct Bit {
    surface: Surface,
    view: vec3f,
    flat_normal: vec3f,
    // Depth below the layer's top, and its change per pixel.
    from_top: f32,
    pixel: f32,
}

// Each kind of face has its own entry point: software rendering executes both sides of every
// branch.
fn bit_of(in: Varying, rough: f32) -> Bit {
    let across = in.tangent;
    let view = towards_eye(in.world);
    // A face seen from behind, through a faded body, is lit from the viewer's side.
    let outward = normalize(in.normal);
    let flat_normal = select(outward, -outward, in.more.y > 0.5 && dot(outward, view) < 0.0);
    let along = cross(flat_normal, across);
    let colour = textureSample(albedos, tiles, in.at, in.made.y);
    let relief = textureSample(reliefs, tiles, in.at, in.made.y);
    let tilt = (relief.xy * 2.0 - 1.0) * rough;
    let beside = scene.axis.w * smoothstep(0.002, 0.0, in.needle.y);
    var bit: Bit;
    bit.flat_normal = flat_normal;
    bit.view = view;
    bit.from_top = in.more.x;
    bit.pixel = fwidth(in.more.x);
    bit.surface.base = colour.rgb * colour.rgb * in.more.w;
    bit.surface.normal = normalize(flat_normal + across * tilt.x + along * tilt.y);
    bit.surface.rough = relief.z;
    bit.surface.metal = 0.0;
    bit.surface.soft = 0.36;
    // The needle shades tissue close to it from the room's light.
    bit.surface.open = mix(0.55, 1.0, colour.w) * mix(1.0, smoothstep(-0.6, 2.6, in.needle.x), beside);
    return bit;
}

// `clear` is the fraction of the lamp's light that arrives.
fn seen(bit: Bit, clear: f32, clearest: f32) -> vec4f {
    let light = lit(bit.surface, bit.view, clear);
    if faded {
        return seen_through(bit.surface, bit.view, light, clearest);
    }
    return vec4f(shown(light), 1.0);
}

// With a dark line where a layer begins, and the epidermis.
fn lined_bit(in: Varying) -> Bit {
    var bit = bit_of(in, 0.7);
    let line = 1.0 - smoothstep(0.0, max(1.1 * bit.pixel, 1.2e-4), bit.from_top);
    let dark = select(vec3f(0.45, 0.30, 0.28), vec3f(0.50, 0.30, 0.22), in.made.x == 0u);
    bit.surface.base *= mix(vec3f(1.0), dark, 0.75 * line);
    return bit;
}

// A face where the body ends.
@fragment
fn face_fragment(in: Varying) -> @location(0) vec4f {
    return seen(lined_bit(in), shadow(in.lamp), 0.16);
}

// The same with tracks and the blood in them.
@fragment
fn tracked_fragment(in: Varying) -> @location(0) vec4f {
    var bit = lined_bit(in);
    let cut = track(in.rest);
    let base = mix(bit.surface.base, vec3f(0.30, 0.012, 0.012), 0.9 * cut.y);
    bit.surface.base = mix(base, vec3f(0.05, 0.006, 0.006), 0.85 * cut.x);
    bit.surface.rough = mix(bit.surface.rough, 0.16, cut.y);
    return seen(bit, shadow(in.lamp), 0.16);
}

// A boundary inside a faded body: without relief and specular light, which the tissue above it
// would hide.
@fragment
fn sheet_fragment(in: Varying) -> @location(0) vec4f {
    var bit = bit_of(in, 0.0);
    bit.surface.normal = bit.flat_normal;
    return seen_through(bit.surface, bit.view, matte(bit.surface, shadow(in.lamp)), 0.10);
}

// The skin from above, paler under tension.
fn skin_bit(in: Varying) -> Bit {
    var bit = bit_of(in, 0.85);
    bit.surface.base += (bit.surface.base * vec3f(0.10, 0.04, 0.0) + 0.03) * smoothstep(0.15, 0.9, in.more.z);
    bit.surface.soft = 0.42;
    return bit;
}

@fragment
fn skin_fragment(in: Varying) -> @location(0) vec4f {
    return seen(skin_bit(in), shadow(in.lamp) * beside_needle(in.lamp), 0.10);
}

// The same with holes and blood.
@fragment
fn punctured_fragment(in: Varying) -> @location(0) vec4f {
    var bit = skin_bit(in);
    let blood = wet(in.rest);
    let rise = vec2f(dpdx(blood.x), dpdy(blood.x)) * 6e-4;
    let bump = tilted(bit.flat_normal, dpdx(in.world), dpdy(in.world), rise);
    var s = bit.surface;
    s.base = mix(s.base, vec3f(0.035, 0.008, 0.007), blood.y);
    let covered = smoothstep(0.0, 0.35, blood.x);
    let deep = mix(vec3f(0.24, 0.012, 0.009), vec3f(0.105, 0.003, 0.003), smoothstep(0.1, 1.0, blood.x));
    s.base = mix(s.base, deep, 0.95 * covered);
    s.rough = mix(s.rough, 0.13, covered);
    s.soft = mix(s.soft, 0.15, covered);
    s.normal = normalize(mix(s.normal, bump, covered));
    bit.surface = s;
    return seen(bit, shadow(in.lamp) * beside_needle(in.lamp), 0.10);
}

// The section view: flat colour with a hint of the material, and a clear line between layers.
fn section(in: Varying, cut: vec2f) -> vec4f {
    let bit = bit_of(in, 0.7);
    let base = bit.surface.base;
    let tint = band(in.made.x);
    let grain = mix(0.76, 1.04, bit.surface.open) * mix(0.90, 1.05, smoothstep(0.0, 0.5, dot(base, vec3f(0.34))));
    let colour = mix(tint * grain, vec3f(0.45, 0.06, 0.06), 0.8 * max(cut.x, 0.7 * cut.y));
    let line = 1.0 - smoothstep(0.6, 1.7, bit.from_top / max(bit.pixel, 1e-7));
    return vec4f(mix(colour, tint * 0.45, 0.8 * line), 1.0);
}

@fragment
fn section_fragment(in: Varying) -> @location(0) vec4f {
    return section(in, vec2f(0.0));
}

@fragment
fn tracked_section(in: Varying) -> @location(0) vec4f {
    return section(in, track(in.rest));
}
