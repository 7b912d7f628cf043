//! Hashes of an attempt: of the motion, which identifies a copy under another id, and of the
//! conditions, which do not follow from the motion.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::event::{Event, EventKind};
use crate::fluoroscopy::{CArmControls, Fluoroscopy};
use crate::sample::{Sample, flags};

/// Incremental hash of a motion.
#[derive(Clone, Debug, Default)]
pub struct MotionDigest(Sha256);

impl MotionDigest {
    /// Hashes the motion of samples in order of time.
    #[must_use]
    pub fn from_samples(samples: &[Sample]) -> Self {
        let mut motion = Self::default();
        samples.iter().for_each(|sample| motion.add(sample));
        motion
    }

    /// Adds a tick: the exact inputs of the law. The outputs follow from these and are not hashed.
    pub fn add(&mut self, sample: &Sample) {
        let numbers = [sample.t_s].into_iter().chain(sample.position_m).chain(sample.orientation);
        numbers.for_each(|number| self.0.update(number.to_bits().to_le_bytes()));
        self.0.update([u8::from(sample.flags & flags::CONFIRM != 0)]);
    }

    /// Returns the SHA-256 of every tick so far: time, position, orientation x, y, z, w as doubles,
    /// little-endian, and a byte that is 1 while the confirm button is down.
    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        self.0.clone().finalize().into()
    }
}

/// Incremental hash of an attempt's conditions: the flags that the device sets, the interruption that ended the attempt, and
/// the controls of a C-arm.
#[derive(Clone, Debug, Default)]
pub struct ConditionsDigest {
    flags: Sha256,
    interruptions: Sha256,
    /// `None` without fluoroscopy, where the hash is that of programs without it.
    controls: Option<Sha256>,
}

impl ConditionsDigest {
    /// Hashes the conditions of an attempt, everything in order of time.
    #[must_use]
    pub fn from_attempt(samples: &[Sample], events: &[Event], fluoroscopy: &Fluoroscopy) -> Self {
        let mut conditions = Self::default();
        samples.iter().for_each(|sample| conditions.add_sample(sample));
        events.iter().for_each(|event| conditions.add_event(event));
        fluoroscopy.controls.iter().for_each(|controls| conditions.add_controls(controls));
        conditions
    }

    /// Adds a tick.
    pub fn add_sample(&mut self, sample: &Sample) {
        self.flags.update(sample.flags.to_le_bytes());
    }

    /// Adds an event. Only interruptions are hashed: coaching and faults do not affect the score,
    /// and every other event follows from the motion.
    pub fn add_event(&mut self, event: &Event) {
        if event.kind == EventKind::Interrupted {
            self.interruptions.update(event.t_s.to_bits().to_le_bytes());
            self.interruptions.update((event.text.len() as u64).to_le_bytes());
            self.interruptions.update(&event.text);
        }
    }

    /// Adds controls of the C-arm. Its pulses follow from these.
    pub fn add_controls(&mut self, controls: &CArmControls) {
        let CArmControls { t_s, orbital_rad, tilt_rad, field_m, pedal, shots, contrast_ml } = *controls;
        let hash = self.controls.get_or_insert_default();
        let numbers = [t_s, orbital_rad, tilt_rad, field_m, contrast_ml];
        numbers.iter().for_each(|number| hash.update(number.to_bits().to_le_bytes()));
        hash.update([u8::from(pedal)]);
        hash.update(shots.to_le_bytes());
    }

    /// Returns the SHA-256 of two hashes: of the flags of every tick so far as four bytes,
    /// little-endian, and of the interruptions, each as its time as a double, the length of its
    /// text as eight bytes, little-endian, and its text. With fluoroscopy a third follows, of the controls: time, both angles,
    /// field and contrast medium as doubles, the pedal as a byte, the shots as four bytes.
    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        let hashes = [Some(&self.flags), Some(&self.interruptions), self.controls.as_ref()];
        let parts: Vec<_> = hashes.into_iter().flatten().map(|hash| hash.clone().finalize()).collect();
        Sha256::digest(parts.concat()).into()
    }
}

/// The two hashes of an attempt that a station signs together with the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AttemptHashes {
    /// Motion: [`MotionDigest::sha256`].
    pub motion: [u8; 32],
    /// Conditions: [`ConditionsDigest::sha256`].
    pub conditions: [u8; 32],
}

impl AttemptHashes {
    /// Hashes an attempt, everything in order of time.
    #[must_use]
    pub fn of_attempt(samples: &[Sample], events: &[Event], fluoroscopy: &Fluoroscopy) -> Self {
        Self {
            motion: MotionDigest::from_samples(samples).sha256(),
            conditions: ConditionsDigest::from_attempt(samples, events, fluoroscopy).sha256(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_is_what_the_law_was_fed_and_nothing_else() {
        let sample = Sample { t_s: 0.001, orientation: [0.0, 0.0, 0.0, 1.0], ..Sample::default() };
        let motion = |sample: Sample| MotionDigest::from_samples(&[Sample::default(), sample]).sha256();
        let whole = motion(sample);
        let answered = Sample { tip_n: 3.0, force_n: [1.0; 3], flags: flags::INSIDE, lateness_us: 9.0, ..sample };
        assert_eq!(motion(answered), whole);
        for moved in [
            Sample { t_s: 0.002, ..sample },
            Sample { position_m: [0.0, 1e-12, 0.0], ..sample },
            Sample { orientation: [0.0, 0.0, 1.0, 0.0], ..sample },
            Sample { flags: flags::CONFIRM, ..sample },
        ] {
            assert_ne!(motion(moved), whole);
        }
        assert_ne!(MotionDigest::from_samples(&[sample]).sha256(), whole, "a tick is missing");
    }
}
