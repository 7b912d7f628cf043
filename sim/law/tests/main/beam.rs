//! A needle that bends is the beam of the textbooks: it meets the closed forms of Hetényi, agrees with finite elements that
//! are written here and nowhere else, and becomes the rigid law as it stiffens.
//!
//! It would fail on a wrong sign between the free and the inserted part, a series that ends too soon, a closed form that
//! cancels, a tip that does not bend with its needle, or a rigid needle that pays for one that bends.

use law::beam::{Beam, Bend, tube_n_m2};
use law::puncture::{PunctureEvent, PunctureParams, PunctureState, measure_clearance_m};
use law::structures::{Shape, StructureKind, StructureSpec};
use nalgebra::{DMatrix, DVector, Point3, SMatrix, Vector3};
use trials::needle::DrivenNeedle;
use trials::scenes::training_axial_spec;

/// Foundation, in N/m².
const K: f64 = 10_000.0;
/// Needle length, in m.
const LENGTH_M: f64 = 0.15;

/// A 22 gauge steel cannula: 0.7 mm outside, 0.4 mm inside.
fn thin() -> f64 {
    tube_n_m2(193e9, 0.7e-3, 0.4e-3)
}

fn beam(bending_n_m2: f64) -> Beam {
    Beam::new(bending_n_m2, LENGTH_M, K).expect("a valid needle")
}

fn close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected}");
}

/// Hermite elements: free over `LENGTH_M − inserted`, on the foundation below, the hub held at 1 m and level.
struct Elements {
    stiffness: DMatrix<f64>,
    shape: DVector<f64>,
}

impl Elements {
    fn solve(bending_n_m2: f64, inserted_m: f64, per_part: usize) -> Self {
        let free_m = LENGTH_M - inserted_m;
        let nodes = 2 * per_part + 1;
        let mut stiffness = DMatrix::zeros(2 * nodes, 2 * nodes);
        for element in 0..2 * per_part {
            let (part_m, foundation) = if element < per_part { (free_m, 0.0) } else { (inserted_m, K) };
            let h = part_m / per_part as f64;
            let mut block = stiffness.fixed_view_mut::<4, 4>(2 * element, 2 * element);
            block += hermite(h, bending_n_m2, foundation);
        }
        // The hub's two unknowns are known: (1, 0).
        let inner = 2 * nodes - 2;
        let load = -stiffness.view((2, 0), (inner, 1));
        let found = stiffness.view((2, 2), (inner, inner)).clone_owned().cholesky().expect("held").solve(&load);
        let mut shape = DVector::zeros(2 * nodes);
        shape[0] = 1.0;
        shape.rows_mut(2, inner).copy_from(&found);
        Self { stiffness, shape }
    }

    fn bend(&self) -> Bend {
        let reactions = &self.stiffness * &self.shape;
        Bend { stiffness_n_per_m: reactions[0], tip_share: self.shape[self.shape.len() - 2] }
    }
}

/// Cubic Hermite element: bending and consistent foundation (any textbook of finite elements).
fn hermite(h: f64, bending: f64, foundation: f64) -> SMatrix<f64, 4, 4> {
    let b = bending / (h * h * h);
    let f = foundation * h / 420.0;
    let bend = SMatrix::<f64, 4, 4>::new(
        12.0,
        6.0 * h,
        -12.0,
        6.0 * h, //
        6.0 * h,
        4.0 * h * h,
        -6.0 * h,
        2.0 * h * h, //
        -12.0,
        -6.0 * h,
        12.0,
        -6.0 * h, //
        6.0 * h,
        2.0 * h * h,
        -6.0 * h,
        4.0 * h * h,
    );
    let rest = SMatrix::<f64, 4, 4>::new(
        156.0,
        22.0 * h,
        54.0,
        -13.0 * h, //
        22.0 * h,
        4.0 * h * h,
        13.0 * h,
        -3.0 * h * h, //
        54.0,
        13.0 * h,
        156.0,
        -22.0 * h, //
        -13.0 * h,
        -3.0 * h * h,
        -22.0 * h,
        4.0 * h * h,
    );
    bend * b + rest * f
}

#[test]
fn a_long_beam_is_semi_infinite() {
    // Hetényi, section 9: w(0) = 2Pβ/k, w'(0) = −2Pβ²/k; a clamped and level end takes V = w k/β.
    let beam = Beam::new(thin(), 2.0, K).unwrap();
    let beta = libm::pow(K / (4.0 * thin()), 0.25);
    let [near, slope, far] = beam.end_loaded(2.0);
    close(near, 2.0 * beta / K, 1e-12);
    close(slope, -2.0 * beta * beta / K, 1e-12);
    assert!(far.abs() < 1e-12 * near);
    close(beam.bend(2.0).stiffness_n_per_m, K / beta, 1e-12);
}

#[test]
fn a_finite_beam_meets_hetenyi() {
    // Section 13, both ends free, at βl = 1: with sinh 1, cosh 1, sin 1 and cos 1 from tables.
    let bending = thin();
    let beta = beam(bending).beta_per_m();
    let (sh, ch, sn, cs) =
        (1.175_201_193_643_801_4, 1.543_080_634_815_243_7, 0.841_470_984_807_896_5, 0.540_302_305_868_139_8);
    let below = sh * sh - sn * sn;
    let [near, slope, far] = beam(bending).end_loaded(1.0 / beta);
    close(near, 2.0 * beta / K * (sh * ch - sn * cs) / below, 1e-13);
    close(slope, -2.0 * beta * beta / K * (sh * sh + sn * sn) / below, 1e-13);
    close(far, 2.0 * beta / K * (sh * cs - ch * sn) / below, 1e-13);
}

#[test]
fn series_and_closed_form_meet() {
    let beam = beam(thin());
    let at = 1.0 / beam.beta_per_m();
    let (below, above) = (beam.end_loaded(at * (1.0 - 1e-15)), beam.end_loaded(at * (1.0 + 1e-15)));
    for (below, above) in below.into_iter().zip(above) {
        close(below, above, 1e-13);
    }
}

#[test]
fn finite_elements_converge_to_it_at_their_order() {
    for bending in [thin(), tube_n_m2(193e9, 2.0e-3, 0.0), 1e-4] {
        for inserted_m in [0.03, 0.1] {
            let exact = beam(bending).bend(inserted_m);
            let error = |per_part| {
                let found = Elements::solve(bending, inserted_m, per_part).bend();
                let force = (found.stiffness_n_per_m / exact.stiffness_n_per_m - 1.0).abs();
                force.max((found.tip_share - exact.tip_share).abs())
            };
            let (coarse, fine) = (error(8), error(16));
            assert!(fine < 1e-4, "{bending} N·m² {inserted_m} m: {fine}");
            // Cubic elements: the deflection converges with h⁴, a factor of 16, until the elements' own round-off.
            assert!(fine < coarse / 12.0 || fine < 1e-5, "{bending} N·m² {inserted_m} m: {coarse} to {fine}");
        }
    }
}

#[test]
fn a_stiff_needle_is_the_rigid_law() {
    for inserted_m in [1e-9, 1e-4, 0.02, 0.15, 0.2] {
        let mut last = f64::INFINITY;
        for bending in [1e0, 1e3, 1e6, 1e9] {
            let bend = beam(bending).bend(inserted_m);
            let off = (bend.stiffness_n_per_m / (K * inserted_m) - 1.0).abs() + (bend.tip_share - 1.0).abs();
            assert!(off <= last.max(1e-11), "{bending} N·m² at {inserted_m} m: {off}");
            last = off;
        }
        assert!(last < 1e-8, "{inserted_m} m: {last}");
    }
}

#[test]
fn beam_is_softer_than_a_rigid_needle_and_stiffens_with_depth() {
    for bending in [1e-9, 1e-4, thin(), 1.0] {
        let mut last = 0.0;
        for tenth_mm in 0..=1500 {
            let inserted_m = f64::from(tenth_mm) * 1e-4;
            let bend = beam(bending).bend(inserted_m);
            assert!(bend.stiffness_n_per_m >= last && bend.stiffness_n_per_m <= K * inserted_m * (1.0 + 1e-12));
            assert!(bend.tip_share.abs() <= 1.0 + 1e-12, "{bend:?}");
            last = bend.stiffness_n_per_m;
        }
    }
}

#[test]
fn hostile_lengths_give_numbers() {
    for inserted_m in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, 1e-300, 1e300] {
        for bending in [1e-300, 1e-9, 1e9] {
            let bend = beam(bending).bend(inserted_m);
            assert!(bend.tip_share.is_finite() && !bend.stiffness_n_per_m.is_nan(), "{inserted_m} m: {bend:?}");
        }
    }
    for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        assert!(Beam::new(bad, LENGTH_M, K).unwrap_err().to_string().contains("needle_bending_n_m2"));
        assert!(Beam::new(1.0, bad, K).unwrap_err().to_string().contains("needle_length_m"));
    }
    assert_eq!(Beam::new(1.0, LENGTH_M, 0.0).unwrap().bend(0.05), Bend { stiffness_n_per_m: 0.0, tip_share: 1.0 });
}

/// A needle 30 mm in, then moved sideways by each of the offsets, in m; the work of the hand, in J, and the last force, in N.
fn sideways(needle: &mut DrivenNeedle, offsets_m: impl Iterator<Item = f64>) -> (f64, Vector3<f64>) {
    needle.travel(-Vector3::z(), Point3::new(0.0, 0.0, 0.001), Point3::new(0.0, 0.0, -0.03));
    let (mut work_j, mut last) = (0.0, (0.0, Vector3::zeros()));
    for offset_m in offsets_m {
        let force_n = needle.down(offset_m, 0.0, -0.03).lateral_n;
        work_j -= 0.5 * (force_n + last.1).x * (offset_m - last.0);
        last = (offset_m, force_n);
    }
    (work_j, last.1)
}

#[test]
fn the_hands_work_is_stored_in_needle_and_tissue_and_comes_back() {
    let there = (1..=500_u32).map(|n| f64::from(n) * 1e-5);
    let back = (0..500_u32).rev().map(|n| f64::from(n) * 1e-5);
    let mut needle = DrivenNeedle::bending(training_axial_spec(), vec![], Some(thin())).unwrap();
    let (work_j, force_n) = sideways(&mut needle, there.clone());
    // Energy of the bent elements and of the foundation under them, ½ uᵀ K u, at 5 mm; force and energy are one quadratic form.
    let inserted_m = needle.state.axial.last_output().depth_m;
    let Elements { stiffness, shape } = Elements::solve(thin(), inserted_m, 32);
    let stored_j = 0.5 * (&shape * 0.005).dot(&(&stiffness * &shape * 0.005));
    close(work_j, stored_j, 1e-6);
    close(-force_n.x, 2.0 * stored_j / 0.005, 1e-6);
    // Round a loop the hand gets everything back: at one depth the beam dissipates nothing and creates nothing.
    let (loop_j, _) =
        sideways(&mut DrivenNeedle::bending(training_axial_spec(), vec![], Some(thin())).unwrap(), there.chain(back));
    assert!(loop_j.abs() < 1e-12 * work_j, "{loop_j} J of {work_j} J");
}

#[test]
fn the_bent_tip_is_what_meets_structures() {
    let ball = StructureSpec {
        name: "ball".into(),
        kind: StructureKind::Vessel,
        shape: Shape::Sphere { radius_m: 0.001 },
        position_m: Point3::new(0.006, 0.0, -0.03),
        wall: None,
    };
    let hits = |bending| {
        let mut needle = DrivenNeedle::bending(training_axial_spec(), vec![ball.clone()], bending).unwrap();
        sideways(&mut needle, (1..=60_u32).map(|n| f64::from(n) * 1e-4));
        let output = needle.down(0.006, 0.0, -0.03);
        (
            measure_clearance_m(&needle.params, &needle.state) <= 0.0,
            output.bend_m.x,
            needle.scratch.events.contains(&PunctureEvent::Fault),
        )
    };
    let (rigid, bent) = (hits(None), hits(Some(thin())));
    assert_eq!((rigid.0, rigid.1, rigid.2), (true, 0.0, false));
    // The tip of the thin needle stays behind the hand by most of the offset, and so short of the ball.
    let share = beam(thin()).bend(0.03).tip_share;
    assert!(!bent.0 && bent.1 < -0.002, "{bent:?} with a share of {share}");
}

#[test]
fn a_rigid_needle_pays_nothing() {
    let path = || (1..=300_u32).map(|n| f64::from(n) * 1e-5);
    let mut rigid = DrivenNeedle::new(training_axial_spec(), vec![]).unwrap();
    let (_, force_n) = sideways(&mut rigid, path());
    assert_eq!(force_n.x.to_bits(), (0.003 * -(K * 0.03)).to_bits());
    // No byte of state is there for a beam; the parameters hold it once an attempt.
    let bent = DrivenNeedle::bending(training_axial_spec(), vec![], Some(thin())).unwrap();
    let saved = |state: &PunctureState| serde_json::to_string(state).expect("plain data").len();
    assert_eq!(saved(&PunctureState::new(&rigid.params)), saved(&PunctureState::new(&bent.params)));
    assert!(size_of::<Option<Beam>>() <= 32 && size_of::<PunctureParams>() < 576);
}
