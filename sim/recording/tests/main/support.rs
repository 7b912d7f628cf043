//! A session, samples that look like a puncture, and files made of them.

use data_encoding::HEXLOWER;
use law::axial::ForceLaw;
use law::ledger::{LayerEnergy, Ledger};
use law::structures::{Shape, StructureKind, StructureSpec};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use recording::sample::flags;
use recording::session::{EXERCISE_ATTACHMENT, SCENE_ATTACHMENT};
use recording::write::SceneDrawing;
use recording::{Attachment, Energy, Event, EventKind, Recording, Sample, Session, Writer};
use sha2::{Digest, Sha256};
use time::macros::datetime;

/// The documents.
const EXERCISE: &[u8] = b"id = \"feel-the-layers\"\n";
const SCENE: [u8; 4] = [0, 159, 146, 150];

fn sha256(document: &[u8]) -> String {
    HEXLOWER.encode(&Sha256::digest(document))
}

pub fn session() -> Session {
    Session {
        session_id: "018f4c1e-7a2b-7c3d-8e4f-0123456789ab".parse().unwrap(),
        exercise_id: "feel-the-layers".to_owned(),
        exercise_sha256: sha256(EXERCISE),
        scene_sha256: sha256(&SCENE),
        simulator_version: "0.1.0".to_owned(),
        git: String::new(),
        device: "operator:novice".to_owned(),
        device_max_force_n: f64::INFINITY,
        law: ForceLaw::Version2,
        judging: law::Judging::default(),
        tick_hz: 1000.0,
        seed: u64::MAX,
        trainee: "t-17".to_owned(),
        started_at: datetime!(2031-05-06 07:08:09.000000001 UTC),
        patient_thickness_mm: vec![0.1 + 0.2, 8.4, 39.0],
    }
}

pub fn attachments() -> Vec<Attachment> {
    let file = |name: &str, data: &[u8]| Attachment {
        name: name.to_owned(),
        media_type: "application/toml".to_owned(),
        data: data.to_vec(),
    };
    vec![file(EXERCISE_ATTACHMENT, EXERCISE), file(SCENE_ATTACHMENT, &SCENE)]
}

pub fn drawing() -> SceneDrawing {
    let structure = |name: &str, kind, shape| StructureSpec {
        name: name.to_owned(),
        kind,
        shape,
        position_m: Point3::new(0.01, 0.0, -0.03),
        wall: None,
    };
    SceneDrawing {
        layers: vec![("skin".to_owned(), 0.0008), ("fascia".to_owned(), 0.0), ("muscle".to_owned(), 0.039)],
        structures: vec![
            structure("cyst", StructureKind::Target, Shape::Sphere { radius_m: 0.004 }),
            structure(
                "artery",
                StructureKind::Vessel,
                Shape::Capsule { half_axis_m: Vector3::new(0.0, 0.0, -0.02), radius_m: 0.002 },
            ),
            structure("rib", StructureKind::Bone, Shape::Box { half_extents_m: Vector3::new(0.01, 0.02, 0.003) }),
            structure(
                "spleen",
                StructureKind::Organ,
                Shape::Mesh {
                    vertices_m: vec![Point3::origin(), Point3::new(0.01, 0.0, 0.0), Point3::new(0.0, 0.01, 0.0)],
                    triangles: vec![[0, 1, 2]],
                },
            ),
        ],
        needle_length_m: 0.1,
        needle_radius_m: 0.001,
    }
}

/// A noise of ±0.5 that is the same everywhere and does not compress, like a tremor.
pub fn noise(n: u64) -> f64 {
    let mixed = (n ^ (n >> 7)).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (mixed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// Tick `n` of a hand that trembles its way in at 2 mm/s.
pub fn sample(n: u64) -> Sample {
    let t_s = n as f64 / 1000.0;
    let wobble = |k: u64| 1e-4 * noise(8 * n + k);
    let force = |k: u64| (1.0 + noise(8 * n + k)) as f32;
    Sample {
        t_s,
        position_m: [wobble(0), wobble(1), 0.01 - 0.002 * t_s + wobble(2)],
        orientation: UnitQuaternion::from_euler_angles(wobble(3), 3.0, wobble(4)).coords.into(),
        velocity_m_per_s: [force(0), force(1), force(2)],
        x_m: 0.002 * t_s + wobble(2),
        depth_m: 0.001 * force(3),
        force_n: [force(0), force(1), force(2)],
        tip_n: force(3),
        rim_n: force(4),
        viscous_n: force(5),
        friction_n: force(6),
        cutting_n: force(7),
        lateral_n: [force(5), force(6), force(7)],
        device_n: [force(0), force(1), force(2)],
        flags: flags::INSIDE,
        lateness_us: 40.0 * force(1),
        bend_m: [0.0; 3],
    }
}

pub fn samples(count: u64) -> Vec<Sample> {
    (0..count).map(sample).collect()
}

pub fn rupture(t_s: f64) -> Event {
    Event {
        t_s,
        kind: EventKind::TipRupture,
        boundary: Some(0),
        x_m: 0.003_021_1,
        position_m: [1e-4, -2e-4, -0.003],
        force_n: 1.0,
        dissipated_j: 1.5e-3,
        track: None,
        structure: None,
        text: "skin".to_owned(),
    }
}

pub fn energy(t_s: f64) -> Energy {
    let layer = |k: f64| LayerEnergy {
        elastic_j: 0.1 * k,
        rupture_j: 0.2 * k,
        viscous_j: 0.3 * k,
        friction_j: 0.4 * k,
        cutting_j: 0.5 * k,
        lateral_j: 0.6 * k,
    };
    let ledger = Ledger {
        input_j: t_s,
        returned_j: 0.1,
        presliding_j: 0.01,
        lagged_j: 0.002,
        layers: vec![layer(1.0), layer(3.0)],
    };
    Energy { t_s, ledger }
}

pub fn writer() -> Writer<Vec<u8>> {
    Writer::create(Vec::new(), &session(), &attachments(), &drawing()).unwrap()
}

/// A file of `count` ticks at 1 kHz with a rupture and a ledger in the middle.
pub fn file(count: u64) -> Vec<u8> {
    let mut writer = writer();
    for n in 0..count {
        let sample = sample(n);
        writer.sample(&sample).unwrap();
        if n == count / 2 {
            writer.event(&rupture(sample.t_s)).unwrap();
            writer.energy(&energy(sample.t_s)).unwrap();
        }
    }
    writer.finish().unwrap()
}

pub fn read(bytes: &[u8]) -> Recording {
    Recording::read(bytes).unwrap()
}
