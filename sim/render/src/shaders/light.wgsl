// Light on a surface: a lamp with shadows, a softer fill, and a room that is mirrored. Linear colours.

@group(1) @binding(0) var albedos: texture_2d_array<f32>;
@group(1) @binding(1) var reliefs: texture_2d_array<f32>;
@group(1) @binding(2) var tiles: sampler;
@group(1) @binding(3) var shadow_map: texture_depth_2d;
@group(1) @binding(4) var shadow_compare: sampler_comparison;

const PI: f32 = 3.14159265;
const LAMP: vec3f = vec3f(2.75, 2.62, 2.42);
const FILL: vec3f = vec3f(0.30, 0.36, 0.44);
const FILL_FROM: vec3f = vec3f(0.66, -0.62, 0.42);

struct Surface {
    base: vec3f,
    normal: vec3f,
    rough: f32,
    metal: f32,
    // How far light wraps around what it enters: 0 wood, 0.4 skin.
    soft: f32,
    open: f32,
}

// What lies behind everything, and what metal mirrors: softboxes above, a dim room, the drape below.
fn room(dir: vec3f, rough: f32) -> vec3f {
    let up = dir.z;
    let wall = mix(vec3f(0.20, 0.23, 0.26), vec3f(0.52, 0.58, 0.63), smoothstep(-0.3, 0.75, up));
    let floor = vec3f(0.055, 0.13, 0.15);
    let edge = 0.04 + 0.5 * rough;
    var light = mix(floor, wall, smoothstep(-edge, edge, up));
    let blur = 0.03 + 0.6 * rough;
    let lamp = dot(dir, scene.lamp.xyz);
    light += LAMP * 1.1 * smoothstep(0.93 - blur, 0.95 + 0.3 * blur, lamp) * (1.0 - 0.75 * rough);
    // A strip window on the right and a narrow one on the left draw lines along a shaft.
    let side = dir.x / max(length(dir.xy), 1e-4);
    let band = smoothstep(-0.35 - blur, 0.1, up) * (1.0 - smoothstep(0.55, 0.9 + blur, up));
    light += vec3f(0.95, 1.0, 1.06) * band * smoothstep(0.80 - blur, 0.86 + blur, side) * (1.0 - 0.6 * rough);
    light += vec3f(0.55, 0.6, 0.66) * band * smoothstep(0.90 - blur, 0.94 + blur, -side) * (1.0 - 0.6 * rough);
    return light;
}

fn ambient(normal: vec3f) -> vec3f {
    let sky = mix(vec3f(0.20, 0.22, 0.25), vec3f(0.46, 0.49, 0.52), 0.5 + 0.5 * normal.z);
    return mix(vec3f(0.10, 0.13, 0.14), sky, smoothstep(-1.0, 0.3, normal.z));
}

fn shadow(world: vec3f, normal: vec3f) -> f32 {
    let texel = scene.lamp.w;
    if texel == 0.0 {
        return 1.0;
    }
    let at = scene.light_clip_from_world * vec4f(world + normal * 4e-4, 1.0);
    let uv = vec2f(0.5, -0.5) * at.xy + 0.5;
    var lit = 0.0;
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            lit += textureSampleCompareLevel(shadow_map, shadow_compare, uv + vec2f(f32(x), f32(y)) * 0.85 * texel, at.z - 8e-4);
        }
    }
    let inside = all(abs(at.xy) < vec2f(0.99));
    return select(1.0, 0.25 * lit, inside);
}

// Distribution and shadowing of facets: GGX with Schlick's approximations (Karis, 2013).
fn glint(s: Surface, view: vec3f, light: vec3f, f0: vec3f) -> vec3f {
    let half_way = normalize(view + light);
    let nh = max(dot(s.normal, half_way), 0.0);
    let nl = max(dot(s.normal, light), 0.0);
    let nv = max(dot(s.normal, view), 1e-3);
    let a = s.rough * s.rough;
    let d = nh * nh * (a * a - 1.0) + 1.0;
    let k = 0.125 * (s.rough + 1.0) * (s.rough + 1.0);
    let visible = 0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
    let fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(view, half_way), 0.0), 5.0);
    return fresnel * (a * a / (PI * d * d) * visible * nl);
}

fn wrapped(nl: f32, soft: f32) -> vec3f {
    // Light that wraps is redder the further it went under the surface.
    let w = soft * vec3f(1.0, 0.45, 0.35);
    return max((vec3f(nl) + w) / ((1.0 + w) * (1.0 + w)), vec3f(0.0));
}

fn lit(s: Surface, view: vec3f, world: vec3f, flat_normal: vec3f) -> vec3f {
    let f0 = mix(vec3f(0.04), s.base, s.metal);
    let clear = shadow(world, flat_normal);
    let nl = dot(s.normal, scene.lamp.xyz);
    let paint = s.base * (1.0 - s.metal) / PI;
    var light = LAMP * clear * (PI * 0.62 * paint * wrapped(nl, s.soft) + glint(s, view, scene.lamp.xyz, f0));
    let fill = normalize(FILL_FROM);
    light += FILL * (PI * 0.62 * paint * wrapped(dot(s.normal, fill), s.soft) + glint(s, view, fill, f0));
    light += s.open * PI * 0.62 * paint * ambient(s.normal);
    // The room in the mirror, by an analytic fit of the split sum (Karis, 2014).
    let nv = max(dot(s.normal, view), 0.0);
    let c = vec4f(-1.0, -0.0275, -0.572, 0.022) * s.rough + vec4f(1.0, 0.0425, 1.04, -0.04);
    let a = min(c.x * c.x, exp2(-9.28 * nv)) * c.x + c.y;
    let split = f0 * (-1.04 * a + c.z) + (1.04 * a + c.w);
    light += s.open * split * room(reflect(-view, s.normal), s.rough) * mix(0.55, 1.0, clear);
    return light;
}

// Khronos PBR Neutral: colours of base stay what they are, highlights roll off.
fn shown(light: vec3f) -> vec3f {
    let low = min(light.x, min(light.y, light.z));
    let toe = select(0.04, low - 6.25 * low * low, low < 0.08);
    let c = light - toe;
    let peak = max(c.x, max(c.y, c.z));
    let start = 0.76;
    if peak < start {
        return c;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    let g = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(c * (new_peak / peak), vec3f(new_peak), g);
}

fn towards_eye(world: vec3f) -> vec3f {
    return select(-scene.forward.xyz, normalize(scene.eye.xyz - world), scene.eye.w > 0.5);
}

// Distance in front of the cut face, negative behind it.
fn before_cut(world: vec3f) -> f32 {
    return dot(world - scene.focus.xyz, scene.cut.xyz);
}
