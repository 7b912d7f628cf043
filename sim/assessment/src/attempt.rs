//! An attempt as the metrics see it: the motion, where the needle went in, what it opened, what was confirmed.

use nalgebra::{Point3, Vector3};
use recording::{Event, EventKind, Recording, Sample, sample::flags};
use scene::ExerciseBundle;

use crate::motion::{Motion, Timeline, axis};
use crate::score::AssessError;
use crate::signal::{CUTOFF_HZ, INTENT_HZ};

/// Why a metric has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Absent {
    /// The tip never met the skin.
    Untouched,
    /// The tip never went through the skin.
    NotInside,
    /// The tip went in, but did not reach this layer.
    LayerNotReached,
    /// The tip went in, but this boundary did not rupture.
    NoRupture,
    /// The needle was still moving when the recording ended.
    NeverStopped,
    /// The recording holds no energy ledger of this scene.
    NoLedger,
    /// The recording is too short to tell a speed.
    TooShort,
    /// The recorded numbers do not yield a finite value.
    NotFinite,
}

impl Absent {
    const ALL: [Self; 8] = [
        Self::Untouched,
        Self::NotInside,
        Self::LayerNotReached,
        Self::NoRupture,
        Self::NeverStopped,
        Self::NoLedger,
        Self::TooShort,
        Self::NotFinite,
    ];

    /// Told by its words, as a metric carries them.
    pub(crate) fn told(why: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|absent| absent.why() == why)
    }

    /// In words.
    pub(crate) fn why(self) -> &'static str {
        match self {
            Self::Untouched => "the needle never reached the skin",
            Self::NotInside => "the needle never went through the skin",
            Self::LayerNotReached => "the needle did not reach this layer",
            Self::NoRupture => "this boundary was not opened",
            Self::NeverStopped => "the needle was still moving when the recording ended",
            Self::NoLedger => "the recording holds no energy ledger",
            Self::TooShort => "the recording is too short to tell a speed",
            Self::NotFinite => "the recorded numbers yield no value",
        }
    }

    /// Not having met a layer or a boundary cost the tissue nothing: there is nothing to mark down. Whether the needle
    /// went deep enough is judged by the depth.
    pub(crate) fn is_harmless(self) -> bool {
        matches!(self, Self::LayerNotReached | Self::NoRupture)
    }
}

/// A metric's value, or why there is none.
pub(crate) type Outcome = Result<f64, Absent>;

/// The needle met the skin: from here on its axis is latched.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Insertion {
    /// When, in s.
    pub(crate) from_s: f64,
    /// Where, in m.
    pub(crate) entry_m: Point3<f64>,
    /// Along which axis, unit length.
    pub(crate) axis: Vector3<f64>,
    /// In which puncture track.
    pub(crate) track: u32,
}

impl Insertion {
    /// 1/cos θ: how much longer the path through a layer is than the layer is thick.
    pub(crate) fn path_factor(&self) -> f64 {
        1.0 / self.axis.z.abs().max(0.1)
    }
}

/// A boundary gave way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rupture {
    /// When, in s.
    pub(crate) t_s: f64,
    /// Which boundary, from 0; the layer below it has the same index.
    pub(crate) boundary: usize,
    /// The rim, not the tip.
    pub(crate) by_rim: bool,
    /// Axial displacement of the tip, in m.
    pub(crate) x_m: f64,
    /// Elastic force of the contactor just before, in N.
    pub(crate) force_n: f64,
}

/// Where the attempt ended for the one who made it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Confirmed {
    /// When, in s.
    pub(crate) t_s: f64,
    /// Axial displacement, in m.
    pub(crate) x_m: f64,
    /// Tip position, in m.
    pub(crate) tip_m: Point3<f64>,
}

/// A recording beside the exercise it is judged by.
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
    pub(crate) ruptures: Vec<Rupture>,
    /// Contacts with the skin in order of time.
    pub(crate) insertions: Vec<Insertion>,
    motion: Option<Motion>,
    intent: Option<Motion>,
    inside: bool,
}

impl<'a> Attempt<'a> {
    pub(crate) fn new(recording: &'a Recording, bundle: &'a ExerciseBundle) -> Result<Self, AssessError> {
        let timeline = Timeline::new(&recording.samples)?;
        Ok(Self {
            recording,
            bundle,
            thickness_m: thickness_m(recording, bundle),
            ruptures: ruptures(recording, bundle.scene.layers.len()),
            insertions: insertions(&recording.events, &timeline),
            motion: Motion::behind(CUTOFF_HZ, &timeline),
            intent: Motion::behind(INTENT_HZ, &timeline),
            inside: timeline.samples().iter().any(|s| s.depth_m > 0.0),
            timeline,
        })
    }

    /// The first contact with the skin.
    pub(crate) fn touched(&self) -> Result<&Insertion, Absent> {
        self.insertions.first().ok_or(Absent::Untouched)
    }

    /// Passes once the tip was in tissue.
    pub(crate) fn inside(&self) -> Result<(), Absent> {
        self.touched()?;
        if self.inside { Ok(()) } else { Err(Absent::NotInside) }
    }

    /// The motion, where it is long enough for a derivative.
    pub(crate) fn motion(&self) -> Result<&Motion, Absent> {
        self.motion.as_ref().ok_or(Absent::TooShort)
    }

    /// The motion that was meant: without the tremor.
    pub(crate) fn intent(&self) -> Result<&Motion, Absent> {
        self.intent.as_ref().ok_or(Absent::TooShort)
    }

    /// The first confirm event; where there is none, the last moment at the largest depth.
    pub(crate) fn confirmed(&self) -> Result<Confirmed, Absent> {
        self.touched()?;
        let event = self.recording.events.iter().find(|e| e.kind == EventKind::Confirm && e.t_s.is_finite());
        let t_s = event.map_or_else(|| self.deepest_s(), |e| e.t_s);
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

    /// The insertion under way at a time; the first one before it.
    pub(crate) fn insertion_at(&self, t_s: f64) -> Result<&Insertion, Absent> {
        let started = self.insertions.iter().rfind(|insertion| insertion.from_s <= t_s);
        started.map_or_else(|| self.touched(), Ok)
    }

    /// Each usable sample with the insertion under way, if the needle has met the skin by then.
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

    /// Axial force on the hand at each sample, in N: the recorded force less its lateral part, along the latched axis.
    /// Unlike the sum of the axial law's parts it holds the contact with bone.
    pub(crate) fn axial_n(&self) -> Vec<f64> {
        let axial = |(s, insertion): (&Sample, Option<&Insertion>)| {
            let force = |i: usize| f64::from(s.force_n[i]) - f64::from(s.lateral_n[i]);
            insertion.map_or(0.0, |i| -i.axis.dot(&Vector3::new(force(0), force(1), force(2))))
        };
        self.ticks().map(axial).collect()
    }
}

/// The tip is in the body.
pub(crate) fn is_inserted(sample: &Sample) -> bool {
    sample.depth_m > 0.0 || sample.flags & flags::INSIDE != 0
}

/// The drawn patient's thicknesses, or the scene's own where the recording has none that fit.
fn thickness_m(recording: &Recording, bundle: &ExerciseBundle) -> Vec<f64> {
    let drawn = &recording.session.patient_thickness_mm;
    let layers = &bundle.scene.layers;
    let fits = drawn.len() == layers.len() && drawn.iter().all(|mm| mm.is_finite() && *mm >= 0.0);
    if fits {
        drawn.iter().map(|mm| mm * 1e-3).collect()
    } else {
        layers.iter().map(|layer| layer.thickness_mm * 1e-3).collect()
    }
}

fn ruptures(recording: &Recording, layers: usize) -> Vec<Rupture> {
    let rupture = |e: &Event| {
        let by_rim = match e.kind {
            EventKind::TipRupture => false,
            EventKind::RimRupture => true,
            _ => return None,
        };
        let boundary = usize::try_from(e.boundary?).ok().filter(|b| *b < layers)?;
        let finite = e.t_s.is_finite() && e.x_m.is_finite() && e.force_n.is_finite();
        finite.then_some(Rupture { t_s: e.t_s, boundary, by_rim, x_m: e.x_m, force_n: e.force_n })
    };
    let mut ruptures: Vec<Rupture> = recording.events.iter().filter_map(rupture).collect();
    ruptures.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    ruptures
}

/// One insertion per contact event; without any, one from the first sample in the body.
fn insertions(events: &[Event], timeline: &Timeline) -> Vec<Insertion> {
    let samples = timeline.samples();
    let contact = |e: &Event| {
        let usable = e.kind == EventKind::Contact && e.t_s.is_finite() && e.position_m.iter().all(|m| m.is_finite());
        // The axis is latched by the tick of the contact itself.
        let at_contact = samples[samples.partition_point(|s| s.t_s < e.t_s).min(samples.len() - 1)];
        let (entry_m, track) = (Point3::from(e.position_m), e.track.unwrap_or(0));
        usable.then(|| Insertion { from_s: e.t_s, entry_m, axis: axis(at_contact), track })
    };
    let mut insertions: Vec<Insertion> = events.iter().filter_map(contact).collect();
    insertions.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    if insertions.is_empty() {
        insertions.extend(samples.iter().find(|s| is_inserted(s)).map(|s| {
            let entry_m = Point3::from(s.position_m) - axis(s) * s.x_m;
            Insertion { from_s: s.t_s, entry_m, axis: axis(s), track: 0 }
        }));
    }
    insertions
}
