//! An attempt in progress: the servo, the recorder, and the window's view of both.

pub mod desk;
mod faults;
pub mod given;
pub mod history;
pub mod open;
mod recorder;
mod shown;
pub mod wall;
pub mod x_ray;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use documents::{Channel, ExerciseBundle};
use haptics::device::DeviceInfo;
use haptics::mapping::Mapping;
use haptics::scaling::Scaling;
use haptics::servo::{self, Driven, LatestReader, Report, Running, Setup};
use law::operator::{Operator, Skill};
use phrase::{Phrase, phrase};
pub use recorder::{Kept, Unsaved, recover_left_behind};
use recording::Session;
pub use shown::{AttemptView, Phase, SpokenEvent};
use tissue::Specimen;

use crate::exit::Failure;
use crate::station::StationKey;

/// The inputs of an attempt. Shared with the recorder's thread.
pub struct LiveTrial {
    /// The exercise and its scene.
    pub bundle: ExerciseBundle,
    /// The punctured tissue: the session's patient.
    pub specimen: Arc<Specimen>,
    /// Trainee, exercise, device and start time.
    pub session: Session,
    /// Path of the finished recording.
    pub path: PathBuf,
    /// The C-arm, if the exercise has one and its pictures are given to the trainee.
    pub arm: Option<x_ray::LiveArm>,
    /// The station's key, which attests that a person made the attempt; `None` if it is not to be
    /// signed.
    pub key: Option<Arc<StationKey>>,
}

/// An attempt in progress. Dropping it stops the servo with zero force on the device and keeps the
/// recording so far.
pub struct Live {
    /// The inputs of the attempt.
    pub trial: Arc<LiveTrial>,
    /// Description and capabilities of the device.
    pub info: DeviceInfo,
    /// Scaling of the scene's forces for the device.
    pub scaling: Scaling,
    running: Running,
    latest: LatestReader,
    recorder: recorder::Recorder,
}

/// The result of an attempt.
pub struct Finished {
    /// The servo's report; `None` if its thread panicked.
    pub report: Option<Report>,
    /// The recording, or the unsaved attempt if it could not be written.
    pub kept: Result<Kept, Box<Unsaved>>,
}

impl Live {
    /// Starts servo and recorder.
    ///
    /// # Errors
    /// If the recording cannot be created, or a thread cannot be started.
    pub fn start(trial: LiveTrial, mapping: Mapping, driven: Driven) -> Result<Self, Failure> {
        let exercise = &trial.bundle.exercise;
        let target_x_m = exercise.target_depth_mm * 1e-3;
        let info = driven.info().clone();
        let mut setup = Setup::new(Arc::clone(trial.specimen.law()), mapping, &info, target_x_m, trial.session.tick_hz);
        if !exercise.feedback.gives(Channel::Force) {
            setup.scaling = setup.scaling.silent();
        }
        let (scaling, rehearsed) = (setup.scaling.clone(), setup.clone());
        let trial = Arc::new(trial);
        let draft = recorder::begin(&trial, &trial.path)?;
        let started = servo::start(setup, driven).map_err(|error| Failure::work(format_args!("servo: {error}")))?;
        let recorder = recorder::Recorder::start(Arc::clone(&trial), started.records, draft)?;
        if !info.is_virtual {
            warn_of_heat(&trial, rehearsed, recorder.shown());
        }
        Ok(Self { trial, info, scaling, running: started.running, latest: started.latest, recorder })
    }

    /// Returns the view of the attempt so far, locked.
    pub fn shown(&self) -> MutexGuard<'_, AttemptView> {
        lock(self.recorder.shown())
    }

    /// Returns the servo's latest tick.
    pub fn latest(&mut self) -> Option<&servo::Snapshot> {
        self.latest.read()
    }

    /// Returns the running servo.
    pub fn servo(&self) -> &Running {
        &self.running
    }

    /// Stops with zero force on the device and finishes the recording.
    pub fn stop(self) -> (Arc<LiveTrial>, Finished) {
        let report = self.running.stop();
        let kept = self.recorder.finish(report.as_ref());
        (self.trial, Finished { report, kept })
    }
}

/// Warns if an expert's attempt at the exercise would warm the motors so much that the force is
/// reduced. The rehearsal takes a fraction of a second, in parallel with the first movements of the
/// trainee; if no thread can be started, there is no warning.
fn warn_of_heat(trial: &LiveTrial, setup: Setup, shown: &Arc<Mutex<AttemptView>>) {
    let exercise = &trial.bundle.exercise;
    let (operator, limit_s) = (Operator::skilled(&Skill::expert(), &trial.bundle.plan(), 0), exercise.time_limit_s);
    let shown = Arc::downgrade(shown);
    let rehearsal = move || {
        let cooled_s = servo::rehearse(setup, operator, limit_s).map_or(0.0, |rehearsal| rehearsal.cooled_s);
        if let Some(shown) = shown.upgrade().filter(|_| cooled_s >= 0.5) {
            lock(&shown).warn(phrase!(
                "this exercise heats the motors of this device: the force may be reduced for {time} s",
                time = Phrase::number(cooled_s, 0)
            ));
        }
    };
    let _without = std::thread::Builder::new().name("rehearsal".to_owned()).spawn(rehearsal);
}

/// Locks data that are consistent after each change, also after a panic.
fn lock<T>(data: &Mutex<T>) -> MutexGuard<'_, T> {
    data.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
pub mod tests {
    //! Fails if a lost device is recorded like an attempt ended by the trainee, which would be
    //! judged as the trainee's failure.

    use std::path::Path;

    use assessment::{AssessError, Void};
    use data_encoding::HEXLOWER;
    use documents::Patient;
    use ed25519_dalek::{Signature, Verifier, VerifyingKey};
    use haptics::devices::scripted::{Fault, Scripted};
    use haptics::mapping::{Home, Pointing};
    use nalgebra::{Point3, Vector3};
    use recording::{EventKind, Recording, signature};
    use uuid::Uuid;

    use super::*;
    use crate::maker::Maker;
    use crate::station::NewKey;

    const TICK_HZ: f64 = 1000.0;

    /// Starts an attempt with a device that has a fault after 300 readings.
    pub fn begin(fault: Fault, key: Option<Arc<StationKey>>, folder: &Path) -> Live {
        let file =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/lower-back-basics/1-feel-the-layers.toml");
        let bundle = ExerciseBundle::read(&file).expect("a shipped exercise");
        let patient = Patient::draw(&bundle.scene, 1);
        let specimen = Arc::new(crate::sources::prepare_specimen(&file, &bundle, &patient).expect("a force law"));
        let maker = Maker { device: "scripted", device_max_force_n: 3.3, seed: 1, tick_hz: TICK_HZ };
        let session = maker.session(&bundle);
        let path = folder.join("attempt.mcap");
        let device = Scripted::new(0.02, TICK_HZ).with(fault, 300, u64::MAX);
        let home = Home::above(Point3::origin(), -Vector3::z_axis(), 0.001);
        let mapping = Mapping::at_home(home, Pointing::Planned);
        let trial = LiveTrial { bundle, specimen, session, path, arm: None, key };
        Live::start(trial, mapping, Driven::ByTimer(Box::new(device))).expect("it begins")
    }

    /// Waits until an attempt has lasted half a second, or has ended.
    pub fn wait_for_ticks(live: &Live) {
        while live.servo().ended().is_none() && live.shown().moment.sample.t_s < 0.5 {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }

    /// Returns the recording of an attempt with a device that has a fault after 300 readings, as
    /// read from disk, and its exercise.
    pub fn recorded(fault: Fault, key: Option<Arc<StationKey>>, folder: &Path) -> (Recording, ExerciseBundle) {
        let live = begin(fault, key, folder);
        wait_for_ticks(&live);
        let (trial, finished) = live.stop();
        assert!(finished.kept.is_ok());
        (crate::sources::read_recording(&trial.path).expect("a recording"), trial.bundle.clone())
    }

    #[test]
    fn an_attempt_that_a_lost_device_has_ended_says_so_and_is_void() {
        let folder = tempfile::tempdir().expect("a folder");
        let (recording, bundle) = recorded(Fault::Disconnect, None, folder.path());
        let last = recording.events.last().expect("events");
        assert_eq!((last.kind, last.text.as_str()), (EventKind::Interrupted, "device lost: the device is gone"));
        let error = assessment::assess(&recording, &bundle).expect_err("it is not judged");
        assert!(matches!(error, AssessError::Void(Void::Interrupted { .. })), "{error}");
        assert!(recording.samples.len() >= 300, "and all of it is kept");
    }

    #[test]
    fn an_attempt_that_its_trainee_has_ended_is_signed_and_judged() {
        let folder = tempfile::tempdir().expect("a folder");
        let key = NewKey::random();
        let (public, station) = (key.public(), Uuid::new_v4());
        let (recording, bundle) = recorded(Fault::None, Some(Arc::new(key.for_station(station))), folder.path());
        let signature = recording.signature.clone().expect("the station has signed it");
        let signed = signature::signed_statement(&recording.session, station, &recording.hashes());
        let key = HEXLOWER.decode(public.as_bytes()).ok().and_then(|key| VerifyingKey::try_from(&key[..]).ok());
        let bytes = HEXLOWER.decode(signature.ed25519.as_bytes()).expect("hexadecimal");
        let right = key.expect("a key").verify(&signed, &Signature::from_slice(&bytes).expect("a signature"));
        assert!(right.is_ok() && signature.station == station);
        assert!(recording.events.iter().all(|event| event.kind != EventKind::Interrupted));
        assert!(assessment::assess(&recording, &bundle).is_ok());
    }
}
