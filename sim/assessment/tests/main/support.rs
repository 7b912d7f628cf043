//! Exercises and recordings made by hand, so that every metric has a closed answer.

use std::ops::Range;

use assessment::{Assessment, assess};
use documents::{
    Exercise, ExerciseBundle, FluoroscopySettings, HardFail, Needle, RubricLine, Scene, SceneLayer, SceneLayerOptions,
    SceneStructure, Shape, StructureKind, StructureSpec, TissueOptions,
};
use law::axial::ForceLaw;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use recording::sample::flags;
use recording::{Energy, Event, EventKind, Recording, Sample, Session};

/// Skin 2 mm, fat 10 mm, muscle 40 mm; straight down at the origin to 20 mm.
pub fn bundle() -> ExerciseBundle {
    let layers = [("skin", 2.0), ("fat", 10.0), ("muscle", 40.0)];
    let scene = Scene {
        id: "scene".into(),
        title: String::new(),
        description: String::new(),
        layers: layers.iter().map(|(name, thickness_mm)| layer(name, *thickness_mm)).collect(),
        body: None,
        needle: needle(),
        rate: None,
        law: ForceLaw::Version2,
        scaling: documents::NeedleScaling::Version1,
        structures: Vec::new(),
        skin: None,
        skin_shape: law::Skin::Flat,
        tissue: TissueOptions { model: "none".into(), tolerance: 0.01, coupling: "none".into() },
        sha256: String::new(),
    };
    ExerciseBundle {
        exercise: exercise(),
        scene,
        exercise_bytes: vec![],
        scene_bytes: vec![],
        meshes: vec![],
        pictures: vec![],
    }
}

/// A C-arm at its defaults.
pub fn c_arm() -> FluoroscopySettings {
    FluoroscopySettings { orbital_deg: 0.0, tilt_deg: 0.0, field_mm: 300.0, pulses_per_s: 7.5 }
}

fn exercise() -> Exercise {
    Exercise {
        id: "reach-20-mm".into(),
        title: "".into(),
        briefing: "".into(),
        scene: "scene.toml".into(),
        entry_mm: [0.0, 0.0],
        skin_shape: law::Skin::Flat,
        angle_deg: 0.0,
        azimuth_deg: 0.0,
        target_depth_mm: 20.0,
        time_limit_s: 60.0,
        feedback: documents::Feedback::Both,
        fluoroscopy: None,
        required: None,
        rubric: vec![line("depth_error_mm", 0.5, 4.5, 1.0)],
        hard_fails: vec![],
        pass_mark: 70.0,
        coaching: vec![],
        pictures: vec![],
        difficulty: 1,
        sha256: String::new(),
    }
}

fn layer(name: &str, thickness_mm: f64) -> SceneLayer {
    SceneLayer {
        name: name.into(),
        thickness_mm,
        thickness_spread_mm: 0.0,
        stiffness_n_per_m: 300.0,
        damping_n_s_per_m2: 1.0,
        tip_rupture_n: 1.0,
        rim_rupture_n: 1.3,
        friction_n_per_m: 0.0,
        cutting_n: 0.0,
        density_kg_per_m3: 1000.0,
        poisson_ratio: 0.45,
        youngs_modulus_pa: None,
        toughness_factor: 1.0,
        recoil_time_s: None,
        texture: name.into(),
        source: String::new(),
        provenance: Vec::new(),
        options: SceneLayerOptions::default(),
    }
}

fn needle() -> Needle {
    Needle {
        kind: "trocar".into(),
        family: None,
        diameter_mm: 2.0,
        diameter_exponent: 1.0,
        tip: "diamond".into(),
        hub: "stylet".into(),
        tip_to_rim_mm: 2.0,
        length_mm: 150.0,
        hub_stiffness_n_per_m: None,
        lubrication: 1.0,
        flexible: false,
        youngs_modulus_pa: 193e9,
        inner_diameter_mm: 0.0,
        presliding_stiffness_n_per_m: 2000.0,
        speed_window_ms: 12.0,
        damping_time_ms: 0.0,
        lateral_stiffness_n_per_m2: 10_000.0,
        breakaway_mm: None,
        friction_rest_s: 1.0,
    }
}

pub fn line(metric: &str, full: f64, zero: f64, weight: f64) -> RubricLine {
    RubricLine { metric: metric.into(), version: 1, full, zero, weight }
}

pub fn limit(metric: &str, above: f64, why: &str) -> HardFail {
    HardFail { metric: metric.into(), version: 1, above, why: why.into() }
}

pub fn structure(name: &str, kind: StructureKind, shape: Shape, position_mm: [f64; 3]) -> SceneStructure {
    let spec = StructureSpec {
        name: name.into(),
        kind,
        shape,
        position_m: Point3::from(position_mm.map(|mm| mm * 1e-3)),
        wall: None,
    };
    SceneStructure { spec, mesh_file: None, elastic: None }
}

/// A session that names the documents of an exercise.
pub fn session_of(bundle: &ExerciseBundle, session: Session) -> Session {
    let (exercise_sha256, scene_sha256) = (bundle.exercise.sha256.clone(), bundle.scene.sha256.clone());
    Session { exercise_sha256, scene_sha256, ..session }
}

/// An attempt without samples or events.
pub fn empty() -> Recording {
    Recording::in_memory(Session::in_memory(ForceLaw::Version2, vec![2.0, 10.0, 40.0]))
}

/// Where the needle is.
#[derive(Clone, Copy)]
pub struct Pose {
    pub tip_mm: [f64; 3],
    pub axis: Vector3<f64>,
}

/// Straight down at a place on the skin, so deep.
pub fn down(x_mm: f64, y_mm: f64, depth_mm: f64) -> Pose {
    Pose { tip_mm: [x_mm, y_mm, -depth_mm], axis: -Vector3::z() }
}

pub fn orientation(axis: &Vector3<f64>) -> [f64; 4] {
    // Straight down is half a turn, about which axis is anyone's choice.
    let half_turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let q = UnitQuaternion::rotation_between(&Vector3::z(), axis).unwrap_or(half_turn);
    [q.i, q.j, q.k, q.w]
}

/// A motion at a rate over a time; in tissue as soon as the tip is below the skin, with contact and skin rupture there.
pub fn record(rate_hz: f64, duration_s: f64, pose: impl Fn(f64) -> Pose) -> Recording {
    let mut recording = empty();
    let mut inside = false;
    for i in 0..=(duration_s * rate_hz).round() as u64 {
        let t_s = i as f64 / rate_hz;
        let sample = sample(t_s, &pose(t_s));
        if sample.depth_m > 0.0 && !inside {
            recording.events.push(event(EventKind::Contact, &sample, None));
            recording.events.push(event(EventKind::TipRupture, &sample, Some(0)));
        }
        inside = sample.depth_m > 0.0;
        recording.samples.push(sample);
    }
    recording
}

fn sample(t_s: f64, pose: &Pose) -> Sample {
    let depth_m = -pose.tip_mm[2] * 1e-3;
    Sample {
        t_s,
        position_m: pose.tip_mm.map(|mm| mm * 1e-3),
        orientation: orientation(&pose.axis),
        x_m: depth_m / pose.axis.z.abs(),
        depth_m: (depth_m.max(0.0) / pose.axis.z.abs()) as f32,
        flags: if depth_m > 0.0 { flags::INSIDE } else { 0 },
        ..Sample::default()
    }
}

pub fn event(kind: EventKind, sample: &Sample, boundary: Option<u32>) -> Event {
    Event {
        t_s: sample.t_s,
        kind,
        boundary,
        x_m: sample.x_m,
        position_m: sample.position_m,
        force_n: 1.0,
        dissipated_j: 0.0,
        track: Some(0),
        structure: None,
        text: String::new(),
    }
}

/// Adds an event at a time, with what the sample then was.
pub fn mark(recording: &mut Recording, t_s: f64, kind: EventKind, boundary: Option<u32>) {
    let at = recording.samples.partition_point(|s| s.t_s < t_s - 1e-9);
    let event = event(kind, &recording.samples[at], boundary);
    recording.events.push(event);
    recording.events.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
}

/// An axial force as the tip's own, during a time.
pub fn press(recording: &mut Recording, during_s: Range<f64>, force_n: impl Fn(f64) -> f64) {
    for sample in recording.samples.iter_mut().filter(|s| during_s.contains(&s.t_s)) {
        let force = force_n(sample.t_s);
        let [x, y, z, w] = sample.orientation;
        let axis = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z)) * Vector3::z();
        sample.tip_n = force as f32;
        sample.force_n = (axis * -force).cast::<f32>().into();
    }
}

/// A force across the needle, in N, during a time.
pub fn pull(recording: &mut Recording, during_s: Range<f64>, lateral_n: [f32; 3]) {
    for sample in recording.samples.iter_mut().filter(|s| during_s.contains(&s.t_s)) {
        sample.lateral_n = lateral_n;
    }
}

/// A ledger with the same parts in each of three layers, in J.
pub fn ledger(recording: &mut Recording, rupture_j: [f64; 3]) {
    let mut energy = Energy::default();
    energy.ledger.layers.resize_with(3, Default::default);
    energy.ledger.layers.iter_mut().zip(rupture_j).for_each(|(layer, j)| layer.rupture_j = j);
    recording.energies.push(energy);
}

/// Every fourth sample from one on: the same attempt recorded more slowly.
pub fn decimate(recording: &Recording, from: usize) -> Recording {
    let samples = recording.samples.iter().skip(from).step_by(4).copied().collect();
    Recording { samples, ..recording.clone() }
}

pub fn judge(recording: &Recording, bundle: &ExerciseBundle) -> Assessment {
    assess(recording, bundle).expect("there are samples and a rubric")
}

#[track_caller]
pub fn expect(assessment: &Assessment, id: &str, expected: f64, tolerance: f64) {
    let value = assessment.value(id).unwrap_or_else(|| panic!("{id} does not apply"));
    assert!((value - expected).abs() <= tolerance, "{id} is {value}, not {expected}");
}

/// By the second definition.
#[track_caller]
pub fn expect_anew(assessment: &Assessment, id: &str, expected: f64, tolerance: f64) {
    let value = assessment.value_of(id, 2).unwrap_or_else(|| panic!("{id} does not apply"));
    assert!((value - expected).abs() <= tolerance, "{id} is {value}, not {expected}");
}

#[track_caller]
pub fn expect_absent(assessment: &Assessment, id: &str) {
    let metric = assessment.metrics.iter().find(|m| m.id == id).unwrap_or_else(|| panic!("{id} is not listed"));
    assert!(!metric.applies && metric.value.is_none() && metric.absent.is_some(), "{metric:?}");
}

/// From 5 mm above the skin at 2 mm/s to a depth, then held for a second.
pub fn plunge(to_mm: f64) -> Recording {
    let moving_s = (to_mm + 5.0) / 2.0;
    record(1000.0, moving_s + 1.0, |t_s| down(0.0, 0.0, 2.0 * t_s.min(moving_s) - 5.0))
}
