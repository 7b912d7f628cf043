//! Recordings of short attempts at the shipped exercise, simulated with the real force law.

use std::io::Cursor;
use std::sync::LazyLock;

use attempt::simulate::{Clock, MotionSource, simulate};
use data_encoding::HEXLOWER;
use documents::{ExerciseBundle, Patient};
use ed25519_dalek::{Signer, SigningKey};
use law::operator::{Felt, Motion};
use model::ids::{SessionId, StationId};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use recording::session::{EXERCISE_ATTACHMENT, SCENE_ATTACHMENT};
use recording::write::SceneDrawing;
use recording::{Attachment, Event, EventKind, Sample, Session, Signature, Writer, signature};
use time::OffsetDateTime;
use tissue::Specimen;

use super::course_folder;

/// The shipped exercise that is attempted.
pub static EXERCISE: LazyLock<ExerciseBundle> =
    LazyLock::new(|| ExerciseBundle::read(&course_folder().join("1-feel-the-layers.toml")).unwrap());

/// What an attempt is to be.
#[derive(Clone)]
pub struct Attempt {
    pub session_id: SessionId,
    /// Pseudonym in the metadata.
    pub trainee: String,
    pub seed: u64,
    /// Depth at which the hand turns back, in mm.
    pub depth_mm: f64,
    /// Whose hand it is: none moves as another does. By default one of the session's own.
    pub hand: Option<SessionId>,
    /// When it begins.
    pub started_at: OffsetDateTime,
    /// The exercise that is attempted.
    pub bundle: &'static ExerciseBundle,
    /// The station that signs it.
    pub station: Option<Station>,
}

/// A station as its own machine knows it.
#[derive(Clone)]
pub struct Station {
    pub id: StationId,
    pub key: SigningKey,
}

impl Default for Attempt {
    fn default() -> Self {
        Self {
            session_id: SessionId::random(),
            trainee: String::new(),
            seed: 7,
            depth_mm: 20.0,
            hand: None,
            started_at: time::macros::datetime!(2026-03-04 05:06:07 UTC),
            bundle: &EXERCISE,
            station: None,
        }
    }
}

/// The same exercise as a forger wants it: whatever the hand does is passed.
pub static FORGED: LazyLock<ExerciseBundle> = LazyLock::new(|| {
    let text = String::from_utf8(EXERCISE.exercise_bytes.clone()).unwrap();
    let line = text.lines().find(|line| line.starts_with("pass_mark")).unwrap();
    let forged = text.replace(line, "pass_mark = 0");
    ExerciseBundle::from_parts(forged.as_bytes(), &EXERCISE.scene_bytes, &[]).unwrap()
});

/// A hand that goes straight in at 20 mm/s, confirms, and comes straight out.
struct StraightHand {
    t_s: f64,
    depth_m: f64,
    /// What tells it from other hands, in m: far less than it takes to change a score.
    beside_m: f64,
}

impl MotionSource for StraightHand {
    fn step(&mut self, dt_s: f64, _felt: &Felt) -> Motion {
        const START_M: f64 = -0.005;
        const SPEED_M_PER_S: f64 = 0.02;
        self.t_s += dt_s;
        let way_m = self.depth_m - START_M;
        let gone_m = self.t_s * SPEED_M_PER_S;
        let x_m = if gone_m < way_m { START_M + gone_m } else { self.depth_m - (gone_m - way_m) };
        // The needle's +z points to its tip; turned about x it points into the body.
        let turned = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        Motion {
            patient_from_needle: Isometry3::from_parts(Translation3::new(self.beside_m, 0.0, -x_m), turned),
            confirm: (gone_m - way_m).abs() < 1e-3,
            done: gone_m > 2.0 * way_m,
        }
    }
}

fn session(attempt: &Attempt, patient: &Patient) -> Session {
    Session {
        session_id: attempt.session_id.uuid(),
        exercise_id: attempt.bundle.exercise.id.clone(),
        exercise_sha256: attempt.bundle.exercise.sha256.clone(),
        scene_sha256: attempt.bundle.scene.sha256.clone(),
        simulator_version: "0.1.0".to_owned(),
        git: String::new(),
        device: "operator:test".to_owned(),
        device_max_force_n: f64::INFINITY,
        law: EXERCISE.scene.law,
        judging: law::Judging::default(),
        tick_hz: 1000.0,
        seed: attempt.seed,
        trainee: attempt.trainee.clone(),
        started_at: attempt.started_at,
        patient_thickness_mm: patient.thickness_mm.clone(),
    }
}

fn document(name: &str, data: &[u8]) -> Attachment {
    Attachment { name: name.to_owned(), media_type: "application/toml".to_owned(), data: data.to_vec() }
}

fn attachments(bundle: &ExerciseBundle) -> Vec<Attachment> {
    vec![document(EXERCISE_ATTACHMENT, &bundle.exercise_bytes), document(SCENE_ATTACHMENT, &bundle.scene_bytes)]
}

/// Records an attempt; `spoil` may add to what is written before it ends.
fn write(attempt: &Attempt, spoil: impl FnOnce(&mut Writer<Cursor<Vec<u8>>>), moves: bool) -> Vec<u8> {
    write_with(attempt, &attachments(attempt.bundle), spoil, moves)
}

fn write_with(
    attempt: &Attempt,
    attachments: &[Attachment],
    spoil: impl FnOnce(&mut Writer<Cursor<Vec<u8>>>),
    moves: bool,
) -> Vec<u8> {
    let patient = Patient::draw(&EXERCISE.scene, attempt.seed);
    let params = Specimen::new(EXERCISE.specimen_spec(&patient)).unwrap();
    let (sink, session) = (Cursor::new(Vec::new()), session(attempt, &patient));
    let mut writer = Writer::create(sink, &session, attachments, &SceneDrawing::default()).unwrap();
    if moves {
        let beside_m = attempt.hand.unwrap_or(attempt.session_id).uuid().as_u128() as u32;
        let mut hand =
            StraightHand { t_s: 0.0, depth_m: attempt.depth_mm * 1e-3, beside_m: f64::from(beside_m) * 1e-18 };
        simulate(&params, &mut hand, &mut writer, &Clock { tick_hz: 1000.0, time_limit_s: 30.0 }).unwrap();
    }
    spoil(&mut writer);
    if let Some(Station { id, key }) = &attempt.station {
        let signed = signature::signed_statement(&session, id.uuid(), &writer.hashes());
        let ed25519 = HEXLOWER.encode(&key.sign(&signed).to_bytes());
        writer.sign(&Signature { station: id.uuid(), ed25519 }).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// A whole attempt.
pub fn record(attempt: &Attempt) -> Vec<u8> {
    write(attempt, |_| {}, true)
}

/// An attempt whose recording carries one file more.
pub fn with_attachment(attempt: &Attempt, name: &str, data: &[u8]) -> Vec<u8> {
    let mut attachments = attachments(attempt.bundle);
    attachments.push(document(name, data));
    write_with(attempt, &attachments, |_| {}, true)
}

/// An attempt whose last force is not what the tissue answered.
pub fn tampered(attempt: &Attempt) -> Vec<u8> {
    let forged = |writer: &mut Writer<_>| {
        let sample = Sample { t_s: 60.0, orientation: [1.0, 0.0, 0.0, 0.0], tip_n: 3.0, ..Sample::default() };
        writer.sample(&sample).unwrap();
    };
    write(attempt, forged, true)
}

/// An attempt that a lost device has ended.
pub fn interrupted(attempt: &Attempt) -> Vec<u8> {
    let lost = |writer: &mut Writer<_>| {
        let event = Event {
            t_s: 1.0,
            kind: EventKind::Interrupted,
            boundary: None,
            x_m: 0.01,
            position_m: [0.0; 3],
            force_n: 0.0,
            dissipated_j: 0.0,
            track: None,
            structure: None,
            text: "device lost: the device is gone".to_owned(),
        };
        writer.event(&event).unwrap();
    };
    write(attempt, lost, true)
}

/// A recording in which nothing moved.
pub fn without_samples(attempt: &Attempt) -> Vec<u8> {
    write(attempt, |_| {}, false)
}
