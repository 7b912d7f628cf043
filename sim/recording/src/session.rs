//! Who, what and with which program: the metadata record `stylet.session`, and the attachments.

use law::Judging;
use law::axial::ForceLaw;
use uuid::Uuid;

/// Name of the attachment that holds the exercise.
pub const EXERCISE_ATTACHMENT: &str = "exercise.toml";
/// Name of the attachment that holds the scene.
pub const SCENE_ATTACHMENT: &str = "scene.toml";
/// Prefix of the name of an attachment that holds a mesh; the scene's name for it follows.
pub const MESH_PREFIX: &str = "mesh/";

/// The metadata of an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Session {
    /// UUIDv7 made by the client.
    pub session_id: Uuid,
    /// Exercise id.
    pub exercise_id: String,
    /// SHA-256 of the exercise document, lower-case hexadecimal.
    pub exercise_sha256: String,
    /// SHA-256 of the scene document.
    pub scene_sha256: String,
    /// Version of the simulator.
    pub simulator_version: String,
    /// Commit the simulator was built from, with `-dirty` where its sources differed from it; empty where it was built without
    /// git, and in what the service simulates for its demonstration.
    pub git: String,
    /// Device name, for example `operator:novice`.
    pub device: String,
    /// Device's maximum force, in N; infinite for an operator.
    pub device_max_force_n: f64,
    /// Version of the force law, as its scene names it.
    pub law: ForceLaw,
    /// How the error of the tissue's field was judged, which decides its meshes.
    pub judging: Judging,
    /// Servo rate, in Hz.
    pub tick_hz: f64,
    /// Seed of the patient and the operator.
    pub seed: u64,
    /// Opaque pseudonym of the trainee, never a name; may be empty.
    pub trainee: String,
    /// Start, RFC 3339 in UTC.
    pub started_at: time::OffsetDateTime,
    /// Thickness of each layer of the drawn patient, in mm.
    pub patient_thickness_mm: Vec<f64>,
}

impl Session {
    /// Of an attempt that stays in memory: nobody's, at no time, of no document, at 1 kHz.
    #[must_use]
    pub fn in_memory(law: ForceLaw, patient_thickness_mm: Vec<f64>) -> Self {
        Self {
            session_id: Uuid::nil(),
            exercise_id: String::new(),
            exercise_sha256: String::new(),
            scene_sha256: String::new(),
            simulator_version: env!("CARGO_PKG_VERSION").to_owned(),
            git: String::new(),
            device: "operator:memory".to_owned(),
            device_max_force_n: f64::INFINITY,
            law,
            judging: Judging::default(),
            tick_hz: 1000.0,
            seed: 0,
            trainee: String::new(),
            started_at: time::OffsetDateTime::UNIX_EPOCH,
            patient_thickness_mm,
        }
    }
}

/// A file carried in the recording byte for byte.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    /// Name.
    pub name: String,
    /// Media type.
    pub media_type: String,
    /// Bytes.
    pub data: Vec<u8>,
}
