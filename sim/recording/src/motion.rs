//! What a hand has done, as one number: it tells an attempt from a copy of it, whatever the copy's file says beside it.

use sha2::{Digest, Sha256};

use crate::sample::{Sample, flags};

/// The hash of a motion while it is being made.
#[derive(Clone, Debug, Default)]
pub struct MotionDigest(Sha256);

impl MotionDigest {
    /// The motion of samples in order of time.
    #[must_use]
    pub fn from_samples(samples: &[Sample]) -> Self {
        let mut motion = Self::default();
        samples.iter().for_each(|sample| motion.add(sample));
        motion
    }

    /// Adds a tick: what the law was fed, to the bit. What it answered follows from that, and is left out.
    pub fn add(&mut self, sample: &Sample) {
        let numbers = [sample.t_s].into_iter().chain(sample.position_m).chain(sample.orientation);
        numbers.for_each(|number| self.0.update(number.to_bits().to_le_bytes()));
        self.0.update([u8::from(sample.flags & flags::CONFIRM != 0)]);
    }

    /// SHA-256 of every tick so far: time, position, orientation x, y, z, w as doubles, little-endian, and a byte that is 1
    /// while the confirm button is down.
    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        self.0.clone().finalize().into()
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
