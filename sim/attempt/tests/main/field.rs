//! The field in a recording: it follows the needle at its own rate, comes back with its own time, pays only where it is asked for, and
//! is verified. It would fail where a tent is written that the law did not make, a recoil that the tissue does not have, where a
//! scene without a field pays for one, or a forged tent passes.

use std::collections::BTreeSet;

use attempt::simulate::{Clock, MotionSource, simulate};
use attempt::tick::TickedAttempt;
use attempt::verify::{Verification, verify_recording};
use law::axial::{AxialSpec, ForceLaw, Layer, LayerOptions, MaxwellBranch};
use law::closed_form::predict_ruptures;
use law::operator::{Felt, Motion, needle_pose};
use law::puncture::PunctureSpec;
use nalgebra::{Point3, Vector3};
use recording::{EventKind, Follows, Recording, Tent};
use tissue::follow::{Field, TissueSpec, recoil_time_s};
use tissue::{ElasticLayer, Judging, Slab, Specimen, SpecimenError, SpecimenSpec};

use crate::support::{read, writer};

const CLOCK: Clock = Clock { tick_hz: 1000.0, time_limit_s: 60.0 };
const LOAD_RADIUS_M: f64 = 1e-3;

/// Skin, fat and muscle of physics section 2, with friction, under a trocar.
fn axial() -> AxialSpec {
    let layer = |name: &str, [thickness_mm, k, tip, rim, friction]: [f64; 5]| Layer {
        name: name.to_owned(),
        thickness_m: thickness_mm * 1e-3,
        stiffness_n_per_m: k,
        damping_n_s_per_m2: 300.0,
        tip_rupture_n: tip,
        rim_rupture_n: rim,
        friction_n_per_m: friction,
        cutting_n: 0.1,
        options: LayerOptions::default(),
    };
    AxialSpec {
        law: ForceLaw::Version2,
        layers: vec![
            layer("skin", [0.8, 331.0, 1.0, 1.3, 100.0]),
            layer("fat", [8.4, 83.0, 0.5, 0.6, 15.0]),
            layer("muscle", [39.0, 497.0, 1.5, 1.9, 40.0]),
        ],
        tip_to_rim_m: 0.002,
        presliding_stiffness_n_per_m: 2000.0,
        speed_window_s: 0.0,
        damping_time_s: 0.0,
        rate: None,
        breakaway: None,
    }
}

/// Their tissue, each layer of a Young's modulus, in Pa, and a density, in kg/m³; recoil as derived.
fn tissue(axial: &AxialSpec, youngs_modulus_pa: &[f64], density_kg_per_m3: f64) -> TissueSpec {
    let elastic = |(layer, &youngs_modulus_pa): (&Layer, &f64)| ElasticLayer {
        thickness_m: layer.thickness_m,
        youngs_modulus_pa,
        poisson_ratio: 0.45,
        density_kg_per_m3,
    };
    let layers: Vec<ElasticLayer> = axial.layers.iter().zip(youngs_modulus_pa).map(elastic).collect();
    let slab = Slab { layers, radius_m: 50.0 * LOAD_RADIUS_M };
    TissueSpec {
        boundaries_m: slab.boundaries_m(),
        recoil_time_s: slab.layers.iter().map(|layer| recoil_time_s(layer, LOAD_RADIUS_M)).collect(),
        slab,
        load_radius_m: LOAD_RADIUS_M,
        tilt_rad: 0.0,
        skin: law::Skin::Flat,
        inclusions: Vec::new(),
        model: None,
        tolerance: 0.05,
        judging: Judging::default(),
        coupled: false,
    }
}

fn lower_back() -> TissueSpec {
    tissue(&axial(), &[132e3, 33.1e3, 198e3], 1050.0)
}

fn try_params(axial: AxialSpec, tissue: Option<TissueSpec>) -> Result<Specimen, SpecimenError> {
    let puncture = PunctureSpec {
        axial,
        lateral_stiffness_n_per_m2: 10_000.0,
        needle_length_m: 0.15,
        hub_stiffness_n_per_m: None,
        needle_bending_n_m2: None,
        skin: law::Skin::Flat,
        structures: vec![],
    };
    Specimen::new(SpecimenSpec { puncture, tissue })
}

fn params(axial: AxialSpec, tissue: Option<TissueSpec>) -> Specimen {
    try_params(axial, tissue).unwrap()
}

/// A needle that goes from depth to depth along itself, in m, at a speed, in m/s, at an angle to the normal, in rad.
struct Strokes {
    depths_m: Vec<f64>,
    at_m: f64,
    speed_m_per_s: f64,
    tilt_rad: f64,
}

impl Strokes {
    fn new(depths_m: &[f64], speed_m_per_s: f64) -> Self {
        Self { depths_m: depths_m.iter().rev().copied().collect(), at_m: -1e-3, speed_m_per_s, tilt_rad: 0.0 }
    }
}

impl MotionSource for Strokes {
    fn step(&mut self, dt_s: f64, _: &Felt) -> Motion {
        let most_m = self.speed_m_per_s * dt_s;
        if let Some(&to_m) = self.depths_m.last() {
            let way_m = to_m - self.at_m;
            self.at_m += way_m.clamp(-most_m, most_m);
            if way_m.abs() <= most_m {
                self.depths_m.pop();
            }
        }
        let axis = Vector3::new(libm::sin(self.tilt_rad), 0.0, -libm::cos(self.tilt_rad));
        let pose = needle_pose(&Point3::from(axis * self.at_m), &axis);
        Motion { patient_from_needle: pose, confirm: false, done: self.depths_m.is_empty() }
    }
}

fn attempt(params: &Specimen, depths_m: &[f64], speed_m_per_s: f64) -> Vec<u8> {
    attempt_by(params, Strokes::new(depths_m, speed_m_per_s))
}

fn attempt_by(params: &Specimen, mut hand: Strokes) -> Vec<u8> {
    let mut writer = writer();
    simulate(params, &mut hand, &mut writer, &CLOCK).unwrap();
    writer.finish().unwrap()
}

/// In to 20 mm and out, at 10 mm/s.
const IN_AND_OUT_M: [f64; 2] = [0.02, -0.001];

#[test]
fn the_field_is_recorded_120_times_a_second_under_its_own_topic() {
    let bytes = attempt(&params(axial(), Some(lower_back())), &IN_AND_OUT_M, 0.01);
    let Recording { tents, samples, .. } = read(&bytes);
    let last_s = samples[samples.len() - 1].t_s;
    assert_eq!(tents.len(), (120.0 * last_s).floor() as usize + 1);
    for (n, tent) in tents.iter().enumerate() {
        let late_s = tent.t_s - n as f64 / 120.0;
        assert!((-1e-9..1e-3).contains(&late_s), "step {n} at {} s", tent.t_s);
        let sample = samples.iter().find(|sample| sample.t_s == tent.t_s).unwrap();
        let drag_n: f32 = tent.drag_n.iter().sum();
        let law_n = sample.viscous_n + sample.friction_n + sample.cutting_n;
        assert!((drag_n - law_n).abs() < 1e-5, "the drag is the law's: {drag_n} N of {law_n} N");
    }
    assert_eq!(topics(&bytes).get("/tissue/tent").map(String::as_str), Some("stylet.TissueTent"));
}

/// Topic and schema of every channel.
fn topics(bytes: &[u8]) -> std::collections::BTreeMap<String, String> {
    let summary = mcap::Summary::read(bytes).unwrap().unwrap();
    let channel = |c: &std::sync::Arc<mcap::Channel<'_>>| (c.topic.clone(), c.schema.as_ref().unwrap().name.clone());
    summary.channels.values().map(channel).collect()
}

#[test]
fn withdrawal_pulls_the_tissue_out() {
    let Recording { tents, samples, .. } = read(&attempt(&params(axial(), Some(lower_back())), &IN_AND_OUT_M, 0.01));
    let tick = |tent: &Tent| samples.iter().find(|sample| sample.t_s == tent.t_s).unwrap();
    let (mut pushed, mut pulled) = (0, 0);
    for tent in &tents {
        let sample = tick(tent);
        let free = tent.contactor_n.iter().all(|&load_n| load_n < 1e-3);
        // Friction sticks for 1 mm of the way back at most.
        if sample.velocity_m_per_s[2] > 0.0 && free && sample.x_m > 0.002 && sample.x_m < 0.015 {
            assert!(tent.drag_n.iter().all(|&drag_n| drag_n <= 0.0), "{tent:?}");
            assert!(tent.tent_m.iter().all(|&tent_m| tent_m < 0.0), "{tent:?}");
            pulled += 1;
        }
        if sample.velocity_m_per_s[2] < 0.0 && sample.x_m > 0.001 {
            assert!(tent.tent_m[0] > 0.0, "{tent:?}");
            pushed += 1;
        }
    }
    assert!(pushed > 200 && pulled > 120, "{pushed} steps in, {pulled} steps out");
}

/// Time constant, in s, with which the first boundary's load goes after the last rupture of a needle that then rests.
fn recoil_s(tissue: TissueSpec) -> f64 {
    let mut single = axial();
    single.tip_to_rim_m = 0.0;
    single.layers.truncate(1);
    // Skin of 40 mm gives at 1/331 m; the needle then rests for as long as a stroke of nothing takes.
    single.layers[0].thickness_m = 0.04;
    let (peak_m, aside_m) = (3.1e-3, 3.6e-3);
    let recording = read(&attempt(&params(single, Some(tissue)), &[peak_m, aside_m], 1e-3));
    let rupture = recording.events.iter().find(|e| e.kind == EventKind::TipRupture).unwrap();
    let after: Vec<&Tent> = recording.tents.iter().filter(|tent| tent.t_s > rupture.t_s).take(30).collect();
    let ratio = f64::from(after[20].contactor_n[0] / after[1].contactor_n[0]);
    -(after[20].t_s - after[1].t_s) / libm::log(ratio)
}

fn soft(density_kg_per_m3: f64) -> TissueSpec {
    let mut skin = axial();
    skin.layers.truncate(1);
    skin.layers[0].thickness_m = 0.04;
    tissue(&skin, &[500.0], density_kg_per_m3)
}

#[test]
fn recoil_time_follows_the_root_of_density_or_a_stated_value() {
    let derived_s = recoil_s(soft(1000.0));
    assert!((derived_s / (0.04 * 2.0_f64.sqrt()) - 1.0).abs() < 1e-4, "{derived_s} s");
    for (density, factor) in [(4.0, 2.0), (9.0, 3.0), (0.25, 0.5)] {
        let ratio = recoil_s(soft(1000.0 * density)) / derived_s;
        assert!((ratio - factor).abs() < 1e-4 * factor, "{ratio} × the time at {density} × the density");
    }
    for stated_s in [0.03, 0.2] {
        let found_s = recoil_s(TissueSpec { recoil_time_s: vec![stated_s], ..soft(1000.0) });
        assert!((found_s / stated_s - 1.0).abs() < 1e-4, "{found_s} s of {stated_s} s");
    }
}

#[test]
fn a_scene_without_a_field_pays_nothing_for_it() {
    let (none, with) = (params(axial(), None), params(axial(), Some(lower_back())));
    assert!(none.field().is_none(), "no unknowns and no responses");
    assert!(with.field().unwrap().planned().bytes() < 1000);
    let bytes = [&none, &with].map(|params| attempt(params, &IN_AND_OUT_M, 0.01));
    let [bare, followed] = [&bytes[0], &bytes[1]].map(|bytes| read(bytes));
    assert!(bytes[0].len() < bytes[1].len());
    let names: BTreeSet<String> = topics(&bytes[0]).into_keys().collect();
    assert!(!names.contains("/tissue/tent") && names.len() == 8, "{names:?}");
    assert!(bare.tents.is_empty() && !followed.tents.is_empty());
    assert_eq!(bare.samples, followed.samples, "the force law does not know the field");
    assert_eq!(bare.events, followed.events);
    let time_s = |params: &dyn Fn() -> Specimen| (0..5).map(|_| seconds(params)).fold(f64::INFINITY, f64::min);
    let (bare_s, with_s) = (time_s(&|| params(axial(), None)), time_s(&|| params(axial(), Some(lower_back()))));
    assert!(bare_s < 0.1 * with_s, "set-up: {bare_s} s without, {with_s} s with the field");
}

#[expect(clippy::disallowed_methods, reason = "what a scene pays is a time")]
fn seconds(what: &dyn Fn() -> Specimen) -> f64 {
    let start = std::time::Instant::now();
    std::hint::black_box(what());
    start.elapsed().as_secs_f64()
}

fn verified(recording: &Recording) -> Verification {
    verify_recording(recording, &params(axial(), Some(lower_back())))
}

#[test]
fn the_field_re_simulates_to_the_bit_and_a_forged_one_is_found() {
    let bytes = attempt(&params(axial(), Some(lower_back())), &IN_AND_OUT_M, 0.01);
    let honest = read(&bytes);
    let verification = verified(&honest);
    assert!(verification.exact(), "{verification:?}");
    assert_eq!(verification.tents, honest.tents.len() as u64);
    let forged = |change: &dyn Fn(&mut Vec<Tent>)| {
        let mut recording = honest.clone();
        change(&mut recording.tents);
        let verification = verified(&recording);
        assert!(!verification.exact());
        verification
    };
    assert!(forged(&|tents| tents[100].tent_m[1] += 1e-4).largest_tent_deviation_m > 0.9e-4);
    let louder = forged(&|tents| tents[100].contactor_n[0] += 0.5);
    assert_eq!((louder.channel.as_str(), louder.at_s), ("contactor_n", honest.tents[100].t_s));
    assert_eq!(forged(&|tents| tents[100].drag_n[2] = f32::NAN).channel, "drag_n");
    assert_eq!(forged(&|tents| tents[100].linear_n[2] += 0.5).channel, "linear_n");
    assert_eq!(forged(&|tents| drop(tents.pop())).tent_differences, 1);
    assert!(forged(&|tents| drop(tents.remove(3))).tent_differences > 400);
    assert!(forged(&|tents| tents[7].tent_m.truncate(1)).tent_differences > 400);
    // Another tissue is not this one.
    assert!(verify_recording(&honest, &params(axial(), None)).tent_differences > 0);
    let cut = verified(&read(&bytes[..bytes.len() / 2]));
    assert!(cut.exact() && cut.tents > 100, "{cut:?}");
}

/// Files of before the field was judged by every load do not say how it was judged. Their tents are what its meshes of that time
/// made of them.
#[test]
fn recording_judged_the_first_way_still_verifies_bit_for_bit() {
    let before = |judging| params(axial(), Some(TissueSpec { judging, ..lower_back() }));
    let old = read(&attempt(&before(Judging::First), &IN_AND_OUT_M, 0.01));
    assert!(verify_recording(&old, &before(Judging::First)).exact());
    let verification = verify_recording(&old, &before(Judging::Second));
    assert!(verification.tents > 0 && verification.largest_tent_deviation_m > 0.0, "{verification:?}");
}

/// A needle that goes in at 35° finds the field of an exercise that asks for 35°, whatever this one asks for; a recording whose field
/// was that of its exercise keeps it.
#[test]
fn field_tilts_with_the_hand_and_not_with_the_exercise() {
    let tilt_rad = 35_f64.to_radians();
    let asking = |judging, tilt_rad| params(axial(), Some(TissueSpec { judging, tilt_rad, ..lower_back() }));
    let bytes = |specimen: &Specimen| attempt_by(specimen, Strokes { tilt_rad, ..Strokes::new(&IN_AND_OUT_M, 0.01) });
    let [upright, oblique] = [0.0, tilt_rad].map(|asked| asking(Judging::Third, asked));
    let [found, expected] = [&upright, &oblique].map(|specimen| read(&bytes(specimen)));
    let off_m = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    let most_m = found.tents.iter().zip(&expected.tents).map(|(a, b)| off_m(&a.tent_m, &b.tent_m)).fold(0.0, f64::max);
    assert!(most_m < 1e-9, "{most_m} m");
    assert!(verify_recording(&found, &upright).exact());
    let before = asking(Judging::Second, 0.0);
    let old = read(&bytes(&before));
    assert!(verify_recording(&old, &before).exact());
    assert!(verify_recording(&old, &upright).largest_tent_deviation_m > 1e-5);
}

/// Skin that stiffens, and fat that relaxes.
fn stiffening() -> AxialSpec {
    let mut axial = AxialSpec { law: ForceLaw::Version3, ..axial() };
    axial.layers[0].options.stiffening_n_per_m2 = 100_000.0;
    axial.layers[1].options.branches = vec![MaxwellBranch { share: 0.8, time_s: 0.5 }];
    axial
}

/// The tents of an attempt as the field of a version makes them.
fn tents_of(recording: &Recording, specimen: &Specimen, follows: Follows) -> Vec<Tent> {
    let mut attempt = TickedAttempt::following(specimen, follows);
    recording.samples.iter().filter_map(|sample| attempt.step(&sample.into()).tent).collect()
}

#[test]
fn each_version_of_the_field_verifies_by_its_own() {
    let specimen = params(stiffening(), Some(lower_back()));
    let recording = read(&attempt(&specimen, &IN_AND_OUT_M, 0.01));
    assert!(recording.tents.iter().all(|tent| tent.follows == Follows::Secant && tent.linear_n.len() == 6));
    let newest = verify_recording(&recording, &specimen);
    assert!(newest.exact() && newest.tents > 400, "{newest:?}");
    for follows in [Follows::Forces, Follows::Needle] {
        let tents = tents_of(&recording, &specimen, follows);
        assert_ne!(
            tents.iter().map(|tent| &tent.tent_m).collect::<Vec<_>>(),
            recording.tents.iter().map(|tent| &tent.tent_m).collect::<Vec<_>>()
        );
        let old = Recording { tents, ..recording.clone() };
        assert!(verify_recording(&old, &specimen).exact(), "{follows:?}");
        let mut renamed = old;
        renamed.tents.iter_mut().for_each(|tent| tent.follows = Follows::Secant);
        assert!(!verify_recording(&renamed, &specimen).exact(), "{follows:?}");
    }
}

#[test]
fn tents_bear_the_law_and_drags_dent_less_where_it_stiffens() {
    let specimen = params(stiffening(), Some(lower_back()));
    let recording = read(&attempt(&specimen, &[0.02], 0.01));
    let axial = &specimen.spec().axial;
    let (mut pressed, mut dragged) = (0, 0);
    for tent in &recording.tents {
        let sample = recording.samples.iter().find(|sample| sample.t_s == tent.t_s).unwrap();
        // Before the first rupture the skin alone is pressed, at the law's secant stiffness.
        let is_open = recording.events.iter().any(|event| event.kind == EventKind::TipRupture && event.t_s <= tent.t_s);
        if sample.tip_n > 0.0 && !is_open {
            let law_m = axial.layers[0].dent_m(f64::from(tent.contactor_n[0]), 0.0);
            assert_eq!(tent.contactor_n[0], sample.tip_n);
            assert!((f64::from(tent.tent_m[0]) - law_m).abs() < 1e-7, "{law_m} m by {tent:?}");
            pressed += 1;
        }
        // A drag counts as the load k w of the dent that the law has under it.
        let [drag_n, linear_n] = [tent.drag_n[0], tent.linear_n[3]].map(f64::from);
        let law_n = axial.layers[0].stiffness_n_per_m * axial.layers[0].dent_m(drag_n, 0.0);
        assert!((linear_n - law_n).abs() < 1e-6, "{linear_n} N for {law_n} N of {drag_n} N");
        dragged += u32::from(linear_n < 0.99 * drag_n);
        assert_eq!(tent.linear_n[5], tent.drag_n[2], "muscle is linear");
    }
    assert!(pressed > 10 && dragged > 100, "{pressed} pressed, {dragged} dragged steps");
}

#[test]
fn a_recording_from_before_the_field_still_verifies() {
    let old = read(&attempt(&params(axial(), None), &IN_AND_OUT_M, 0.01));
    let verification = verified(&old);
    assert!(verification.exact() && verification.tents == 0, "{verification:?}");
}

#[test]
fn coupled_law_has_field_stiffness_and_predicted_ruptures() {
    let coupled = params(axial(), Some(TissueSpec { coupled: true, ..lower_back() }));
    let stiffnesses = coupled.field().unwrap().planned().stiffnesses_n_per_m();
    let used: Vec<f64> = coupled.spec().axial.layers.iter().map(|layer| layer.stiffness_n_per_m).collect();
    assert_eq!(used, stiffnesses);
    assert_eq!(used, Field::new(&lower_back()).unwrap().planned().stiffnesses_n_per_m(), "one way to the same bits");
    assert!(used.iter().zip(&axial().layers).all(|(k, own)| (k - own.stiffness_n_per_m).abs() > 1.0), "{used:?}");
    let recording = read(&attempt(&coupled, &[0.03], 0.002));
    let found = recording.events.iter().filter(|e| e.kind.contactor().is_some());
    let predicted = predict_ruptures(&coupled.spec().axial);
    assert_eq!(found.clone().count(), 6);
    for (event, expected) in found.zip(&predicted) {
        assert!((-1e-9..2.001e-6).contains(&(event.x_m - expected.x_m)), "{event:?} {expected:?}");
    }
    // Under one contactor alone the field moves as far as the needle does: that is what its stiffness means.
    let only = recording.tents.iter().rfind(|tent| tent.contactor_n[0] > 0.0 && tent.t_s < 0.85).unwrap();
    let sample = recording.samples.iter().find(|sample| sample.t_s == only.t_s).unwrap();
    assert!((f64::from(only.tent_m[0]) / sample.x_m - 1.0).abs() < 1e-5, "{only:?} at {} m", sample.x_m);
    assert!(verify_recording(&recording, &coupled).exact());
}

#[test]
fn unsound_coupled_law_is_rejected_with_its_boundary() {
    let mut unsound = axial();
    (unsound.layers[1].tip_rupture_n, unsound.layers[1].rim_rupture_n) = (9.0, 10.0);
    let stiff_below = TissueSpec { coupled: true, ..tissue(&unsound, &[132e3, 2e6, 2e6], 1050.0) };
    let error = try_params(unsound, Some(stiff_below)).unwrap_err().to_string();
    for part in ["tissue.coupling = \"field\"", "boundary 0 (skin)", "the largest sound threshold is"] {
        assert!(error.contains(part), "{part:?} is not said by: {error}");
    }
}
