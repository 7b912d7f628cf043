// Lighting of a surface: a lamp with shadows, a softer fill light, and a mirrored room. Linear
// colours.

@group(1) @binding(0) var albedos: texture_2d_array<f32>;
@group(1) @binding(1) var reliefs: texture_2d_array<f32>;
@group(1) @binding(2) var tiles: sampler;
@group(1) @binding(3) var shadow_map: texture_depth_2d;
@group(1) @binding(4) var shadow_compare: sampler_comparison;

// Half the width of a needle's handle, in m.
const HANDLE: f32 = 0.0052;
const PI: f32 = 3.14159265;
const LAMP: vec3f = vec3f(2.75, 2.62, 2.42);
const FILL: vec3f = vec3f(0.30, 0.36, 0.44);
const FILL_FROM: vec3f = vec3f(0.661, -0.621, 0.421);

struct Surface {
    base: vec3f,
    normal: vec3f,
    rough: f32,
    metal: f32,
    // How far light wraps around by scattering below the surface: 0 wood, 0.4 skin.
    soft: f32,
    open: f32,
}

// The environment that metal mirrors: softboxes to the sides and above, a dim room, the drape
// below.
fn room(dir: vec3f, rough: f32) -> vec3f {
    let up = dir.z;
    let blur = 0.04 + 0.5 * rough;
    var light = mix(vec3f(0.17, 0.215, 0.225), vec3f(0.30, 0.33, 0.36), smoothstep(-0.35 - blur, 0.1 + blur, up));
    light = mix(light, vec3f(0.62, 0.66, 0.70), smoothstep(0.3, 1.0, up));
    light += LAMP * 0.7 * smoothstep(0.88 - blur, 0.96 + 0.3 * blur, dot(dir, scene.lamp.xyz));
    let flat_dir = dir.xy * inverseSqrt(max(dot(dir.xy, dir.xy), 1e-6));
    let side = dot(flat_dir, scene.across.xy);
    let ahead = dot(flat_dir, scene.away.xy);
    // A tall softbox on the left in front of the body, a narrow one on the right, and dark between
    // them: lines along a shaft.
    let left = smoothstep(-0.50 + blur, -0.70 - 0.3 * blur, side) * smoothstep(-1.05 - blur, -0.93 + 0.4 * blur, side);
    let right = smoothstep(0.62 - blur, 0.74 + 0.4 * blur, side) * smoothstep(0.97 + blur, 0.88 - 0.4 * blur, side);
    light += vec3f(1.02, 1.03, 1.04) * left + vec3f(0.46, 0.54, 0.62) * right;
    return light * (1.0 - 0.45 * smoothstep(0.2, 0.9, -ahead * (1.0 - abs(side))));
}

fn ambient(normal: vec3f) -> vec3f {
    let sky = mix(vec3f(0.20, 0.22, 0.25), vec3f(0.46, 0.49, 0.52), 0.5 + 0.5 * normal.z);
    return mix(vec3f(0.10, 0.13, 0.14), sky, smoothstep(-1.0, 0.3, normal.z));
}

// Whether the shadow map is sampled four times per pixel instead of once.
override soft_shadows: bool = false;

// Position in the lamp's clip space, offset from its surface so that a surface does not shade
// itself.
fn lamp_at(world: vec3f, normal: vec3f) -> vec3f {
    return (scene.light_clip_from_world * vec4f(world + normal * 4e-4, 1.0)).xyz;
}

fn shadow_read(at: vec3f, corner: vec2f) -> f32 {
    let uv = vec2f(0.5, -0.5) * at.xy + 0.5 + 0.85 * scene.lamp.w * corner;
    // The map contains no thin objects: an occluder this close to a surface is the surface itself.
    return textureSampleCompareLevel(shadow_map, shadow_compare, uv, at.z - 2e-3);
}

// Fraction of the lamp's light at a position in the lamp's clip space.
fn shadow(at: vec3f) -> f32 {
    var clear = 0.0;
    if soft_shadows {
        clear = 0.25 * (shadow_read(at, vec2f(-1.0)) + shadow_read(at, vec2f(1.0, -1.0))
            + shadow_read(at, vec2f(-1.0, 1.0)) + shadow_read(at, vec2f(1.0)));
    } else {
        clear = shadow_read(at, vec2f(0.0));
    }
    // Without shadows, their strength is 0.
    return mix(1.0, clear, within_map(at) * scene.bend.w);
}

// Outside the map there is light; shadows fade towards its edge.
fn within_map(at: vec3f) -> f32 {
    return smoothstep(1.0, 0.86, max(abs(at.x), abs(at.y)));
}

// Growth of a shadow's soft edge per metre of distance from the occluder: the lamp is not a point.
const LAMP_WIDTH: f32 = 0.07;

// Fraction of the lamp's light that passes the needle, at a position in the lamp's clip space. It
// is computed analytically, so that the shadow is sharp at the entry and vanishes below a needle
// that is far above.
fn beside_needle(at: vec3f) -> f32 {
    let along = scene.shade_end.xyz - scene.shade_tip.xyz;
    let share = clamp(dot(at.xy - scene.shade_tip.xy, along.xy) / max(dot(along.xy, along.xy), 1e-9), 0.0, 1.0);
    let nearest = scene.shade_tip.xyz + along * share;
    let aside = length(at.xy - nearest.xy) * scene.shade_tip.w;
    // The lamp's map is a metre deep.
    let above = at.z - nearest.z;
    let handle = smoothstep(-0.01, 0.01, share - scene.shade_end.w);
    let radius = mix(scene.focus.w, 1.1 * HANDLE, handle);
    let soft = 2e-4 + LAMP_WIDTH * max(above, 0.0);
    let dark = smoothstep(-soft, soft, radius - aside) * min(1.0, 2.0 * radius / (radius + soft));
    // A needle far above also shades less of the room's light.
    let strength = mix(0.8, 0.42, smoothstep(0.004, 0.04, above)) * smoothstep(0.0, 1e-3, above);
    return 1.0 - strength * dark * scene.tip.w * within_map(at);
}

// Specular reflection of microfacets: GGX, with shadowing and Fresnel in one cheap factor (Lazarov
// 2013, Karis 2013).
fn glint(normal: vec3f, rough: f32, view: vec3f, light: vec3f) -> f32 {
    let half_way = normalize(view + light);
    let nh = max(dot(normal, half_way), 0.0);
    let lh = max(dot(light, half_way), 0.3);
    let a = rough * rough;
    let d = nh * nh * (a * a - 1.0) + 1.0;
    return a * a / (PI * d * d * 4.0 * lh * lh * (rough + 0.5)) * max(dot(normal, light), 0.0);
}

// Wrapped light is redder the further it travelled below the surface.
fn wrapped(nl: f32, soft: f32) -> vec3f {
    let w = soft * vec3f(1.0, 0.45, 0.35);
    let scale = 1.0 / (1.0 + w);
    return max((nl + w) * scale * scale, vec3f(0.0));
}

// Diffuse light only; `clear` is the fraction of the lamp's light that arrives.
fn matte(s: Surface, clear: f32) -> vec3f {
    let nl = dot(s.normal, scene.lamp.xyz);
    let fill = max(0.7 + dot(s.normal, FILL_FROM), 0.0) * 0.55;
    return s.base * (0.62 * (LAMP * clear * wrapped(nl, s.soft) + FILL * fill + s.open * ambient(s.normal)));
}

// Tissue, cloth and plastic.
fn lit(s: Surface, view: vec3f, clear: f32) -> vec3f {
    var light = matte(s, clear);
    light += LAMP * (clear * 0.04 * glint(s.normal, s.rough, view, scene.lamp.xyz));
    let edge = 1.0 - max(dot(s.normal, view), 0.0);
    let mirror = reflect(-view, s.normal).z;
    let sky = mix(vec3f(0.10, 0.13, 0.14), vec3f(0.55, 0.60, 0.64), smoothstep(-0.2, 0.8, mirror));
    let square = edge * edge;
    return light + s.open * sky * (0.04 + 0.6 * (1.0 - s.rough) * square * square * edge);
}

// Steel mirrors the room.
fn lit_metal(s: Surface, view: vec3f, clear: f32) -> vec3f {
    let edge = 1.0 - max(dot(s.normal, view), 0.0);
    let square = edge * edge;
    let mirrored = mix(s.base, vec3f(1.0), square * square * edge);
    let room = room(reflect(-view, s.normal), s.rough) * mix(0.65, 1.0, clear);
    return mirrored * (s.open * room + LAMP * (0.22 * clear * glint(s.normal, s.rough, view, scene.lamp.xyz)));
}

// Khronos PBR Neutral tone mapping: base colours are unchanged, highlights roll off.
fn rolled_off(light: vec3f) -> vec3f {
    let low = min(light.x, min(light.y, light.z));
    let toe = select(0.04, low - 6.25 * low * low, low < 0.08);
    let c = light - toe;
    let peak = max(c.x, max(c.y, c.z));
    let start = 0.76;
    if peak < start {
        return c;
    }
    // The peak becomes new_peak = 1 - d²/a and is mixed with grey by 1 - 1/(0.15 (peak - new_peak)
    // + 1); all by one division.
    let d = 1.0 - start;
    let a = peak + d - start;
    let b = (0.15 * (peak - 1.0) + 1.0) * a + 0.15 * d * d;
    let share = 1.0 / (a * peak * b);
    let new_peak = (a - d * d) * (share * peak * b);
    return mix(vec3f(new_peak), c * ((a - d * d) * b * share), a * a * peak * share);
}

fn shown(light: vec3f) -> vec3f {
    return encoded(rolled_off(light));
}

// Approximates the sRGB transfer function by roots.
fn encoded(light: vec3f) -> vec3f {
    let a = sqrt(max(light, vec3f(0.0)));
    let b = sqrt(a);
    return 0.585122381 * a + 0.783140355 * b - 0.368262736 * sqrt(b);
}

// A fading body shows the objects behind it, most where the view is perpendicular to its surface:
// `clearest` is the opacity there.
fn seen_through(s: Surface, view: vec3f, light: vec3f, clearest: f32) -> vec4f {
    let rim = 1.0 - abs(dot(s.normal, view));
    let clear = smoothstep(0.0, 0.9, scene.look.x);
    let alpha = mix(1.0, mix(clearest, 0.45, rim * rim), clear);
    // Transmitted light glows in the body's own colour instead of darkening the objects behind.
    let glow = s.base * 0.9 + 0.22;
    return vec4f(shown(mix(light, glow, 0.65 * clear)), alpha);
}

fn towards_eye(world: vec3f) -> vec3f {
    return select(-scene.forward.xyz, normalize(scene.eye.xyz - world), scene.eye.w > 0.5);
}

// Distance in front of the cut face, negative behind it; negative everywhere in a body that is not
// cut open.
fn before_cut(world: vec3f) -> f32 {
    return select(dot(world - scene.focus.xyz, scene.cut.xyz), -1.0, scene.look.y > 0.5);
}
