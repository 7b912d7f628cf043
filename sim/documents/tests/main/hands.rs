//! Virtual hands at the shipped exercises differ as published ones do: known groups, over seeds, on forces and overshoots.
//!
//! Fails when an overshoot leaves its band, when a loss of resistance throws a hand as far as it once threw the novice
//! (38 mm), when a hand goes on where the hub lies on the skin, when a novice pushes no harder than an expert where a harder
//! boundary is within reach or one gives way at a dent, or when the same seed is not the same attempt. Bands are of medians; messages say the spread.

use std::ops::RangeInclusive;
use std::{fmt, thread};

use documents::{ExerciseBundle, Patient};
use law::axial::Contactor;
use law::operator::{Occasion, Operator, Plan, Skill};
use tissue::Specimen;
use trials::{Performance, perform};

use crate::support::{curricula, shipped};

/// Seeds of a novice and of the steadier hands, whose figures spread less.
const NOVICES: u64 = 40;
const OTHERS: u64 = 12;
/// The same at a body, whose bones take most of the time.
const AT_A_BODY: [u64; 2] = [8, 4];

fn exercises() -> Vec<ExerciseBundle> {
    let found: Vec<_> = shipped().iter().filter_map(|path| ExerciseBundle::read(path).ok()).collect();
    assert!(found.len() >= 9, "{} exercises", found.len());
    found
}

fn exercise(file: &str) -> ExerciseBundle {
    ExerciseBundle::read(&curricula().join(file)).expect("a shipped exercise is sound")
}

fn attempt(bundle: &ExerciseBundle, skill: &Skill, seed: u64) -> Performance {
    let mut spec = bundle.specimen_spec(&Patient::draw(&bundle.scene, seed));
    // A field that only a picture shows: no force depends on it, and under an oblique needle it takes seconds.
    spec.tissue = spec.tissue.filter(|_| bundle.scene.is_coupled());
    let specimen = Specimen::new(spec).expect("sound");
    let mut operator = Operator::skilled(skill, &bundle.plan(), seed);
    perform(specimen.law(), &mut operator, bundle.exercise.time_limit_s)
}

fn attempts(bundle: &ExerciseBundle, skill: &Skill, seeds: u64) -> Vec<Performance> {
    (0..seeds).map(|seed| attempt(bundle, skill, seed)).collect()
}

/// Median and the middle eight tenths.
#[derive(Clone, Copy)]
struct Spread {
    low: f64,
    median: f64,
    high: f64,
}

impl Spread {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        Self { low: at(0.1), median: at(0.5), high: at(0.9) }
    }
}

impl fmt::Display for Spread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} ({:.2} to {:.2})", self.median, self.low, self.high)
    }
}

/// The part of the needle whose pop at the skin is the last.
fn last(bundle: &ExerciseBundle) -> Contactor {
    if bundle.scene.needle.tip_to_rim_mm > 0.0 { Contactor::Rim } else { Contactor::Tip }
}

fn skin_mm(bundle: &ExerciseBundle, attempts: &[Performance]) -> Spread {
    Spread::of(attempts.iter().filter_map(|attempt| attempt.overshoot_m(0, last(bundle))).map(|over_m| over_m * 1e3))
}

/// In which bands medians of the skin's overshoot lie, in mm: relaxed, normal, braced.
struct OvershootBands([RangeInclusive<f64>; 3]);

impl OvershootBands {
    /// Physics section 6: relaxed 5–14 mm, normal 2–5 mm, braced 0.8–1.5 mm. Skin that holds as much as measured skin throws a hand farther than the
    /// millimetres of the specification, which were written for a skin of 1 N: a thicker or blunter needle further, and the skin of a body's
    /// back under a Tuohy needle most; of a thin spinal needle a relaxed hand then goes through the ligaments, too.
    fn of(bundle: &ExerciseBundle) -> Self {
        let needle = &bundle.scene.needle;
        let is_of_a_body = bundle.scene.skin.is_some();
        let is_thick = needle.diameter_mm > 2.0 || last(bundle) == Contactor::Tip;
        Self(match (is_of_a_body, is_thick) {
            (true, _) => [2.0..=26.0, 0.8..=7.0, 0.3..=3.5],
            (false, true) => [5.0..=18.0, 2.0..=8.0, 0.8..=3.5],
            (false, false) => [5.0..=18.0, 2.0..=6.5, 0.8..=2.5],
        })
    }
}

/// Whether the skin is incised before the needle: nothing gives way there, so that no hand overshoots.
fn is_incised(bundle: &ExerciseBundle) -> bool {
    bundle.scene.layers[0].tip_rupture_n <= 0.0
}

/// Overshoots lie in their bands, and nobody goes in beyond the hub.
fn check(bundle: &ExerciseBundle) {
    let (id, needle) = (&bundle.exercise.id, &bundle.scene.needle);
    let OvershootBands([relaxed, normal, braced]) = OvershootBands::of(bundle);
    let [novices, others] = if bundle.scene.skin.is_some() { AT_A_BODY } else { [NOVICES, OTHERS] };
    let groups = [
        ("novice", Skill::novice(), novices, relaxed),
        ("intermediate", Skill::intermediate(), others, normal),
        ("expert", Skill::expert(), others, braced),
    ];
    for (who, skill, seeds, band_mm) in groups {
        let attempts = attempts(bundle, &skill, seeds);
        let over_mm = skin_mm(bundle, &attempts);
        let is_inside = is_incised(bundle) || band_mm.contains(&over_mm.median);
        assert!(is_inside, "{id}, {who}: {over_mm} mm is outside {band_mm:?}");
        let furthest_mm = attempts.iter().map(|attempt| attempt.furthest_m * 1e3).fold(0.0, f64::max);
        assert!(furthest_mm < needle.length_mm, "{id}, {who}: {furthest_mm} mm with a needle of {}", needle.length_mm);
        let done = attempts.iter().filter(|attempt| attempt.confirmed_m.is_some()).count();
        assert_eq!(done, attempts.len(), "{id}, {who}: confirmed");
    }
}

#[test]
fn relaxed_normal_and_braced_hands_overshoot_as_published() {
    let exercises = exercises();
    thread::scope(|scope| {
        let checks: Vec<_> = exercises.iter().map(|bundle| scope.spawn(|| check(bundle))).collect();
        checks.into_iter().for_each(|check| check.join().expect("the bands hold"));
    });
}

/// Where the ligamentum flavum gives way, the 71 kg scene's epidural space begins.
const EPIDURAL_SPACE: usize = 5;
const DURA: usize = 6;

#[test]
fn a_loss_of_resistance_throws_nobody_farther_than_hands_go() {
    let bundle = exercise("lumbar-epidural/1-stop-in-the-epidural-space.toml");
    let lost_mm = |attempts: &[Performance]| {
        let over_m = attempts.iter().filter_map(|attempt| attempt.overshoot_m(EPIDURAL_SPACE, Contactor::Tip));
        Spread::of(over_m.map(|over_m| over_m * 1e3))
    };
    let novices = attempts(&bundle, &Skill::novice(), 100);
    let (novice, expert) = (lost_mm(&novices), lost_mm(&attempts(&bundle, &Skill::expert(), OTHERS)));
    assert!((4.0..=10.0).contains(&novice.median) && novice.high < 15.0, "novice {novice} mm");
    assert!((1.0..=4.0).contains(&expert.median), "expert {expert} mm");
    let through = novices.iter().filter(|attempt| attempt.overshoot_m(DURA, Contactor::Tip).is_some()).count();
    // The profile's epidural space is 8.6 mm deep, and its dura dents by 3.6 mm: less than published rates, 0.4 a person in six attempts.
    assert!(through < 40, "{through} of 100 novices puncture the dura");
    let furthest_m = novices.iter().map(|attempt| attempt.furthest_m).fold(0.0, f64::max);
    assert!(furthest_m < 0.09, "{furthest_m} m with a needle of 90 mm");
}

#[test]
fn novice_peak_exceeds_expert_peak_unless_thresholds_set_it() {
    let peak_n = |bundle: &ExerciseBundle, skill: &Skill, seeds| {
        Spread::of(attempts(bundle, skill, seeds).iter().map(|attempt| attempt.peak_n))
    };
    let ratio = |file: &str, seeds| {
        let bundle = exercise(file);
        let (novice, expert) = (peak_n(&bundle, &Skill::novice(), seeds), peak_n(&bundle, &Skill::expert(), OTHERS));
        (
            [novice.median, novice.high].map(|n| n / expert.median),
            format!("{file}: novice {novice} N, expert {expert} N"),
        )
    };
    // The median novice stops before the fascia, and pushes as hard as the expert (1.00); the tenth that overshoots most tents it (1.21).
    let ([_, fat], said) = ratio("lower-back-basics/2-stop-in-the-fat.toml", 60);
    assert!((1.1..=1.35).contains(&fat), "{said}");
    // The flavum of a body is the harder the faster it is dented.
    let ([flavum, _], said) = ratio("lumbar-epidural-on-a-body/1-midline.toml", OTHERS);
    assert!((1.0..=1.35).contains(&flavum), "{said}");
    // Behind the last boundary thresholds set the peak, whoever pushes, but for the drag of a quicker hand.
    let ([muscle, _], said) = ratio("lower-back-basics/3-reach-the-muscle.toml", OTHERS);
    assert!((0.98..1.1).contains(&muscle), "{said}");
}

#[test]
fn the_hub_stops_a_hand_that_nothing_else_stops() {
    let bundle = exercise("lower-back-basics/3-reach-the-muscle.toml");
    let specimen = Specimen::new(bundle.specimen_spec(&Patient::nominal(&bundle.scene))).expect("sound");
    for seed in 0..5 {
        let plan = Plan { reach_m: 0.018, target_x_m: 0.03, ..bundle.plan() };
        let performance = perform(specimen.law(), &mut Operator::skilled(&Skill::novice(), &plan, seed), 60.0);
        let short_m = plan.reach_m - performance.furthest_m;
        assert!((-1e-4..5e-4).contains(&short_m), "seed {seed}: {} m", performance.furthest_m);
        assert!(performance.confirmed_m.is_some(), "seed {seed}: it gives up, confirms and comes back");
    }
}

#[test]
fn a_seed_fixes_an_attempt_and_a_day_changes_it() {
    let bundle = exercise("lower-back-basics/2-stop-in-the-fat.toml");
    let specimen = Specimen::new(bundle.specimen_spec(&Patient::nominal(&bundle.scene))).expect("sound");
    let on = |occasion| perform(specimen.law(), &mut Operator::on(&Skill::expert(), &bundle.plan(), &occasion), 60.0);
    let first = Occasion { person: 3, day: 1, attempt: 0 };
    assert_eq!(on(first), on(first));
    for other in [Occasion { attempt: 1, ..first }, Occasion { day: 2, ..first }, Occasion { person: 4, ..first }] {
        assert_ne!(on(other), on(first), "{other:?}");
    }
}
