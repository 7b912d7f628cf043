//! The state that a picture shows at a moment of an attempt, built from its samples, events and
//! tents in order.

use std::sync::Arc;

use attempt::{Dents, Hub, Wound, Wounds};
use documents::{ExerciseBundle, Scene, SceneLayer};
use law::operator::needle_pose;
use recording::Recording;
use recording::event::{Event, EventKind};
use recording::sample::Sample;
use recording::tent::Tent;
use render::frame::{DrawnHub, DrawnPuncture, Frame, Ghost, Orbit, View};

/// Time for which a structure that was hit is highlighted, in s.
const LIT_S: f64 = 1.5;
/// Fade of a body with structures inside when the tip is at the target: for a block that is cut
/// open, and for a whole patient.
const FADED: f64 = 0.5;
const FADED_PATIENT: f64 = 0.8;

/// The state of an attempt so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// Last sample.
    pub sample: Sample,
    /// Loads on the linear field, in N: contactors, then drags.
    pub loads_n: Vec<f32>,
    dents: Dents,
    wounds: Wounds,
    hit: Option<Hit>,
    /// Orientation of the needle at its contact with the skin: tissue holds the shaft in it, even
    /// if the hand turns the handle.
    held: Option<[f64; 4]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Hit {
    structure: usize,
    at_s: f64,
}

/// How the picture is viewed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// The selected view.
    pub view: View,
    /// The user's rotation and zoom.
    pub orbit: Orbit,
    /// Whether the planned line, entry and target are drawn.
    pub guide: bool,
    /// Whether the body is seen from outside: not cut open, not faded.
    pub closed: bool,
    /// Whether there are structures inside, for which the body fades as the needle goes deeper.
    pub anatomy: bool,
}

impl Look {
    /// The default for a scene, with or without the plan: the whole patient if the scene has a skin
    /// mesh, otherwise a block that is cut open.
    #[must_use]
    pub fn at(scene: &Scene, guide: bool) -> Self {
        let view = if scene.skin.is_some() { View::Patient } else { View::Whole };
        Self { guide, view, anatomy: !scene.structures.is_empty(), ..Self::default() }
    }

    /// Fade of the body with the tip at the target, 0 to 1.
    fn most_faded(&self) -> f64 {
        match (self.anatomy && !self.closed, self.view) {
            (false, _) => 0.0,
            (true, View::Patient) => FADED_PATIENT,
            (true, View::Whole | View::Tip | View::Section) => FADED,
        }
    }
}

impl Moment {
    /// The state before the first tick: the needle is above its planned entry. Layers have the
    /// patient's thickness, in mm, or the scene's if it is missing.
    #[must_use]
    pub fn before(bundle: &ExerciseBundle, thickness_mm: &[f64]) -> Self {
        let plan = bundle.exercise.plan();
        let pose = needle_pose(&(plan.entry_m - plan.axis * plan.approach_m), &plan.axis);
        let sample = Sample {
            position_m: pose.translation.vector.into(),
            orientation: pose.rotation.coords.into(),
            ..Sample::default()
        };
        let ExerciseBundle { scene, .. } = bundle;
        let thickness_m =
            |(at, layer): (usize, &SceneLayer)| thickness_mm.get(at).unwrap_or(&layer.thickness_mm) * 1e-3;
        let thicknesses_m = scene.layers.iter().enumerate().map(thickness_m);
        let dents = Dents::new(scene.skin_shape, thicknesses_m.clone(), scene.needle.tip_to_rim_mm * 1e-3);
        Self { sample, dents, wounds: Wounds::new(bundle, thicknesses_m), ..Self::default() }
    }

    /// Adds a tick.
    pub fn sample(&mut self, sample: &Sample) {
        self.sample = *sample;
        self.wounds.sample(sample);
    }

    /// Adds an event. The events of a tick follow its sample.
    pub fn event(&mut self, event: &Event) {
        self.dents.event(event);
        self.wounds.event(event, &self.sample);
        match event.kind {
            EventKind::StructureHit => {
                self.hit = event.structure.map(|structure| Hit { structure: structure as usize, at_s: event.t_s });
            }
            EventKind::Contact => self.held = Some(self.sample.orientation),
            EventKind::SkinExit => self.held = None,
            _ => {}
        }
    }

    /// Updates the field.
    pub fn tent(&mut self, tent: &Tent) {
        self.dents.tent(tent);
        self.loads_n.clear();
        self.loads_n.extend(tent.field_loads_n());
    }

    /// Returns the number of boundaries that the tip has opened in its current track; `None`
    /// outside.
    #[must_use]
    pub fn opened(&self) -> Option<u32> {
        self.wounds.open().map(|wound| wound.opened)
    }

    /// Returns the layer that the tip is in, from the skin down; `None` at or above the skin.
    #[must_use]
    pub fn layer(&self) -> Option<usize> {
        self.dents.layer(&self.sample)
    }

    /// Returns the pose of the needle, for drawing it as a ghost.
    #[must_use]
    pub fn needle(&self) -> Ghost {
        Ghost { tip_m: self.sample.position_m.map(|c| c as f32), orientation: self.orientation() }
    }

    /// Orientation of the drawn needle: in tissue, that at its contact.
    fn orientation(&self) -> [f32; 4] {
        self.held.unwrap_or(self.sample.orientation).map(|c| c as f32)
    }

    /// Returns the data of the picture, for a body whose target is at a depth in m.
    #[must_use]
    pub fn frame(&self, look: &Look, target_depth_m: f64) -> Frame {
        let Sample { t_s, position_m, bend_m, .. } = self.sample;
        let inside = self.wounds.open();
        let deep = inside.map_or(0.0, |_| (self.sample.x_m / target_depth_m).clamp(0.0, 1.0));
        Frame {
            t_s: t_s as f32,
            tip_m: position_m.map(|c| c as f32),
            orientation: self.orientation(),
            bend_m,
            loads_n: self.loads_n.clone(),
            dents_m: self.dents.at(&self.sample),
            entry_m: inside.map(|wound| wound.entry_m.map(|c| c as f32)),
            punctures: self.wounds.punctures().iter().map(|wound| drawn_puncture(wound, t_s)).collect(),
            hub: drawn_hub(self.wounds.hub(&self.sample)),
            fade: (look.most_faded() * deep) as f32,
            guide: look.guide,
            touched: self.hit.filter(|hit| !look.closed && t_s - hit.at_s < LIT_S).map(|hit| hit.structure),
            closed: look.closed || look.view == View::Patient,
            ghost: None,
            view: look.view,
            orbit: look.orbit,
        }
    }
}

fn drawn_puncture(wound: &Wound, t_s: f64) -> DrawnPuncture {
    let Wound { entry_m, axis, depth_m, opened, .. } = *wound;
    let [entry_m, axis] = [entry_m, axis].map(|place| place.map(|c| c as f32));
    DrawnPuncture { entry_m, axis, depth_m: depth_m as f32, opened, blood: wound.blood(t_s) as f32 }
}

fn drawn_hub(hub: Hub) -> DrawnHub {
    let Hub { open, blood, plunger, drop, fallen_m } = hub;
    DrawnHub { open, blood, plunger, drop, fallen_m }
}

/// Plays a recording moment by moment. Going forwards costs only the ticks in between; going back
/// starts from the beginning.
pub struct Telling {
    recording: Arc<Recording>,
    start: Moment,
    moment: Moment,
    told: Told,
}

/// Number of elements of each list that have been played.
#[derive(Clone, Copy, Default)]
struct Told {
    samples: usize,
    events: usize,
    tents: usize,
}

impl Telling {
    /// Starts before the first sample.
    #[must_use]
    pub fn new(recording: Arc<Recording>, bundle: &ExerciseBundle) -> Self {
        let start = Moment::before(bundle, &recording.session.patient_thickness_mm);
        Self { recording, moment: start.clone(), start, told: Told::default() }
    }

    /// The recording.
    #[must_use]
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Returns the moment at a time since the start, in s; after the end, the last one.
    pub fn at(&mut self, t_s: f64) -> &Moment {
        if t_s < self.moment.sample.t_s {
            (self.moment, self.told) = (self.start.clone(), Told::default());
        }
        let (moment, told) = (&mut self.moment, &mut self.told);
        let Recording { samples, events, tents, .. } = &*self.recording;
        while let Some(sample) = samples.get(told.samples).filter(|sample| sample.t_s <= t_s) {
            moment.sample(sample);
            told.samples += 1;
            while let Some(event) = events.get(told.events).filter(|event| event.t_s <= sample.t_s) {
                moment.event(event);
                told.events += 1;
            }
        }
        while let Some(tent) = tents.get(told.tents).filter(|tent| tent.t_s <= t_s) {
            moment.tent(tent);
            told.tents += 1;
        }
        &self.moment
    }
}

#[cfg(test)]
mod tests {
    //! Fails if a picture loses a hole, highlights a structure for ever, or bleeds before the skin
    //! is open.

    use documents::Patient;
    use law::operator::Plan;
    use recording::Follows;
    use recording::sample::flags;
    use tissue::Specimen;

    use super::*;

    fn sample(t_s: f64, depth_mm: f64) -> Sample {
        let flags = if depth_mm > 0.0 { flags::INSIDE } else { 0 };
        let (x_m, position_m) = (depth_mm * 1e-3, [0.0, 0.0, -depth_mm * 1e-3]);
        Sample { t_s, x_m, position_m, orientation: [1.0, 0.0, 0.0, 0.0], flags, ..Sample::default() }
    }

    fn event(kind: EventKind, t_s: f64, track: u32) -> Event {
        Event {
            t_s,
            kind,
            boundary: Some(0),
            x_m: 0.0,
            position_m: [f64::from(track) * 0.01, 0.0, 0.0],
            force_n: 1.0,
            dissipated_j: 0.002,
            track: Some(track),
            structure: Some(3),
            text: String::new(),
        }
    }

    #[test]
    fn a_handle_that_turns_in_the_tissue_turns_no_needle() {
        let turned = |t_s, depth_mm| Sample { orientation: [0.96, 0.28, 0.0, 0.0], ..sample(t_s, depth_mm) };
        let drawn = |moment: &Moment| moment.frame(&Look::default(), 0.02).orientation[0];
        let mut moment = Moment::default();
        moment.sample(&sample(0.0, 0.1));
        moment.event(&event(EventKind::Contact, 0.0, 0));
        moment.sample(&turned(1.0, 10.0));
        assert!((drawn(&moment) - 1.0).abs() < 1e-6);
        moment.sample(&turned(2.0, -1.0));
        moment.event(&event(EventKind::SkinExit, 2.0, 0));
        assert!((drawn(&moment) - 0.96).abs() < 1e-6);
    }

    /// A needle that goes 10 mm deep, comes out, and enters again elsewhere.
    fn twice() -> Moment {
        let mut moment = Moment::default();
        moment.sample(&sample(0.0, 0.5));
        moment.event(&event(EventKind::Contact, 0.0, 0));
        moment.sample(&sample(1.0, 10.0));
        moment.event(&event(EventKind::TipRupture, 1.0, 0));
        moment.sample(&sample(2.0, -1.0));
        moment.sample(&sample(3.0, 0.5));
        moment.event(&event(EventKind::Contact, 3.0, 1));
        moment
    }

    #[test]
    fn every_hole_stays_and_the_open_one_is_known() {
        let frame = twice().frame(&Look::default(), 0.02);
        let depths: Vec<f32> = frame.punctures.iter().map(|hole| hole.depth_m).collect();
        assert_eq!(frame.punctures.iter().map(|hole| hole.opened).collect::<Vec<_>>(), [1, 0]);
        assert!((depths[0] - 0.01).abs() < 1e-9 && depths[1] < 0.001, "{depths:?}");
        assert_eq!(frame.entry_m, Some([0.01, 0.0, 0.0]));
        assert!((frame.punctures[0].axis[2] + 1.0).abs() < 1e-6, "half a turn about x points down");
    }

    /// The browser's frames have the same test (`web-admin/model/src/replay/frames.rs`).
    #[test]
    fn hub_and_wounds_are_as_the_attempt_has_them() {
        let mut moment = twice();
        let mut told = moment.wounds.clone();
        moment.event(&event(EventKind::Confirm, 3.0, 1));
        told.event(&event(EventKind::Confirm, 3.0, 1), &sample(3.0, 0.5));
        moment.sample(&sample(4.0, 5.0));
        told.sample(&sample(4.0, 5.0));
        let (frame, hub) = (moment.frame(&Look::default(), 0.02), told.hub(&sample(4.0, 5.0)));
        assert_eq!(frame.hub, drawn_hub(hub));
        let blood: Vec<f32> = told.punctures().iter().map(|wound| wound.blood(4.0) as f32).collect();
        assert_eq!(frame.punctures.iter().map(|hole| hole.blood).collect::<Vec<_>>(), blood);
        assert!(blood[0] > 0.0 && blood[1].abs() < 1e-9, "the second hole is not through the skin: {blood:?}");
    }

    #[test]
    fn a_hit_is_lit_for_a_moment() {
        let mut moment = twice();
        moment.event(&event(EventKind::StructureHit, 3.0, 0));
        assert_eq!(moment.frame(&Look::default(), 0.02).touched, Some(3));
        moment.sample(&sample(3.0 + LIT_S, 0.5));
        assert_eq!(moment.frame(&Look::default(), 0.02).touched, None);
    }

    /// An insertion past every boundary and a withdrawal, at 5 mm/s along the planned axis.
    fn attempt(bundle: &ExerciseBundle, specimen: &Specimen, patient: &Patient) -> Recording {
        let path = documents::spec_along_path(specimen.spec().axial.clone(), &bundle.exercise.incidence());
        let last_m = law::closed_form::predict_ruptures(&path).last().map_or(0.03, |rupture| rupture.x_m);
        let plan = Plan { target_x_m: last_m + 0.004, approach_m: 0.001, hold_s: 0.2, ..bundle.exercise.plan() };
        let maker = crate::maker::Maker { device: "test", device_max_force_n: f64::INFINITY, seed: 0, tick_hz: 1000.0 };
        let session =
            recording::Session { patient_thickness_mm: patient.thickness_mm.clone(), ..maker.session(bundle) };
        let attachments = assessment::attachments(bundle);
        let mut writer =
            recording::Writer::create(Vec::new(), &session, &attachments, &Default::default()).expect("memory");
        let clock = attempt::simulate::Clock { tick_hz: 1000.0, time_limit_s: 60.0 };
        let mut hand = law::operator::Operator::constant(0.005, &plan);
        attempt::simulate::simulate(specimen, &mut hand, &mut writer, &clock).expect("memory");
        Recording::read(writer.finish().expect("memory").as_slice()).expect("just written")
    }

    /// The same attempt as an older simulator recorded it, whose field followed the forces.
    fn as_before(recording: &Recording, specimen: &Specimen) -> Recording {
        let mut tissue = attempt::tick::TickedAttempt::following(specimen, Follows::Forces);
        let tents = recording.samples.iter().filter_map(|sample| tissue.step(&sample.into()).tent).collect();
        Recording { tents, ..recording.clone() }
    }

    /// Returns the largest disagreement of any frame, in m, as shown and with the field alone.
    fn disagreement_m(recording: Recording, bundle: &ExerciseBundle) -> [f64; 2] {
        let duration_s = recording.samples.last().map_or(0.0, |sample| sample.t_s);
        let mut telling = Telling::new(Arc::new(recording), bundle);
        let mut most_m = [0.0_f64; 2];
        for frame in 0..=(duration_s * 60.0) as u32 {
            let moment = telling.at(f64::from(frame) / 60.0);
            let shown = moment.frame(&Look::default(), 0.02).dents_m;
            assert_eq!(shown.len(), bundle.scene.layers.len());
            let field = moment.dents.field_m();
            for (most_m, dents_m) in most_m.iter_mut().zip([shown.as_slice(), field]) {
                *most_m = most_m.max(moment.dents.disagreement_m(&moment.sample, dents_m));
            }
        }
        most_m
    }

    #[test]
    fn tip_and_tissue_agree_in_frames_of_new_and_old_recordings() {
        let curricula = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula");
        let shelf = crate::shelf::Shelf::read(&[curricula]).expect("the shipped exercises");
        assert!(shelf.exercises.len() >= 9 && shelf.broken.is_empty());
        let mut field_m = 0.0_f64;
        for bundle in shelf.exercises.iter().map(|offer| &*offer.bundle) {
            let patient = Patient::draw(&bundle.scene, 3);
            let specimen = Specimen::new(bundle.specimen_spec(&patient)).expect("a shipped scene");
            let now = attempt(bundle, &specimen, &patient);
            let before = as_before(&now, &specimen);
            for (recording, when) in [(now, "now"), (before, "before")] {
                let verified = attempt::verify::verify_recording(&recording, &specimen);
                assert!(verified.exact(), "{} as recorded {when}: {verified:?}", bundle.exercise.id);
                let [shown_m, alone_m] = disagreement_m(recording, bundle);
                assert!(shown_m < 1e-4, "{} as recorded {when}: {shown_m} m", bundle.exercise.id);
                field_m = field_m.max(alone_m);
            }
        }
        assert!(field_m > 2e-3, "what is mended was not there: {field_m} m");
    }

    #[test]
    fn the_body_fades_on_the_way_to_the_target_unless_it_is_closed() {
        let mut moment = twice();
        moment.sample(&sample(4.0, 40.0));
        let fade = |closed, anatomy| moment.frame(&Look { closed, anatomy, ..Look::default() }, 0.02).fade;
        assert!((f64::from(fade(false, true)) - FADED).abs() < 1e-6);
        assert!(fade(true, true).abs() < 1e-9 && fade(false, false).abs() < 1e-9, "closed, or nothing to be seen");
        let patient = moment.frame(&Look { view: View::Patient, anatomy: true, ..Look::default() }, 0.02);
        assert!(patient.closed && (f64::from(patient.fade) - FADED_PATIENT).abs() < 1e-6, "{patient:?}");
    }
}
