//! `check`: a threshold too high for its stiffness is refused where it is written, with the largest sound one.
//!
//! Would fail if an unsound scene passed, if only the nominal patient were looked at, or if the limit that the message
//! gives were not itself sound.

use documents::{DocumentError, check_documents};
use law::axial::Contactor;

use crate::support::{SCENE, folder, scene, write};

/// Skin that gives at 1 N, 3 mm deep, onto tough fat that is stiffer than it is.
fn unsound() -> String {
    tough(SCENE)
}

fn tough(scene: &str) -> String {
    scene.replace("= 83", "= 500").replace("tip_rupture_n = 0.5", "tip_rupture_n = 5").replace("= 0.6", "= 6")
}

fn refusal(text: &str) -> DocumentError {
    check_documents(&write(&folder(), "scene.toml", text)).unwrap_err()
}

#[test]
fn an_unsound_threshold_is_refused_where_it_is_written() {
    let error = refusal(&unsound()).to_string();
    for part in [
        "scene.toml:8:17: layer[0].tip_rupture_n: 1 N is unsound",
        "boundary 0 (skin) of the nominal patient at 0°",
        " N and the elastic energy by ",
        " mJ; the largest sound threshold is ",
    ] {
        assert!(error.contains(part), "{part:?} is not said by:\n{error}");
    }
}

#[test]
fn the_limit_that_is_named_is_sound_and_more_is_not() {
    let finding = scene(&unsound()).soundness(0.0).unwrap().remove(0);
    assert_eq!(finding.unsound.contactor, Contactor::Tip);
    let with = |tip_n: f64| {
        let text = unsound().replace("tip_rupture_n = 1.0", &format!("tip_rupture_n = {tip_n}"));
        scene(&text)
            .soundness(0.0)
            .unwrap()
            .iter()
            .any(|f| (f.unsound.boundary, f.unsound.contactor) == (0, Contactor::Tip))
    };
    assert!(!with(finding.unsound.largest_sound_n * (1.0 - 1e-6)));
    assert!(with(finding.unsound.largest_sound_n * (1.0 + 1e-3)));
}

#[test]
fn the_limit_is_in_the_documents_terms_whatever_the_needle() {
    let limit = |needle: &str| {
        let error = refusal(&unsound().replace("diameter_mm = 2.0", needle)).to_string();
        let rest = error.lines().next().unwrap().split("the largest sound threshold is ").nth(1).unwrap().to_owned();
        rest.split(' ').next().unwrap().parse::<f64>().unwrap()
    };
    // A thicker needle scales stiffness and thresholds alike, so the limit as written stays.
    assert!((limit("diameter_mm = 2.0") - limit("diameter_mm = 3.0")).abs() < 2e-4);
    // A blunt tip scales the thresholds alone, so only a third may be written.
    assert!((limit("tip = \"blunt\"") * 3.0 - limit("tip = \"diamond\"")).abs() < 6e-4);
}

#[test]
fn the_thinnest_patient_must_be_sound_too() {
    let sound = tough(&SCENE.replace("thickness_mm = 0.8", "thickness_mm = 4"));
    assert!(scene(&sound).soundness(0.0).unwrap().is_empty());
    let spread = sound.replace("thickness_mm = 4", "thickness_mm = 4\nthickness_spread_mm = 3.5");
    let error = refusal(&spread).to_string();
    assert!(error.contains("of the thinnest patient"), "{error}");
}

#[test]
fn reading_alone_does_not_refuse_an_unsound_scene() {
    assert!(!scene(&unsound()).soundness(0.0).unwrap().is_empty());
}
