//! The sample scene.

use documents::{Needle, Scene, SceneLayer, SceneLayerOptions, SceneStructure, TissueOptions};
use law::structures::{Shape, StructureKind, StructureSpec};

pub(super) fn scene() -> Scene {
    let structure = |name: &str, kind, x_m, z_m| SceneStructure {
        spec: StructureSpec {
            name: name.to_owned(),
            kind,
            shape: Shape::Sphere { radius_m: 0.004 },
            position_m: nalgebra::Point3::new(x_m, 0.0, z_m),
            wall: None,
        },
        mesh_file: None,
        elastic: None,
    };
    Scene {
        id: "lower-back".to_owned(),
        title: "Lower back, with a vessel and bone".to_owned(),
        description: String::new(),
        layers: vec![layer("skin", 0.8), layer("fat", 8.4), layer("fascia", 0.6), layer("muscle", 39.0)],
        body: None,
        needle: needle(),
        rate: None,
        law: law::axial::ForceLaw::Version2,
        scaling: documents::NeedleScaling::Version1,
        structures: vec![
            structure("lumbar vessel", StructureKind::Vessel, -0.008, -0.018),
            structure("transverse process", StructureKind::Bone, 0.022, -0.022),
        ],
        skin: None,
        skin_shape: law::Skin::Flat,
        tissue: TissueOptions { model: "auto".to_owned(), tolerance: 0.01, coupling: "none".to_owned() },
        sha256: "c0ffee".to_owned(),
    }
}

fn layer(name: &str, thickness_mm: f64) -> SceneLayer {
    SceneLayer {
        name: name.to_owned(),
        thickness_mm,
        thickness_spread_mm: 0.1,
        stiffness_n_per_m: 331.0,
        damping_n_s_per_m2: 300.0,
        tip_rupture_n: 1.0,
        rim_rupture_n: 1.3,
        friction_n_per_m: 100.0,
        cutting_n: 0.3,
        density_kg_per_m3: 1090.0,
        poisson_ratio: 0.45,
        youngs_modulus_pa: None,
        toughness_factor: 1.0,
        recoil_time_s: None,
        texture: name.to_owned(),
        source: "sample".to_owned(),
        provenance: Vec::new(),
        options: SceneLayerOptions::default(),
    }
}

fn needle() -> Needle {
    Needle {
        kind: "trocar".to_owned(),
        family: None,
        diameter_mm: 2.0,
        diameter_exponent: 1.0,
        tip: "diamond".to_owned(),
        hub: "stylet".to_owned(),
        tip_to_rim_mm: 2.0,
        length_mm: 150.0,
        hub_stiffness_n_per_m: None,
        lubrication: 1.0,
        flexible: false,
        youngs_modulus_pa: 193e9,
        inner_diameter_mm: 0.0,
        presliding_stiffness_n_per_m: 2000.0,
        speed_window_ms: 12.0,
        damping_time_ms: 0.0,
        lateral_stiffness_n_per_m2: 10_000.0,
        breakaway_mm: None,
        friction_rest_s: 1.0,
    }
}
