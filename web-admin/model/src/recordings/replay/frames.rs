//! The moving part of a replay: frames of needle and tents, small enough to be sent before
//! playback.

use attempt::{
    Dents, HandForces, HandSample, Hub, Wounds, find_insertions, is_inserted, needle_axis, patient_thicknesses_m,
};
use documents::ExerciseBundle;
use nalgebra::Vector3;
use recording::{Recording, Sample};

use crate::recordings::series::lateral_n;

/// Columns of each frame, before those of the tents and of the blood at the punctures. Lengths in
/// mm, forces in N, times in s; the axis points from hub to tip. The columns of the hub correspond
/// to [`attempt::Hub`].
pub const COLUMNS: [&str; 16] = [
    "t_s",
    "x_mm",
    "y_mm",
    "z_mm",
    "axis_x",
    "axis_y",
    "axis_z",
    "advance_mm",
    "depth_mm",
    "force_n",
    "lateral_n",
    "hub_open",
    "hub_blood",
    "plunger",
    "drop",
    "fallen_mm",
];

/// Maximum frame rate, in Hz: that of a usual screen.
const MOST_HZ: f64 = 60.0;
/// Maximum number of punctures with blood.
const MOST_PUNCTURES: usize = 16;
/// Maximum size of all frames, in bytes.
const MOST_BYTES: usize = 1_200_000;

/// Frames at equal intervals, as rows of a table of little-endian 32-bit floats.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// Number of boundaries, each with a column for its tent.
    boundaries: usize,
    /// Positions of the punctures with columns for their blood, in m, by track.
    entries_m: Vec<[f64; 3]>,
    bytes: Vec<u8>,
}

/// A sample as a frame shows it.
#[derive(Clone, Copy)]
struct DrawnSample<'a> {
    sample: &'a Sample,
    /// Force on the hand along the needle, in N.
    force_n: f64,
    /// From hub to tip, of unit length.
    axis: Vector3<f64>,
}

impl Frames {
    /// Computes the frames of a recording: each contains the last sample before its time, and the
    /// positions of all boundaries next to the needle.
    #[must_use]
    pub fn of(recording: &Recording, bundle: &ExerciseBundle) -> Self {
        let boundaries = bundle.scene.layers.len();
        let thicknesses_m = patient_thicknesses_m(recording, bundle);
        let mut wounds = Wounds::new(bundle, thicknesses_m.iter().copied());
        let mut dents = Dents::new(bundle.scene.skin_shape, thicknesses_m, bundle.scene.needle.tip_to_rim_mm * 1e-3);
        let forces = HandForces::measure(recording);
        let (mut samples, mut events) = (forces.iter().peekable(), recording.events.iter().peekable());
        let mut tents = recording.tents.iter().peekable();
        let mut frames = Self { boundaries, entries_m: entries_m(recording), bytes: Vec::new() };
        let (Some(first), Some(last)) = (recording.samples.first(), recording.samples.last()) else { return frames };
        let count = frames.count(last.t_s - first.t_s, recording.samples.len());
        let insertions = find_insertions(&recording.events, recording.samples.iter());
        let (mut sample, mut force_n) = (first, 0.0);
        for k in 0..count {
            let share = k as f64 / (count - 1).max(1) as f64;
            let t_s = first.t_s + share * (last.t_s - first.t_s);
            while let Some(next) = samples.next_if(|next| next.sample.t_s <= t_s) {
                HandSample { sample, force_n } = next;
                wounds.sample(sample);
                while let Some(event) = events.next_if(|event| event.t_s <= sample.t_s) {
                    dents.event(event);
                    wounds.event(event, sample);
                }
            }
            while let Some(tent) = tents.next_if(|tent| tent.t_s <= t_s) {
                dents.tent(tent);
            }
            let under_way = insertions.iter().rfind(|insertion| insertion.from_s <= sample.t_s);
            // Tissue holds the shaft to the axis of its insertion, however the hand turns the handle.
            let held = under_way.filter(|_| is_inserted(sample)).map(|insertion| insertion.axis);
            let axis = held.unwrap_or_else(|| needle_axis(sample));
            frames.push(&DrawnSample { sample, force_n, axis }, &dents.at(sample), &wounds);
        }
        frames
    }

    fn count(&self, duration_s: f64, samples: usize) -> usize {
        let room = MOST_BYTES / (4 * self.width());
        // The duration is finite, because the times of samples are.
        ((duration_s * MOST_HZ).ceil() as usize + 1).min(room).min(samples)
    }

    fn push(&mut self, drawn: &DrawnSample<'_>, dents_m: &[f32], wounds: &Wounds) {
        let DrawnSample { sample, force_n, axis } = *drawn;
        let tip_mm = sample.tip_m().map(|part| part * 1e3);
        let measured = [sample.x_m * 1e3, f64::from(sample.depth_m) * 1e3, force_n, lateral_n(sample)];
        let Hub { open, blood, plunger, drop, fallen_m } = wounds.hub(sample);
        let hub = [f32::from(u8::from(open)), blood, plunger, drop, fallen_m * 1e3];
        let row = [sample.t_s].into_iter().chain(tip_mm).chain(axis.iter().copied()).chain(measured);
        let row = row.map(|value| value as f32).chain(hub).chain(dents_m.iter().map(|dent_m| dent_m * 1e3));
        // Punctures that come later do not bleed yet.
        let bleeding =
            wounds.punctures().iter().map(|wound| wound.blood(sample.t_s) as f32).chain(std::iter::repeat(0.0));
        let row = row.chain(bleeding.take(self.entries_m.len()));
        // A browser would draw nothing at all if one coordinate were not a number.
        let finite = row.map(|value| if value.is_finite() { value } else { 0.0 });
        self.bytes.extend(finite.flat_map(f32::to_le_bytes));
    }

    fn width(&self) -> usize {
        COLUMNS.len() + self.boundaries + self.entries_m.len()
    }

    /// Returns the positions of the punctures with columns for their blood, in m.
    #[must_use]
    pub fn entries_m(&self) -> &[[f64; 3]] {
        &self.entries_m
    }

    /// Returns the names of all columns, in order.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let tents = (0..self.boundaries).map(|boundary| format!("tent_{boundary}_mm"));
        let blood = (0..self.entries_m.len()).map(|puncture| format!("blood_{puncture}"));
        COLUMNS.map(str::to_owned).into_iter().chain(tents).chain(blood).collect()
    }

    /// Returns the content of the file.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// Returns the entry point of each track on the skin, in m.
fn entries_m(recording: &Recording) -> Vec<[f64; 3]> {
    let mut entries_m = Vec::new();
    for insertion in find_insertions(&recording.events, recording.samples.iter()) {
        let track = insertion.track as usize;
        if track < MOST_PUNCTURES {
            entries_m.resize(entries_m.len().max(track + 1), [0.0; 3]);
            entries_m[track] = insertion.entry_m.into();
        }
    }
    entries_m
}

#[cfg(test)]
mod tests {
    //! Checks that an hour-long recording fits, that frames do not anticipate later samples, and
    //! that the axis has the right direction.
    use std::path::Path;

    use attempt::simulate::{Clock, simulate};
    use documents::Patient;
    use law::operator::{Operator, Plan};
    use recording::{Event, EventKind, Tent, Writer};
    use tissue::Specimen;

    use super::*;

    fn bundle() -> ExerciseBundle {
        shipped("lower-back-basics/1-feel-the-layers")
    }

    fn shipped(exercise: &str) -> ExerciseBundle {
        let file = format!("{}/../../curricula/{exercise}.toml", env!("CARGO_MANIFEST_DIR"));
        ExerciseBundle::read(Path::new(&file)).expect("a shipped exercise")
    }

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
        let tents =
            (0..seconds * 120).map(|i| Tent { t_s: f64::from(i) / 120.0, tent_m: vec![0.001; 4], ..Tent::default() });
        Recording {
            samples: (0..=seconds * hz).map(sample).collect(),
            tents: tents.collect(),
            ..Recording::in_memory(super::super::stage::tests::session())
        }
    }

    #[test]
    fn a_short_attempt_has_a_frame_for_each_picture() {
        let rows = numbers(&Frames::of(&recording(2, 1000), &bundle()));
        assert_eq!((rows.len(), rows[0].len()), (121, COLUMNS.len() + 4));
        assert!((rows[60][0] - 1.0).abs() < 2e-3, "{:?}", rows[60]);
        assert!((rows[120][7] - 2.0).abs() < 1e-6 && (rows[120][COLUMNS.len()] - 1.0).abs() < 1e-6, "{:?}", rows[120]);
        assert!((rows[5][6] + 1.0).abs() < 1e-6, "a needle straight down points along -z: {:?}", rows[5]);
    }

    #[test]
    fn ten_minutes_still_fit() {
        let frames = Frames::of(&recording(600, 100), &bundle());
        assert!(frames.bytes().len() <= MOST_BYTES, "{}", frames.bytes().len());
        assert!(numbers(&frames).len() > 12_000, "{}", frames.bytes().len());
    }

    /// An insertion past every boundary at 5 mm/s, and the withdrawal.
    fn attempt(bundle: &ExerciseBundle) -> Recording {
        let params = Specimen::new(bundle.specimen_spec(&Patient::nominal(&bundle.scene))).expect("a shipped scene");
        let path = documents::spec_along_path(params.spec().axial.clone(), &bundle.exercise.incidence());
        let last_m = law::closed_form::predict_ruptures(&path).last().expect("a boundary").x_m;
        let plan = Plan { target_x_m: last_m + 0.004, approach_m: 0.001, hold_s: 0.2, ..bundle.exercise.plan() };
        let (exercise_sha256, scene_sha256) = (bundle.exercise.sha256.clone(), bundle.scene.sha256.clone());
        let session = recording::Session { exercise_sha256, scene_sha256, ..super::super::stage::tests::session() };
        let attachments = assessment::attachments(bundle);
        let mut writer = Writer::create(Vec::new(), &session, &attachments, &Default::default()).expect("memory");
        let clock = Clock { tick_hz: 1000.0, time_limit_s: 60.0 };
        simulate(&params, &mut Operator::constant(0.005, &plan), &mut writer, &clock).expect("memory");
        Recording::read(writer.finish().expect("memory").as_slice()).expect("just written")
    }

    /// Returns the largest deviation between needle and tissue in the frames of a recording, in mm,
    /// from the columns alone, as a browser draws them.
    fn disagreement_mm(recording: &Recording, bundle: &ExerciseBundle) -> f64 {
        let mut dents = Dents::new(
            bundle.scene.skin_shape,
            bundle.scene.layers.iter().map(|layer| layer.thickness_mm * 1e-3),
            bundle.scene.needle.tip_to_rim_mm * 1e-3,
        );
        let mut events = recording.events.iter().peekable();
        let mut most_mm = 0.0_f64;
        for row in numbers(&Frames::of(recording, bundle)) {
            let at = recording.samples.partition_point(|sample| sample.t_s as f32 <= row[0]) - 1;
            let sample = &recording.samples[at];
            while let Some(event) = events.next_if(|event| event.t_s <= sample.t_s) {
                dents.event(event);
            }
            let tents_mm = row[COLUMNS.len()..].iter().take(bundle.scene.layers.len());
            let shown_m: Vec<f32> = tents_mm.map(|mm| mm * 1e-3).collect();
            assert_eq!(shown_m.len(), bundle.scene.layers.len());
            most_mm = most_mm.max(1e3 * dents.disagreement_m(sample, &shown_m));
        }
        most_mm
    }

    #[test]
    fn tip_and_tissue_agree_in_every_frame_of_every_exercise() {
        let curricula = concat!(env!("CARGO_MANIFEST_DIR"), "/../../curricula");
        let folders = std::fs::read_dir(curricula).expect("the shipped documents").flatten();
        let files = folders.filter(|folder| folder.path().is_dir());
        let files = files.flat_map(|folder| std::fs::read_dir(folder.path()).expect("a shipped course").flatten());
        let mut found: Vec<ExerciseBundle> = files.filter_map(|file| ExerciseBundle::read(&file.path()).ok()).collect();
        assert!(found.len() >= 9, "{} exercises", found.len());
        let bent = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/lump/exercise.toml");
        found.push(ExerciseBundle::read(Path::new(bent)).expect("an exercise on a skin that bends"));
        for bundle in &found {
            let off_mm = disagreement_mm(&attempt(bundle), bundle);
            assert!(off_mm < 0.1, "{}: {off_mm} mm", bundle.exercise.id);
        }
    }

    fn event(kind: EventKind, t_s: f64, boundary: Option<u32>) -> Event {
        Event {
            t_s,
            kind,
            boundary,
            x_m: 0.0,
            position_m: [0.0; 3],
            force_n: 1.0,
            dissipated_j: 0.002,
            track: Some(0),
            structure: None,
            text: String::new(),
        }
    }

    /// A needle that rests in the dural sac from 1 s on, is confirmed at 2 s and withdrawn at 6 s.
    fn in_the_sac() -> Recording {
        let depth_m = |t_s: f64| if (1.0..6.0).contains(&t_s) { 0.0565 } else { -0.001 };
        let mut recording = recording(7, 200);
        for sample in &mut recording.samples {
            sample.x_m = depth_m(sample.t_s);
            sample.position_m = [0.0, 0.0, -sample.x_m];
            sample.flags = if sample.x_m > 0.0 { recording::sample::flags::INSIDE } else { 0 };
        }
        let ruptures = (0..8).map(|boundary| event(EventKind::TipRupture, 1.0, Some(boundary)));
        recording.events.push(event(EventKind::Contact, 1.0, None));
        recording.events.extend(ruptures);
        recording.events.push(event(EventKind::Confirm, 2.0, None));
        recording.tents.clear();
        recording
    }

    #[test]
    fn drops_fall_and_wounds_bleed_as_the_attempt_has_them() {
        let bundle = shipped("lumbar-puncture/1-reach-the-fluid");
        let recording = in_the_sac();
        let frames = Frames::of(&recording, &bundle);
        assert_eq!((frames.entries_m().len(), frames.columns().last().map(String::as_str)), (1, Some("blood_0")));
        let (mut told, mut at) = (Wounds::new(&bundle, patient_thicknesses_m(&recording, &bundle)), 0);
        let (mut fell, mut before_mm) = (Vec::new(), 0.0);
        for row in numbers(&frames) {
            while let Some(sample) = recording.samples.get(at).filter(|sample| sample.t_s as f32 <= row[0]) {
                told.sample(sample);
                let now = recording.events.iter().filter(|event| (event.t_s - sample.t_s).abs() < 1e-9);
                now.for_each(|event| told.event(event, sample));
                at += 1;
            }
            let sample = &recording.samples[at - 1];
            let hub = told.hub(sample);
            let blood = told.punctures().first().map_or(0.0, |wound| wound.blood(sample.t_s) as f32);
            let open = f32::from(u8::from(hub.open));
            let shown = [row[11], row[12], row[13], row[14], row[15], row[row.len() - 1]];
            let wanted = [open, hub.blood, hub.plunger, hub.drop, hub.fallen_m * 1e3, blood];
            assert!(shown.iter().zip(wanted).all(|(shown, wanted)| (shown - wanted).abs() < 1e-6), "{row:?} {hub:?}");
            if row[15] > 0.0 && before_mm <= 0.0 {
                fell.push(row[0].round() as i32);
            }
            before_mm = row[15];
        }
        assert_eq!(fell, [3, 4, 5], "a drop a second, from the confirmation until the needle is out");
    }

    #[test]
    fn an_empty_recording_and_broken_numbers_are_contained() {
        let empty = Recording { samples: vec![], ..recording(0, 1) };
        assert!(Frames::of(&empty, &bundle()).bytes().is_empty());
        let mut broken = recording(1, 10);
        broken.samples[3].position_m = [f64::NAN; 3];
        assert!(numbers(&Frames::of(&broken, &bundle())).iter().flatten().all(|value| value.is_finite()));
    }
}
