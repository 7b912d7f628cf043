//! The moving part of a replay: so many pictures a second of needle and tents, small enough to be sent before play.

use recording::{Recording, Sample, Tent};

use crate::domain::series::lateral_n;

/// What each frame holds before its tents. Lengths in mm, forces in N, times in s; the axis points from hub to tip.
pub const COLUMNS: [&str; 11] =
    ["t_s", "x_mm", "y_mm", "z_mm", "axis_x", "axis_y", "axis_z", "advance_mm", "depth_mm", "force_n", "lateral_n"];

/// Pictures a second where there is room: what a screen shows.
const MOST_HZ: f64 = 60.0;
/// Room for all frames, in bytes.
const MOST_BYTES: usize = 1_200_000;

/// Frames at even times, as the rows of a table of little-endian 32-bit floats.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames {
    /// Number of boundaries whose tents each frame holds.
    boundaries: usize,
    bytes: Vec<u8>,
}

impl Frames {
    /// The frames of a recording: each is the last sample and the last tent before its time.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let boundaries = recording.tents.iter().map(|tent| tent.tent_m.len()).max().unwrap_or(0);
        let mut frames = Self { boundaries, bytes: Vec::new() };
        let (Some(first), Some(last)) = (recording.samples.first(), recording.samples.last()) else { return frames };
        let count = frames.count(last.t_s - first.t_s, recording.samples.len());
        for k in 0..count {
            let share = k as f64 / (count - 1).max(1) as f64;
            let t_s = first.t_s + share * (last.t_s - first.t_s);
            let at = recording.samples.partition_point(|sample| sample.t_s <= t_s).saturating_sub(1);
            let tent = recording.tents.partition_point(|tent| tent.t_s <= t_s).checked_sub(1);
            frames.push(&recording.samples[at], tent.map(|at| &recording.tents[at]));
        }
        frames
    }

    fn count(&self, duration_s: f64, samples: usize) -> usize {
        let room = MOST_BYTES / (4 * self.width());
        // A duration is finite: the times of samples are.
        ((duration_s * MOST_HZ).ceil() as usize + 1).min(room).min(samples)
    }

    fn push(&mut self, sample: &Sample, tent: Option<&Tent>) {
        let tip_mm = sample.tip_m().map(|part| part * 1e3);
        let axis = axis(sample.orientation);
        let measured = [sample.x_m * 1e3, f64::from(sample.depth_m) * 1e3, sample.axial_n(), lateral_n(sample)];
        let row = [sample.t_s].into_iter().chain(tip_mm).chain(axis).chain(measured);
        let tent_mm = |boundary: usize| tent.and_then(|tent| tent.tent_m.get(boundary)).map_or(0.0, |m| m * 1e3);
        let row = row.map(|value| value as f32).chain((0..self.boundaries).map(tent_mm));
        // A browser draws nothing at a place that is no number, and everything else with it.
        let finite = row.map(|value| if value.is_finite() { value } else { 0.0 });
        self.bytes.extend(finite.flat_map(f32::to_le_bytes));
    }

    fn width(&self) -> usize {
        COLUMNS.len() + self.boundaries
    }

    /// What each frame holds, in order.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let tents = (0..self.boundaries).map(|boundary| format!("tent_{boundary}_mm"));
        COLUMNS.map(str::to_owned).into_iter().chain(tents).collect()
    }

    /// As a file holds them.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// The needle's +z in the patient frame: the third column of the rotation.
fn axis([x, y, z, w]: [f64; 4]) -> [f64; 3] {
    [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]
}

#[cfg(test)]
mod tests {
    //! Fails when an hour would not fit, a frame tells of the future, or the axis points the wrong way.
    use super::*;

    fn numbers(frames: &Frames) -> Vec<Vec<f32>> {
        let numbers: Vec<f32> = frames.bytes().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        numbers.chunks(frames.columns().len()).map(<[f32]>::to_vec).collect()
    }

    fn recording(seconds: u32, hz: u32) -> Recording {
        let down = [1.0, 0.0, 0.0, 0.0];
        let sample = |i: u32| Sample {
            t_s: f64::from(i) / f64::from(hz),
            orientation: down,
            x_m: f64::from(i) * 1e-6,
            ..Sample::default()
        };
        let tents = (0..seconds * 120).map(|i| Tent {
            t_s: f64::from(i) / 120.0,
            tent_m: vec![0.001; 4],
            contactor_n: vec![],
            drag_n: vec![],
        });
        Recording {
            session: super::super::stage::tests::session(),
            attachments: vec![],
            samples: (0..=seconds * hz).map(sample).collect(),
            events: vec![],
            energies: vec![],
            tents: tents.collect(),
            complete: true,
        }
    }

    #[test]
    fn a_short_attempt_has_a_frame_for_each_picture() {
        let rows = numbers(&Frames::of(&recording(2, 1000)));
        assert_eq!((rows.len(), rows[0].len()), (121, 15));
        assert!((rows[60][0] - 1.0).abs() < 2e-3, "{:?}", rows[60]);
        assert!((rows[120][7] - 2.0).abs() < 1e-6 && (rows[120][11] - 1.0).abs() < 1e-6, "{:?}", rows[120]);
        assert!((rows[5][6] + 1.0).abs() < 1e-6, "a needle straight down points along -z: {:?}", rows[5]);
    }

    #[test]
    fn ten_minutes_still_fit() {
        let frames = Frames::of(&recording(600, 100));
        assert!(frames.bytes().len() <= MOST_BYTES, "{}", frames.bytes().len());
        assert!(numbers(&frames).len() > 12_000, "{}", frames.bytes().len());
    }

    #[test]
    fn an_empty_recording_and_broken_numbers_are_contained() {
        let empty = Recording { samples: vec![], ..recording(0, 1) };
        assert!(Frames::of(&empty).bytes().is_empty());
        let mut broken = recording(1, 10);
        broken.samples[3].position_m = [f64::NAN; 3];
        assert!(numbers(&Frames::of(&broken)).iter().flatten().all(|value| value.is_finite()));
    }
}
