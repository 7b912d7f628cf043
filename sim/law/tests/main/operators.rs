//! Virtual operators against the tissue: how far a hand overshoots a pop, how well it finds its depth, what it does when it meets bone, and
//! that a seed fixes every bit.
//!
//! It would fail if a hand's stiffness no longer told a novice from an expert, if a hand shook itself to pieces against bone, pushed on it
//! harder than its skill says, turned the needle inside the skin or redirected for ever, or if anything but the seed, the steps and the forces reached the motion.

use law::axial::{AxialSpec, Contactor};
use law::operator::{Felt, Motion, Operator, Plan, Skill};
use law::puncture::{PunctureEvent, PunctureOutput};
use law::structures::{Shape, StructureKind, StructureSpec};
use nalgebra::{Point3, Vector3};
use trials::needle::DrivenNeedle;
use trials::scenes::{paper_axial_spec, training_axial_spec};

const DT: f64 = 1e-3;
const TARGET_M: f64 = 0.025;
const SEEDS: u64 = 6;
/// Ticks of three minutes.
const LONGEST: usize = 180_000;

fn plan() -> Plan {
    Plan {
        entry_m: Point3::origin(),
        skin: law::Skin::Flat,
        axis: -Vector3::z(),
        target_x_m: TARGET_M,
        approach_m: 0.01,
        hold_s: 1.0,
        reach_m: 0.15,
    }
}

struct Tick {
    motion: Motion,
    output: PunctureOutput,
    events: Vec<PunctureEvent>,
}

/// Runs an operator until it is done, or for three minutes.
fn perform(operator: &mut Operator, needle: DrivenNeedle) -> Vec<Tick> {
    perform_feeling(operator, needle, |output| Felt::from(output))
}

/// The same with a hand that feels what it is told.
fn perform_feeling(
    operator: &mut Operator,
    mut needle: DrivenNeedle,
    feel: impl Fn(&PunctureOutput) -> Felt,
) -> Vec<Tick> {
    let mut ticks: Vec<Tick> = Vec::new();
    let mut felt = Felt::default();
    for _ in 0..LONGEST {
        let motion = operator.step(DT, &felt);
        let output = needle.pose(motion.patient_from_needle);
        felt = feel(&output);
        ticks.push(Tick { motion, output, events: needle.scratch.events.clone() });
        if motion.done {
            break;
        }
    }
    ticks
}

fn attempt(skill: &Skill, seed: u64, scene: AxialSpec) -> Vec<Tick> {
    perform(&mut Operator::skilled(skill, &plan(), seed), DrivenNeedle::new(scene, vec![]).expect("a valid scene"))
}

fn confirmed_x_m(ticks: &[Tick]) -> f64 {
    let confirmed: Vec<_> = ticks.iter().filter(|tick| tick.motion.confirm).collect();
    assert_eq!(confirmed.len(), 1, "an operator confirms once");
    confirmed[0].output.x_m
}

/// Furthest advance within a second after the skin's rim pop, in m.
fn overshoot_m(ticks: &[Tick]) -> f64 {
    let popped = |event: &PunctureEvent| matches!(event, PunctureEvent::Rupture(rupture) if rupture.contactor == Contactor::Rim && rupture.boundary == 0);
    let at = ticks.iter().position(|tick| tick.events.iter().any(popped)).expect("the skin's rim pop");
    let furthest = ticks[at..(at + 1000).min(ticks.len())].iter().map(|tick| tick.output.x_m).fold(f64::MIN, f64::max);
    furthest - ticks[at].output.x_m
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn hands_overshoot_the_skin_as_their_stiffness_says() {
    // Physics section 6: relaxed 5–14 mm, normal 2–5 mm, braced 0.8–1.5 mm, of the hand alone: a scene without friction.
    let cases = [(Skill::novice(), 5.0..=14.0), (Skill::intermediate(), 2.0..=5.0), (Skill::expert(), 0.8..=1.5)];
    for (skill, range_mm) in cases {
        let overshoots = (0..SEEDS).map(|seed| overshoot_m(&attempt(&skill, seed, paper_axial_spec())) * 1e3).collect();
        let typical = median(overshoots);
        assert!(range_mm.contains(&typical), "{typical} mm is outside {range_mm:?}");
    }
}

#[test]
fn expert_finds_depth_better_than_novice_and_both_withdraw() {
    let errors_mm = |skill: &Skill| -> Vec<f64> {
        (0..SEEDS)
            .map(|seed| {
                let ticks = attempt(skill, seed, training_axial_spec());
                let last = ticks.last().expect("ticks");
                assert!(last.motion.done && !last.output.inside, "seed {seed} did not come back");
                assert!(last.output.x_m < -0.008, "withdrawn to about where it began");
                (confirmed_x_m(&ticks) - TARGET_M).abs() * 1e3
            })
            .collect()
    };
    let (novice, expert) = (errors_mm(&Skill::novice()), errors_mm(&Skill::expert()));
    assert!(expert.iter().all(|error| *error < 1.3), "{expert:?}");
    assert!(novice.iter().all(|error| *error < 5.0), "{novice:?}");
    assert!(median(expert.clone()) < median(novice.clone()), "{expert:?} against {novice:?}");
}

#[test]
fn a_seed_fixes_every_bit_and_another_seed_is_another_attempt() {
    let poses = |seed| -> Vec<_> {
        attempt(&Skill::novice(), seed, training_axial_spec())
            .iter()
            .map(|tick| tick.motion.patient_from_needle)
            .collect()
    };
    let (first, again, other) = (poses(5), poses(5), poses(6));
    assert_eq!(first, again);
    assert_ne!(first[0], other[0]);
}

fn bone(half_mm: [f64; 3], middle_mm: [f64; 3]) -> StructureSpec {
    StructureSpec {
        name: "rib".into(),
        kind: StructureKind::Bone,
        shape: Shape::Box { half_extents_m: Vector3::from(half_mm) * 1e-3 },
        position_m: Point3::from(Vector3::from(middle_mm) * 1e-3),
        wall: None,
    }
}

/// Two ribs, 14 to 22 mm deep, and a gap between them on the planned line.
fn ribs(gap_mm: f64) -> Vec<StructureSpec> {
    [-1.0, 1.0].map(|side| bone([10.0 - gap_mm / 2.0, 20.0, 4.0], [side * 10.0, 0.0, -18.0])).to_vec()
}

fn skills() -> [Skill; 3] {
    [Skill::novice(), Skill::intermediate(), Skill::expert()]
}

/// What everybody does where bone is in the way wherever they go.
fn against_a_wall(look: impl Fn(&Skill, u64, &[Tick])) {
    let wall = vec![bone([40.0, 40.0, 4.0], [0.0, 0.0, -18.0])];
    for skill in skills() {
        for seed in 0..SEEDS {
            let needle = DrivenNeedle::new(training_axial_spec(), wall.clone()).expect("a valid scene");
            look(&skill, seed, &perform(&mut Operator::skilled(&skill, &plan(), seed), needle));
        }
    }
}

#[test]
fn operator_blocked_by_bone_everywhere_gives_up_and_withdraws() {
    against_a_wall(|_, seed, ticks| {
        let last = ticks.last().expect("ticks");
        assert!(last.motion.done && !last.output.inside, "seed {seed}: it must not redirect for ever");
        assert!(confirmed_x_m(ticks) < 0.018, "seed {seed}: confirmed on the bone");
        let entries = ticks.windows(2).filter(|pair| turns(pair)).count();
        assert!(entries > 0, "seed {seed}: redirected");
    });
}

/// Hardest push on bone, in N: with what a hand adds until it reacts, or brings along when it is thrown.
fn hardest_n(skill: &Skill) -> f64 {
    3.0 * skill.bone_push_n + 1.0
}

/// Whether the needle turns between two ticks.
fn turns(pair: &[Tick]) -> bool {
    let axis = |tick: &Tick| tick.motion.patient_from_needle.rotation * Vector3::z();
    axis(&pair[0]) != axis(&pair[1])
}

#[test]
fn operator_limits_bone_force_and_turns_only_outside_the_skin() {
    against_a_wall(|skill, seed, ticks| {
        let most_n = ticks.iter().map(|tick| tick.output.bone_n).fold(0.0, f64::max);
        assert!(most_n < hardest_n(skill), "seed {seed}: {most_n} N");
        assert!(ticks.windows(2).all(|pair| !turns(pair) || !pair[1].output.inside), "seed {seed}: turned inside");
    });
}

/// Bone pushes a tip out the shortest way, so that who pushes hard enough slips off it or comes through: a target counts where that was not done.
#[test]
fn redirecting_operator_reaches_targets_past_bone_more_often() {
    for skill in skills() {
        // Led far astray, so that bone is met, and never in doubt.
        let skill = Skill { angle_sd_rad: 15.0_f64.to_radians(), accepted_m: f64::INFINITY, ..skill };
        let reached = |feel: fn(&PunctureOutput) -> Felt| {
            let reaches = |seed: &u64| {
                let needle = DrivenNeedle::new(training_axial_spec(), ribs(4.0)).expect("a valid scene");
                let ticks = perform_feeling(&mut Operator::skilled(&skill, &plan(), *seed), needle, feel);
                let most_n = ticks.iter().map(|tick| tick.output.bone_n).fold(0.0, f64::max);
                (confirmed_x_m(&ticks) - TARGET_M).abs() < 0.005 && most_n < 2.0 * skill.bone_push_n + 2.0
            };
            (0..20).filter(reaches).count()
        };
        let (with, without) = (reached(|output| Felt::from(output)), reached(|output| Felt::from(output.force_n)));
        assert!(with > without + 2, "{with} of 20 who redirect, {without} who do not");
    }
}

#[test]
fn where_there_is_no_bone_nothing_is_otherwise_for_feeling_it() {
    let poses = |feel: fn(&PunctureOutput) -> Felt| -> Vec<_> {
        let needle = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
        let ticks = perform_feeling(&mut Operator::skilled(&Skill::novice(), &plan(), 3), needle, feel);
        ticks.iter().map(|tick| tick.motion.patient_from_needle).collect()
    };
    assert_eq!(poses(|output| Felt::from(output)), poses(|output| Felt::from(output.force_n)));
}

#[test]
fn constant_speed_is_exact_from_the_start_position_at_time_zero() {
    let mut operator = Operator::constant(0.002, &plan());
    let ticks = perform(&mut operator, DrivenNeedle::new(paper_axial_spec(), vec![]).expect("a valid scene"));
    for (n, tick) in ticks.iter().take(17_000).enumerate() {
        let wanted = -0.01 + 0.002 * (n as f64 * DT);
        assert!((tick.output.x_m - wanted).abs() < 1e-12, "tick {n}: {}", tick.output.x_m);
    }
    assert!((confirmed_x_m(&ticks) - TARGET_M).abs() <= 0.002 * DT + 1e-12, "within a tick of leaving the target");
    let whole_s = 2.0 * 17.5 + 1.0;
    assert!((ticks.len() as f64 * DT - whole_s).abs() < 0.01, "{}", ticks.len());
    assert!((ticks.last().expect("ticks").output.x_m + 0.01).abs() < 1e-5);
}

#[test]
fn bad_steps_and_forces_do_no_harm() {
    let mut operator = Operator::skilled(&Skill::expert(), &plan(), 2);
    let mut last = operator.step(DT, &Felt::default());
    for dt_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(operator.step(dt_s, &Felt::default()), last);
    }
    for _ in 0..1000 {
        last = operator.step(DT, &Felt { force_n: Vector3::new(f64::NAN, 0.0, f64::INFINITY), bone_n: f64::NAN });
    }
    assert!(last.patient_from_needle.translation.vector.norm() < 0.02);
    assert!(Operator::constant(0.0, &plan()).step(DT, &Felt::default()).done);
    assert!(Operator::constant(f64::NAN, &plan()).step(DT, &Felt::default()).done);
}

#[test]
fn a_trainee_between_two_skills_is_between_them() {
    let (novice, expert) = (Skill::novice(), Skill::expert());
    assert_eq!(novice.towards(&expert, 0.0), novice);
    assert_eq!(novice.towards(&expert, 1.0), expert);
    let quarter = novice.towards(&expert, 0.25);
    let wanted = 0.75 * novice.stiffness_n_per_m + 0.25 * expert.stiffness_n_per_m;
    assert!((quarter.stiffness_n_per_m - wanted).abs() < 1e-9);
    assert!(quarter.lapse < novice.lapse && quarter.depth_sd_m > expert.depth_sd_m);
}
