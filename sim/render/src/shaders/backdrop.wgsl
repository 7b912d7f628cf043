// The background: the drape under the body, and a softly lit room. All of it is smooth except the
// shadows, so its light is computed at the corners of a grid.

struct Varying {
    @builtin(position) clip: vec4f,
    // Display colour in the shadow, and in the lamp's light.
    @location(0) dark: vec3f,
    @location(1) bright: vec3f,
    // Position on the drape in the lamp's clip space, scaled; w holds the scale.
    @location(2) lamp: vec4f,
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

// The tray shades the cloth too: its centre, rotation and half extent are those of `tray.rs`.
fn beside_tray(off: vec2f) -> f32 {
    let from_middle = off + vec2f(0.0, 0.5 * scene.away.w) - TRAY;
    let turned = vec2f(0.976 * from_middle.x - 0.218 * from_middle.y, 0.218 * from_middle.x + 0.976 * from_middle.y);
    return mix(0.40, 1.0, smoothstep(-0.002, 0.022, length(max(abs(turned) - vec2f(0.058, 0.042), vec2f(0.0)))));
}

// The drape's light with and without the lamp, linear.
struct Light {
    dark: vec3f,
    bright: vec3f,
}

fn cloth(world: vec3f, base: vec3f) -> Light {
    let normal = normalize(vec3f(-fold_slope(world.xy), 1.0));
    let from_focus = world - scene.focus.xyz;
    let off = vec2f(dot(from_focus, scene.across.xyz), dot(from_focus, scene.away.xyz) - 0.5 * scene.away.w);
    let outside = length(max(abs(off) - vec2f(scene.across.w, 0.5 * scene.away.w), vec2f(0.0)));
    // The body shades the cloth close to it from the room's light.
    let close = max(0.30, scene.look.x);
    let open = mix(close, 1.0, smoothstep(-0.004, 0.05, outside)) * beside_tray(off);
    let dark = base * (0.62 * open * (FILL * 0.6 + ambient(normal)));
    return Light(dark, dark + base * (0.62 * LAMP * wrapped(dot(normal, scene.lamp.xyz), 0.25)));
}

// Far away the drape fades into the room; the picture is darker towards its corners.
fn of_light(light: Light, room: vec3f, far: f32, ndc: vec2f) -> Varying {
    let vignette = 1.0 - 0.20 * dot(ndc, ndc);
    let lost = smoothstep(0.16, 0.62, far);
    var out: Varying;
    out.dark = shown(mix(light.dark, room, lost) * vignette);
    out.bright = shown(mix(light.bright, room, lost) * vignette);
    return out;
}

const TEAL: vec3f = vec3f(0.030, 0.098, 0.118);
const RED: vec3f = vec3f(0.34, 0.105, 0.095);
const LIFT: vec3f = vec3f(0.0, 0.0, 4e-4);

// at: a corner of a grid over the picture.
@vertex
fn backdrop_vertex(@location(0) at: vec4f) -> Varying {
    let ndc = at.xy;
    let end = scene.world_from_clip * vec4f(ndc, 1.0, 1.0);
    let ray = end.xyz / end.w - scene.eye.xyz;
    let up = normalize(ray).z;
    let room = mix(vec3f(0.105, 0.135, 0.158), vec3f(0.032, 0.043, 0.056), smoothstep(-0.10, 0.45, up));
    let height = scene.place.w - scene.eye.z;
    let world = scene.eye.xyz + ray * (height / min(ray.z, -1e-6));
    let far = select(1.0, length(world.xy - scene.focus.xy), up < -0.01);
    var out = of_light(cloth(world, TEAL), room, far, ndc);
    out.clip = vec4f(ndc, 1.0, 1.0);
    // Scaled by the ray's descent, so that the position on the drape interpolates linearly over the
    // picture.
    out.lamp = scene.light_clip_from_world * vec4f((scene.eye.xyz + LIFT) * ray.z + ray * height, ray.z);
    return out;
}

// The cloth would turn red tissue grey under a body that is seen through: the colour of deeper
// tissue is shown instead. at: a corner of a grid under the body.
@vertex
fn floor_vertex(@location(0) at: vec4f) -> Varying {
    let plan = scene.focus.xyz + scene.across.xyz * (at.x * scene.across.w) + scene.away.xyz * ((0.5 + 0.5 * at.y) * scene.away.w);
    let world = vec3f(plan.xy, scene.place.w);
    let clip = scene.clip_from_world * vec4f(world, 1.0);
    let light = cloth(world, mix(TEAL, RED, scene.look.x));
    var out = of_light(light, vec3f(0.0), 0.0, clip.xy / max(clip.w, 1e-3));
    // Behind everything but the room, and not visible from below.
    out.clip = select(vec4f(0.0, 0.0, -1.0, 1.0), vec4f(clip.xy, 0.99999 * clip.w, clip.w), scene.eye.z > world.z);
    out.lamp = scene.light_clip_from_world * vec4f(world + LIFT, 1.0);
    return out;
}

@fragment
fn backdrop_fragment(in: Varying) -> @location(0) vec4f {
    let lamp = in.lamp.xyz / in.lamp.w;
    return vec4f(mix(in.dark, in.bright, shadow(lamp) * beside_needle(lamp)), 1.0);
}

// Without shadows.
@fragment
fn bright_fragment(in: Varying) -> @location(0) vec4f {
    return vec4f(in.bright, 1.0);
}

struct Paper {
    @builtin(position) clip: vec4f,
    @location(0) up: f32,
}

@vertex
fn paper_vertex(@location(0) at: vec4f) -> Paper {
    return Paper(vec4f(at.xy, 1.0, 1.0), 0.5 + 0.5 * at.y);
}

// The background of a section: paper.
@fragment
fn paper_fragment(in: Paper) -> @location(0) vec4f {
    return vec4f(mix(vec3f(0.80, 0.835, 0.86), vec3f(0.90, 0.925, 0.94), in.up), 1.0);
}
