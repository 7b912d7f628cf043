//! Options of version 3 one by one: fibres, toughness, and what the mass of the tissue comes to.
//!
//! They would fail if a sheet were alike under every edge, a threshold did not follow its mechanics, or tissue set in motion were felt.

use law::axial::{
    AxialParams, AxialSpec, Breakaway, FibrousSheet, ForceLaw, MaxwellBranch, RateDependence, RuptureCriterion,
};
use law::fracture::SharpPunch;
use law::inertia::MovedTissue;
use law::operator::{Felt, Operator, Plan, Skill};
use law::soundness::find_unsound_ruptures;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use trials::needle::DrivenNeedle;
use trials::scenes::{AxialRun, make_layer, needle_through, optioned_axial_spec, training_axial_spec};

/// A fascia on soft fat, weaker along its fibres, which lie along the patient's y.
fn fascia() -> AxialSpec {
    let mut fascia = make_layer("fascia", [1.0, 600.0, 0.0, 2.0, 2.0, 0.0, 0.0]);
    fascia.options.sheet = Some(FibrousSheet { fibres: [0.0, 1.0], along_stiffness: 0.8, along_threshold: 0.5 });
    let fat = make_layer("fat", [40.0, 50.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
    AxialSpec { law: ForceLaw::Version3, ..needle_through(vec![fascia, fat]) }
}

/// The pose of a needle straight down at a depth in m, its edge turned from the patient's x by an angle in rad.
fn pose(depth_m: f64, turn_rad: f64) -> Isometry3<f64> {
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI);
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn_rad) * down;
    Isometry3::from_parts(Translation3::new(0.0, 0.0, -depth_m), turned)
}

/// Force at which the fascia opens under an edge turned so, in N, and how deep the tip is then, in m.
fn opening(turn_rad: f64) -> [f64; 2] {
    let mut needle = DrivenNeedle::new(fascia(), vec![]).expect("a valid scene");
    for tick in 0..=600_u32 {
        let depth_m = f64::from(tick) * 1e-5 - 1e-4;
        let before_n = needle.state.axial.last_output().tip_n;
        needle.pose(pose(depth_m, turn_rad));
        if needle.state.axial.tip_open > 0 {
            return [before_n, depth_m];
        }
    }
    panic!("the fascia never opened");
}

#[test]
fn a_sheet_opens_at_what_the_edges_angle_to_its_fibres_says() {
    for turn_deg in [0.0_f64, 30.0, 45.0, 90.0, 135.0, 180.0, 270.0] {
        let along = libm::sin(turn_deg.to_radians()) * libm::sin(turn_deg.to_radians());
        let [threshold_n, stiffness] = [2.0 * (1.0 - 0.5 * along), 600.0 * (1.0 - 0.2 * along)];
        let [found_n, found_m] = opening(turn_deg.to_radians());
        assert!((found_n - threshold_n).abs() <= 0.0061, "{turn_deg} degrees: {found_n} N is not {threshold_n} N");
        assert!((found_m - threshold_n / stiffness).abs() <= 1.01e-5, "{turn_deg} degrees: {found_m} m");
    }
}

#[test]
fn turning_the_edge_inside_changes_nothing_and_slit_stays_open() {
    let mut needle = DrivenNeedle::new(fascia(), vec![]).expect("a valid scene");
    // Along the fibres it would give way at 1 N, 2.1 mm deep.
    for tick in 0..=300_u32 {
        needle.pose(pose(f64::from(tick) * 1e-5 - 1e-4, if tick < 50 { 0.0 } else { 1.57 }));
    }
    assert_eq!(needle.state.axial.tip_open, 0, "the edge is latched with the axis");
    needle.pose(pose(0.004, 0.0));
    assert_eq!(needle.state.axial.tip_open, 1);
    needle.pose(pose(-0.001, 0.0));
    for turn_rad in [0.0, 1.57] {
        needle.pose(pose(0.002, turn_rad));
        assert_eq!(needle.state.axial.tip_open, 1);
        assert!(needle.state.axial.last_output().tip_n <= 50.0 * 0.001 + 1e-12, "only the fat is dented");
        needle.pose(pose(-0.001, turn_rad));
    }
}

#[test]
fn a_sheet_under_an_edge_is_the_plain_layer_of_that_edge() {
    let edge = [libm::cos(0.7), libm::sin(0.7)];
    let turned = optioned_axial_spec().under_edge(edge);
    let mut runs = [optioned_axial_spec(), turned].map(|spec| AxialRun::new(spec).expect("a valid scene"));
    runs[0].state.edge = edge;
    for tick in 0..6000_u32 {
        let (t_s, x_m) = (f64::from(tick) * 1e-3, 0.02 - 0.021 * libm::cos(f64::from(tick) * 1e-3));
        let [sheet, plain] = &mut runs;
        let (found, wanted) = (sheet.step(t_s, x_m).total_n(), plain.step(t_s, x_m).total_n());
        assert!((found - wanted).abs() <= 1e-12, "tick {tick}: {found} N is not {wanted} N");
    }
    assert_eq!(runs[0].state.tip_open, 3);
}

#[test]
fn a_sheet_that_is_unsound_under_one_edge_only_is_named() {
    let mut spec = fascia();
    // Across the fibres both give way in one breath; along them the fat holds on, dented deeper than the fascia held.
    spec.layers[1].stiffness_n_per_m = 900.0;
    spec.layers[1].tip_rupture_n = 1.9;
    assert_eq!(find_unsound_ruptures(&spec.under_edge([1.0, 0.0])), []);
    let unsound = find_unsound_ruptures(&spec);
    assert_eq!(unsound.len(), 1);
    assert_eq!((unsound[0].boundary, unsound[0].threshold_n.to_bits()), (0, 2.0_f64.to_bits()));
}

/// Would fail if what static friction takes were lost where no kinetic friction tells whose it is.
#[test]
fn static_friction_alone_is_booked() {
    let mut muscle = make_layer("muscle", [100.0, 300.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    muscle.options.static_friction_n_per_m = Some(80.0);
    let breakaway = Some(Breakaway { slid_m: 1e-3, rest_s: 1.0 });
    let spec = AxialSpec { law: ForceLaw::Version3, breakaway, ..needle_through(vec![muscle]) };
    let mut run = AxialRun::new(spec).expect("a valid scene");
    for tick in 0..3000_u32 {
        run.step(f64::from(tick) * 1e-3, f64::from(tick) * 1e-5);
    }
    let ledger = &run.state.ledger;
    assert!(ledger.layers[0].friction_j > 1e-6, "{ledger:?}");
    assert!(ledger.closure_error_j().abs() <= 1e-9 * ledger.input_j, "{ledger:?}");
}

/// A random insertion found it: what takes over has relaxed, so it holds on where its branches would have torn it in the same breath.
#[test]
fn soundness_assumes_relaxed_branches_in_the_layer_below() {
    let mut skin = make_layer("skin", [0.0, 70.0, 0.0, 0.97, 0.97, 0.0, 0.0]);
    let mut below = make_layer("below", [40.0, 320.0, 0.0, 3.7, 3.7, 0.0, 0.0]);
    assert_eq!(
        find_unsound_ruptures(&needle_through(vec![skin.clone(), below.clone()])).len(),
        0,
        "slowly both give way"
    );
    skin.options.branches = vec![MaxwellBranch { share: 1.05, time_s: 5.0 }];
    below.options.branches = vec![MaxwellBranch { share: 2.5, time_s: 1.0 }];
    let spec = AxialSpec { law: ForceLaw::Version3, ..needle_through(vec![skin, below]) };
    let unsound = find_unsound_ruptures(&spec);
    assert_eq!(unsound.iter().map(|found| found.boundary).collect::<Vec<_>>(), [0]);
}

#[test]
fn options_are_rejected_before_law_3_and_when_contradictory() {
    let branch = MaxwellBranch { share: 0.5, time_s: 1.0 };
    let mut relaxing = AxialSpec { law: ForceLaw::Version3, ..training_axial_spec() };
    relaxing.layers[1].options.branches = vec![branch];
    assert!(AxialParams::new(relaxing.clone()).is_ok());
    let refused = |change: &dyn Fn(&mut AxialSpec)| {
        let mut spec = relaxing.clone();
        change(&mut spec);
        AxialParams::new(spec).expect_err("must be refused").to_string()
    };
    assert_eq!(
        refused(&|spec| spec.law = ForceLaw::Version2),
        "layers[1].options = 2 is the law: must be absent before version 3 of the law"
    );
    let rate = RateDependence { p_infinity_n: 0.1, v0_m_per_s: 0.01 };
    assert!(
        refused(&|spec| spec.rate = Some(rate))
            .starts_with("rate.p_infinity_n = 0.1 N: must be absent together with branches")
    );
    assert!(refused(&|spec| spec.layers[0].options.branches = vec![branch; 4]).ends_with("must be at most 3"));
    assert!(
        refused(&|spec| spec.layers[0].options.branches = vec![MaxwellBranch { time_s: 0.0, ..branch }])
            .contains("time_s = 0 s")
    );
    assert!(
        refused(&|spec| spec.layers[0].options.stiffening_n_per_m2 = f64::NAN).contains("stiffening_n_per_m2 = NaN")
    );
    assert!(
        refused(&|spec| spec.layers[0].options.static_friction_n_per_m = Some(200.0)).contains("needs the breakaway")
    );
    let sheet = FibrousSheet { fibres: [1.0, 1.0], along_stiffness: 1.0, along_threshold: 1.0 };
    assert!(refused(&|spec| spec.layers[0].options.sheet = Some(sheet)).contains("options.sheet.fibres"));
}

/// `tests/data/force/toughness.csv`: the energy of a stretched ring integrated numerically and minimised numerically. The reference's own
/// quadrature is good to 1e-8.
#[test]
fn sharp_tip_threshold_minimises_slit_and_opening_energy() {
    let table = include_str!("../../../../tests/data/force/toughness.csv");
    let mut rows = 0;
    for row in table.lines().skip(1) {
        let numbers: Vec<f64> = row.split(',').map(|number| number.parse().expect("a number")).collect();
        let [radius_m, shear_modulus_pa, fracture_energy_j_per_m2, wanted_n] = numbers[..] else { panic!("{row}") };
        let found_n = SharpPunch { radius_m, shear_modulus_pa, fracture_energy_j_per_m2 }.threshold_n();
        assert!((found_n / wanted_n - 1.0).abs() <= 1e-8, "{row}: {found_n} N");
        rows += 1;
    }
    assert!(rows >= 20, "{rows} rows");
}

/// A wall that relaxes, opened at a constant speed in ticks of 1 µm: force in N and place in m.
fn open_wall(gives_way_at: RuptureCriterion, speed_m_per_s: f64) -> [f64; 2] {
    let mut wall = make_layer("wall", [40.0, 1000.0, 0.0, 4.0, 4.0, 0.0, 0.0]);
    wall.options.branches = vec![MaxwellBranch { share: 1.0, time_s: 2.0 }];
    wall.options.gives_way_at = gives_way_at;
    let spec = AxialSpec { law: ForceLaw::Version3, ..needle_through(vec![wall]) };
    let mut run = AxialRun::new(spec).expect("a valid scene");
    for tick in 0..20_000_u32 {
        run.step(f64::from(tick) * 1e-6 / speed_m_per_s, f64::from(tick) * 1e-6);
        if let Some(rupture) = run.ruptures().first() {
            return [rupture.force_n, rupture.x_m];
        }
    }
    panic!("the wall never opened");
}

/// k w + g k τ v (1 − e^(−w/(v τ))) of that wall, in N.
fn wall_force_n(speed_m_per_s: f64, w_m: f64) -> f64 {
    1000.0 * w_m + 2000.0 * speed_m_per_s * (1.0 - libm::exp(-w_m / (2.0 * speed_m_per_s)))
}

/// What docs/physics.md says of speed: a boundary that relaxes opens at its threshold whatever the speed, and the sooner the faster.
#[test]
fn speed_shifts_where_a_relaxing_boundary_opens_not_its_force() {
    let [slow, fast] = [0.4e-3, 2e-3];
    let [[slow_n, slow_m], [fast_n, fast_m]] = [slow, fast].map(|speed| open_wall(RuptureCriterion::Force, speed));
    assert!((fast_n / slow_n - 1.0).abs() < 1e-3, "{slow_n} N and {fast_n} N");
    for (speed, w) in [(slow, slow_m), (fast, fast_m)] {
        let force_n = wall_force_n(speed, w);
        assert!((force_n - 4.0).abs() < 2.1e-3, "{force_n} N at {w} m");
    }
    assert!(fast_m < 0.8 * slow_m, "{slow_m} m and {fast_m} m");
}

/// And the other way round where it gives way at a dent.
#[test]
fn speed_changes_dent_rupture_force_and_not_its_depth() {
    for speed in [0.4e-3, 2e-3, 50e-3] {
        let [force_n, x_m] = open_wall(RuptureCriterion::Dent, speed);
        assert!((x_m - 4e-3).abs() < 1.1e-6, "{x_m} m at {speed} m/s");
        assert!((force_n / wall_force_n(speed, x_m) - 1.0).abs() < 1e-9, "{force_n} N at {speed} m/s");
    }
    let [slow, fast] = [0.4e-3, 2e-3].map(|speed| open_wall(RuptureCriterion::Dent, speed)[0]);
    assert!(fast > 1.3 * slow, "{slow} N and {fast} N");
}

/// What docs/physics.md says: under 1 mN up to 19 mm/s in the stiffest layer of the lower back, 5.3 mN at 100 mm/s.
#[test]
fn tissue_set_in_motion_is_not_felt_at_the_speeds_of_a_hand() {
    let layers = training_axial_spec().layers;
    let of = |at: usize, density_kg_per_m3| {
        let layer: &law::axial::Layer = &layers[at];
        let youngs_modulus_pa = layer.stiffness_n_per_m * (1.0 - 0.45 * 0.45) / 2e-3;
        MovedTissue { radius_m: 1e-3, youngs_modulus_pa, poisson_ratio: 0.45, density_kg_per_m3, depth_m: 0.0482 }
    };
    for (tissue, most) in [(of(0, 1090.0), 0.044), (of(1, 950.0), 0.0205), (of(2, 1050.0), 0.053)] {
        let drag = tissue.wave_drag_n_s_per_m();
        assert!(drag <= most && drag >= 0.95 * most, "{drag} N s/m");
        assert!(drag * 0.019 < 1.01e-3 && drag * 0.1 < 5.3e-3, "{drag} N s/m at 19 and at 100 mm/s");
        assert!(tissue.riding_mass_kg() < 3.5e-4, "{} kg", tissue.riding_mass_kg());
    }
    // The hardest that a simulated hand starts and stops without a lunge: what rides along asks for well under 1 mN.
    let plan = Plan {
        entry_m: Point3::origin(),
        skin: law::Skin::Flat,
        axis: -Vector3::z(),
        target_x_m: 0.02,
        approach_m: 0.01,
        hold_s: 0.5,
        reach_m: 0.15,
    };
    let mut hand = Operator::skilled(&Skill::novice(), &plan, 1);
    let mut heights_m: Vec<f64> = Vec::new();
    for _ in 0..3000 {
        heights_m.push(hand.step(1e-3, &Felt::default()).patient_from_needle.translation.vector.z);
    }
    // Over 8 ms, in which a wave has crossed the layers and come back.
    let most = heights_m.windows(17).map(|z| ((z[16] - 2.0 * z[8] + z[0]) / 64e-6).abs()).fold(0.0, f64::max);
    let force_n = most * of(2, 1050.0).riding_mass_kg();
    assert!(force_n < 1e-3, "{most} m/s2 make {force_n} N");
}

/// What docs/physics.md says of the recoil. Tissue that springs back drags at the shaft by friction and for its recoil time, and by no more.
#[test]
fn tissue_recoil_gives_a_hand_about_one_percent_of_the_pop() {
    /// Time in which a hand answers a pop by its own stiffness, in s.
    const HAND_S: f64 = 0.03;
    let layers = training_axial_spec().layers;
    let mut cap_n = 0.0;
    let mut impulses = Vec::new();
    for (layer, density_kg_per_m3) in layers.iter().zip([1090.0, 950.0, 1050.0]) {
        let youngs_modulus_pa = layer.stiffness_n_per_m * (1.0 - 0.45 * 0.45) / 2e-3;
        let recoil_s = layer.thickness_m.max(2e-3) * libm::sqrt(density_kg_per_m3 / youngs_modulus_pa);
        assert!(recoil_s < 2.9e-3, "{recoil_s} s");
        impulses.push(cap_n * recoil_s);
        assert!(cap_n * recoil_s < 0.014 * layer.tip_rupture_n * HAND_S, "{cap_n} N over {recoil_s} s");
        cap_n += layer.friction_n_per_m * layer.thickness_m;
    }
    // On a hand of 0.55 kg with a device of 45 g: less than 1 mm/s, for 3 ms.
    assert!(impulses.iter().all(|impulse| impulse / 0.595 < 1e-3), "{impulses:?} N s");
}
