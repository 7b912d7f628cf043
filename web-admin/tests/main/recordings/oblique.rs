//! An oblique attempt that is held seven degrees off its plan, and turned further in the tissue. Fails when station, score page, replay,
//! corridor and tables place a boundary or a pop differently, or the law places it elsewhere than all of them.

use std::path::Path;

use attempt::simulate::{MotionSource, rehearse};
use attempt::{AttemptCurve, HandForces, LayerSpan, MarkKind, span_layers};
use documents::{ExerciseBundle, Patient};
use law::operator::{Felt, Motion, needle_pose};
use model::recordings::replay::Replay;
use model::scoring::corridor::corridor;
use nalgebra::{Rotation3, Vector3};
use pages::charts::Drawing;
use recording::{EventKind, Recording};
use tissue::Specimen;

/// Angle that is asked for, and by how much more the needle leans at the skin and later, in degrees.
const OFF_DEG: f64 = 7.0;
const TURNED_DEG: f64 = 2.0;

/// A hand that goes in at 10 mm/s along an axis of its own, leans further once it is in, and comes out.
struct LeaningHand {
    t_s: f64,
    entry_m: nalgebra::Point3<f64>,
    angle_deg: f64,
}

impl MotionSource for LeaningHand {
    fn step(&mut self, dt_s: f64, _felt: &Felt) -> Motion {
        const START_M: f64 = -0.005;
        const DEEPEST_M: f64 = 0.025;
        self.t_s += dt_s;
        let (gone_m, way_m) = (0.01 * self.t_s, DEEPEST_M - START_M);
        let x_m = START_M + if gone_m < way_m { gone_m } else { 2.0 * way_m - gone_m };
        let further_deg = TURNED_DEG * (x_m / DEEPEST_M).clamp(0.0, 1.0);
        let along = |angle_deg: f64| {
            let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), -angle_deg.to_radians());
            turn * -Vector3::z()
        };
        let tip_m = self.entry_m + along(self.angle_deg) * x_m;
        Motion {
            patient_from_needle: needle_pose(&tip_m, &along(self.angle_deg + further_deg)),
            confirm: false,
            done: gone_m > 2.0 * way_m,
        }
    }
}

/// The attempt, and its angle at the tick of the contact, in degrees.
fn attempt(bundle: &ExerciseBundle) -> (Recording, f64) {
    let patient = Patient::draw(&bundle.scene, 11);
    let params = Specimen::new(bundle.specimen_spec(&patient)).unwrap();
    let session = recording::Session::in_memory(bundle.scene.law, patient.thickness_mm);
    let angle_deg = bundle.exercise.angle_deg + OFF_DEG;
    let mut hand = LeaningHand { t_s: 0.0, entry_m: bundle.exercise.entry_m(), angle_deg };
    let recording = rehearse(&params, &mut hand, session, 30.0);
    let contact = recording.events.iter().find(|event| event.kind == EventKind::Contact).unwrap();
    let latched = recording.samples.iter().find(|sample| sample.t_s >= contact.t_s).unwrap();
    let gone_m = 0.01 * latched.t_s - 0.005;
    let at_contact_deg = angle_deg + TURNED_DEG * gone_m / 0.025;
    (recording, at_contact_deg)
}

fn assert_equal(ours: f64, others: f64, what: &str) {
    assert!((ours - others).abs() < 1e-9, "{what}: {ours} and {others} mm");
}

#[test]
fn views_of_an_oblique_attempt_agree_on_boundaries_and_pops() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../curricula/lower-back-basics/5-oblique-approach.toml");
    let bundle = ExerciseBundle::read(&folder).unwrap();
    let (recording, latched_deg) = attempt(&bundle);
    let station: Vec<LayerSpan> = span_layers(&recording, &bundle);
    let mut top_mm = 0.0;
    for (layer, thickness_mm) in station.iter().zip(&recording.session.patient_thickness_mm) {
        assert_equal(layer.top_mm, top_mm, &layer.name);
        top_mm += thickness_mm / libm::cos(latched_deg.to_radians());
        assert_equal(layer.bottom_mm, top_mm, &layer.name);
    }
    let curve = AttemptCurve::draw(&recording, &bundle);
    assert_eq!(curve.bands, station);
    let page = Drawing::new(&curve);
    assert_eq!(page.layers.len(), station.len());
    for ((_, from_mm, to_mm), layer) in page.layers.iter().zip(&station) {
        assert_equal(*from_mm, layer.top_mm, &layer.name);
        assert_equal(*to_mm, layer.bottom_mm, &layer.name);
    }
    let replay = Replay::of(&recording, &bundle).stage;
    for (drawn, layer) in replay.layers.iter().zip(&station) {
        assert_equal(drawn.along_top_mm, layer.top_mm, &layer.name);
        assert_equal(drawn.along_bottom_mm, layer.bottom_mm, &layer.name);
    }
    let corridor = corridor(&curve, &vec![curve.clone(); 5]).unwrap();
    let pops: Vec<_> = recording.events.iter().filter(|event| event.kind.contactor().is_some()).collect();
    assert!(pops.len() >= 6, "skin, fat and more are opened: {}", pops.len());
    for pop in pops {
        let is_it = |t_s: f64| (t_s - pop.t_s).abs() < 1e-12;
        let force_n = HandForces::measure(&recording).before_n(pop);
        let mark = curve.marks.iter().find(|mark| is_it(mark.t_s)).unwrap();
        let row = page.marks.iter().find(|row| is_it(row.t_s)).unwrap();
        let happening = replay.events.iter().find(|event| is_it(event.t_s)).unwrap();
        for (advance_mm, told_n) in
            [(mark.advance_mm, mark.axial_n), (row.advance_mm, row.force_n), (happening.advance_mm, happening.force_n)]
        {
            assert_equal(advance_mm, pop.x_m * 1e3, &pop.text);
            assert_equal(told_n, force_n, &pop.text);
        }
        if mark.kind == MarkKind::TipRupture {
            let nearest = corridor.places.iter().map(|place| (place.advance_mm - mark.advance_mm).abs());
            assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-9, "the corridor has no place at {}", pop.text);
        }
    }
}

#[test]
fn the_law_meets_a_boundary_where_it_is_shown() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../curricula/lower-back-basics/5-oblique-approach.toml");
    let bundle = ExerciseBundle::read(&folder).unwrap();
    let (recording, _) = attempt(&bundle);
    for (boundary, layer) in span_layers(&recording, &bundle).iter().enumerate().skip(1) {
        let is_before = |event: &&recording::Event| {
            event.kind == EventKind::TipRupture && event.boundary.map(|b| b as usize) == Some(boundary - 1)
        };
        let Some(before) = recording.events.iter().find(is_before) else { break };
        let pressed = recording.samples.iter().find(|s| s.t_s > before.t_s && s.tip_n > 0.0).unwrap();
        // Where the boundary before opens beyond this one, the tip presses on it in the very next tick.
        let (met_mm, tick_mm) = (pressed.x_m * 1e3, 0.0101);
        let expected_mm = layer.top_mm.max(before.x_m * 1e3);
        assert!(
            (met_mm - expected_mm).abs() <= 2.0 * tick_mm,
            "{}: met at {met_mm}, shown at {}",
            layer.name,
            layer.top_mm
        );
    }
}
