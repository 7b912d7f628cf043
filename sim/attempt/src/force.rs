//! The force on the hand along the needle in a recorded attempt: the sum of layers, bone, walls and
//! the hub.

use law::axial::Contactor;
use nalgebra::Vector3;
use recording::{Event, Recording, Sample, keep_extremes};

use crate::insertion::find_insertions;

/// Returns the force on the hand along the latched axis at a sample, in N, positive outwards: the
/// recorded force without its lateral part. Unlike [`Sample::axial_n`] it includes bone, walls and
/// the hub.
#[must_use]
pub fn hand_force_n(sample: &Sample, axis: &Vector3<f64>) -> f64 {
    let force = |i: usize| f64::from(sample.force_n[i]) - f64::from(sample.lateral_n[i]);
    -axis.dot(&Vector3::new(force(0), force(1), force(2)))
}

/// A sample, and the force on the hand along the needle.
#[derive(Clone, Copy, Debug)]
pub struct HandSample<'a> {
    /// The sample.
    pub sample: &'a Sample,
    /// The force, in N, positive outwards.
    pub force_n: f64,
}

/// The force on the hand along the needle at each sample of a recording.
#[derive(Clone, Debug)]
pub struct HandForces<'a> {
    samples: &'a [Sample],
    forces_n: Vec<f64>,
}

impl<'a> HandForces<'a> {
    /// Computes the forces. They are 0 before the needle first meets the skin.
    #[must_use]
    pub fn measure(recording: &'a Recording) -> Self {
        let samples = &recording.samples;
        let insertions = find_insertions(&recording.events, samples.iter().filter(|sample| sample.t_s.is_finite()));
        let (mut ahead, mut axis) = (insertions.iter().peekable(), Vector3::zeros());
        let force_n = |sample: &Sample| {
            while let Some(next) = ahead.next_if(|next| next.from_s <= sample.t_s) {
                axis = next.axis;
            }
            hand_force_n(sample, &axis)
        };
        Self { samples, forces_n: samples.iter().map(force_n).collect() }
    }

    /// Returns each sample with its force in N.
    pub fn iter(&self) -> impl Iterator<Item = HandSample<'a>> {
        self.samples.iter().zip(&self.forces_n).map(|(sample, &force_n)| HandSample { sample, force_n })
    }

    /// Returns the samples with the least and the greatest force in each of `most / 2` even
    /// stretches, with their forces in N. A sample whose time, displacement or force is not finite
    /// is left out.
    #[must_use]
    pub fn thin(&self, most: usize) -> Vec<HandSample<'a>> {
        let is_finite = |HandSample { sample, force_n }: &HandSample<'_>| {
            sample.t_s.is_finite() && sample.x_m.is_finite() && force_n.is_finite()
        };
        let finite: Vec<_> = self.iter().filter(is_finite).collect();
        keep_extremes(&finite, most, |hand| hand.force_n).into_iter().copied().collect()
    }

    /// Returns the force just before an event, in N. At a rupture the contactor's own force is that
    /// of the event, and the other parts are as last recorded: otherwise a peak would be lower the
    /// slower the recording.
    #[must_use]
    pub fn before_n(&self, event: &Event) -> f64 {
        let after = self.samples.partition_point(|sample| sample.t_s < event.t_s);
        let last = after.checked_sub(1).and_then(|before| self.samples.get(before).zip(self.forces_n.get(before)));
        let Some((sample, &force_n)) = last else { return event.force_n };
        event
            .kind
            .contactor()
            .map_or(force_n, |contactor| raise_to_rupture_n(force_n, sample, contactor, event.force_n))
    }
}

/// Returns a force along the needle at the last sample before a rupture, in N, with the contactor's
/// part replaced by `rupture_n`, its force at the rupture. Unchanged if the contactor did not press
/// yet: it was moved there within one tick, and the hand did not feel its force.
#[must_use]
pub fn raise_to_rupture_n(force_n: f64, sample: &Sample, contactor: Contactor, rupture_n: f64) -> f64 {
    let own_n = f64::from(match contactor {
        Contactor::Tip => sample.tip_n,
        Contactor::Rim => sample.rim_n,
    });
    if own_n > 0.0 { force_n.max(force_n - own_n + rupture_n) } else { force_n }
}

#[cfg(test)]
mod tests {
    //! Fails if a curve loses a peak, or shows the layers' share where bone pushes on the tip.

    use law::axial::ForceLaw;
    use recording::{EventKind, Session};

    use super::*;

    /// A needle straight down whose layers push by `tip_n` and whose bone by `bone_n`.
    fn sample(t_s: f64, tip_n: f32, bone_n: f32) -> Sample {
        let force_n = [0.0, 0.0, tip_n + bone_n];
        Sample { t_s, orientation: [1.0, 0.0, 0.0, 0.0], x_m: 0.01, depth_m: 0.01, tip_n, force_n, ..Sample::default() }
    }

    fn recording(samples: Vec<Sample>) -> Recording {
        Recording { samples, ..Recording::in_memory(Session::in_memory(ForceLaw::Version5, vec![])) }
    }

    #[test]
    fn bone_counts_and_sideways_force_does_not() {
        let mut samples = vec![sample(0.0, 0.5, 0.0), sample(1.0, 0.5, 4.5), sample(2.0, 1.0, 4.0)];
        (samples[1].lateral_n, samples[1].force_n[0]) = ([3.0, 0.0, 0.0], 3.0);
        let attempt = recording(samples);
        let forces = HandForces::measure(&attempt);
        let found: Vec<f64> = forces.iter().map(|hand| hand.force_n).collect();
        assert!(found.iter().zip([0.5, 5.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
        let pop = Event {
            t_s: 2.5,
            kind: EventKind::TipRupture,
            boundary: Some(0),
            x_m: 0.01,
            position_m: [0.0; 3],
            force_n: 1.25,
            dissipated_j: 0.0,
            track: None,
            structure: None,
            text: String::new(),
        };
        assert!((forces.before_n(&pop) - 5.25).abs() < 1e-6, "the tip's own 1 N counts as the 1.25 N of the rupture");
    }

    #[test]
    fn every_extreme_stays_and_time_goes_on() {
        let mut samples: Vec<Sample> = (0..60_000).map(|i| sample(f64::from(i) * 1e-3, 0.5, 0.0)).collect();
        samples[31_234] = sample(31.234, 0.5, 7.0);
        samples[45_678] = sample(45.678, -2.5, 0.0);
        let attempt = recording(samples);
        let kept = HandForces::measure(&attempt).thin(600);
        assert!(kept.len() <= 600);
        for t_s in [31.234, 45.678] {
            assert!(kept.iter().any(|hand| (hand.sample.t_s - t_s).abs() < 1e-9), "the extreme at {t_s} s");
        }
        assert!(kept.windows(2).all(|pair| pair[0].sample.t_s < pair[1].sample.t_s));
    }

    #[test]
    fn few_samples_stay_and_what_is_not_a_number_does_not() {
        let attempt = recording(vec![sample(0.0, 0.1, 0.0), sample(1.0, f32::NAN, 0.0), sample(2.0, 0.3, 0.0)]);
        let times: Vec<f64> = HandForces::measure(&attempt).thin(600).iter().map(|hand| hand.sample.t_s).collect();
        assert_eq!(times, [0.0, 2.0]);
        assert!(HandForces::measure(&recording(vec![])).thin(600).is_empty());
    }
}
