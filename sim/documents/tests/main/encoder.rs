//! What a real encoder makes of every shipped scene: positions in steps of 10 to 55 µm, readings that come twice, both.
//!
//! It would fail on a law that asks whether a tick moved (cutting then was on in 7 % of the ticks of a Phantom Omni, and jumped 400
//! times a second), and on a speed taken between two samples.

use documents::load::read_document;
use documents::{Document, Patient};
use law::axial::AxialSpec;
use trials::scenes::AxialRun;

use crate::support::curricula;

const TICK_S: f64 = 1e-3;
const START_M: f64 = -0.002;
/// A jump of the force, in N, that a hand would notice.
const JUMP_N: f64 = 0.05;
/// The same where readings come three times: at 30 mm/s each is a step of 90 µm, whatever the encoder.
const REPEATED_JUMP_N: f64 = 0.1;

/// Every shipped scene as the law sees it, with its name.
fn scenes() -> Vec<(String, AxialSpec)> {
    let folder = std::fs::read_dir(curricula().join("scenes")).unwrap();
    let scene = |path: std::path::PathBuf| match read_document(&path).unwrap() {
        Document::Scene(scene) => (scene.id.clone(), scene.axial_spec(&Patient::nominal(&scene))),
        other => panic!("not a scene: {other:?}"),
    };
    folder
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(scene)
        .collect()
}

/// How a device reports a motion.
#[derive(Clone, Copy, Debug)]
struct Encoder {
    step_m: f64,
    /// A new reading every so many ticks.
    repeats: u32,
}

impl Encoder {
    fn read(self, x_m: f64) -> f64 {
        if self.step_m > 0.0 { (x_m / self.step_m).floor() * self.step_m } else { x_m }
    }

    /// How many ticks lie between two positions that it may tell apart, at a speed in m/s: two steps, and a reading as old as can be.
    fn reach_ticks(self, speed_m_per_s: f64) -> usize {
        (2.0 * self.step_m / (speed_m_per_s * TICK_S)) as usize + 3 * self.repeats as usize
    }
}

/// Total force and cutting force at each tick.
struct Felt {
    x_m: Vec<f64>,
    total_n: Vec<f64>,
    cutting_n: Vec<f64>,
    /// A boundary gave way.
    ruptured: Vec<bool>,
}

/// An insertion at a constant speed, in m/s, to a depth in m.
fn insert(spec: &AxialSpec, speed_m_per_s: f64, to_m: f64, encoder: Encoder) -> Felt {
    let mut run = AxialRun::new(spec.clone()).unwrap();
    let ticks = ((to_m - START_M) / (speed_m_per_s * TICK_S)) as u32;
    let mut felt = Felt { x_m: Vec::new(), total_n: Vec::new(), cutting_n: Vec::new(), ruptured: Vec::new() };
    for tick in 0..ticks {
        let seen = f64::from(tick - tick % encoder.repeats);
        let x_m = encoder.read(START_M + speed_m_per_s * TICK_S * seen);
        let output = run.step(f64::from(tick) * TICK_S, x_m);
        felt.x_m.push(x_m);
        felt.total_n.push(output.total_n());
        felt.cutting_n.push(output.cutting_n);
        felt.ruptured.push(!run.ruptures().is_empty());
    }
    felt
}

/// Least and most ideal force within a stretch of ticks.
fn range(ideal: &Felt, from: usize, to: usize) -> (f64, f64) {
    let stretch = &ideal.total_n[from..to.min(ideal.total_n.len())];
    stretch.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &n| (low.min(n), high.max(n)))
}

/// Jumps of the force that no rupture explains, and that the ideal force does not make within an encoder's step of there.
fn unexplained_jumps(felt: &Felt, ideal: &Felt, reach_ticks: usize, jump_n: f64) -> usize {
    let jump = |&at: &usize| {
        let (low, high) = range(ideal, at.saturating_sub(reach_ticks), at + 2);
        !felt.ruptured[at]
            && !felt.ruptured[at - 1]
            && (felt.total_n[at] - felt.total_n[at - 1]).abs() > jump_n + (high - low)
    };
    (1..felt.total_n.len()).filter(jump).count()
}

#[test]
fn cutting_is_as_steady_through_an_encoder_as_without_one() {
    for (name, spec) in scenes() {
        // As deep as an exercise on it goes, and a little more.
        let to_m = match name.as_str() {
            "epidural-71kg" | "epidural-midline" | "epidural-off-bone" | "epidural-paramedian" => 0.053,
            "lumbar-puncture" => 0.058,
            "kidney-lower-pole" => 0.082,
            "abdomen-trocar-12mm" => 0.052,
            "lower-back-obese" => 0.05,
            "lower-back-thick-needle" => 0.027,
            _ => 0.035,
        };
        for speed_mm_per_s in [0.5, 2.0, 7.0, 30.0] {
            let speed_m_per_s = speed_mm_per_s * 1e-3;
            let ideal = insert(&spec, speed_m_per_s, to_m, Encoder { step_m: 0.0, repeats: 1 });
            for step_um in [0.0, 10.0, 30.0, 55.0] {
                for repeats in [1, 3] {
                    let encoder = Encoder { step_m: step_um * 1e-6, repeats };
                    let felt = insert(&spec, speed_m_per_s, to_m, encoder);
                    let case = format!("{name}, {speed_mm_per_s} mm/s, {encoder:?}");
                    judge(&felt, &ideal, &Case { name: case, encoder, speed_m_per_s });
                }
            }
        }
    }
}

/// What is tried.
struct Case {
    name: String,
    encoder: Encoder,
    speed_m_per_s: f64,
}

fn judge(felt: &Felt, ideal: &Felt, Case { name: case, encoder, speed_m_per_s }: &Case) {
    let cuts: Vec<usize> = (0..ideal.cutting_n.len()).filter(|&at| ideal.cutting_n[at] > 0.0).collect();
    if !cuts.is_empty() {
        let on = cuts.iter().filter(|&&at| felt.cutting_n[at] > 0.0).count();
        assert!(on as f64 >= 0.95 * cuts.len() as f64, "{case}: cutting in {on} of {} ticks", cuts.len());
        let sum = |forces: &[f64]| cuts.iter().map(|&at| forces[at]).sum::<f64>();
        let ratio = sum(&felt.cutting_n) / sum(&ideal.cutting_n);
        assert!((ratio - 1.0).abs() <= 0.02, "{case}: mean cutting is {ratio} of the ideal");
    }
    let jump_n = if encoder.repeats > 1 { REPEATED_JUMP_N } else { JUMP_N };
    let jumps = unexplained_jumps(felt, ideal, encoder.reach_ticks(*speed_m_per_s), jump_n);
    assert_eq!(jumps, 0, "{case}: jumps over {jump_n} N that nothing explains, up to x = {:?}", felt.x_m.last());
}
