//! How a scene's numbers follow the needle and the tissue (physics.md, section 2), each law on its own.
//!
//! Would fail if a factor reached a quantity it must not, or had the wrong exponent.

use documents::{Patient, Scene};
use law::axial::Layer;

use crate::support::{SCENE, folder, read_text, scene};

const LAYER: &str = "stiffness_n_per_m = 83\ndamping_n_s_per_m2 = 1\ntip_rupture_n = 0.5\nrim_rupture_n = 0.6\n";

/// The fat of a scene with friction and cutting, another needle and other keys in the layer.
fn fat(needle: &str, layer: &str) -> Layer {
    let text = SCENE
        .replace(LAYER, &format!("{LAYER}friction_n_per_m = 15\ncutting_n = 0.1\n{layer}\n"))
        .replace("diameter_mm = 2.0", needle);
    layer_of(&scene(&text))
}

fn layer_of(scene: &Scene) -> Layer {
    scene.axial_spec(&Patient::nominal(scene)).layers[1].clone()
}

/// Ratios to the reference of stiffness, damping, tip, rim, friction and cutting.
fn ratios(changed: &Layer) -> [f64; 6] {
    let r = fat("diameter_mm = 2.0", "");
    [
        changed.stiffness_n_per_m / r.stiffness_n_per_m,
        changed.damping_n_s_per_m2 / r.damping_n_s_per_m2,
        changed.tip_rupture_n / r.tip_rupture_n,
        changed.rim_rupture_n / r.rim_rupture_n,
        changed.friction_n_per_m / r.friction_n_per_m,
        changed.cutting_n / r.cutting_n,
    ]
}

fn assert_ratios(changed: &Layer, expected: [f64; 6]) {
    for (found, expected) in ratios(changed).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12 * expected, "{found} is not {expected}");
    }
}

#[test]
fn the_reference_needle_leaves_every_number_as_written() {
    let layer = fat("diameter_mm = 2.0", "");
    assert!((layer.thickness_m - 0.0084).abs() < 1e-17);
    assert_eq!((layer.stiffness_n_per_m, layer.damping_n_s_per_m2), (83.0, 1.0));
    assert_eq!((layer.tip_rupture_n, layer.rim_rupture_n), (0.5, 0.6));
    assert_eq!((layer.friction_n_per_m, layer.cutting_n), (15.0, 0.1));
}

#[test]
fn everything_goes_with_the_diameter() {
    assert_ratios(&fat("diameter_mm = 3", ""), [1.5; 6]);
    assert_ratios(&fat("diameter_mm = 1", ""), [0.5; 6]);
}

#[test]
fn thresholds_and_cutting_go_with_its_power() {
    let power = 3.0_f64.powi(2);
    assert_ratios(&fat("diameter_mm = 6\ndiameter_exponent = 2", ""), [3.0, 3.0, power, power, 3.0, power]);
    assert_ratios(&fat("diameter_mm = 2\ndiameter_exponent = 2", ""), [1.0; 6]);
}

#[test]
fn the_tip_is_a_factor_on_the_thresholds_alone() {
    for (tip, factor) in [("diamond", 1.0), ("bevel", 0.85), ("conical", 1.4), ("blunt", 3.0)] {
        assert_ratios(&fat(&format!("tip = \"{tip}\""), ""), [1.0, 1.0, factor, factor, 1.0, 1.0]);
    }
}

#[test]
fn second_scaling_takes_the_tip_into_cutting() {
    let layer = |needle: &str| {
        let text = SCENE
            .replace(LAYER, &format!("{LAYER}friction_n_per_m = 15\ncutting_n = 0.1\n"))
            .replace("diameter_mm = 2.0", needle)
            .replacen("id =", "scaling = 2\nid =", 1);
        layer_of(&scene(&text))
    };
    let tips = [
        ("diamond", 1.0),
        ("bevel", 0.85),
        ("conical", 2.2),
        ("pencil-point", 2.2),
        ("tuohy", 2.2),
        ("cutting-dilating", 1.2),
        ("blunt", 3.0),
    ];
    for (tip, factor) in tips {
        assert_ratios(&layer(&format!("tip = \"{tip}\"")), [1.0, 1.0, factor, factor, 1.0, factor]);
    }
}

#[test]
fn first_scaling_refuses_a_tip_of_the_second() {
    let text = SCENE.replace("diameter_mm = 2.0", "tip = \"tuohy\"");
    let refused = read_text(&folder(), &text).expect_err("refused").to_string();
    assert!(refused.contains("needle.tip: \"tuohy\"") && refused.contains("scaling = 2 has this tip"), "{refused}");
}

#[test]
fn second_scaling_cuts_with_the_force_of_the_fracture_energy() {
    let layer = |scaling: u32, cutting: &str| {
        let tough = "fracture_energy_j_per_m2 = 400\nyoungs_modulus_pa = 30000\n";
        let text = SCENE.replace(LAYER, &format!("{}{tough}{cutting}", LAYER.replace("tip_rupture_n = 0.5\n", "")));
        layer_of(&scene(&text.replacen("id =", &format!("law = 3\nscaling = {scaling}\nid ="), 1)))
    };
    let (earlier, derived, stated) = (layer(1, ""), layer(2, ""), layer(2, "cutting_n = 0.1"));
    assert_eq!((earlier.cutting_n, stated.cutting_n), (0.0, 0.1));
    assert!(derived.cutting_n > 0.0);
    assert_eq!(derived.cutting_n, derived.tip_rupture_n, "one balance gives the threshold and the steady force");
}

#[test]
fn lubrication_is_a_factor_on_friction_alone() {
    assert_ratios(&fat("lubrication = 0.5", ""), [1.0, 1.0, 1.0, 1.0, 0.5, 1.0]);
    assert_ratios(&fat("lubrication = 1.5", ""), [1.0, 1.0, 1.0, 1.0, 1.5, 1.0]);
}

#[test]
fn toughness_is_a_factor_on_thresholds_friction_and_cutting() {
    assert_ratios(&fat("diameter_mm = 2", "toughness_factor = 1.7"), [1.0, 1.0, 1.7, 1.7, 1.7, 1.7]);
}

#[test]
fn needle_has_one_contactor_and_a_trocars_rim_lies_2_mm_behind() {
    let tip_to_rim = |needle: &str| {
        let scene = scene(&SCENE.replace("diameter_mm = 2.0", needle));
        scene.axial_spec(&Patient::nominal(&scene)).tip_to_rim_m
    };
    assert_eq!(tip_to_rim("kind = \"needle\""), 0.0);
    assert_eq!(tip_to_rim("kind = \"trocar\""), 0.002);
    assert_eq!(tip_to_rim("tip_to_rim_mm = 3.5"), 0.0035);
}

#[test]
fn the_needle_and_rate_reach_the_law_in_si() {
    let text = SCENE.replace("[needle]", "[rate]\np_infinity_n = 2\nv0_mm_per_s = 50\n\n[needle]\nlength_mm = 120");
    let scene = scene(&text);
    let spec = scene.puncture_spec(&Patient::nominal(&scene));
    let rate = spec.axial.rate.unwrap();
    assert_eq!((rate.p_infinity_n, rate.v0_m_per_s), (2.0, 0.05));
    assert_eq!((spec.needle_length_m, spec.lateral_stiffness_n_per_m2), (0.12, 10_000.0));
    assert_eq!(spec.axial.presliding_stiffness_n_per_m, 2000.0);
}

#[test]
fn needle_bends_only_if_stated_and_by_default_as_a_steel_tube() {
    let bending = |needle: &str| {
        let scene = scene(&SCENE.replace("diameter_mm = 2.0", needle));
        scene.puncture_spec(&Patient::nominal(&scene)).needle_bending_n_m2
    };
    // π/64 · 193e9 Pa · (2 mm)⁴, worked out by hand: 0.151 582 N·m².
    let solid = bending("kind = \"needle\"\nflexible = true\ninner_diameter_mm = 0").unwrap();
    assert!((solid / 0.151_582 - 1.0).abs() < 1e-5, "{solid} N·m²");
    let steel = bending("kind = \"needle\"\nflexible = true").unwrap();
    assert!((steel / (solid * (1.0 - 0.66_f64.powi(4))) - 1.0).abs() < 1e-12);
    let half = bending("kind = \"needle\"\nflexible = true\nyoungs_modulus_pa = 96.5e9").unwrap();
    assert!((half / steel - 0.5).abs() < 1e-12);
    assert_eq!((bending("kind = \"needle\""), bending("diameter_mm = 2.0")), (None, None));
}

#[test]
fn friction_and_cutting_are_0_unless_the_scene_states_them() {
    let layer = layer_of(&scene(SCENE));
    assert_eq!((layer.friction_n_per_m, layer.cutting_n), (0.0, 0.0));
}

#[test]
fn a_fascia_may_have_no_thickness() {
    let fascia = scene(&SCENE.replace("thickness_mm = 8.4", "thickness_mm = 0"));
    assert_eq!(layer_of(&fascia).thickness_m, 0.0);
}
