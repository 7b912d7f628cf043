//! The shipped scenes against the bounds of `tests/data/tissue/*.toml`: what is published of each procedure, what follows from it by
//! the needle, and what is our choice.
//!
//! Fails when an edit of a scene, of a needle's scaling or of the tissues of a body moves a force, a dent or a depth out of its bounds.
#![expect(clippy::expect_used, clippy::panic, reason = "a test says what it expects by failing")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use documents::Scene;
use dossier::{MeasuredQuantity, measure_scene};
use serde::Deserialize;

#[derive(Deserialize)]
struct Bounds {
    bound: Vec<Bound>,
}

#[derive(Deserialize)]
struct Bound {
    scene: String,
    quantity: String,
    #[serde(default)]
    layer: String,
    low: f64,
    high: f64,
    class: String,
    source: String,
    #[serde(default)]
    slow_mm_per_s: f64,
    #[serde(default)]
    fast_mm_per_s: f64,
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

fn read_scene(name: &str) -> Scene {
    let path = repository("curricula/scenes").join(name).with_extension("toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    documents::load::read_scene_text(&path, &text).expect("it is sound")
}

impl Bound {
    fn quantity(&self) -> MeasuredQuantity {
        let layer: &'static str = Box::leak(self.layer.clone().into_boxed_str());
        let [slow_m_per_s, fast_m_per_s] = [self.slow_mm_per_s * 1e-3, self.fast_mm_per_s * 1e-3];
        match self.quantity.as_str() {
            "peak_until_through" => MeasuredQuantity::PeakUntilThrough { layer },
            "opening_force" => MeasuredQuantity::OpeningForce { layer },
            "peak_around" => MeasuredQuantity::PeakAround { layer },
            "held_force" => MeasuredQuantity::HeldForce { layer },
            "opening_depth_mm" => MeasuredQuantity::OpeningDepth { layer },
            "dent_mm" => MeasuredQuantity::Dent { layer },
            "force_at_opening" => MeasuredQuantity::ForceAtOpening { layer },
            "loss_behind" => MeasuredQuantity::LossBehind { layer },
            "relative_loss_behind" => MeasuredQuantity::RelativeLossBehind { layer },
            "way_slope" => MeasuredQuantity::WaySlope,
            "layer_depth_mm" => MeasuredQuantity::LayerDepth { layer },
            "thickness_mm" => MeasuredQuantity::Thickness { layer },
            "speed_ratio" => MeasuredQuantity::SpeedRatio { layer, slow_m_per_s, fast_m_per_s },
            "dry_ratio" => MeasuredQuantity::DryRatio,
            other => panic!("no quantity is called {other}"),
        }
    }
}

fn read_bounds() -> Vec<Bound> {
    let files = fs::read_dir(repository("tests/data/tissue")).expect("the bounds");
    let texts = files.map(|file| fs::read_to_string(file.expect("a file").path()).expect("a text"));
    texts.flat_map(|text| toml::from_str::<Bounds>(&text).expect("bounds").bound).collect()
}

#[test]
fn scenes_stay_within_their_bounds() {
    let mut bounds: BTreeMap<String, Vec<Bound>> = BTreeMap::new();
    for bound in read_bounds() {
        assert!(["measured", "derived", "choice"].contains(&bound.class.as_str()), "{}", bound.class);
        assert!(!bound.source.is_empty() && bound.low <= bound.high, "{} {}", bound.scene, bound.quantity);
        bounds.entry(bound.scene.clone()).or_default().push(bound);
    }
    let mut missed = Vec::new();
    for (scene, bounds) in &bounds {
        let quantities: Vec<MeasuredQuantity> = bounds.iter().map(Bound::quantity).collect();
        let values = measure_scene(&read_scene(scene), &quantities);
        for ((bound, quantity), value) in bounds.iter().zip(&quantities).zip(values) {
            let scale = if quantity.unit() == "m" { 1e3 } else { 1.0 };
            let value = value.map(|value| value * scale);
            if !value.is_ok_and(|value| (bound.low..=bound.high).contains(&value)) {
                let Bound { quantity, layer, low, high, .. } = bound;
                missed.push(format!("{scene}: {quantity} of {layer} is {value:?}; allowed: {low} to {high}"));
            }
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
    let judged: Vec<&str> = bounds.keys().map(String::as_str).collect();
    // The rest reproduce a table or a record, and say so.
    let exempt = ["lower-back-paper", "liver-18g", "heart-18g"];
    for scene in dossier::read_shipped_scenes().expect("the shipped scenes are sound") {
        assert!(judged.contains(&scene.id.as_str()) != exempt.contains(&scene.id.as_str()), "{} has bounds", scene.id);
    }
}
