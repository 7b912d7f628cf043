//! The field carries what the force law gave it: every newton, at any rate, with recoil and drag, and nothing that is no number.
//!
//! It would fail on a load that is lost or counted twice between boundaries and layers, a recoil that depends on the field's rate
//! or not on the layer, a drag that pushes on withdrawal, and a follower that drifts or is thrown by a bad clock.

use allocation_counter::measure;
use law::axial::{AxialParams, AxialSpec, forecast_standing, write_loads};
use law::{Incidence, Skin};
use tissue::follow::{
    FollowError, FollowParams, FollowState, HandOver, Responses, StraightInsertion, TissueSpec, hand_over, rate_errors,
    recoil_time_s, step,
};
use tissue::volumetric::Problem3;
use tissue::{ElasticLayer, FieldModel, LoadKind, Model};
use trials::lumps::lower_back_with;
use trials::scenes::{AxialRun, Leg, in_hold_out_in, paper_axial_spec, training_axial_spec};

/// The lower back of physics section 4 under a needle of 1 mm radius, held 50 mm away.
pub fn lower_back() -> TissueSpec {
    let mut tissue = lower_back_with(0.0, Skin::Flat, &[]);
    tissue.slab.radius_m = 0.05;
    tissue
}

/// The force law with its loads and a field behind it.
struct Field {
    run: AxialRun,
    params: FollowParams,
    state: FollowState,
    latest_n: Vec<f64>,
    /// Ticks of the law for one of the field.
    every: u32,
    tick: u32,
}

impl Field {
    fn new(axial: AxialSpec, every: u32) -> Self {
        let params = FollowParams::new(&lower_back()).expect("a valid tissue");
        let state = FollowState::new(&params);
        Self {
            run: AxialRun::new(axial).unwrap(),
            params,
            latest_n: vec![0.0; state.loads_n.len()],
            state,
            every,
            tick: 0,
        }
    }

    /// Moves the needle to x; the field takes what is latest when it is due. Returns the law's force.
    fn put(&mut self, x_m: f64) -> f64 {
        let output = self.run.step(f64::from(self.tick) * 1e-3, x_m);
        if self.tick.is_multiple_of(self.every) {
            write_loads(&self.run.params, &self.run.state.standing(), &self.run.scratch, &mut self.latest_n);
            step(&self.params, &mut self.state, f64::from(self.every) * 1e-3, &self.latest_n);
        }
        self.tick += 1;
        output.total_n()
    }
}

#[test]
fn the_loads_are_the_force_of_the_law_to_round_off() {
    let mut run = AxialRun::new(training_axial_spec()).unwrap();
    let mut found_n = vec![0.0; 6];
    let (mut drags, mut pulls) = (0, 0);
    for leg in in_hold_out_in() {
        run.travel(&leg, |run, x_m, output| {
            write_loads(&run.params, &run.state.standing(), &run.scratch, &mut found_n);
            let total_n: f64 = found_n.iter().sum();
            assert!((total_n - output.total_n()).abs() < 1e-12, "{total_n} N of {} N at {x_m} m", output.total_n());
            assert!(found_n[..3].iter().all(|&load_n| load_n >= 0.0), "a contactor only pushes: {found_n:?}");
            drags += u32::from(found_n[3..].iter().any(|&n| n > 0.0));
            pulls += u32::from(output.v_m_per_s < -1e-3 && found_n[3..].iter().all(|&n| n <= 0.0) && found_n[5] < 0.0);
        });
    }
    assert!(drags > 1000 && pulls > 2000, "in it drags the tissue inwards, out it pulls: {drags} and {pulls} ticks");
}

#[test]
fn boundary_tents_twice_and_recoils_in_three_time_constants() {
    let mut field = Field::new(paper_axial_spec(), 1);
    let mut tents = [0; 3];
    let mut left: Option<(usize, f64, u32)> = None;
    for micron in 0..17_000_u32 {
        field.put(f64::from(micron) * 1e-6);
        for rupture in field.run.ruptures() {
            tents[rupture.boundary] += 1;
            // The law's tent just before, one tick of 1 µm earlier, is what the field let go of.
            let tau_s = lower_back().recoil_time_s[rupture.boundary];
            let carried_n = field.state.loads_n[rupture.boundary];
            assert!(carried_n > 0.99 * rupture.force_n * libm::exp(-1e-3 / tau_s), "{carried_n} N of {rupture:?}");
            left = Some((rupture.boundary, rupture.force_n, field.tick + (3.0 * tau_s / 1e-3).ceil() as u32));
        }
        if let Some((boundary, peak_n, until)) = left {
            let again = field.latest_n[boundary] > 0.05 * peak_n;
            assert!(field.tick < until || again || field.state.loads_n[boundary] <= 0.05 * peak_n, "{left:?}");
        }
    }
    assert_eq!(tents, [2, 2, 2]);
}

/// Load left at the skin after a time, in s, in so many steps, of 1 N let go at once.
fn left_n(tissue: &TissueSpec, steps: u32, time_s: f64) -> f64 {
    let params = FollowParams::new(tissue).expect("a valid tissue");
    let mut state = FollowState::new(&params);
    step(&params, &mut state, 0.0, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    (0..steps).for_each(|_| step(&params, &mut state, time_s / f64::from(steps), &[0.0; 6]));
    state.loads_n[0]
}

#[test]
fn recoil_takes_as_long_as_the_root_of_the_density_at_any_rate() {
    for (density, factor) in [(1.0, 1.0), (4.0, 2.0), (9.0, 3.0)] {
        let mut tissue = lower_back();
        let skin = &mut tissue.slab.layers[0];
        skin.density_kg_per_m3 *= density;
        tissue.recoil_time_s[0] = recoil_time_s(skin, 1e-3);
        let tau_s = factor * 2e-3 * (1090.0_f64 / 132e3).sqrt();
        for steps in [1, 2, 15, 1000] {
            let left = left_n(&tissue, steps, tau_s);
            assert!((left - libm::exp(-1.0)).abs() < 1e-12, "{left} N in {steps} steps at {density} × the density");
        }
    }
    let soft =
        ElasticLayer { thickness_m: 0.01, youngs_modulus_pa: 1000.0, poisson_ratio: 0.45, density_kg_per_m3: 1000.0 };
    assert!((recoil_time_s(&soft, 1e-3) - 0.01).abs() < 1e-15);
}

#[test]
fn field_at_15_hz_never_exceeds_the_largest_load_of_the_law() {
    for every in [1, 8, 67] {
        let mut field = Field::new(training_axial_spec(), every);
        let mut most_n = [0.0_f64; 6];
        for tick in 0..9000_u32 {
            let t_s = f64::from(tick) * 1e-3;
            field.put(0.02 * libm::sin(t_s) + 1e-4 * libm::sin(63.0 * t_s));
            for (most_n, load_n) in most_n.iter_mut().zip(&field.latest_n) {
                *most_n = most_n.max(load_n.abs());
            }
            assert!(field.state.loads_n.iter().zip(&most_n).all(|(load_n, most_n)| load_n.abs() <= *most_n));
        }
    }
}

#[test]
fn a_bad_clock_and_bad_loads_are_contained() {
    let params = FollowParams::new(&lower_back()).expect("a valid tissue");
    let mut state = FollowState::new(&params);
    let pressed = [1.0, 0.5, 0.0, -0.1, 0.2, 0.3];
    step(&params, &mut state, 0.01, &pressed);
    for dt_s in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        step(&params, &mut state, dt_s, &[0.0, 0.5, 0.0, -0.1, 0.2, 0.3]);
        assert_eq!(state.loads_n, pressed, "no time passes in {dt_s} s");
    }
    for bad in [f64::NAN, f64::INFINITY] {
        step(&params, &mut state, 1.0, &[bad; 6]);
        assert_eq!(state.loads_n, pressed, "{bad} N is no load");
    }
    step(&params, &mut state, 1.0, &[]);
    assert_eq!(state.loads_n, pressed);
    step(&params, &mut state, f64::INFINITY, &[0.0; 6]);
    assert_eq!(state.loads_n, [0.0; 6], "a gap of any length is over");
}

#[test]
fn field_matches_the_law_after_eight_hours_and_a_long_hold() {
    let params = FollowParams::new(&lower_back()).expect("a valid tissue");
    let mut state = FollowState::new(&params);
    // The follower alone, at 120 Hz: its loads are a function of the latest ones, so that nothing can add up.
    for tick in 0..8 * 3600 * 120_u32 {
        let load_n = 1.0 + libm::sin(f64::from(tick % 240) * 0.026);
        step(&params, &mut state, 1.0 / 120.0, &[load_n, 0.0, 0.5 * load_n, 0.1, -0.1, 0.0]);
    }
    for _ in 0..600 * 120 {
        step(&params, &mut state, 1.0 / 120.0, &[0.25, 0.0, 0.5, 0.1, -0.1, 0.0]);
    }
    assert_eq!(state.loads_n, [0.25, 0.0, 0.5, 0.1, -0.1, 0.0]);
}

#[test]
fn a_law_at_4_khz_gives_the_field_the_same_loads() {
    let at = |dt_s: f64| {
        let (mut run, mut found) = (AxialRun::new(paper_axial_spec()).unwrap(), Vec::new());
        let leg = Leg { start_s: 0.0, duration_s: 2.0, dt_s, from_m: 0.0, to_m: 0.02 };
        let mut tick = 0;
        run.travel(&leg, |run, _, _| {
            let mut loads_n = vec![0.0; 6];
            write_loads(&run.params, &run.state.standing(), &run.scratch, &mut loads_n);
            if tick % ((0.05 / dt_s).round() as u32) == 0 {
                found.push(loads_n);
            }
            tick += 1;
        });
        found
    };
    for (slow, fast) in at(1e-3).iter().zip(&at(0.25e-3)) {
        assert!(slow.iter().zip(fast).all(|(a, b)| (a - b).abs() < 1e-6), "{slow:?} and {fast:?}");
    }
}

#[test]
fn what_is_ahead_is_what_the_law_says_when_it_gets_there() {
    let mut run = AxialRun::new(training_axial_spec()).unwrap();
    for tick in 0..3000_u32 {
        run.step(f64::from(tick) * 1e-3, f64::from(tick) * 1e-5);
        let (state, mut scratch) = (run.state.clone(), run.scratch.clone());
        let foreseen = forecast_standing(&run.params, &state, &mut scratch, 1e-3);
        assert_eq!(state, run.state, "looking ahead changes nothing");
        let mut next = AxialRun {
            params: AxialParams::new(training_axial_spec()).unwrap(),
            state,
            scratch,
            incidence: Incidence::UPRIGHT,
        };
        let output = next.step(f64::from(tick + 1) * 1e-3, f64::from(tick + 1) * 1e-5);
        let off_n = (foreseen.output.total_n() - output.total_n()).abs();
        // Without a velocity yet nothing lies ahead; a rupture may fall on either side of a rounding.
        assert!(off_n < 1e-6 || tick == 0, "tick {tick}: {off_n} N");
        for dt_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let held = forecast_standing(&run.params, &run.state, &mut run.scratch, dt_s);
            assert_eq!(held, run.state.standing());
        }
    }
}

#[test]
fn the_force_handed_over_at_120_hz_is_within_a_hundredth() {
    let params = AxialParams::new(training_axial_spec()).expect("a valid scene");
    let steady = StraightInsertion { speed_m_per_s: 0.01, depth_m: 0.03, tremor_m: 0.0 };
    for insertion in [steady, StraightInsertion { tremor_m: 60e-6, ..steady }] {
        let rows = rate_errors(&params, &insertion, &[15.0, 30.0, 60.0, 120.0, 1000.0]);
        assert_eq!(rows[3].error, hand_over(&params, &insertion, rows[3].field_hz));
        let errors: Vec<HandOver> = rows.iter().map(|row| row.error).collect();
        assert!(errors[3].forecast <= 0.01, "{insertion:?}: {:?}", errors[3]);
        assert!(errors.windows(2).all(|pair| pair[1].forecast <= pair[0].forecast), "{errors:?}");
        assert!(errors[..4].iter().all(|error| error.forecast < error.held), "{errors:?}");
        assert_eq!(errors[4], HandOver { held: 0.0, extrapolated: 0.0, forecast: 0.0 });
    }
}

/// A tissue of springs for the tests: 1 N moves a point by 1 mm at the load's depth, less farther off, all of it inwards.
struct Springs {
    depth_m: f64,
    force_n: f64,
}

impl FieldModel for Springs {
    fn model(&self) -> Model {
        Model::None
    }

    fn unknowns(&self) -> usize {
        1
    }

    fn bytes(&self) -> usize {
        size_of::<Self>()
    }

    fn solve(&mut self, force_n: f64) {
        self.force_n = force_n;
    }

    fn displacement_m(&self, r_m: f64, depth_m: f64) -> [f64; 2] {
        [-1e-3 * self.force_n / (1.0 + 100.0 * (r_m + (depth_m - self.depth_m).abs())), 0.0]
    }
}

pub fn springs(question: &Problem3) -> Result<Box<dyn FieldModel>, FollowError> {
    question.check()?;
    let depth_m = match question.flat.load.kind {
        LoadKind::Contactor { depth_m } => depth_m,
        LoadKind::Drag { from_m, to_m } => 0.5 * (from_m + to_m),
    };
    Ok(Box::new(Springs { depth_m, force_n: 0.0 }))
}

#[test]
fn a_displacement_is_the_sum_of_the_unit_responses() {
    let tissue = lower_back();
    let responses = Responses::new(&tissue, &[[0.0, 0.0], [0.002, 0.0092]], &mut springs).expect("a valid tissue");
    // Skin, fat and muscle are at 0, 0.8 and 9.2 mm; the middles of the layers at 0.4, 5 and 28.7 mm.
    let at = |r_m: f64, depth_m: f64, load_m: f64| 1e-3 / (1.0 + 100.0 * (r_m + (depth_m - load_m).abs()));
    let loads_n = [1.0, -0.5, 0.25, 2.0, 0.0, 0.0];
    let expected = at(0.002, 0.0092, 0.0) - 0.5 * at(0.002, 0.0092, 0.8e-3)
        + 0.25 * at(0.002, 0.0092, 9.2e-3)
        + 2.0 * at(0.002, 0.0092, 0.4e-3);
    assert!((responses.axial_m(1, &loads_n) - expected).abs() < 1e-15);
    assert!(responses.axial_m(0, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]) > 0.0, "a push goes in");
    assert!(responses.axial_m(2, &loads_n).abs() <= 0.0, "there is no third point");
    let at_boundaries = Responses::at_boundaries(&tissue, &mut springs).expect("a valid tissue");
    let stiffnesses = at_boundaries.stiffnesses_n_per_m();
    assert!(stiffnesses.iter().all(|k| (k - 1000.0).abs() < 1e-9), "{stiffnesses:?}");
}

#[test]
fn layer_without_thickness_is_loaded_in_place_and_never_dragged() {
    let mut tissue = lower_back();
    tissue.boundaries_m = vec![0.0, 0.0008, 0.0092, 0.0092, 0.0482];
    tissue.recoil_time_s = vec![1e-3; 4];
    let responses = Responses::at_boundaries(&tissue, &mut springs).expect("a valid tissue");
    let unit = |load: usize| std::array::from_fn::<f64, 8, _>(|at| if at == load { 1.0 } else { 0.0 });
    assert!((responses.axial_m(2, &unit(2)) - responses.axial_m(3, &unit(3))).abs() <= 0.0);
    assert!(responses.axial_m(2, &unit(6)).abs() <= 0.0);
}

#[test]
fn a_tissue_that_makes_no_sense_is_refused() {
    let refused = |change: &dyn Fn(&mut TissueSpec)| {
        let mut tissue = lower_back();
        change(&mut tissue);
        Responses::at_boundaries(&tissue, &mut springs).expect_err("nonsense").to_string()
    };
    assert!(refused(&|t| t.load_radius_m = 0.0).contains("load_radius_m = 0 m"));
    assert!(refused(&|t| t.recoil_time_s[1] = f64::NAN).contains("recoil_time_s[1]"));
    assert!(refused(&|t| t.boundaries_m.truncate(3)).contains("boundaries_m"));
    assert!(refused(&|t| t.slab.layers.clear()).contains("layers"));
}

#[test]
fn the_field_never_allocates() {
    let mut field = Field::new(training_axial_spec(), 8);
    let responses = Responses::at_boundaries(&lower_back(), &mut springs).expect("a valid tissue");
    let counted = measure(|| {
        for tick in 0..4000_u32 {
            field.put(f64::from(tick) * 1e-5);
            let look = forecast_standing(&field.run.params, &field.run.state, &mut field.run.scratch, 4e-3);
            assert!(look.output.total_n().is_finite());
            assert!(responses.axial_m(1, &field.state.loads_n).is_finite());
        }
    });
    assert_eq!(counted.count_total, 0);
}
