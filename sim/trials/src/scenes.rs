//! The scenes of physics section 2, and the force law on a single trajectory.

use law::Incidence;
use law::axial::{
    AxialInput, AxialOutput, AxialParams, AxialScratch, AxialSpec, AxialState, Breakaway, Contactor, FibrousSheet,
    ForceLaw, Layer, LayerOptions, MaxwellBranch, ParamError, Rupture, RuptureCriterion, step, tense_stiffness_n_per_m,
};
use law::fracture::SharpPunch;

/// Creates a layer from its numbers: thickness in mm, stiffness in N/m, damping in N·s/m², tip and
/// rim threshold in N, friction in N/m, cutting in N.
#[must_use]
pub fn make_layer(name: &str, numbers: [f64; 7]) -> Layer {
    let [thickness_mm, stiffness, damping, tip, rim, friction, cutting] = numbers;
    Layer {
        name: name.into(),
        thickness_m: thickness_mm * 1e-3,
        stiffness_n_per_m: stiffness,
        damping_n_s_per_m2: damping,
        tip_rupture_n: tip,
        rim_rupture_n: rim,
        friction_n_per_m: friction,
        cutting_n: cutting,
        options: LayerOptions::default(),
    }
}

/// Creates the specification of layers under a trocar with 2 mm from tip to rim.
#[must_use]
pub fn trocar_through(layers: Vec<Layer>) -> AxialSpec {
    AxialSpec {
        law: ForceLaw::Version2,
        layers,
        tip_to_rim_m: 0.002,
        presliding_stiffness_n_per_m: 2000.0,
        speed_window_s: 0.0,
        damping_time_s: 0.0,
        rate: None,
        breakaway: None,
    }
}

/// Creates the specification of layers under a needle without a rim.
#[must_use]
pub fn needle_through(layers: Vec<Layer>) -> AxialSpec {
    AxialSpec { tip_to_rim_m: 0.0, ..trocar_through(layers) }
}

/// The lower back of the paper with the thresholds of section 2: no friction, no cutting.
#[must_use]
pub fn paper_axial_spec() -> AxialSpec {
    trocar_through(vec![
        make_layer("skin", [0.8, 331.0, 3.0, 1.0, 1.3, 0.0, 0.0]),
        make_layer("fat", [8.4, 83.0, 1.0, 0.5, 0.6, 0.0, 0.0]),
        make_layer("muscle", [39.0, 497.0, 3.0, 1.5, 1.9, 0.0, 0.0]),
    ])
}

/// The training lower back of section 2.
#[must_use]
pub fn training_axial_spec() -> AxialSpec {
    trocar_through(vec![
        make_layer("skin", [0.8, 331.0, 300.0, 1.0, 1.3, 100.0, 0.3]),
        make_layer("fat", [8.4, 83.0, 100.0, 0.5, 0.6, 15.0, 0.1]),
        make_layer("muscle", [39.0, 497.0, 300.0, 1.5, 1.9, 40.0, 0.3]),
    ])
}

/// An option of version 3 of the law, with the size used in trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriedOption {
    /// Tents that stiffen.
    Stiffening,
    /// Branches that relax.
    Relaxation,
    /// Boundaries that rupture at a fixed indentation; no effect without branches.
    DentCriterion,
    /// Static over kinetic friction.
    StaticFriction,
    /// Sheets of fibres.
    Fibres,
    /// Sheets under tension.
    Tension,
    /// Tip thresholds derived from a fracture energy.
    Toughness,
}

/// Every option alone, and all together.
pub const OPTION_SETS: [&[TriedOption]; 8] = [
    &[TriedOption::Stiffening],
    &[TriedOption::Relaxation],
    &[TriedOption::Relaxation, TriedOption::DentCriterion],
    &[TriedOption::StaticFriction],
    &[TriedOption::Fibres],
    &[TriedOption::Tension],
    &[TriedOption::Toughness],
    ALL_OPTIONS,
];
/// Every option.
pub const ALL_OPTIONS: &[TriedOption] = &[
    TriedOption::Stiffening,
    TriedOption::Relaxation,
    TriedOption::DentCriterion,
    TriedOption::StaticFriction,
    TriedOption::Fibres,
    TriedOption::Tension,
    TriedOption::Toughness,
];

/// Radius of the needle for which the scenes' numbers hold, in m.
const NEEDLE_RADIUS_M: f64 = 1e-3;
/// Tension of every sheet, in N/m, and the radius at which it is fixed, in m: a fifth of the skin's
/// own stiffness (choice).
const TENSION_N_PER_M: f64 = 30.0;
const HELD_RADIUS_M: f64 = 0.02;
/// Fracture energy of every layer, in J/m²: of the order of magnitude of skin (choice).
const FRACTURE_ENERGY_J_PER_M2: f64 = 4e3;

/// Returns the tip's threshold in a layer with that fracture energy, in N; the modulus is that of a
/// flat punch with the layer's stiffness.
fn torn_n(layer: &Layer) -> f64 {
    const POISSON_RATIO: f64 = 0.45;
    let youngs_modulus_pa = layer.stiffness_n_per_m * (1.0 - POISSON_RATIO * POISSON_RATIO) / (2.0 * NEEDLE_RADIUS_M);
    let shear_modulus_pa = youngs_modulus_pa / (2.0 * (1.0 + POISSON_RATIO));
    let fracture_energy_j_per_m2 = FRACTURE_ENERGY_J_PER_M2;
    SharpPunch { radius_m: NEEDLE_RADIUS_M, shear_modulus_pa, fracture_energy_j_per_m2 }.threshold_n()
}

/// Adds options of version 3 to each layer of a scene; raises the version of the law to 3 if
/// necessary.
#[must_use]
pub fn with_options(spec: AxialSpec, options: &[TriedOption]) -> AxialSpec {
    let branch = |share, time_s| MaxwellBranch { share, time_s };
    let has = |option| options.contains(&option);
    let breakaway = has(TriedOption::StaticFriction).then_some(Breakaway { slid_m: 0.8e-3, rest_s: 1.0 });
    let mut spec = AxialSpec { law: spec.law.max(ForceLaw::Version3), breakaway, ..spec };
    for layer in &mut spec.layers {
        if has(TriedOption::Toughness) {
            layer.tip_rupture_n = torn_n(layer);
        }
        if has(TriedOption::Tension) {
            layer.stiffness_n_per_m += tense_stiffness_n_per_m(TENSION_N_PER_M, HELD_RADIUS_M, NEEDLE_RADIUS_M);
        }
        if has(TriedOption::Stiffening) {
            layer.options.stiffening_n_per_m2 = 40.0 * layer.stiffness_n_per_m;
        }
        if has(TriedOption::Relaxation) {
            layer.options.branches = vec![branch(0.5, 0.08), branch(0.4, 1.5), branch(0.3, 30.0)];
        }
        if has(TriedOption::DentCriterion) {
            layer.options.gives_way_at = RuptureCriterion::Dent;
        }
        if has(TriedOption::StaticFriction) {
            layer.options.static_friction_n_per_m = Some(1.6 * layer.friction_n_per_m);
        }
        if has(TriedOption::Fibres) {
            let sheet = FibrousSheet { fibres: [0.6, 0.8], along_stiffness: 0.9, along_threshold: 0.9 };
            layer.options.sheet = Some(sheet);
        }
    }
    spec
}

/// The training lower back with every option of version 3.
#[must_use]
pub fn optioned_axial_spec() -> AxialSpec {
    with_options(training_axial_spec(), ALL_OPTIONS)
}

/// The force law on a single trajectory.
pub struct AxialRun {
    /// The scene.
    pub params: AxialParams,
    /// The state of the track.
    pub state: AxialState,
    /// The last step's ruptures.
    pub scratch: AxialScratch,
    /// The needle's incidence on the layers.
    pub incidence: Incidence,
}

impl AxialRun {
    /// Creates a needle above the skin of a scene, perpendicular to it.
    ///
    /// # Errors
    /// If the law refuses the scene.
    pub fn new(spec: AxialSpec) -> Result<Self, ParamError> {
        let params = AxialParams::new(spec)?;
        let (state, scratch) = (AxialState::new(&params), AxialScratch::new(&params));
        Ok(Self { params, state, scratch, incidence: Incidence::UPRIGHT })
    }

    /// Steps to a displacement in m at a time in s.
    pub fn step(&mut self, t_s: f64, x_m: f64) -> AxialOutput {
        let input = AxialInput { t_s, x_m, incidence: self.incidence };
        step(&self.params, &mut self.state, &mut self.scratch, &input)
    }

    /// Returns the ruptures of the last step.
    #[must_use]
    pub fn ruptures(&self) -> &[Rupture] {
        &self.scratch.ruptures
    }

    /// Formats the ruptures of the last step as in the reference files, for example `tip:0+tip:1`.
    #[must_use]
    pub fn events(&self) -> String {
        let name = |rupture: &Rupture| match rupture.contactor {
            Contactor::Tip => format!("tip:{}", rupture.boundary),
            Contactor::Rim => format!("rim:{}", rupture.boundary),
        };
        self.ruptures().iter().map(name).collect::<Vec<_>>().join("+")
    }

    /// Moves at constant speed along a leg and passes each tick with its displacement in m to
    /// `see`.
    pub fn travel(&mut self, leg: &Leg, mut see: impl FnMut(&Self, f64, &AxialOutput)) {
        let ticks = (leg.duration_s / leg.dt_s).round() as u32;
        for tick in 0..=ticks {
            let part = f64::from(tick) / f64::from(ticks);
            let x_m = leg.from_m + (leg.to_m - leg.from_m) * part;
            let output = self.step(leg.start_s + f64::from(tick) * leg.dt_s, x_m);
            see(self, x_m, &output);
        }
    }
}

/// A straight segment of a trajectory. The first tick of a leg repeats the last one of the previous
/// leg and is then held.
#[derive(Clone, Copy)]
pub struct Leg {
    /// Time of its first tick, in s.
    pub start_s: f64,
    /// Length, in s.
    pub duration_s: f64,
    /// Duration of a tick, in s.
    pub dt_s: f64,
    /// First displacement, in m.
    pub from_m: f64,
    /// Last displacement, in m.
    pub to_m: f64,
}

/// In, hold, out, in again, at 1 kHz: to 40 mm at 10 mm/s.
#[must_use]
pub fn in_hold_out_in() -> [Leg; 4] {
    let leg = |start_s, duration_s, from_m, to_m| Leg { start_s, duration_s, dt_s: 1e-3, from_m, to_m };
    [leg(0.0, 4.2, -0.002, 0.04), leg(4.2, 2.0, 0.04, 0.04), leg(6.2, 4.2, 0.04, -0.002), leg(10.4, 4.4, -0.002, 0.042)]
}
