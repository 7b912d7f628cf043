//! Structures outside the body and a skin that leans: `stylet check` finds them, and reading does not refuse them, for recordings carry such
//! scenes.
//!
//! Would fail if height were measured the wrong way, if a curved skin were taken for a plane, or if a structure near the skin were blamed.

use crate::support::{SCENE, folder, write};

fn ball(z_mm: f64) -> String {
    let keys =
        format!("name = \"v\"\nkind = \"vessel\"\nshape = \"sphere\"\nradius_mm = 3\nposition_mm = [0, 40, {z_mm}]\n");
    SCENE.replace("[needle]", &format!("[[structure]]\n{keys}\n[needle]"))
}

fn check(text: &str, skin: Option<&str>) -> Result<(), String> {
    let folder = folder();
    let with = match skin {
        Some(obj) => {
            write(&folder, "s.obj", obj);
            text.replace("[needle]", "[skin]\nfile = \"s.obj\"\nunit = \"mm\"\n\n[needle]")
        }
        None => text.to_owned(),
    };
    let path = write(&folder, "scene.toml", with);
    assert!(documents::load::read_document(&path).is_ok(), "it can be read all the same");
    documents::check_documents(&path).map(|_| ()).map_err(|refused| refused.to_string())
}

/// A roof along x: its ridge over the origin, falling to both sides by `fall` mm in 100 mm, or to one side alone.
fn roof(left: f64, right: f64) -> String {
    let rows = [(-100.0, -left), (0.0, 0.0), (100.0, -right)];
    let corners = rows.iter().flat_map(|(y, z)| [-100.0, 100.0].map(|x| format!("v {x} {y} {z}\n")));
    corners.collect::<String>() + "f 1 2 4\nf 1 4 3\nf 3 4 6\nf 3 6 5\n"
}

#[test]
fn a_structure_outside_the_body_is_found_with_its_place() {
    assert_eq!(check(&ball(-20.0), None), Ok(()));
    let over = check(&ball(60.0), None).unwrap_err();
    assert!(over.contains("structure[0].position_mm: \"v\" protrudes 63.0 mm from the body at ("), "{over}");
    assert!(check(&ball(0.0), None).unwrap_err().contains("protrudes 3.0 mm from"));
    assert_eq!(check(&ball(-1.5), None), Ok(()), "1.5 mm are within what is allowed");
}

#[test]
fn the_body_ends_at_its_own_skin() {
    // 40 mm beside the ridge the roof is 8 mm lower.
    assert_eq!(check(&ball(-20.0), Some(&roof(20.0, 20.0))), Ok(()));
    let over = check(&ball(-6.0), Some(&roof(20.0, 20.0))).unwrap_err();
    assert!(over.contains("out of the body"), "{over}");
    assert_eq!(check(&ball(-6.0), None), Ok(()));
}

#[test]
fn a_skin_that_leans_at_the_entry_is_found() {
    assert_eq!(check(SCENE, Some(&roof(0.0, 0.0))), Ok(()));
    assert_eq!(check(SCENE, Some(&roof(-15.0, 15.0))), Ok(()), "8.5°");
    let steep = check(SCENE, Some(&roof(-40.0, 40.0))).unwrap_err();
    assert!(steep.contains("skin.file: a skin inclined by 22° at the entry; allowed: at most 12°"), "{steep}");
}
