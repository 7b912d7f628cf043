//! A body's pictures.

use anatomy::{Body, BodyOrder, BodyQuality, BodySide, BodyVolume, Contrast, Posture, Substance};
use guidance::attenuation::{coefficients_per_cm, transmit};
use guidance::{BodyShadow, CArm, Exposure, KermaLevel, PIXELS, Pulse, Radiograph};
use nalgebra::Point3;

fn body() -> Body {
    Body::new(&BodyOrder { posture: Posture::Prone, seed: 2, weight_kg: 78.0, age_years: 50.0 }).unwrap()
}

const PULSE: Pulse = Pulse { seed: 5, index: 1, level: KermaLevel::Low };

#[test]
fn volumes_nest_and_their_siblings_are_apart() {
    let volumes = body().list_volumes(BodyQuality::Low, Some(Contrast { side: BodySide::Right, volume_ml: 4.0 }));
    for (at, volume) in volumes.iter().enumerate() {
        assert!(volume.parent.is_none_or(|parent| parent < at), "{}", volume.name);
        assert_eq!(anatomy::check_manifold(&volume.mesh.triangles), Ok(0), "{}", volume.name);
        println!("{} {:?} {}", volume.name, volume.substance, volume.mesh.triangles.len());
    }
}

#[test]
fn prints_a_picture() {
    let start = std::time::Instant::now();
    let volumes: Vec<BodyVolume> =
        body().list_volumes(BodyQuality::Medium, Some(Contrast { side: BodySide::Right, volume_ml: std::env::var("ML").map_or(4.0, |v| v.parse().unwrap()) }));
    println!("volumes {:?}, {} triangles", start.elapsed(), volumes.iter().map(|v| v.mesh.triangles.len()).sum::<usize>());
    for (name, orbital) in [("a", 0.0_f64), ("b", 30.0), ("c", 90.0)] {
        let arm = CArm { orbital_rad: orbital.to_radians(), ..CArm::over(Point3::new(0.04, 0.03, -0.07)) };
        let start = std::time::Instant::now();
        let shadow = BodyShadow::cast(&arm, &volumes).unwrap();
        println!("cast {:?}", start.elapsed());
        let start = std::time::Instant::now();
        let radiograph = Radiograph::expose(&shadow, None, PULSE);
        println!("exposed {:?} {:?}", start.elapsed(), radiograph.exposure);
        let mut out = format!("P5\n{PIXELS} {PIXELS}\n255\n").into_bytes();
        out.extend(&radiograph.greys);
        std::fs::write(format!("/work/x{name}.pgm"), out).unwrap();
    }
    let _ = (coefficients_per_cm(Substance::Muscle), transmit(&[0.0; 7]), KermaLevel::Low);
    let _ = Exposure::control(&CArm::over(Point3::origin()), KermaLevel::Low, 0.01);
}
