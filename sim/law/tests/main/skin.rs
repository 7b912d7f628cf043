//! A skin that bends: where it is met, how layers lie along a straight needle below it, and that nothing else changes.
//!
//! Would fail if the needle met the plane z = 0 instead of the skin, if layers were taken for flat ones, if a path had another length than the
//! geometry says, or if a needle beside or along the skin gave a force that is no number.

use law::axial::Contactor;
use law::puncture::{PunctureEvent, PunctureSpec};
use law::{Incidence, Skin};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use trials::needle::DrivenNeedle;
use trials::scenes::training_axial_spec;

fn over(skin: Skin) -> DrivenNeedle {
    let spec = PunctureSpec {
        axial: training_axial_spec(),
        lateral_stiffness_n_per_m2: 10_000.0,
        needle_length_m: 0.15,
        hub_stiffness_n_per_m: None,
        needle_bending_n_m2: None,
        skin,
        structures: Vec::new(),
    };
    DrivenNeedle::held_over(spec).expect("a valid scene")
}

fn any_skin() -> impl Strategy<Value = Skin> {
    let radius_m = 0.03..2.0_f64;
    prop_oneof![
        Just(Skin::Flat),
        radius_m.clone().prop_map(|radius_m| Skin::Sphere { radius_m }),
        (radius_m, 0.0..7.0_f64).prop_map(|(radius_m, along_rad)| Skin::Cylinder { radius_m, along_rad }),
    ]
}

fn leaning(angle_rad: f64, azimuth_rad: f64) -> Vector3<f64> {
    let sideways = libm::sin(angle_rad);
    Vector3::new(sideways * libm::cos(azimuth_rad), sideways * libm::sin(azimuth_rad), -libm::cos(angle_rad))
}

/// Where a needle meets a depth, found by halving a way.
fn halved_way_m(skin: &Skin, entry_m: &Point3<f64>, axis: &Vector3<f64>, depth_m: f64) -> f64 {
    let (mut low_m, mut high_m) = (0.0, 3.0 * depth_m);
    for _ in 0..80 {
        let middle_m = 0.5 * (low_m + high_m);
        if -skin.height_m(&(entry_m + axis * middle_m)) < depth_m {
            low_m = middle_m;
        } else {
            high_m = middle_m;
        }
    }
    low_m
}

proptest! {
    // Nowhere farther aside than the smallest radius: the skin does not reach beyond it.
    #[test]
    fn laying_flat_undoes_bending(skin in any_skin(), x in -0.021..0.021_f64, y in -0.021..0.021_f64, z in -0.025..0.02_f64) {
        let flat = Point3::new(x, y, z);
        let back = skin.flatten(&skin.bend(&flat));
        prop_assert!((back - flat).norm() < 1e-12, "{flat} became {back}");
        let above = skin.above(x, y);
        prop_assert!(skin.height_m(&above).abs() < 1e-12 && (above.x - x).abs() < 1e-12, "{above} is not on the skin");
        let nearest = skin.nearest(&skin.bend(&flat));
        prop_assert!((nearest - skin.bend(&Point3::new(x, y, 0.0))).norm() < 1e-12, "{nearest}");
    }

    #[test]
    fn a_path_is_as_long_as_the_geometry_says(
        skin in any_skin(),
        place in (-0.01..0.01_f64, -0.01..0.01_f64),
        angle_rad in 0.0..0.6_f64,
        azimuth_rad in 0.0..7.0_f64,
        depth_m in 1e-4..0.02_f64,
    ) {
        let (entry_m, axis) = (skin.above(place.0, place.1), leaning(angle_rad, azimuth_rad));
        let incidence = skin.incidence(&entry_m, &axis);
        let way_m = incidence.way_m(depth_m);
        let found_m = halved_way_m(&skin, &entry_m, &axis, depth_m);
        // Deeper than a line ever comes there is no such way, and where it lies flatter than at 80° it is taken for one at 80°.
        let there_m = entry_m + axis * found_m;
        let cosine = -axis.dot(&skin.outward(&there_m));
        prop_assume!((skin.height_m(&there_m) + depth_m).abs() < 1e-9 && cosine > libm::cos(80_f64.to_radians()));
        prop_assert!((way_m - found_m).abs() < 1e-9, "{way_m} m, by halving {found_m} m");
        prop_assert!((incidence.depth_m(way_m) - depth_m).abs() < 1e-12);
        let back_m = skin.displacement_m(&(entry_m + axis * way_m), &axis);
        prop_assert!((back_m - way_m).abs() < 1e-9, "the line meets the skin {back_m} m back");
    }

    #[test]
    fn the_flatter_a_skin_the_less_it_matters(angle_rad in 0.0..1.0_f64, depth_m in 0.0..0.04_f64) {
        let axis = leaning(angle_rad, 0.3);
        let flat = Skin::Flat.incidence(&Point3::origin(), &axis).way_m(depth_m);
        for skin in [Skin::Sphere { radius_m: 1e4 }, Skin::cylinder_along_y(1e4)] {
            let way_m = skin.incidence(&Point3::origin(), &axis).way_m(depth_m);
            prop_assert!((way_m - flat).abs() < 1e-5 * depth_m + 1e-12, "{way_m} m, flat {flat} m");
        }
    }

    #[test]
    fn every_way_is_a_number_that_rises_with_the_depth(
        skin in any_skin(),
        place in (-0.5..0.5_f64, -0.5..0.5_f64, -0.5..0.5_f64),
        angle_rad in 0.0..3.2_f64,
        azimuth_rad in 0.0..7.0_f64,
    ) {
        let (at, axis) = (Point3::new(place.0, place.1, place.2), leaning(angle_rad, azimuth_rad));
        let incidence = skin.incidence(&at, &axis);
        let mut boundaries_m = Vec::new();
        incidence.lay_layers([1e-3, 0.0, 8e-3, 40e-3], &mut boundaries_m);
        prop_assert!(boundaries_m.iter().all(|way_m| way_m.is_finite()), "{boundaries_m:?}");
        prop_assert!(boundaries_m.windows(2).all(|pair| pair[1] >= pair[0]), "{boundaries_m:?}");
        prop_assert!(skin.displacement_m(&at, &axis).is_finite());
    }
}

#[test]
fn on_a_slope_layers_open_where_they_are_met_along_the_needle() {
    // Straight down, 12° off the top of a ball of 60 mm: the plane z = 0 is 1.3 mm above the skin there.
    let skin = Skin::Sphere { radius_m: 0.06 };
    let aside_m = 0.06 * libm::sin(12_f64.to_radians());
    let mut needle = over(skin);
    let path = needle.travel(-Vector3::z(), Point3::new(aside_m, 0.0, 0.004), Point3::new(aside_m, 0.0, -0.03));
    let entry_m = path.iter().flat_map(|tick| &tick.events).find_map(|event| match event {
        PunctureEvent::Contact { entry_m, .. } => Some(*entry_m),
        _ => None,
    });
    assert!((entry_m.expect("it met the skin") - skin.above(aside_m, 0.0)).norm() < 1e-9);
    let opened = path.iter().flat_map(|tick| &tick.events).filter_map(|event| match event {
        PunctureEvent::Rupture(rupture) if rupture.contactor == Contactor::Tip => Some(rupture.x_m),
        _ => None,
    });
    let mut top_m = 0.0;
    let mut met = 0;
    for (layer, x_m) in training_axial_spec().layers.iter().zip(opened) {
        let reached_m = halved_way_m(&skin, &skin.above(aside_m, 0.0), &-Vector3::z(), top_m);
        let wanted_m = reached_m + layer.tip_rupture_n / layer.stiffness_n_per_m;
        // A tick moves it by 20 µm.
        assert!((x_m - wanted_m).abs() < 2.1e-5, "{} opened at {x_m} m, {wanted_m} m wanted", layer.name);
        top_m += layer.thickness_m;
        met += 1;
    }
    assert_eq!(met, 3, "the path must have opened everything");
}

#[test]
fn needle_beside_curved_skin_meets_nothing_and_exit_frees_it() {
    let skin = Skin::Sphere { radius_m: 0.06 };
    let mut needle = over(skin);
    let past = needle.travel(-Vector3::z(), Point3::new(0.061, 0.0, 0.0), Point3::new(0.061, 0.0, -0.06));
    assert!(past.iter().all(|tick| !tick.output.inside && tick.output.force_n == Vector3::zeros()));
    let x_m = 0.03;
    let top = skin.above(x_m, 0.0);
    needle.travel(-Vector3::z(), Point3::new(x_m, 0.0, 0.002), Point3::new(x_m, 0.0, top.z - 0.02));
    assert!(needle.down(x_m, 0.0, top.z - 0.02).inside);
    let out = needle.travel(-Vector3::z(), Point3::new(x_m, 0.0, top.z - 0.02), Point3::new(x_m, 0.0, top.z + 0.001));
    let last = out.last().expect("it moved");
    assert!(!last.output.inside && last.output.force_n == Vector3::zeros());
    assert!(out.iter().flat_map(|tick| &tick.events).any(|event| *event == PunctureEvent::SkinExit));
}

#[test]
fn flat_skin_gives_the_angle_of_incidence_capped_at_80_degrees() {
    let upright = Skin::Flat.incidence(&Point3::origin(), &-Vector3::z());
    assert_eq!(upright, Incidence::UPRIGHT);
    let flat = Skin::Flat.incidence(&Point3::origin(), &Vector3::x());
    assert!((flat.path_factor - 1.0 / libm::cos(80_f64.to_radians())).abs() < 1e-12);
}
