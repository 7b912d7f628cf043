//! Blood at each entry, which depends on the structures hit, and the state of the needle's hub. It
//! is for pictures, not a measurement; window and browser both take it from here.

use documents::ExerciseBundle;
use law::structures::StructureKind;
use law::{Incidence, Skin};
use nalgebra::Point3;
use recording::sample::{Sample, flags};
use recording::{Event, EventKind};

use crate::insertion::needle_axis;
use crate::layers::tops_of_layers_m;

/// Maximum blood at an entry if no vessel was hit: a dot. 1 is the overall maximum.
const DOT: f64 = 0.16;
/// Blood that a vessel adds while the needle is still in and plugs it; the rest follows after the
/// needle is out.
const PLUGGED: f64 = 0.26;
/// Time constants of bleeding, in s: at the skin past a needle, freely from a vessel, and in the
/// hub.
const BLEEDING_S: f64 = 4.0;
const FREELY_S: f64 = 1.5;
const FLASHBACK_S: f64 = 0.6;
/// Depth, in m, and dissipated energy, in J, each of which alone makes two thirds of the blood that
/// skin alone gives.
const BLEEDING_DEPTH_M: f64 = 0.020;
const BLEEDING_J: f64 = 0.015;
/// Time in which a drop forms, in s.
const DROP_S: f64 = 1.0;
/// Acceleration of a falling drop, in m/s².
const GRAVITY_M_PER_S2: f64 = 9.81;
/// Time constant of a plunger that yields when resistance is lost, in s.
const YIELDING_S: f64 = 0.7;
/// Texture of layers that run out of an open hub.
const FLUID: &str = "fluid";

/// Entries and hub of an attempt, by the samples and events added so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wounds {
    tissue: WoundedTissue,
    wounds: Vec<Wound>,
    /// The track that the needle is in.
    open: Option<usize>,
    hub: HubStory,
}

/// Properties of scene and plan that determine bleeding and flow.
#[derive(Clone, Debug, Default, PartialEq)]
struct WoundedTissue {
    skin: Skin,
    /// Depth of every boundary below the skin, along its normal, in m.
    tops_m: Vec<f64>,
    /// Whether each layer is fluid.
    fluid: Vec<bool>,
    /// Whether each structure is a vessel.
    vessels: Vec<bool>,
    target_depth_m: f64,
    needle_length_m: f64,
    /// Whether the needle's hub can be opened, by drawing its stylet or removing its syringe. A
    /// trocar keeps its tip.
    opens: bool,
}

/// Times at which the visible states of the hub began, in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct HubStory {
    confirmed: bool,
    vessel_s: Option<f64>,
    flow: Option<Flow>,
    lost_s: Option<f64>,
}

/// Flow of fluid out of the hub.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flow {
    since_s: f64,
    /// `None` while it runs; afterwards the last drop stays where it hangs.
    until_s: Option<f64>,
}

/// A puncture, as far as it has gone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wound {
    /// Entry point on the skin, in m.
    pub entry_m: [f64; 3],
    /// Direction of its track into the body, unit length.
    pub axis: [f64; 3],
    /// Its incidence on the layers.
    incidence: Incidence,
    /// Maximum advance of the tip along it, in m.
    pub depth_m: f64,
    /// Number of boundaries that the tip has opened.
    pub opened: u32,
    dissipated_j: f64,
    /// Times at which the tip opened the skin, first hit a vessel, and was first out after that, in
    /// s.
    skin_s: Option<f64>,
    vessel_s: Option<f64>,
    out_s: Option<f64>,
}

/// The visible state of the hub at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hub {
    /// Whether stylet or syringe are removed.
    pub open: bool,
    /// Blood in it: 0 empty, 1 full.
    pub blood: f32,
    /// Position of a syringe's plunger: 0 where the hand holds it, 1 fully yielded.
    pub plunger: f32,
    /// Radius of the drop that forms at it, relative to that at which it falls; 0 without a drop.
    pub drop: f32,
    /// Distance of the last drop below the hub, in m; 0 if no drop is in the air.
    pub fallen_m: f32,
}

impl Wounds {
    /// An untouched body, with layers of given thickness from the skin down, in m.
    #[must_use]
    pub fn new(bundle: &ExerciseBundle, thicknesses_m: impl IntoIterator<Item = f64>) -> Self {
        let ExerciseBundle { scene, exercise, .. } = bundle;
        let tissue = WoundedTissue {
            skin: scene.skin_shape,
            tops_m: tops_of_layers_m(thicknesses_m),
            fluid: scene.layers.iter().map(|layer| layer.texture == FLUID).collect(),
            vessels: scene.structures.iter().map(|structure| structure.kind() == StructureKind::Vessel).collect(),
            target_depth_m: -scene.skin_shape.height_m(&exercise.target_m()),
            needle_length_m: scene.needle.length_mm * 1e-3,
            opens: scene.needle.tip_to_rim_mm <= 0.0,
        };
        Self { tissue, ..Self::default() }
    }

    /// Adds a tick.
    pub fn sample(&mut self, sample: &Sample) {
        let wound = self.open.and_then(|at| self.wounds.get_mut(at));
        let Some(wound) = wound.filter(|_| sample.flags & flags::INSIDE != 0) else {
            self.leave(sample.t_s);
            return;
        };
        wound.depth_m = wound.depth_m.max(sample.x_m);
        let layer = self.tissue.layer_of_tip(wound, sample.x_m);
        let flows = self.hub.confirmed && self.tissue.opens && layer.is_some_and(|layer| self.tissue.fluid[layer]);
        self.hub.flows(flows, sample.t_s);
        if layer.is_some_and(|layer| self.tissue.is_target(layer)) {
            self.hub.lost_s.get_or_insert(sample.t_s);
        }
    }

    fn leave(&mut self, t_s: f64) {
        self.hub.flows(false, t_s);
        if let Some(wound) = self.open.take().and_then(|at| self.wounds.get_mut(at)) {
            wound.out_s = wound.out_s.or(wound.vessel_s.map(|_| t_s));
        }
    }

    /// Adds an event, with the needle at the pose of `sample`. The events of a tick follow its
    /// sample.
    pub fn event(&mut self, event: &Event, sample: &Sample) {
        match event.kind {
            EventKind::Contact => self.contact(event, sample),
            EventKind::TipRupture | EventKind::RimRupture => self.rupture(event),
            EventKind::StructureHit => self.hit(event),
            EventKind::Confirm => self.hub.confirmed = true,
            EventKind::HubContact
            | EventKind::SkinExit
            | EventKind::Coaching
            | EventKind::Fault
            | EventKind::Interrupted => {}
        }
    }

    fn contact(&mut self, event: &Event, sample: &Sample) {
        let at = event.track.map_or(self.wounds.len(), |track| track as usize);
        // A needle that re-enters a track continues its wound.
        if at >= self.wounds.len() {
            let axis = needle_axis(sample);
            let incidence = self.tissue.skin.incidence(&Point3::from(event.position_m), &axis);
            let wound = Wound { entry_m: event.position_m, axis: axis.into(), incidence, ..Wound::default() };
            self.wounds.resize(at, Wound::default());
            self.wounds.push(wound);
        }
        self.open = Some(at);
    }

    fn rupture(&mut self, event: &Event) {
        let Some(wound) = self.open.and_then(|at| self.wounds.get_mut(at)) else { return };
        wound.dissipated_j += event.dissipated_j;
        if let (EventKind::TipRupture, Some(boundary)) = (event.kind, event.boundary) {
            wound.opened = wound.opened.max(boundary + 1);
            wound.skin_s.get_or_insert(event.t_s);
        }
    }

    fn hit(&mut self, event: &Event) {
        let structure = event.structure.and_then(|structure| self.tissue.vessels.get(structure as usize));
        if structure != Some(&true) {
            return;
        }
        self.hub.vessel_s.get_or_insert(event.t_s);
        if let Some(wound) = self.open.and_then(|at| self.wounds.get_mut(at)) {
            wound.vessel_s.get_or_insert(event.t_s);
        }
    }

    /// Returns all punctures so far, by their tracks.
    #[must_use]
    pub fn punctures(&self) -> &[Wound] {
        &self.wounds
    }

    /// Returns the puncture that the needle is in.
    #[must_use]
    pub fn open(&self) -> Option<&Wound> {
        self.open.and_then(|at| self.wounds.get(at))
    }

    /// Returns the visible state of the hub, with the needle at the pose of `sample`.
    #[must_use]
    pub fn hub(&self, sample: &Sample) -> Hub {
        let (story, t_s) = (&self.hub, sample.t_s);
        let (volume, falling_s) = story.flow.map_or((0.0, None), |flow| flow.drops(t_s));
        let fallen_m = falling_s.map_or(0.0, |falling_s| 0.5 * GRAVITY_M_PER_S2 * falling_s * falling_s);
        // The drop disappears when it has fallen to the level of the skin.
        let in_air = fallen_m < self.height_of_hub_m(sample);
        Hub {
            open: story.confirmed && self.tissue.opens,
            blood: rise(story.vessel_s, t_s, FLASHBACK_S) as f32,
            plunger: rise(story.lost_s, t_s, YIELDING_S) as f32,
            drop: libm::cbrt(volume) as f32,
            fallen_m: if in_air { fallen_m as f32 } else { 0.0 },
        }
    }

    fn height_of_hub_m(&self, sample: &Sample) -> f64 {
        sample.position_m[2] - needle_axis(sample).z * self.tissue.needle_length_m
    }
}

impl HubStory {
    /// Records whether fluid runs at a time in s.
    fn flows(&mut self, flows: bool, t_s: f64) {
        let running = self.flow.is_some_and(|flow| flow.until_s.is_none());
        if flows && !running {
            self.flow = Some(Flow { since_s: t_s, until_s: None });
        }
        if let Some(flow) = self.flow.as_mut().filter(|_| !flows && running) {
            flow.until_s = Some(t_s);
        }
    }
}

impl Flow {
    /// Returns the volume of the drop that hangs at the hub at a time in s, relative to that at
    /// which it falls, and the time for which the last one has been falling, in s.
    fn drops(&self, t_s: f64) -> (f64, Option<f64>) {
        let formed = (self.until_s.map_or(t_s, |until_s| until_s.min(t_s)) - self.since_s).max(0.0) / DROP_S;
        let whole = libm::floor(formed);
        (formed - whole, (whole > 0.0).then_some(t_s - self.since_s - whole * DROP_S))
    }
}

impl WoundedTissue {
    /// Returns the layer that the tip is in at an advance along an open track, in m: the deepest
    /// one that it has opened and not left again.
    fn layer_of_tip(&self, wound: &Wound, x_m: f64) -> Option<usize> {
        let depth_m = wound.incidence.depth_m(x_m);
        let opened = self.tops_m.iter().take(wound.opened as usize);
        opened.enumerate().rfind(|(_, top_m)| **top_m <= depth_m).map(|(layer, _)| layer)
    }

    /// Whether a layer holds the target.
    fn is_target(&self, layer: usize) -> bool {
        self.tops_m.iter().filter(|top_m| **top_m <= self.target_depth_m).count() == layer + 1
    }
}

impl Wound {
    /// Returns the blood at the skin at a time in s: 0 none, 1 the maximum. Skin alone gives a dot,
    /// which depends on depth and damage; a vessel that was hit bleeds past the needle, and freely
    /// once the needle is out.
    #[must_use]
    pub fn blood(&self, t_s: f64) -> f64 {
        let there_is = 1.0 - libm::exp(-(self.depth_m / BLEEDING_DEPTH_M + self.dissipated_j / BLEEDING_J));
        DOT * there_is * rise(self.skin_s, t_s, BLEEDING_S)
            + PLUGGED * rise(self.vessel_s, t_s, BLEEDING_S)
            + (1.0 - DOT - PLUGGED) * rise(self.out_s, t_s, FREELY_S)
    }
}

/// Returns an exponential rise from 0 to 1 with a time constant in s.
fn rise(since_s: Option<f64>, t_s: f64, over_s: f64) -> f64 {
    since_s.map_or(0.0, |since_s| 1.0 - libm::exp(-(t_s - since_s).max(0.0) / over_s))
}

#[cfg(test)]
mod tests {
    //! Fails if wounds bleed alike regardless of the structure hit, or if a hub drips before it is
    //! open.

    use documents::Patient;

    use super::*;

    fn wounds(file: &str) -> Wounds {
        let curricula = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula");
        let bundle = ExerciseBundle::read(&curricula.join(file)).expect("a shipped exercise");
        let patient = Patient::nominal(&bundle.scene);
        Wounds::new(&bundle, patient.thickness_mm.iter().map(|mm| mm * 1e-3))
    }

    fn sample(t_s: f64, depth_mm: f64) -> Sample {
        let flags = if depth_mm > 0.0 { flags::INSIDE } else { 0 };
        let (x_m, position_m) = (depth_mm * 1e-3, [0.0, 0.0, -depth_mm * 1e-3]);
        Sample { t_s, x_m, position_m, orientation: [1.0, 0.0, 0.0, 0.0], flags, ..Sample::default() }
    }

    fn event(kind: EventKind, t_s: f64, [boundary, structure]: [Option<u32>; 2]) -> Event {
        Event {
            t_s,
            kind,
            boundary,
            x_m: 0.0,
            position_m: [0.0; 3],
            force_n: 1.0,
            dissipated_j: 0.002,
            track: Some(0),
            structure,
            text: String::new(),
        }
    }

    /// Moves the tip to a depth in mm within a second, through a number of boundaries.
    fn put_in(wounds: &mut Wounds, depth_mm: f64, boundaries: u32) {
        wounds.sample(&sample(0.0, 0.1));
        wounds.event(&event(EventKind::Contact, 0.0, [None; 2]), &sample(0.0, 0.1));
        wounds.sample(&sample(1.0, depth_mm));
        for boundary in 0..boundaries {
            wounds.event(&event(EventKind::TipRupture, 1.0, [Some(boundary), None]), &sample(1.0, depth_mm));
        }
    }

    const WITH_VESSEL: &str = "lower-back-basics/6-avoid-the-vessel.toml";
    const WITH_FLUID: &str = "lumbar-puncture/1-reach-the-fluid.toml";
    const EPIDURAL: &str = "lumbar-epidural-on-a-body/1-midline.toml";

    /// Returns the blood at the skin of a deep puncture that hit a structure of a kind: with the
    /// needle in at 20 s, and 20 s after it is out.
    fn blood_after(hit: Option<StructureKind>) -> [f64; 2] {
        let mut wounds = wounds(WITH_VESSEL);
        put_in(&mut wounds, 28.0, 4);
        let is_vessel = |vessel: &bool| *vessel == (hit == Some(StructureKind::Vessel));
        let which = wounds.tissue.vessels.iter().position(is_vessel).expect("such a structure");
        if hit.is_some() {
            wounds.event(&event(EventKind::StructureHit, 2.0, [None, Some(which as u32)]), &sample(2.0, 28.0));
        }
        let inside = wounds.punctures()[0].blood(20.0);
        wounds.sample(&sample(20.0, -1.0));
        [inside, wounds.punctures()[0].blood(40.0)]
    }

    #[test]
    fn hit_vessel_bleeds_more_than_skin_and_most_after_withdrawal() {
        let [skin, bone, vessel] = [None, Some(StructureKind::Bone), Some(StructureKind::Vessel)].map(blood_after);
        assert!(skin[1] > 0.0 && skin[1] <= DOT, "skin alone is a dot: {skin:?}");
        assert!((bone[1] - skin[1]).abs() < 1e-12, "what is no vessel bleeds as skin does: {bone:?} {skin:?}");
        assert!(vessel[0] > 2.0 * skin[0] && vessel[1] > 5.0 * skin[1] && vessel[1] < 1.0, "{vessel:?} {skin:?}");
        assert!(vessel[1] > 2.0 * vessel[0], "the needle plugs it: {vessel:?}");
    }

    #[test]
    fn only_an_open_skin_bleeds_and_blood_comes_with_time() {
        let mut wounds = wounds(WITH_VESSEL);
        put_in(&mut wounds, 0.4, 0);
        assert!(wounds.punctures()[0].blood(30.0).abs() < 1e-12, "the skin is only pressed");
        put_in(&mut wounds, 10.0, 2);
        let blood = |t_s: f64| wounds.punctures()[0].blood(t_s);
        assert!(blood(1.0).abs() < 1e-12 && blood(2.0) > 0.0 && blood(30.0) > 2.0 * blood(2.0));
    }

    #[test]
    fn blood_stands_in_the_hub_since_a_vessel_was_hit_and_stays() {
        let mut wounds = wounds(WITH_VESSEL);
        put_in(&mut wounds, 18.0, 4);
        assert!(wounds.hub(&sample(5.0, 18.0)).blood.abs() < 1e-9, "nothing was hit");
        let vessel = wounds.tissue.vessels.iter().position(|vessel| *vessel).expect("a vessel") as u32;
        wounds.event(&event(EventKind::StructureHit, 5.0, [None, Some(vessel)]), &sample(5.0, 18.0));
        let [soon, later] = [5.2, 9.0].map(|t_s| wounds.hub(&sample(t_s, 18.0)).blood);
        assert!(soon > 0.1 && later > 0.99 && soon < later, "{soon} {later}");
        wounds.sample(&sample(10.0, -1.0));
        assert!(wounds.hub(&sample(10.0, -1.0)).blood > 0.99, "it does not run back");
    }

    #[test]
    fn open_hub_drips_by_time_alone_while_the_tip_is_in_fluid() {
        let mut wounds = wounds(WITH_FLUID);
        put_in(&mut wounds, 56.5, 8);
        let at = |wounds: &Wounds, t_s: f64| wounds.hub(&sample(t_s, 56.5));
        assert_eq!(at(&wounds, 3.0), Hub { plunger: at(&wounds, 3.0).plunger, ..Hub::default() }, "the stylet is in");
        wounds.event(&event(EventKind::Confirm, 3.0, [None; 2]), &sample(3.0, 56.5));
        wounds.sample(&sample(3.0, 56.5));
        let grown: Vec<f32> = (0..5).map(|tenth| at(&wounds, 3.0 + 0.2 * f64::from(tenth)).drop).collect();
        assert!(grown.windows(2).all(|pair| pair[1] > pair[0]), "a drop forms: {grown:?}");
        let falls = at(&wounds, 3.0 + DROP_S + 0.05);
        assert!((falls.fallen_m - 0.0123).abs() < 1e-3, "and falls freely: {falls:?}");
        assert!(at(&wounds, 3.0 + DROP_S + 0.5).fallen_m.abs() < 1e-9, "until it is on the skin");
        let third = at(&wounds, 3.0 + 3.0 * DROP_S + 0.05);
        assert!((third.fallen_m - falls.fallen_m).abs() < 1e-6, "one after the other: {third:?}");
        wounds.sample(&sample(9.3, 40.0));
        let hanging = at(&wounds, 9.3);
        assert!(hanging.open && hanging.drop > 0.5, "{hanging:?}");
        let later = Hub { plunger: hanging.plunger, ..at(&wounds, 12.4) };
        assert_eq!(later, hanging, "none from outside the sac: the last one hangs");
    }

    #[test]
    fn epidural_space_gives_no_drop_and_releases_the_plunger() {
        let mut wounds = wounds(EPIDURAL);
        put_in(&mut wounds, 48.0, 5);
        assert!(wounds.hub(&sample(5.0, 48.0)).plunger.abs() < 1e-9, "the flavum holds");
        put_in(&mut wounds, 51.5, 6);
        wounds.event(&event(EventKind::Confirm, 2.0, [None; 2]), &sample(2.0, 51.5));
        wounds.sample(&sample(2.0, 51.5));
        let hub = wounds.hub(&sample(6.0, 51.5));
        assert!(hub.plunger > 0.99 && hub.open && hub.drop.abs() < 1e-9, "{hub:?}");
    }
}
