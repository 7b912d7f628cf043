//! The body that the pictures of the tests are of: the training scene's layers with a vessel, a bone and a target, and a field
//! like that of an elastic half-space.

use render::frame::{
    DrawnLayer, DrawnMaterial, DrawnNeedle, DrawnPuncture, DrawnStructure, DrawnStructureKind, FieldTable, Frame, Mesh,
    Stage, Tip,
};

/// Skin, fat, fascia, muscle: name, material, thickness in m, stiffness in N/m.
const LAYERS: [(&str, DrawnMaterial, f32, f32); 4] = [
    ("skin", DrawnMaterial::Skin, 0.0008, 331.0),
    ("fat", DrawnMaterial::Fat, 0.0084, 83.0),
    ("fascia", DrawnMaterial::Fascia, 0.0006, 800.0),
    ("muscle", DrawnMaterial::Muscle, 0.039, 497.0),
];
const LOADS: usize = 2 * LAYERS.len();

/// The stage: a path straight down, a target at 28 mm.
pub fn stage() -> Stage {
    let mut top_m = 0.0;
    let layers = LAYERS.map(|(name, material, thickness_m, _)| {
        let layer = DrawnLayer { name: name.to_owned(), material, top_m, thickness_m };
        top_m += thickness_m;
        layer
    });
    Stage {
        bend: render::frame::DrawnBend::Flat,
        field: field(&layers),
        layers: layers.to_vec(),
        needle: DrawnNeedle {
            length_m: 0.15,
            diameter_m: 0.002,
            tip_to_rim_m: 0.002,
            tip: Tip::Diamond,
            ..DrawnNeedle::default()
        },
        structures: vec![
            structure("lumbar vessel", DrawnStructureKind::Vessel, tube([0.011, 0.0, -0.018], 0.002, 0.03)),
            structure(
                "transverse process",
                DrawnStructureKind::Bone,
                cuboid([-0.026, 0.004, -0.030], [0.013, 0.006, 0.004]),
            ),
            structure("target", DrawnStructureKind::Target, ball([0.0, 0.0, -0.028], 0.0025)),
        ],
        entry_m: [0.0; 3],
        axis: [0.0, 0.0, -1.0],
        target_m: Some([0.0, 0.0, -0.028]),
        skin: None,
    }
}

fn structure(name: &str, kind: DrawnStructureKind, mesh: Mesh) -> DrawnStructure {
    DrawnStructure { name: name.to_owned(), kind, mesh }
}

/// A dent that is deep at the load and wide, and weaker away from its boundary.
fn field(layers: &[DrawnLayer; 4]) -> FieldTable {
    let radii_m: Vec<f32> = (0..48).map(|i| 0.06 * (i as f32 / 47.0) * (i as f32 / 47.0)).collect();
    let mut axial_m_per_n = Vec::new();
    for boundary in layers {
        for load in 0..LOADS {
            let at = load % layers.len();
            let far_m = (boundary.top_m - layers[at].top_m).abs();
            let (share, wide_m) = if load < layers.len() { (1.0, 0.0042) } else { (0.15, 0.008) };
            let peak = share / LAYERS[at].3;
            axial_m_per_n.extend(radii_m.iter().map(|r| peak * wide_m / (wide_m + r + 1.2 * far_m)));
        }
    }
    FieldTable { radii_m, loads: LOADS, axial_m_per_n }
}

/// The needle's tip at a depth along the path, in m; no puncture yet.
pub fn at_depth(depth_m: f32) -> Frame {
    Frame {
        tip_m: [0.0, 0.0, -depth_m],
        // Half a turn around x: from hub to tip is down.
        orientation: [1.0, 0.0, 0.0, 0.0],
        loads_n: vec![0.0; LOADS],
        ..Frame::default()
    }
}

/// The tip presses on a boundary that it has not opened, having opened those before.
pub fn tenting(boundary: usize, depth_m: f32, blood: f32) -> Frame {
    let mut frame = at_depth(depth_m);
    let top_m: f32 = LAYERS[..boundary].iter().map(|layer| layer.2).sum();
    frame.loads_n[boundary] = LAYERS[boundary].3 * (depth_m - top_m);
    let mut tops_m = LAYERS.iter().scan(0.0, |top_m, layer| Some(std::mem::replace(top_m, *top_m + layer.2)));
    // All others go with the field.
    frame.dents_m = (0..boundary).map(|_| f32::NAN).collect();
    frame.dents_m.extend(tops_m.nth(boundary).map(|top_m| depth_m - top_m));
    inside(frame, boundary as u32, blood)
}

/// The needle is in the tissue and has opened so many boundaries.
pub fn inside(frame: Frame, opened: u32, blood: f32) -> Frame {
    let depth_m = -frame.tip_m[2];
    let puncture = DrawnPuncture { entry_m: [0.0; 3], axis: [0.0, 0.0, -1.0], depth_m, opened, blood };
    Frame { entry_m: Some([0.0; 3]), punctures: vec![puncture], ..frame }
}

/// A sphere.
pub fn ball(middle: [f32; 3], radius_m: f32) -> Mesh {
    round(middle, radius_m, 0.0)
}

/// A capsule along y.
pub fn tube(middle: [f32; 3], radius_m: f32, half_m: f32) -> Mesh {
    round(middle, radius_m, half_m)
}

fn round(middle: [f32; 3], radius_m: f32, half_m: f32) -> Mesh {
    const AROUND: u32 = 32;
    const ALONG: u32 = 24;
    let mut mesh = Mesh::default();
    for i in 0..=ALONG {
        let polar = std::f32::consts::PI * i as f32 / ALONG as f32;
        let shift = if i <= ALONG / 2 { half_m } else { -half_m };
        for k in 0..AROUND {
            let angle = std::f32::consts::TAU * k as f32 / AROUND as f32;
            let (x, z) = (angle.cos() * polar.sin() * radius_m, angle.sin() * polar.sin() * radius_m);
            mesh.positions_m.push([middle[0] + x, middle[1] + polar.cos() * radius_m + shift, middle[2] + z]);
        }
    }
    for i in 0..ALONG {
        for k in 0..AROUND {
            let (a, b) = (i * AROUND + k, i * AROUND + (k + 1) % AROUND);
            mesh.triangles.extend([[a, a + AROUND, b], [b, a + AROUND, b + AROUND]]);
        }
    }
    mesh
}

/// A box.
pub fn cuboid(middle: [f32; 3], half_m: [f32; 3]) -> Mesh {
    let corner =
        |i: usize| [0, 1, 2].map(|axis| middle[axis] + if i >> axis & 1 == 1 { half_m[axis] } else { -half_m[axis] });
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Mesh { positions_m: (0..8).map(corner).collect(), triangles }
}
