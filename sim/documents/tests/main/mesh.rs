//! Meshes of structures: read from binary and text STL in a stated unit; a bad one is refused where it is named.
//!
//! Would fail if a mesh with a hole, without size or inside out reached the physics, or if its unit were ignored.

use documents::{Document, DocumentError, ExerciseBundle};
use law::structures::Shape;
use stl_io::{Normal, Triangle, Vertex};

use crate::support::{EXERCISE, SCENE, folder, read_text, write};

/// A tetrahedron with an edge of 10 along each axis, counter-clockwise seen from outside; −0 stands beside 0.
fn tetrahedron(scale: f32) -> Vec<Triangle> {
    let corners = [[0.0, 0.0, 0.0], [10.0, -0.0, 0.0], [0.0, 10.0, -0.0], [-0.0, 0.0, 10.0]];
    let vertex = |i: usize| Vertex::new(corners[i].map(|c: f32| c * scale));
    [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
        .map(|t| Triangle { normal: Normal::new([0.0; 3]), vertices: t.map(vertex) })
        .to_vec()
}

fn binary(triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = Vec::new();
    stl_io::write_stl(&mut bytes, triangles.iter()).unwrap();
    bytes
}

fn text(triangles: &[Triangle]) -> Vec<u8> {
    let mut text = "solid t\n".to_owned();
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for v in triangle.vertices {
            text += &format!("vertex {} {} {}\n", v.0[0], v.0[1], v.0[2]);
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid t\n").into_bytes()
}

fn scene_text(unit: &str) -> String {
    let keys = "name = \"kidney\"\nkind = \"organ\"\nshape = \"mesh\"\nfile = \"k.stl\"\nposition_mm = [0, 0, -40]\n";
    SCENE.replace("[needle]", &format!("[[structure]]\n{keys}{unit}\n\n[needle]"))
}

fn read_mesh(bytes: &[u8], unit: &str) -> Result<Shape, DocumentError> {
    let folder = folder();
    write(&folder, "k.stl", bytes);
    match read_text(&folder, &scene_text(&format!("unit = \"{unit}\"")))? {
        Document::Scene(scene) => Ok(scene.structures[0].spec.shape.clone()),
        other => panic!("not a scene: {other:?}"),
    }
}

fn refusal(bytes: &[u8]) -> String {
    read_mesh(bytes, "mm").unwrap_err().to_string()
}

#[test]
fn binary_and_text_files_give_the_same_mesh() {
    let mesh = read_mesh(&binary(&tetrahedron(1.0)), "mm").unwrap();
    assert_eq!(mesh, read_mesh(&text(&tetrahedron(1.0)), "mm").unwrap());
    let Shape::Mesh { vertices_m, triangles } = mesh else { panic!("not a mesh") };
    assert_eq!((vertices_m.len(), triangles.len()), (4, 4));
    assert!(vertices_m.iter().any(|p| p.x == 0.01));
}

#[test]
fn the_unit_is_the_one_stated() {
    let Shape::Mesh { vertices_m, .. } = read_mesh(&binary(&tetrahedron(0.05)), "m").unwrap() else {
        panic!("not a mesh")
    };
    assert!(vertices_m.iter().any(|p| p.x == 0.5));
    let missing = read_text(&folder(), &scene_text("")).unwrap_err().to_string();
    assert!(missing.contains("structure[0].unit: missing; required for a mesh"), "{missing}");
}

#[test]
fn unreadable_meshes_are_refused_where_they_are_named() {
    let whole = binary(&tetrahedron(1.0));
    let mut endless = whole.clone();
    endless[80..84].fill(0xff);
    for bytes in [&b""[..], b"not a mesh", &whole[..whole.len() - 1], &endless] {
        let error = refusal(bytes);
        assert!(error.contains("document.toml:23:8: structure[0].file: \"k.stl\": unreadable as STL"), "{error}");
    }
    let missing = read_text(&folder(), &scene_text("unit = \"mm\"")).unwrap_err().to_string();
    assert!(missing.contains("structure[0].file: \"k.stl\": No such file"), "{missing}");
}

#[test]
fn a_mesh_must_be_a_closed_solid_of_a_sensible_size() {
    let whole = tetrahedron(1.0);
    assert!(refusal(&binary(&[])).contains("without triangles"));
    assert!(refusal(&binary(&whole[..3])).contains("not closed (3 open"));
    let mut nan = whole.clone();
    nan[0].vertices[0] = Vertex::new([f32::NAN, 0.0, 0.0]);
    assert!(refusal(&binary(&nan)).contains("not finite"));
    let inside_out: Vec<_> = whole
        .iter()
        .map(|t| Triangle { normal: t.normal, vertices: [t.vertices[0], t.vertices[2], t.vertices[1]] })
        .collect();
    assert!(refusal(&binary(&inside_out)).contains("inside out"));
    assert!(refusal(&binary(&tetrahedron(0.001))).contains("check its unit"));
    assert!(read_mesh(&binary(&whole), "m").unwrap_err().to_string().contains("10000 mm; check its unit"));
}

#[test]
fn attached_meshes_rebuild_the_exercise_and_are_required() {
    let folder = folder();
    write(&folder, "k.stl", binary(&tetrahedron(1.0)));
    write(&folder, "scene.toml", scene_text("unit = \"mm\""));
    let bundle = ExerciseBundle::read(&write(&folder, "e.toml", EXERCISE)).unwrap();
    assert_eq!(bundle.meshes, [("k.stl".to_owned(), binary(&tetrahedron(1.0)))]);
    let parts =
        |meshes: &[(String, Vec<u8>)]| ExerciseBundle::from_parts(&bundle.exercise_bytes, &bundle.scene_bytes, meshes);
    assert_eq!(parts(&bundle.meshes).unwrap(), bundle);
    assert!(parts(&[]).unwrap_err().to_string().contains("structure[0].file: \"k.stl\": not attached"));
}

#[test]
fn every_solid_of_a_text_file_counts() {
    let near = tetrahedron(1.0);
    let aside = |v: Vertex| Vertex::new([v.0[0] + 20.0, v.0[1], v.0[2]]);
    let far = near.iter().map(|t| Triangle { normal: t.normal, vertices: t.vertices.map(aside) });
    let both: Vec<Triangle> = near.iter().cloned().chain(far).collect();
    let expected = read_mesh(&binary(&both), "mm").unwrap();
    let plain = [text(&both[..4]), text(&both[4..])].concat();
    let named = String::from_utf8(plain.clone()).unwrap().replace("solid t", "solid the solid endsolid").into_bytes();
    // Open each, closed together.
    let halves = [text(&both[..3]), text(&both[3..])].concat();
    for file in [plain, named, halves] {
        assert_eq!(read_mesh(&file, "mm").unwrap(), expected, "{}", String::from_utf8_lossy(&file));
    }
}

#[test]
fn a_text_file_is_known_however_it_is_written() {
    let expected = read_mesh(&binary(&tetrahedron(1.0)), "mm").unwrap();
    let plain = String::from_utf8(text(&tetrahedron(1.0))).unwrap();
    let name = |bytes: &[u8]| {
        let rest = plain.strip_prefix("solid t").unwrap();
        [b"solid ", bytes, rest.as_bytes()].concat()
    };
    for file in [
        plain.to_uppercase().into_bytes(),
        plain.replace("solid t", "solid").into_bytes(),
        format!("\u{feff}{plain}").into_bytes(),
        plain.replace('\n', "\r\n").into_bytes(),
        plain.replace('\n', "\r").into_bytes(),
        plain.replace("outer", "  outer").replace("\nvertex", " vertex").into_bytes(),
        name(b"GEF\xc4SS"),
        name("Gefäß".as_bytes()),
        name(&[0xff; 90]),
    ] {
        assert_eq!(read_mesh(&file, "mm").unwrap(), expected, "{}", String::from_utf8_lossy(&file));
    }
    for head in ["solid exported by a program", "SOLID\nfacet normal 0 0 0\n"] {
        let mut file = binary(&tetrahedron(1.0));
        file[..head.len()].copy_from_slice(head.as_bytes());
        assert_eq!(read_mesh(&file, "mm").unwrap(), expected, "{head}");
    }
}

#[test]
fn a_text_file_that_was_cut_is_refused() {
    let whole = String::from_utf8(text(&tetrahedron(1.0))).unwrap();
    let told = refusal(whole.replace("endsolid t", "").as_bytes());
    assert!(told.contains("line 1: a solid that does not end with \"endsolid\""), "{told}");
    let told = refusal(format!("{whole}{}", &whole[..whole.len() / 2]).as_bytes());
    assert!(told.contains("a solid that does not end"), "{told}");
}
