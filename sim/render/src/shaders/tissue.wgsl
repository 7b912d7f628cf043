// The block of the body: boundaries seen from above, and the faces where it is cut.

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) rest: vec3f,
    @location(2) normal: vec3f,
    @location(3) tangent: vec3f,
    // Depth before anything moved; 1 on a cut face; steepness of the tent; -.
    @location(4) more: vec4f,
    @location(5) @interpolate(flat) layer: u32,
}

// plan: end of a ray from the middle of the cut, in m, and how far along it; wall: outward normal, 1 at the layer's bottom, 1 on a face.
@vertex
fn tissue_vertex(@location(0) plan: vec3f, @location(1) wall: vec4f, @builtin(instance_index) layer: u32) -> Varying {
    let boundary = layer + u32(wall.z);
    let tissue = boundary_at(plan.xy * (plan.z * (0.02 + 0.98 * plan.z * plan.z)), boundary);
    var out: Varying;
    out.world = tissue.world;
    out.rest = tissue.rest;
    let face = select(scene.across.xyz * wall.x + scene.away.xyz * wall.y, scene.cut.xyz, wall.y < -0.5);
    out.normal = select(tissue.normal, face, wall.w > 0.5);
    out.tangent = select(vec3f(1.0, 0.0, 0.0), scene.away.xyz * wall.x - scene.across.xyz * wall.y, wall.w > 0.5);
    out.more = vec4f(depth_of(boundary), wall.w, tissue.slope, 0.0);
    out.layer = layer;
    out.clip = scene.clip_from_world * vec4f(out.world, 1.0);
    return out;
}

@vertex
fn tissue_shadow(@location(0) plan: vec3f, @location(1) wall: vec4f, @builtin(instance_index) layer: u32) -> @builtin(position) vec4f {
    let tissue = boundary_at(plan.xy * (plan.z * (0.02 + 0.98 * plan.z * plan.z)), layer + u32(wall.z));
    return scene.light_clip_from_world * vec4f(tissue.world, 1.0);
}

// Pictures of the materials: skin, fat, muscle, fascia, bone, fluid, skin cut through. Width of a tile, in m.
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

// Depth of blood at a place on the skin, in units of its full depth: a pool with a ragged rim, and a trickle sideways.
fn blood_depth(off: vec2f, blood: f32) -> f32 {
    let angle = atan2(off.y, off.x);
    let ragged = 0.16 * sin(3.0 * angle + 0.7) + 0.09 * sin(5.0 * angle + 2.1) + 0.05 * sin(9.0 * angle);
    let pool = scene.focus.w + 0.0052 * blood * (1.0 + ragged) - length(off);
    let along = -off.x;
    let meander = 0.0013 * sin(along * 210.0) + 0.0006 * sin(along * 530.0 + 1.0) + 0.10 * along;
    let end = 0.034 * blood * blood;
    let width = 0.0012 * (0.5 + blood) * (1.0 + 0.55 * smoothstep(0.006, 0.0, end - along));
    let trickle = min(width - abs(off.y - meander), min(along, end - along));
    let rim = 0.0011;
    return smoothstep(0.0, rim, max(pool, trickle) + 0.6 * min(max(pool, 0.0), max(trickle, 0.0)));
}

struct Wet {
    depth: f32,
    slope: vec2f,
    hole: f32,
}

fn wet(rest: vec3f) -> Wet {
    var out = Wet(0.0, vec2f(0.0), 0.0);
    for (var i = 0u; i < scene.count.y; i++) {
        let puncture = scene.punctures[i];
        let off = rest.xy - puncture.entry.xy;
        let far = dot(off, off);
        if far < 0.0016 {
            out.hole = max(out.hole, smoothstep(0.85, 0.45, sqrt(far) / scene.focus.w));
            if puncture.blood > 0.0 {
                let step = 2e-4;
                let depth = blood_depth(off, puncture.blood);
                let slope = vec2f(blood_depth(off + vec2f(step, 0.0), puncture.blood), blood_depth(off + vec2f(0.0, step), puncture.blood)) - depth;
                out.slope = select(out.slope, slope, depth > out.depth);
                out.depth = max(out.depth, depth);
            }
        }
    }
    return out;
}

// How much a place inside the body belongs to a track, and how bloody it is.
fn track(rest: vec3f) -> vec2f {
    var out = vec2f(0.0);
    for (var i = 0u; i < scene.count.y; i++) {
        let puncture = scene.punctures[i];
        let off = rest - puncture.entry;
        let along = dot(off, puncture.axis);
        let aside = length(off - puncture.axis * along) / scene.focus.w;
        let within = smoothstep(puncture.depth + 2e-4, puncture.depth - 2e-4, along);
        out.x = max(out.x, within * smoothstep(1.0, 0.55, aside));
        let seep = puncture.blood * smoothstep(1.0 + 2.6 * puncture.blood, 0.9, aside) * exp(-max(along, 0.0) * 45.0);
        out.y = max(out.y, within * max(seep, puncture.blood * smoothstep(1.7, 0.9, aside)));
    }
    return out;
}

// Colours of the section view's bands, by material.
const BANDS = array<vec3f, 7>(
    vec3f(0.86, 0.55, 0.44), vec3f(0.95, 0.76, 0.32), vec3f(0.62, 0.16, 0.15), vec3f(0.82, 0.80, 0.72),
    vec3f(0.86, 0.80, 0.64), vec3f(0.45, 0.66, 0.80), vec3f(0.86, 0.50, 0.40));

@fragment
fn tissue_fragment(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let layer = scene.layers[in.layer];
    let face = in.more.y > 0.5;
    var material = u32(layer.z);
    material = select(material, 6u, face && material == 0u);
    let depth = in.more.x;
    let across = normalize(in.tangent);
    let flat_normal = normalize(in.normal);
    let along = cross(flat_normal, across);
    let uv = select(in.rest.xy, vec2f(dot(in.rest, across), -depth), face) / tile_width(material);
    let albedo = textureSample(albedos, tiles, uv, material);
    let relief = textureSample(reliefs, tiles, uv, material);
    let broad = textureSample(reliefs, tiles, uv * 0.137 + 0.37, material).w;
    let section = scene.cut.w > 0.5;

    var s: Surface;
    s.base = albedo.rgb * mix(0.86, 1.12, broad);
    s.rough = relief.z;
    s.metal = 0.0;
    s.soft = select(0.34, 0.42, material == 0u);
    s.open = mix(0.55, 1.0, relief.w);
    let tilt = (relief.xy * 2.0 - 1.0) * select(1.0, 0.8, face);
    s.normal = normalize(flat_normal + across * tilt.x + along * tilt.y);

    let off = in.rest - scene.focus.xyz;
    let aside = length(off - scene.axis.xyz * dot(off, scene.axis.xyz));
    var alpha = 1.0;
    if face {
        // A fine dark line and a lighter lip where one layer ends and the next begins.
        let from_top = depth - layer.x;
        let pixel = fwidth(depth);
        let line = 1.0 - smoothstep(0.0, max(1.1 * pixel, 1.2e-4), from_top);
        s.base = mix(s.base, s.base * vec3f(0.45, 0.30, 0.28), 0.75 * line);
        if u32(layer.z) == 0u {
            s.base = mix(vec3f(0.42, 0.20, 0.13), s.base, smoothstep(0.6e-4, 2.2e-4, from_top));
        }
        let cut = track(in.rest);
        s.base = mix(s.base, vec3f(0.30, 0.012, 0.012), 0.9 * cut.y);
        s.base = mix(s.base, vec3f(0.05, 0.006, 0.006), 0.85 * cut.x);
        s.rough = mix(s.rough, 0.16, cut.y);
        s.open *= mix(1.0, mix(0.6, 1.0, smoothstep(0.9, 2.2, aside / scene.focus.w)), scene.axis.w);
    } else {
        s.open *= mix(1.0, mix(0.45, 1.0, smoothstep(0.8, 3.0, aside / scene.focus.w)), scene.axis.w);
        if in.layer == 0u {
            // Skin under tension pales; around a puncture it reddens.
            s.base = mix(s.base, s.base * vec3f(1.10, 1.04, 1.0) + 0.03, smoothstep(0.15, 0.9, in.more.z));
            let blood = wet(in.rest);
            s.base = mix(s.base, vec3f(0.035, 0.008, 0.007), blood.hole);
            if blood.depth > 0.0 {
                s.base = mix(mix(s.base, vec3f(0.30, 0.010, 0.008), 0.9), vec3f(0.115, 0.003, 0.003), blood.depth) ;
                s.rough = 0.10;
                s.soft = 0.2;
                let meniscus = vec3f(-blood.slope * 0.9, 0.0);
                s.normal = normalize(mix(s.normal, flat_normal, 0.85) + meniscus);
            }
        }
    }
    let view = towards_eye(in.world);
    s.normal = select(s.normal, -s.normal, front && !face);
    let fade = scene.look.x;
    let rim = pow(1.0 - abs(dot(s.normal, view)), 2.0);
    alpha = mix(1.0, mix(select(0.10, 0.16, face), 0.45, rim), smoothstep(0.0, 0.9, fade));
    if section && face {
        let band = BANDS[material] * mix(vec3f(1.0), albedo.rgb / max(dot(albedo.rgb, vec3f(0.34)), 0.05), 0.25);
        let grain = mix(0.80, 1.10, relief.w) * mix(0.95, 1.05, broad);
        let blooded = mix(band * grain, s.base, max(track(in.rest).x, track(in.rest).y));
        let line = 1.0 - smoothstep(0.6, 1.6, (depth - layer.x) / max(fwidth(depth), 1e-7));
        return vec4f(mix(blooded, band * 0.25, 0.8 * line), alpha);
    }
    return vec4f(shown(lit(s, view, in.world, flat_normal)), alpha);
}
