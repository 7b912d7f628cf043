//! Options of version 3 of the law in a scene: what they become for a needle, and what is refused.
//!
//! Would fail if an option were taken under a law that does not know it, or lost on its way to the law.

use documents::Patient;
use law::axial::{AxialSpec, Breakaway, ForceLaw, LayerOptions, MaxwellBranch, RuptureCriterion};
use law::fracture::SharpPunch;

use crate::support::{SCENE, folder, read_text, scene, write};

const FAT: &str = "tip_rupture_n = 0.5\nrim_rupture_n = 0.6\n";
const RELAXATION: &str =
    "[[layer.relaxation]]\nshare = 0.5\ntime_s = 2\n[[layer.relaxation]]\nshare = 0.25\ntime_s = 30\n";

/// The small scene under version 3, with keys in its fat and in its needle.
fn optioned(fat: &str, needle: &str) -> String {
    SCENE
        .replace("title = \"Small\"", "title = \"Small\"\nlaw = 3")
        .replace(FAT, &format!("{FAT}{fat}"))
        .replace("diameter_mm = 2.0", &format!("diameter_mm = 2.0\n{needle}"))
}

/// What the reader says to a scene that it must refuse.
fn refusal(text: &str) -> String {
    match read_text(&folder(), text) {
        Err(error) => error.to_string(),
        Ok(document) => panic!("accepted: {document:?}"),
    }
}

fn assert_says(text: &str, parts: &[&str]) {
    let said = refusal(text);
    for part in parts {
        assert!(said.contains(part), "{part:?} is not said by:\n{said}");
    }
}

#[test]
fn every_option_reaches_the_law_scaled_for_the_needle() {
    let fat = format!(
        "friction_n_per_m = 15\nstatic_friction_n_per_m = 25\nstiffening_n_per_m2 = 4000\ntoughness_factor = 2\n{RELAXATION}"
    );
    let text = optioned(&fat, "breakaway_mm = 0.6\nfriction_rest_s = 2\nlubrication = 0.5")
        .replace("diameter_mm = 2.0", "diameter_mm = 3.0");
    let scene = scene(&text);
    let spec = scene.axial_spec(&Patient::nominal(&scene));
    assert_eq!(spec.law, ForceLaw::Version3);
    assert_eq!(spec.breakaway, Some(Breakaway { slid_m: 0.6 / 1e3, rest_s: 2.0 }));
    assert_eq!(spec.layers[0].options, LayerOptions::default());
    let branch = |share, time_s| MaxwellBranch { share, time_s };
    let wanted = LayerOptions {
        // Stiffening goes with the diameter as the stiffness does; static friction as the kinetic one.
        stiffening_n_per_m2: 6000.0,
        branches: vec![branch(0.5, 2.0), branch(0.25, 30.0)],
        static_friction_n_per_m: Some(25.0 * 1.5 * 0.5 * 2.0),
        ..LayerOptions::default()
    };
    assert_eq!(spec.layers[1].options, wanted);
}

#[test]
fn an_option_under_an_earlier_law_is_refused_where_it_stands() {
    for key in [
        "stiffening_n_per_m2 = 0",
        "gives_way_at = \"force\"",
        "static_friction_n_per_m = 40",
        "[[layer.relaxation]]\nshare = 1\ntime_s = 1",
    ] {
        let name = key.trim_start_matches("[[layer.").split([' ', ']']).next().unwrap();
        let text = optioned(&format!("{key}\n"), "").replace("law = 3", "law = 2");
        let field = format!("layer[1].{name}: an option of version 3");
        assert_says(
            &text,
            &["document.toml:", &field, "allowed from law = 3; this scene has version 2 of the force law"],
        );
        assert_says(&text.replace("law = 2\n", ""), &["this scene has version 1 of the force law"]);
    }
    assert_says(
        &optioned("", "friction_rest_s = 2").replace("law = 3", "law = 2"),
        &["needle.friction_rest_s: an option"],
    );
}

#[test]
fn relaxation_and_rate_exclude_each_other() {
    let text = optioned(RELAXATION, "") + "[rate]\np_infinity_n = 0.2\nv0_mm_per_s = 5\n";
    assert_says(
        &text,
        &["rate: together with layer[1].relaxation", "allowed: only one of the two", "remove rate or every relaxation"],
    );
}

#[test]
fn a_dent_opens_what_relaxes_and_nothing_else() {
    let text = optioned(&format!("gives_way_at = \"dent\"\n{RELAXATION}"), "");
    assert_eq!(spec(&text).layers[1].options.gives_way_at, RuptureCriterion::Dent);
    assert_says(
        &optioned("gives_way_at = \"dent\"\n", ""),
        &["layer[1].gives_way_at: \"dent\"", "\"force\" without relaxation"],
    );
    assert_says(&text.replace("dent", "strain"), &["layer[1].gives_way_at", "force", "dent"]);
}

#[test]
fn no_more_than_three_branches_of_numbers_that_make_sense() {
    let branches = |share: &str| format!("[[layer.relaxation]]\nshare = {share}\ntime_s = 2\n").repeat(4);
    assert_says(&optioned(&branches("1"), ""), &["layer[1].relaxation: 4 tables", "0 to 3 tables"]);
    assert_says(&optioned(&branches("0"), ""), &["layer[1].relaxation"]);
    let still = RELAXATION.replace("time_s = 30", "time_s = 0");
    assert_says(&optioned(&still, ""), &["layer[1].relaxation[1].time_s: 0 s", "from 0.001 to 10000 s"]);
}

#[test]
fn static_friction_is_at_least_kinetic_and_needs_a_breakaway() {
    let friction = "friction_n_per_m = 15\nstatic_friction_n_per_m = 10\n";
    assert_says(
        &optioned(friction, "breakaway_mm = 1"),
        &["layer[1].static_friction_n_per_m: 10 N/m", "allowed: at least 15 N/m"],
    );
    assert_says(
        &optioned(&friction.replace("= 10", "= 30"), ""),
        &["needle.breakaway_mm: missing", "needed with layer[1].static_friction_n_per_m"],
    );
    assert_says(
        &optioned("", "breakaway_mm = 1"),
        &["needle.breakaway_mm: 1 mm", "only if a layer has static_friction_n_per_m"],
    );
}

#[test]
fn a_scene_that_is_unsound_only_when_it_is_hurried_is_refused() {
    // A fast needle opens the skin at half the dent: then the fat holds on under it, which a slow one would have torn in the same breath.
    let text = |skin: &str| {
        optioned("", "")
            .replace("rim_rupture_n = 1.3", &format!("rim_rupture_n = 1.3\n{skin}"))
            .replace("stiffness_n_per_m = 83", "stiffness_n_per_m = 900")
            .replace("tip_rupture_n = 0.5", "tip_rupture_n = 1.9")
            .replace("rim_rupture_n = 0.6", "rim_rupture_n = 2.1")
    };
    let folder = folder();
    let check = |text: &str| documents::check_documents(&write(&folder, "scene.toml", text)).map(|_| ());
    assert!(check(&text("")).is_ok(), "slowly the fat gives way in the cascade of the skin: {:?}", check(&text("")));
    let hurried =
        check(&text("[[layer.relaxation]]\nshare = 0.2\ntime_s = 1\n")).expect_err("unsound when hurried").to_string();
    assert!(hurried.contains("layer[0].tip_rupture_n: 1 N is unsound"), "{hurried}");
}

/// Fibres along the patient's y, in a sheet under 20 N/m held 20 mm away.
const FIBRES: &str =
    "[layer.fibres]\nangle_deg = 90\nalong_stiffness = 0.8\nalong_threshold = 0.3\npretension_n_per_m = 20\n";

/// What a scene becomes for its nominal patient.
fn spec(text: &str) -> AxialSpec {
    let scene = scene(text);
    scene.axial_spec(&Patient::nominal(&scene))
}

#[test]
fn fibres_follow_the_edge_and_tension_stiffens_all_directions() {
    let tense_n_per_m = core::f64::consts::TAU * 20.0 / libm::log(20.0);
    let sheet = spec(&optioned(FIBRES, "tip = \"bevel\""));
    let [across, along] = [[1.0, 0.0], [0.0, 1.0]].map(|edge| sheet.under_edge(edge).layers[1].clone());
    let near = |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1e-12, "{found} is not {wanted}");
    near(across.stiffness_n_per_m, 83.0 + tense_n_per_m);
    near(along.stiffness_n_per_m, 0.8 * 83.0 + tense_n_per_m);
    near(across.tip_rupture_n, 0.85 * 0.5);
    near(along.tip_rupture_n, 0.3 * across.tip_rupture_n);
    near(along.rim_rupture_n, 0.3 * across.rim_rupture_n);
    // A thicker needle dents a wider part of the sheet.
    let thick = spec(&optioned(FIBRES, "tip = \"bevel\"").replace("diameter_mm = 2.0", "diameter_mm = 4.0"));
    near(thick.layers[1].stiffness_n_per_m, 2.0 * 83.0 + core::f64::consts::TAU * 20.0 / libm::log(10.0));
}

#[test]
fn fibres_require_a_bevel_and_pretension_excludes_coupling() {
    assert_says(&optioned(FIBRES, ""), &["layer[1].fibres: tip = \"diamond\"", "only with tip = \"bevel\""]);
    let coupled = optioned(FIBRES, "tip = \"bevel\"") + "[tissue]\ncoupling = \"field\"\n";
    assert_says(&coupled, &["layer[1].fibres.pretension_n_per_m: 20 N/m", "the field does not model tension"]);
}

#[test]
fn toughness_sets_the_threshold_instead_of_a_diameter_power() {
    let tough = |diameter_mm: f64, tip: &str| {
        let keys = "fracture_energy_j_per_m2 = 400\nyoungs_modulus_pa = 30000\n";
        let text = optioned(keys, &format!("tip = \"{tip}\"\ndiameter_exponent = 2"));
        let text = text.replace("tip_rupture_n = 0.5\n", "").replace("= 2.0\n", &format!("= {diameter_mm}\n"));
        spec(&text).layers[1].tip_rupture_n
    };
    for diameter_mm in [0.7, 2.0, 4.0] {
        let shear_modulus_pa = 30_000.0 / (2.0 * 1.45);
        let punch = SharpPunch { radius_m: diameter_mm * 0.5e-3, shear_modulus_pa, fracture_energy_j_per_m2: 400.0 };
        for tip in ["diamond", "bevel", "conical"] {
            assert_eq!(tough(diameter_mm, tip), punch.threshold_n(), "{tip} of {diameter_mm} mm");
        }
    }
    // Tough against its radius: between a line and a square.
    let power = libm::log(tough(4.0, "bevel") / tough(0.7, "bevel")) / libm::log(4.0 / 0.7);
    assert!((1.0..2.0).contains(&power), "{power}");
}

#[test]
fn toughness_is_one_of_both_and_needs_a_modulus_and_a_sharp_tip() {
    let energy = "fracture_energy_j_per_m2 = 400\n";
    let modulus = "youngs_modulus_pa = 30000\n";
    let tough = |keys: &str, needle: &str| optioned(keys, needle).replace("tip_rupture_n = 0.5\n", "");
    assert_says(
        &optioned(&format!("{energy}{modulus}"), ""),
        &["layer[1].fracture_energy_j_per_m2: together with layer[1].tip_rupture_n", "allowed: only one of the two"],
    );
    assert_says(&tough(energy, ""), &["layer[1].youngs_modulus_pa: missing", "needed with layer[1].fracture_energy"]);
    assert_says(&tough("", ""), &["layer[1].tip_rupture_n: missing", "or fracture_energy_j_per_m2"]);
    let blunt = tough(&format!("{energy}{modulus}"), "tip = \"blunt\"");
    assert_says(&blunt, &["layer[1].fracture_energy_j_per_m2: 400 J/m²", "a blunt one tears"]);
}
