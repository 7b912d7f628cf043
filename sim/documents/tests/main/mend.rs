//! Meshes as other tools write them: corners a rounding apart, triangles of no size, pairs back to back; and those that no welding closes.
//!
//! Would fail if such a mesh were refused, if welding moved a corner by more than it says, if a sound mesh were touched, or if a broken one
//! were named without its place.

use documents::Document;
use law::structures::Shape;

use crate::support::{SCENE, folder, read_text, write};

fn read(obj: &str, axes: &str) -> Result<Shape, String> {
    let folder = folder();
    write(&folder, "k.obj", obj);
    let keys = "name = \"kidney\"\nkind = \"organ\"\nshape = \"mesh\"\nposition_mm = [0, 0, -40]\nunit = \"mm\"\n";
    let text =
        SCENE.replace("[needle]", &format!("[[structure]]\n{keys}file = \"k.obj\"\naxes = \"{axes}\"\n[needle]"));
    match read_text(&folder, &text) {
        Ok(Document::Scene(scene)) => Ok(scene.structures[0].spec.shape.clone()),
        Ok(other) => panic!("not a scene: {other:?}"),
        Err(error) => Err(error.to_string()),
    }
}

fn counts(obj: &str) -> (usize, usize) {
    match read(obj, "patient") {
        Ok(Shape::Mesh { vertices_m, triangles }) => (vertices_m.len(), triangles.len()),
        other => panic!("{other:?}"),
    }
}

/// A cube of 20 mm whose twelve triangles have corners of their own, each off by at most `off` mm.
fn cube(off: f64) -> String {
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::new();
    let mut at = 0_u32;
    for [a, b, c, d] in quads {
        for corner in [a, b, c, a, c, d] {
            let mut place = [0, 1, 2].map(|axis: i32| f64::from(corner >> axis & 1) * 20.0);
            place[(at % 3) as usize] += off * (f64::from(at % 7) / 3.0 - 1.0);
            text += &format!("v {:.9} {:.9} {:.9}\n", place[0], place[1], place[2]);
            at += 1;
        }
    }
    text + &(0..12).map(|t| format!("f {} {} {}\n", 3 * t + 1, 3 * t + 2, 3 * t + 3)).collect::<String>()
}

#[test]
fn mesh_repair_joins_rounded_corners_and_rejects_real_gaps() {
    assert_eq!(counts(&cube(0.0)), (8, 12));
    assert_eq!(counts(&cube(1e-5)), (8, 12), "parted by 10 nm in 20 mm");
    let apart = read(&cube(1e-2), "patient").unwrap_err();
    assert!(apart.contains("the first at ("), "{apart}");
}

#[test]
fn triangles_of_no_size_are_dropped() {
    // A sliver between two corners that are one, a triangle twice, and two back to back.
    let sliver = cube(0.0) + "v 20 0 20.0000001\nf 37 36 1\nf 36 36 1\n";
    assert_eq!(counts(&(sliver + "f 1 2 3\nf 4 9 18\nf 9 4 18\n")), (8, 12));
}

#[test]
fn what_cannot_be_mended_is_named_with_its_place_in_the_file() {
    // The edge from (0, 0, 0) to (20, 0, 0) has a corner in its middle on one side alone.
    let tee = "v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 20\nv 10 0 0\nf 1 3 2\nf 1 5 4\nf 5 2 4\nf 2 3 4\nf 1 4 3\n";
    for axes in ["patient", "RAS", "LPS"] {
        let why = read(tee, axes).unwrap_err();
        assert!(why.contains("not closed (3 open edges), the first at (10.000, 0.000, 0.000) mm of the file"), "{why}");
    }
    let flat = read("v 0 0 0\nv 20 0 0\nv 0 0 0\nf 1 2 3\n", "patient").unwrap_err();
    assert!(flat.contains("a mesh whose triangles have no area"), "{flat}");
}
