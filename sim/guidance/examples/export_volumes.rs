//! Writes the volumes of a body as STL, with the transmission of each pixel, for a comparison with other programs.

use std::fs;
use std::path::PathBuf;

use anatomy::{Body, BodyOrder, BodyQuality, BodySide, Contrast, Posture};
use guidance::{BodyShadow, CArm, Exposure, KermaLevel, Pulse, Radiograph, mean_transmission};
use nalgebra::Point3;

fn main() {
    let out = PathBuf::from(std::env::args().nth(1).expect("a folder"));
    fs::create_dir_all(&out).expect("a folder");
    let order = BodyOrder { posture: Posture::Prone, seed: 2, weight_kg: 78.0, age_years: 50.0 };
    let contrast = Contrast { side: BodySide::Right, volume_ml: 8.0 };
    let volumes = Body::new(&order).expect("a body").list_volumes(BodyQuality::Low, Some(contrast));
    let mut table = String::from("name,substance,parent\n");
    for volume in &volumes {
        let parent = volume.parent.map_or(String::new(), |parent| volumes[parent].name.clone());
        table += &format!("{},{:?},{parent}\n", volume.name, volume.substance);
        let mut stl = vec![0; 80];
        stl.extend((volume.mesh.triangles.len() as u32).to_le_bytes());
        for triangle in &volume.mesh.triangles {
            stl.extend([0; 12]);
            for corner in triangle {
                let place = volume.mesh.vertices_m[*corner as usize];
                place.coords.iter().for_each(|c| stl.extend(((c * 1e3) as f32).to_le_bytes()));
            }
            stl.extend([0; 2]);
        }
        fs::write(out.join(format!("{}.stl", volume.name)), stl).expect("a file");
    }
    fs::write(out.join("volumes.csv"), table).expect("a file");
    for degrees in [0.0_f64, 30.0, 90.0] {
        let arm = CArm { orbital_rad: degrees.to_radians(), ..CArm::over(Point3::new(0.055, 0.03, -0.075)) };
        let shadow = BodyShadow::cast(&arm, &volumes).expect("a body within reach");
        let mean = mean_transmission(&arm, &volumes).expect("a body within reach");
        let pulse = Pulse { seed: 1, index: 0, exposure: Exposure::control(&arm, KermaLevel::Low, mean) };
        let picture = Radiograph::expose(&shadow, None, pulse);
        let bytes: Vec<u8> = picture.transmissions.iter().flat_map(|t| t.to_le_bytes()).collect();
        fs::write(out.join(format!("{degrees}.f64")), bytes).expect("a file");
    }
}
