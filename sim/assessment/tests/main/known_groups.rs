//! Virtual novices and experts differ as published groups do: experts are faster, need fewer insertions and puncture the dura less often, and
//! the groups overlap.
//!
//! Fails when a time or a score separates the groups fully or not at all, or when the order of the groups is reversed.

use std::path::Path;
use std::thread;

use assessment::Tryout;
use assessment::statistics::{area_under_curve, hedges_g, mean, quantile};
use documents::{ExerciseBundle, Patient};
use law::operator::{Operator, Skill};
use recording::Recording;

/// Attempts of each group.
const SEEDS: u64 = 24;
/// Threads that share them.
const THREADS: u64 = 4;

struct Attempt {
    time_s: f64,
    insertions: f64,
    score: f64,
    punctures_dura: bool,
}

/// Number of insertions: passages of the tip from 1 mm above the skin to 2 mm below.
fn count_insertions(recording: &Recording) -> f64 {
    let (mut is_inside, mut count) = (false, 0_u32);
    for sample in &recording.samples {
        count += u32::from(!is_inside && sample.x_m > 0.002);
        is_inside = if is_inside { sample.x_m > -0.001 } else { sample.x_m > 0.002 };
    }
    f64::from(count)
}

fn attempt(bundle: &ExerciseBundle, skill: &Skill, seed: u64) -> Attempt {
    let tryout = Tryout::new(bundle, Patient::draw(&bundle.scene, seed)).expect("a shipped scene is sound");
    let recording = tryout.perform(&mut Operator::skilled(skill, &bundle.plan(), seed));
    let judged = tryout.judge(&recording).expect("scored");
    Attempt {
        time_s: judged.value("time_total_s").expect("measured"),
        insertions: count_insertions(&recording),
        score: judged.score,
        punctures_dura: judged.value("rupture_force_n.dura.tip").is_some_and(|force_n| force_n > 0.0),
    }
}

fn group(bundle: &ExerciseBundle, skill: &Skill) -> Vec<Attempt> {
    let part = |first: u64| (first..SEEDS).step_by(THREADS as usize).map(|seed| attempt(bundle, skill, seed)).collect();
    thread::scope(|scope| {
        let parts: Vec<_> = (0..THREADS).map(|first| scope.spawn(move || -> Vec<Attempt> { part(first) })).collect();
        parts.into_iter().flat_map(|part| part.join().expect("no attempt panics")).collect()
    })
}

fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5).expect("values")
}

#[test]
fn virtual_experts_are_faster_and_tap_less_but_groups_overlap() {
    let file = "../../curricula/lumbar-epidural-on-a-body/3-paramedian.toml";
    let bundle = ExerciseBundle::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).expect("shipped");
    let [novices, experts] = [Skill::novice(), Skill::expert()].map(|skill| group(&bundle, &skill));
    let of =
        |figure: fn(&Attempt) -> f64| [&novices, &experts].map(|group| group.iter().map(figure).collect::<Vec<f64>>());
    let [novice_s, expert_s] = of(|attempt| attempt.time_s);
    assert!(median(&expert_s) < median(&novice_s), "{expert_s:?} s against {novice_s:?} s");
    let effect = hedges_g(&novice_s, &expert_s).expect("two groups").value;
    assert!((0.5..2.0).contains(&effect), "effect size {effect} of the time");
    let [novice_tries, expert_tries] =
        of(|attempt| attempt.insertions).map(|tries| mean(&tries).expect("values").value);
    assert!(expert_tries < novice_tries - 0.2, "{expert_tries} against {novice_tries} insertions");
    let [novice_score, expert_score] = of(|attempt| attempt.score);
    let effect = hedges_g(&expert_score, &novice_score).expect("two groups").value;
    assert!((0.8..1.8).contains(&effect), "effect size {effect} of the score");
    let area = area_under_curve(&expert_score, &novice_score).expect("two groups").value;
    assert!(area > 0.7 && area < 0.95, "area under the curve {area} of the score");
    let [novice_taps, expert_taps] =
        [&novices, &experts].map(|group| group.iter().filter(|attempt| attempt.punctures_dura).count());
    assert!(expert_taps < novice_taps && novice_taps < SEEDS as usize / 4, "{expert_taps} against {novice_taps} taps");
}
