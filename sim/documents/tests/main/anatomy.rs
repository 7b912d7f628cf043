//! One's own anatomy: OBJ beside STL, stated axes, a skin; what is no manifold surface of a sensible size and place is refused.
//!
//! Would fail if axes were mirrored or swapped, if OBJ polygons or objects were lost, if a broken surface were taken for a
//! whole one, or if a recording could not carry the skin.

use documents::{Document, DocumentError, ExerciseBundle, Scene, SceneSkin};
use law::structures::Shape;
use nalgebra::Point3;

use crate::support::{EXERCISE, SCENE, folder, read_text, write};

/// Quads of a box, counter-clockwise seen from outside; bit 0 of a corner's number is x, bit 1 is y, bit 2 is z.
const QUADS: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn vertices(corners: &[[f64; 3]]) -> String {
    corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect()
}

/// A box between two corners as OBJ quads whose vertices are counted back from the last, so that boxes can follow each other.
fn obj_box(low: [f64; 3], high: [f64; 3]) -> String {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let faces = QUADS.map(|q| format!("f {}\n", q.map(|i| (i as i32 - 8).to_string()).join(" ")));
    vertices(&(0..8).map(corner).collect::<Vec<_>>()) + &faces.concat()
}

/// A tetrahedron of 10 mm, counter-clockwise seen from outside, whose faces are these.
fn tetrahedron(faces: &str) -> String {
    vertices(&[[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0], [9.0, 9.0, 9.0]]) + faces
}

const FACES: &str = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// A patch of 100 mm by 100 mm about a place, its middle raised, which faces up.
fn patch([x, y, z]: [f64; 3]) -> String {
    let corners = [[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]].map(|[a, b]| [x + a, y + b, z]);
    vertices(&corners) + &vertices(&[[x, y, z + 1.0]]) + "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
}

fn organ(file: &str, more: &str) -> String {
    let keys = "name = \"kidney\"\nkind = \"organ\"\nshape = \"mesh\"\nposition_mm = [0, 0, -40]\nunit = \"mm\"\n";
    SCENE.replace("[needle]", &format!("[[structure]]\n{keys}file = \"{file}\"\n{more}\n[needle]"))
}

fn skin_scene(more: &str) -> String {
    SCENE.replace("[needle]", &format!("[skin]\nfile = \"s.obj\"\nunit = \"mm\"\n{more}\n[needle]"))
}

fn scene(file: &str, bytes: &[u8], text: &str) -> Result<Scene, DocumentError> {
    let folder = folder();
    write(&folder, file, bytes);
    match read_text(&folder, text)? {
        Document::Scene(scene) => Ok(*scene),
        other => panic!("not a scene: {other:?}"),
    }
}

/// Corners in m, and triangles.
type Surface = (Vec<Point3<f64>>, Vec<[u32; 3]>);

fn mesh(obj: &str, more: &str) -> Result<Surface, DocumentError> {
    match &scene("k.obj", obj.as_bytes(), &organ("k.obj", more))?.structures[0].spec.shape {
        Shape::Mesh { vertices_m, triangles } => Ok((vertices_m.clone(), triangles.clone())),
        other => panic!("not a mesh: {other:?}"),
    }
}

fn skin(obj: &str, more: &str) -> Result<SceneSkin, DocumentError> {
    Ok(scene("s.obj", obj.as_bytes(), &skin_scene(more))?.skin.expect("the scene has a skin"))
}

/// Least and greatest coordinates in mm, rounded.
fn extent_mm(vertices: &[Point3<f64>]) -> [(i64, i64); 3] {
    [0, 1, 2].map(|axis| {
        let of = |p: &Point3<f64>| (p[axis] * 1e3).round() as i64;
        (vertices.iter().map(of).min().unwrap(), vertices.iter().map(of).max().unwrap())
    })
}

fn says(result: Result<impl std::fmt::Debug, DocumentError>, parts: &[&str]) {
    let error = result.unwrap_err().to_string();
    for part in parts {
        assert!(error.contains(part), "{part:?} is not in {error}");
    }
}

#[test]
fn an_obj_file_is_read_however_it_is_written() {
    let plain = obj_box([0.0; 3], [10.0; 3]);
    let expected = mesh(&plain, "").unwrap();
    for other in [
        format!("\u{feff}{plain}"),
        plain.replace("v ", "V ").replace("f ", "F "),
        plain.replace('\n', "\r\n"),
        plain.replacen(' ', " \\\n ", 40),
        format!("# from C:\\models\\\n{plain}"),
        plain.replace("f ", "s off\nf ") + "# end \\",
    ] {
        assert_eq!(mesh(&other, "").unwrap(), expected, "{other}");
    }
    let western = [b"o GEF\xc4SS\n".as_slice(), plain.as_bytes()].concat();
    assert!(scene("k.obj", &western, &organ("k.obj", "")).is_ok());
    says(mesh(&plain.replacen("f ", "f 1 \\\n 2\nf ", 1), ""), &["line 10: a face of 2 corners"]);
}

#[test]
fn obj_polygons_become_triangles_and_objects_become_one_mesh() {
    let first = obj_box([0.0; 3], [10.0; 3]).replace("f ", "usemtl gold\nf ");
    let second = obj_box([20.0; 3], [30.0; 3]).replace("f -8 ", "f -8/99/99 ");
    let (vertices, triangles) = mesh(&format!("mtllib no.mtl\no one\n{first}g two\n{second}vn x\n"), "").unwrap();
    assert_eq!((vertices.len(), triangles.len()), (16, 24));
    assert_eq!(extent_mm(&vertices), [(0, 30); 3]);
    let pentagon = "v 0 0 0\nv 10 0 0\nv 14 6 0\nv 5 12 0\nv -4 6 0\nv 5 5 9\n";
    let pyramid = "f 5 4 3 2 1\nf 1 2 6\nf 2 3 6\nf 3 4 6\nf 4 5 6\nf 5 1 6\n";
    assert_eq!(mesh(&format!("{pentagon}{pyramid}"), "").unwrap().1.len(), 8);
}

#[test]
fn axes_turn_a_mesh_into_the_frame_of_a_prone_patient() {
    // The patient's right 10 mm, back to front 20 mm, up to the head 30 mm, all from the mesh's origin.
    let ras = mesh(&obj_box([0.0; 3], [10.0, 20.0, 30.0]), "axes = \"RAS\"").unwrap();
    assert_eq!(extent_mm(&ras.0), [(0, 10), (0, 30), (-20, 0)], "right is +x, superior +y, anterior −z");
    let lps = mesh(&obj_box([-10.0, -20.0, 0.0], [0.0, 0.0, 30.0]), "axes = \"LPS\"").unwrap();
    assert_eq!(extent_mm(&lps.0), extent_mm(&ras.0), "the same body");
    let own = mesh(&obj_box([0.0; 3], [10.0, 20.0, 30.0]), "").unwrap();
    assert_eq!(extent_mm(&own.0), [(0, 10), (0, 20), (0, 30)]);
    assert_eq!(own, mesh(&obj_box([0.0; 3], [10.0, 20.0, 30.0]), "axes = \"patient\"").unwrap());
    says(mesh(&tetrahedron(FACES), "axes = \"ras\""), &["structure[0].axes: \"ras\"", "allowed: patient, RAS, LPS"]);
}

#[test]
fn what_cannot_be_read_says_why() {
    let bad: [(&str, &str); 8] = [
        ("", "a mesh without triangles"),
        ("v 1 2 3\nv 4 5", "unreadable as OBJ (line 2: position parse error)"),
        ("v 0 0 0\n\nf 1 2", "unreadable as OBJ (line 3: a face of 2 corners)"),
        ("v 0 0 0\n# two\nf 1 one 1", "unreadable as OBJ (line 3: face parse error)"),
        ("v 0 0 0\nv 1 0 0\nf 1 2 3", "a face refers to a vertex that does not exist in the file"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9", "a face refers to a vertex that does not exist in the file"),
        ("v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3", "a vertex that is not finite (number 3)"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2", "a face refers to a vertex that does not exist in the file"),
    ];
    for (obj, why) in bad {
        says(mesh(obj, ""), &["structure[0].file: \"k.obj\"", why, "allowed: an STL (.stl, binary or text) or OBJ"]);
    }
    says(scene("k.obj", &[0xff, 0xfe], &organ("k.obj", "")), &["unreadable as OBJ (not text)"]);
    says(scene("k.ply", b"ply", &organ("k.ply", "")), &["\"k.ply\": a file that ends in \".ply\"", "(.obj)"]);
    says(scene("s.obj", b"", &organ("k.obj", "")), &["structure[0].file: \"k.obj\": No such file"]);
    let folder = folder();
    std::fs::create_dir(folder.path().join("k.obj")).unwrap();
    says(read_text(&folder, &organ("k.obj", "")), &["structure[0].file: \"k.obj\": Is a directory"]);
}

#[test]
fn a_surface_that_is_no_manifold_is_refused_with_what_is_wrong() {
    mesh(&tetrahedron(FACES), "").unwrap();
    let touching = obj_box([0.0; 3], [10.0; 3]) + &obj_box([10.0; 3], [20.0; 3]);
    let bad = [
        (tetrahedron(&FACES.replace("f 1 3 2\n", "")), "not closed (3 open edges)"),
        (tetrahedron(&format!("{FACES}f 1 2 5\n")), "not manifold (1 edges in three or more triangles)"),
        (tetrahedron(&FACES.replace("f 1 3 2\n", "f 1 2 3\n")), "not consistently oriented (3 edges"),
        (touching, "not manifold (1 vertices at which only corners of the surface touch)"),
        (tetrahedron("f 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n"), "inside out"),
        (tetrahedron(&"f 1 2 3\n".repeat(200_001)), "\"k.obj\": 200001 triangles"),
        (obj_box([0.0; 3], [0.05; 3]), "a mesh of 0.05 mm; check its unit"),
        (obj_box([0.0; 3], [1001.0; 3]), "a mesh of 1001 mm; check its unit"),
    ];
    for (obj, why) in bad {
        says(mesh(&obj, ""), &[why, "at most 200000 triangles"]);
    }
}

#[test]
fn a_skin_may_be_open_and_goes_where_the_scene_puts_it() {
    let flat = skin(&patch([0.0, 0.0, -1.0]), "").unwrap();
    assert_eq!((extent_mm(&flat.vertices_m), flat.triangles.len()), ([(-50, 50), (-50, 50), (-1, 0)], 4));
    let far = skin(&patch([300.0, -900.0, 7.0]), "position_mm = [-290, 900, -8]").unwrap();
    assert_eq!(extent_mm(&far.vertices_m), [(-40, 60), (-50, 50), (-1, 0)]);
    // A box of a body in a scanner's coordinates: its back is at A = −100 mm.
    let body = obj_box([-150.0, -100.0, 600.0], [150.0, 100.0, 1000.0]);
    let body = skin(&body, "axes = \"RAS\"\nposition_mm = [0, -800, -100]").unwrap();
    assert_eq!(extent_mm(&body.vertices_m), [(-150, 150), (-200, 200), (-200, 0)]);
    assert_eq!(crate::support::scene(SCENE).skin, None);
}

#[test]
fn a_skin_elsewhere_or_broken_is_refused_with_where_it_is() {
    let all = ["document.toml:20:8: skin.file: \"s.obj\": ", "of 20 mm to 2000 mm", "within 5 mm of the origin"];
    let over = patch([0.0, 0.0, -1.0]);
    let bad = [
        (patch([0.0, 0.0, 11.5]), "a skin at z = 12.5 mm over the origin; check position_mm and axes"),
        (patch([0.0, 0.0, -7.0]), "a skin at z = -6.0 mm"),
        (patch([60.0, 0.0, 0.0]), "a skin that is not over the origin (its nearest vertex is 51.0 mm away)"),
        (over.replace("f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5", "f 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5"), "inside out"),
        (over.replace("f 1 2 5", "f 2 1 5"), "not consistently oriented (2 edges"),
        (obj_box([-5.0, -5.0, -5.0], [5.0, 5.0, 0.0]), "a mesh of 10 mm; check its unit"),
        (over.replace("50", "5000"), "a mesh of 10000 mm; check its unit"),
    ];
    for (obj, why) in bad {
        says(skin(&obj, ""), &[&[why], &all[..]].concat());
    }
    says(scene("s.obj", b"", &skin_scene("").replace("unit = \"mm\"\n", "")), &["skin.unit: missing"]);
    says(scene("s.obj", b"", &skin_scene("axes = 3")), &["skin.axes: 3"]);
}

#[test]
fn a_key_of_meshes_is_refused_on_another_shape() {
    let ball = "[[structure]]\nname = \"v\"\nkind = \"vessel\"\nshape = \"sphere\"\nradius_mm = 3\nposition_mm = [0, 0, -20]\n";
    let text = SCENE.replace("[needle]", &format!("{ball}axes = \"RAS\"\n[needle]"));
    says(read_text(&folder(), &text), &["structure[0].axes: not a key of this shape", "a sphere has radius_mm"]);
}

#[test]
fn attachments_rebuild_the_skin() {
    let folder = folder();
    write(&folder, "s.obj", patch([0.0; 3]));
    write(&folder, "scene.toml", skin_scene(""));
    let bundle = ExerciseBundle::read(&write(&folder, "e.toml", EXERCISE)).unwrap();
    assert_eq!(bundle.meshes, [("s.obj".to_owned(), patch([0.0; 3]).into_bytes())]);
    let parts =
        |meshes: &[(String, Vec<u8>)]| ExerciseBundle::from_parts(&bundle.exercise_bytes, &bundle.scene_bytes, meshes);
    assert_eq!(parts(&bundle.meshes).unwrap(), bundle);
    says(parts(&[]), &["skin.file: \"s.obj\": not attached"]);
}
