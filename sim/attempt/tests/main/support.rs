//! A session, and files in memory.

use data_encoding::HEXLOWER;
use law::axial::ForceLaw;
use recording::session::{EXERCISE_ATTACHMENT, SCENE_ATTACHMENT};
use recording::write::SceneDrawing;
use recording::{Attachment, Recording, Sample, Session, Writer};
use sha2::{Digest, Sha256};
use time::macros::datetime;

/// The documents.
const EXERCISE: &[u8] = b"id = \"feel-the-layers\"\n";
const SCENE: [u8; 4] = [0, 159, 146, 150];

fn sha256(document: &[u8]) -> String {
    HEXLOWER.encode(&Sha256::digest(document))
}

fn session() -> Session {
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

fn attachments() -> Vec<Attachment> {
    let file = |name: &str, data: &[u8]| Attachment {
        name: name.to_owned(),
        media_type: "application/toml".to_owned(),
        data: data.to_vec(),
    };
    vec![file(EXERCISE_ATTACHMENT, EXERCISE), file(SCENE_ATTACHMENT, &SCENE)]
}

pub fn writer() -> Writer<Vec<u8>> {
    writer_under(ForceLaw::Version2)
}

/// A file of an attempt under a version of the force law.
pub fn writer_under(law: ForceLaw) -> Writer<Vec<u8>> {
    let session = Session { law, ..session() };
    Writer::create(Vec::new(), &session, &attachments(), &SceneDrawing::default()).unwrap()
}

/// A file of `count` ticks at 1 kHz of a force that no law made.
pub fn file(count: u64) -> Vec<u8> {
    let mut writer = writer();
    for n in 0..count {
        let t_s = n as f64 / 1000.0;
        let (position_m, orientation) = ([0.0, 0.0, 0.01 - 0.002 * t_s], [1.0, 0.0, 0.0, 0.0]);
        writer.sample(&Sample { t_s, position_m, orientation, tip_n: 1.0, ..Sample::default() }).unwrap();
    }
    writer.finish().unwrap()
}

pub fn read(bytes: &[u8]) -> Recording {
    Recording::read(bytes).unwrap()
}
