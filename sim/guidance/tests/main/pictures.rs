//! Pictures of boxes and of a body. Fails if a volume adds what its parent already has, if the dose does not follow the
//! exposure, or if noise depends on anything but seed, pulse and pixel.

use std::sync::OnceLock;

use anatomy::{Body, BodyMesh, BodyOrder, BodyQuality, BodySide, BodyVolume, Contrast, Posture, Substance};
use guidance::attenuation::{WEIGHTS, coefficients_per_cm, transmit};
use guidance::{BodyShadow, CArm, Exposure, ImagedNeedle, KermaLevel, PIXELS, Pulse, Radiograph, mean_transmission};
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

use crate::paths::box_mesh;

/// Near the lower pole of the right kidney, in m.
const KIDNEY_M: Point3<f64> = Point3::new(0.055, 0.03, -0.075);

fn volumes() -> &'static [BodyVolume] {
    static VOLUMES: OnceLock<Vec<BodyVolume>> = OnceLock::new();
    VOLUMES.get_or_init(|| {
        let order = BodyOrder { posture: Posture::Prone, seed: 2, weight_kg: 78.0, age_years: 50.0 };
        let contrast = Contrast { side: BodySide::Right, volume_ml: 5.0 };
        Body::new(&order).unwrap().list_volumes(BodyQuality::Medium, Some(contrast))
    })
}

fn box_volume(half_m: f64, substance: Substance, parent: Option<usize>) -> BodyVolume {
    BodyVolume { name: "box".to_owned(), substance, parent, mesh: box_mesh([half_m; 3]) }
}

/// The first pulse of a view at the lowest kerma.
fn pulse(arm: &CArm, volumes: &[BodyVolume]) -> Pulse {
    let exposure = Exposure::control(arm, KermaLevel::Low, mean_transmission(arm, volumes).unwrap());
    Pulse { seed: 5, index: 0, exposure }
}

fn middle(pixels: &[f64]) -> f64 {
    pixels[PIXELS / 2 * PIXELS + PIXELS / 2]
}

#[test]
fn weights_add_up_and_air_transmits_everything() {
    assert!((WEIGHTS.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    assert!((transmit(&[0.0; 7]) - 1.0).abs() < 1e-12);
    for substance in Substance::ALL {
        let coefficients = coefficients_per_cm(substance);
        // Only iodine has an edge within the spectrum.
        let falls = coefficients.windows(2).all(|pair| pair[1] < pair[0]);
        assert_eq!(falls, substance != Substance::ContrastMedium, "{substance:?}");
    }
}

#[test]
fn a_nested_volume_replaces_its_parent() {
    let volumes = [box_volume(0.05, Substance::Muscle, None), box_volume(0.01, Substance::CorticalBone, Some(0))];
    let arm = CArm::over(Point3::origin());
    let shadow = BodyShadow::cast(&arm, &volumes).unwrap();
    let radiograph = Radiograph::expose(&shadow, None, pulse(&arm, &volumes));
    let [muscle, bone] = [Substance::Muscle, Substance::CorticalBone].map(coefficients_per_cm);
    // The pixel beside the middle is lit at an angle of 0.02°.
    let slant = (1.0 + 2.0 * (0.5 * 0.3 / PIXELS as f64).powi(2)).sqrt();
    let expected = transmit(&std::array::from_fn(|bin| (muscle[bin] * 8.0 + bone[bin] * 2.0) * slant));
    let found = middle(&radiograph.transmissions);
    assert!((found / expected - 1.0).abs() < 1e-9, "{found}, expected {expected}");
}

#[test]
fn exposure_control_gives_the_detector_its_kerma() {
    let arm = CArm::over(Point3::origin());
    for (level, kerma_ugy) in [(KermaLevel::Low, 0.030), (KermaLevel::Normal, 0.045), (KermaLevel::Boost, 0.065)] {
        let exposure = Exposure::control(&arm, level, 0.01);
        assert!((exposure.open_kerma_ugy * 0.01 - kerma_ugy).abs() < 1e-15);
        assert!((exposure.load_mas - kerma_ugy / 35.76 / 0.01).abs() < 1e-12);
        // The reference point is 450 mm from the source, where the field of 300 mm is 135 mm wide.
        assert!((exposure.kerma_ugy / (exposure.load_mas * 35.76 / 0.2025) - 1.0).abs() < 1e-9);
        assert!((exposure.kerma_area_ugy_m2 / (exposure.kerma_ugy * 0.135 * 0.135) - 1.0).abs() < 1e-9);
    }
    let near = CArm { source_isocentre_m: 0.5, field_m: 0.1, ..arm };
    let exposure = Exposure::control(&near, KermaLevel::Low, 0.01);
    assert!((exposure.kerma_ugy / (exposure.load_mas * 35.76 / 0.1225) - 1.0).abs() < 1e-9);
    assert!((exposure.kerma_area_ugy_m2 / (exposure.kerma_ugy * 0.035 * 0.035) - 1.0).abs() < 1e-9);
    // The tube's limits.
    assert_eq!(Exposure::control(&arm, KermaLevel::Low, 1e-9).load_mas, 1.0);
    assert_eq!(Exposure::control(&arm, KermaLevel::Low, 1.0).load_mas, 0.02);
}

#[test]
fn a_shot_has_the_dose_of_its_tube_load() {
    let arm = CArm::over(KIDNEY_M);
    let once = pulse(&arm, volumes()).exposure;
    let shot = Exposure::with_load(&arm, 10.0 * once.load_mas);
    for (shot, once) in [(shot.kerma_ugy, once.kerma_ugy), (shot.kerma_area_ugy_m2, once.kerma_area_ugy_m2)] {
        assert!((shot / once - 10.0).abs() < 1e-9, "{shot} {once}");
    }
}

#[test]
fn noise_follows_from_seed_and_pulse() {
    let arm = CArm::over(KIDNEY_M);
    let shadow = BodyShadow::cast(&arm, volumes()).unwrap();
    let exposure = pulse(&arm, volumes()).exposure;
    let take = |seed, index| Radiograph::expose(&shadow, None, Pulse { seed, index, exposure }).greys;
    let first = take(5, 1);
    assert_eq!(first, take(5, 1));
    for other in [take(5, 2), take(6, 1)] {
        let same = first.iter().zip(&other).filter(|(one, two)| one == two).count();
        assert!(same < first.len() / 5, "{same} pixels are the same");
    }
}

#[test]
fn a_collimated_field_is_dark_around_and_dosed_less() {
    let open = CArm::over(KIDNEY_M);
    let narrow = CArm { field_m: 0.15, ..open };
    let [open, narrow] = [open, narrow].map(|arm| {
        let shadow = BodyShadow::cast(&arm, volumes()).unwrap();
        let pulse = pulse(&arm, volumes());
        (Radiograph::expose(&shadow, None, pulse).greys, pulse.exposure.kerma_area_ugy_m2)
    });
    let lit = |greys: &[u8]| greys.iter().filter(|grey| **grey > 0).count();
    assert!(lit(&open.0) > PIXELS * PIXELS * 9 / 10);
    assert!(lit(&narrow.0) <= PIXELS * PIXELS / 4);
    assert!(narrow.1 < 0.3 * open.1);
}

#[test]
fn a_needle_is_darker_with_its_stylet() {
    let arm = CArm::over(KIDNEY_M);
    let shadow = BodyShadow::cast(&arm, volumes()).unwrap();
    let pulse = pulse(&arm, volumes());
    let needle = ImagedNeedle {
        tip_m: KIDNEY_M,
        direction: Vector3::new(-1.0, 0.0, -1.0).normalize(),
        length_m: 0.15,
        outer_m: 1.27e-3,
        bore_m: 0.84e-3,
        has_stylet: true,
    };
    let take = |needle: Option<&ImagedNeedle>| {
        let transmissions = Radiograph::expose(&shadow, needle, pulse).transmissions;
        // 30 mm from the tip towards the hub.
        let row = PIXELS / 2 * PIXELS;
        let along = transmissions[row + PIXELS / 2 + 10..row + PIXELS / 2 + 90].iter();
        along.sum::<f64>()
    };
    let [full, hollow, without] =
        [take(Some(&needle)), take(Some(&ImagedNeedle { has_stylet: false, ..needle })), take(None)];
    assert!(full < 0.5 * hollow && hollow < 0.8 * without, "{full} {hollow} {without}");
}

#[test]
fn contrast_fills_the_volume_that_was_injected() {
    let volume = |name: &str| {
        let found = volumes().iter().find(|volume| volume.name == name).unwrap();
        anatomy::volume_m3(&found.mesh.vertices_m, &found.mesh.triangles) * 1e6
    };
    let (contrast_ml, system_ml) = (volume("contrast-right"), volume("calyces-right"));
    assert!((contrast_ml - 5.0).abs() < 0.5, "{contrast_ml} ml");
    assert!((6.0..25.0).contains(&system_ml), "{system_ml} ml");
    assert!(volumes().iter().all(|volume| volume.name != "contrast-left"));
}

#[test]
fn a_turned_body_keeps_its_bones_where_they_project() {
    // Seen from the side, the body of L3 is darker than the disc below it. From behind, laminae lie in front of both.
    let place = |name: &str| {
        let BodyMesh { vertices_m, .. } = &volumes().iter().find(|volume| volume.name == name).unwrap().mesh;
        let sum = vertices_m.iter().fold(Vector3::zeros(), |sum, vertex| sum + vertex.coords);
        Point3::from(sum / vertices_m.len() as f64)
    };
    let disc_m = place("disc-L3-4");
    let above_m = disc_m + Vector3::new(0.0, 0.018, 0.0);
    for orbital_deg in [80.0_f64, 90.0] {
        let arm = CArm { orbital_rad: orbital_deg.to_radians(), ..CArm::over(disc_m) };
        let shadow = BodyShadow::cast(&arm, volumes()).unwrap();
        let radiograph = Radiograph::expose(&shadow, None, pulse(&arm, volumes()));
        let detector = guidance::Detector::new(&arm, PIXELS);
        let at = |point_m: &Point3<f64>| {
            let place = detector.project(point_m);
            radiograph.transmissions[place.y as usize * PIXELS + place.x as usize]
        };
        assert!(at(&above_m) < 0.85 * at(&disc_m), "{} and {} at {orbital_deg}°", at(&above_m), at(&disc_m));
    }
}

/// A volume's surface for the question whether a point is inside.
fn solid(volume: &BodyVolume) -> TriMesh {
    let vertices = volume.mesh.vertices_m.iter().map(|v| Vector::new(v.x, v.y, v.z)).collect();
    TriMesh::with_flags(vertices, volume.mesh.triangles.clone(), TriMeshFlags::ORIENTED).expect("a closed surface")
}

#[test]
fn children_lie_inside_and_siblings_apart() {
    let volumes = volumes();
    let solids: Vec<TriMesh> = volumes.iter().map(solid).collect();
    // Surfaces of triangles enter each other by up to half a cell.
    let deepest_m = 2.5e-3;
    let depth = |at: usize, point_m: &Point3<f64>| {
        let point = Vector::new(point_m.x, point_m.y, point_m.z);
        let projected = solids[at].project_local_point(point, false);
        let distance = (projected.point - point).length();
        if projected.is_inside { distance } else { -distance }
    };
    for (at, volume) in volumes.iter().enumerate() {
        assert_eq!(anatomy::check_manifold(&volume.mesh.triangles), Ok(0), "{}", volume.name);
        assert!(volume.parent.is_none_or(|parent| parent < at), "{}", volume.name);
        for vertex in volume.mesh.vertices_m.iter().step_by(11) {
            for (other, sibling) in volumes.iter().enumerate() {
                let (of, with) = (&volume.name, &sibling.name);
                if volume.parent == Some(other) {
                    assert!(depth(other, vertex) > -deepest_m, "{of} leaves {with} by {} m", -depth(other, vertex));
                } else if at != other && sibling.parent == volume.parent {
                    assert!(depth(other, vertex) < deepest_m, "{of} enters {with} by {} m", depth(other, vertex));
                }
            }
        }
    }
}
