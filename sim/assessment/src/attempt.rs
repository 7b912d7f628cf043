//! An attempt as input of the metrics: motion, entry, ruptures and confirmed position.

use ::attempt::{Insertion, find_insertions, hand_force_n, is_inserted, patient_thicknesses_m};
use documents::ExerciseBundle;
use nalgebra::Point3;
use recording::{Contactor, Event, EventKind, Recording, Sample};

use crate::absent::Absent;
use crate::error::AssessError;
use crate::motion::{Timeline, TipMotion};
use crate::signal::{CUTOFF_HZ, INTENT_HZ};

/// A metric's value, or the reason for its absence.
pub(crate) type Outcome = Result<f64, Absent>;

/// A rupture of a boundary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordedRupture {
    /// Time, in s.
    pub(crate) t_s: f64,
    /// Index of the boundary, from 0; the layer below it has the same index.
    pub(crate) boundary: usize,
    /// The contactor.
    pub(crate) contactor: Contactor,
    /// Axial displacement of the tip, in m.
    pub(crate) x_m: f64,
    /// Elastic force of the contactor just before the rupture, in N.
    pub(crate) force_n: f64,
}

/// The position at which the trainee considered the attempt done.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Confirmed {
    /// Time, in s.
    pub(crate) t_s: f64,
    /// Axial displacement, in m.
    pub(crate) x_m: f64,
    /// Tip position, in m.
    pub(crate) tip_m: Point3<f64>,
}

/// A recording and the exercise by which it is judged.
pub(crate) struct Attempt<'a> {
    /// The recording.
    pub(crate) recording: &'a Recording,
    /// The exercise and its scene.
    pub(crate) bundle: &'a ExerciseBundle,
    /// Usable samples.
    pub(crate) timeline: Timeline<'a>,
    /// Thickness of each layer of the patient, in m, along the surface normal.
    pub(crate) thickness_m: Vec<f64>,
    /// Ruptures in order of time.
    pub(crate) ruptures: Vec<RecordedRupture>,
    /// Contacts with the skin in order of time.
    pub(crate) insertions: Vec<Insertion>,
    motion: Option<TipMotion>,
    intent: Option<TipMotion>,
    inside: bool,
}

impl<'a> Attempt<'a> {
    pub(crate) fn new(recording: &'a Recording, bundle: &'a ExerciseBundle) -> Result<Self, AssessError> {
        let timeline = Timeline::new(&recording.samples)?;
        Ok(Self {
            recording,
            bundle,
            thickness_m: patient_thicknesses_m(recording, bundle),
            ruptures: ruptures(recording, bundle.scene.layers.len()),
            insertions: find_insertions(&recording.events, timeline.samples().iter().copied()),
            motion: TipMotion::behind(CUTOFF_HZ, &timeline),
            intent: TipMotion::behind(INTENT_HZ, &timeline),
            inside: timeline.samples().iter().any(|s| s.depth_m > 0.0),
            timeline,
        })
    }

    /// The first contact with the skin.
    pub(crate) fn touched(&self) -> Result<&Insertion, Absent> {
        self.insertions.first().ok_or(Absent::Untouched)
    }

    /// Succeeds if the tip was in tissue at any time.
    pub(crate) fn inside(&self) -> Result<(), Absent> {
        self.touched()?;
        if self.inside { Ok(()) } else { Err(Absent::NotInside) }
    }

    /// Returns the motion, if it is long enough for a derivative.
    pub(crate) fn motion(&self) -> Result<&TipMotion, Absent> {
        self.motion.as_ref().ok_or(Absent::TooShort)
    }

    /// Returns the intended motion: without tremor.
    pub(crate) fn intent(&self) -> Result<&TipMotion, Absent> {
        self.intent.as_ref().ok_or(Absent::TooShort)
    }

    /// Returns the time at which a position was first confirmed, in s. A confirm outside the body
    /// is ignored, as on the station.
    pub(crate) fn first_confirm_s(&self) -> Option<f64> {
        let samples = self.timeline.samples();
        let is_inside = |t_s: f64| self.timeline.index_at(t_s).is_some_and(|i| is_inserted(samples[i]));
        let confirms = self.recording.events.iter().filter(|e| e.kind == EventKind::Confirm);
        confirms.map(|e| e.t_s).find(|t_s| is_inside(*t_s))
    }

    /// Returns the position confirmed first; without a confirm, that at the last moment of the
    /// largest depth.
    pub(crate) fn confirmed(&self) -> Result<Confirmed, Absent> {
        self.touched()?;
        let t_s = self.first_confirm_s().unwrap_or_else(|| self.deepest_s());
        let coordinate = |i: usize| self.timeline.at(t_s, |s| s.tip_m()[i]);
        Ok(Confirmed {
            t_s,
            x_m: self.timeline.at(t_s, |s| s.x_m),
            tip_m: Point3::new(coordinate(0), coordinate(1), coordinate(2)),
        })
    }

    fn deepest_s(&self) -> f64 {
        let deepest = self.timeline.samples().iter().max_by(|a, b| a.x_m.total_cmp(&b.x_m));
        deepest.map_or(0.0, |s| s.t_s)
    }

    /// Returns the insertion in progress at a time; before the first one, the first one.
    pub(crate) fn insertion_at(&self, t_s: f64) -> Result<&Insertion, Absent> {
        let started = self.insertions.iter().rfind(|insertion| insertion.from_s <= t_s);
        started.map_or_else(|| self.touched(), Ok)
    }

    /// Returns each usable sample with the insertion in progress, if the needle has touched the
    /// skin by then.
    pub(crate) fn ticks(&self) -> impl Iterator<Item = (&'a Sample, Option<&Insertion>)> {
        let mut ahead = self.insertions.iter().peekable();
        let mut current = None;
        self.timeline.samples().iter().map(move |sample| {
            while let Some(next) = ahead.next_if(|next| next.from_s <= sample.t_s) {
                current = Some(next);
            }
            (*sample, current)
        })
    }

    /// Force on the hand along the needle at each sample, in N.
    pub(crate) fn axial_n(&self) -> Vec<f64> {
        self.ticks().map(|(s, insertion)| insertion.map_or(0.0, |i| hand_force_n(s, &i.axis))).collect()
    }
}

fn ruptures(recording: &Recording, layers: usize) -> Vec<RecordedRupture> {
    let rupture = |e: &Event| {
        let contactor = e.kind.contactor()?;
        let boundary = usize::try_from(e.boundary?).ok().filter(|b| *b < layers)?;
        let finite = e.t_s.is_finite() && e.x_m.is_finite() && e.force_n.is_finite();
        finite.then_some(RecordedRupture { t_s: e.t_s, boundary, contactor, x_m: e.x_m, force_n: e.force_n })
    };
    let mut ruptures: Vec<RecordedRupture> = recording.events.iter().filter_map(rupture).collect();
    ruptures.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    ruptures
}
