//! Triangle meshes of structures and of the skin: read from a file, rotated into the patient frame,
//! checked.

mod axes;
mod file;
mod mend;
mod skin;
mod text_stl;

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use anatomy::{check_manifold, volume_m3};
pub(crate) use axes::Axes;
pub use file::write_stl;
use law::structures::{Shape, Surface};
use nalgebra::{Point3, Vector3};
use phrase::{Phrase, phrase};
pub(crate) use skin::crossing;

/// Describes the requirements on a structure's mesh.
pub(crate) fn allowed_solid() -> Phrase {
    phrase!(
        "allowed: an STL (.stl, binary or text) or OBJ (.obj) file, closed, manifold, counter-clockwise seen from outside, of \
         0.1 mm to 1000 mm, at most 200000 triangles"
    )
}

/// Describes the requirements on the skin's mesh.
pub(crate) fn allowed_skin() -> Phrase {
    phrase!(
        "allowed: an STL (.stl, binary or text) or OBJ (.obj) file, manifold, counter-clockwise seen from outside, of 20 mm \
         to 2000 mm, at most 200000 triangles, within 5 mm of the origin"
    )
}

const MOST_TRIANGLES: usize = 200_000;
const SOLID_SIZE_M: RangeInclusive<f64> = 1e-4..=1.0;
const SKIN_SIZE_M: RangeInclusive<f64> = 0.02..=2.0;

/// Properties of the coordinates that the file does not contain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinates {
    /// Whether the unit is mm; otherwise m.
    pub in_mm: bool,
    /// The axes.
    pub axes: Axes,
}

/// A mesh file.
#[derive(Clone, Copy)]
pub(crate) struct MeshFile<'a> {
    /// Its name; the extension determines the format.
    pub name: &'a str,
    /// Content.
    pub bytes: &'a [u8],
}

/// Vertices and triangles as in the file.
struct Raw {
    corners: Vec<[f32; 3]>,
    triangles: Vec<[usize; 3]>,
}

/// Reads a solid from a file.
///
/// # Errors
/// The reason for refusing the mesh, in words.
pub(crate) fn read_solid(file: MeshFile<'_>, coordinates: Coordinates) -> Result<Shape, Phrase> {
    let found = surface(file, coordinates, &SOLID_SIZE_M)?;
    let (vertices_m, triangles) = mend_unless(found, coordinates, check_closed)?;
    if volume_m3(&vertices_m, &triangles) <= 0.0 {
        return Err(phrase!("a mesh that is inside out: its triangles run clockwise seen from outside"));
    }
    Ok(Shape::Mesh { vertices_m, triangles })
}

/// Reads the skin from a file, with the origin of its mesh at `position_m`, patient frame.
///
/// # Errors
/// The reason for refusing the mesh, in words.
pub(crate) fn read_skin_mesh(
    file: MeshFile<'_>,
    coordinates: Coordinates,
    position_m: &Vector3<f64>,
) -> Result<Surface, Phrase> {
    let found = surface(file, coordinates, &SKIN_SIZE_M)?;
    let (mut vertices_m, triangles) =
        mend_unless(found, coordinates, |triangles| check_manifold(triangles).map(|_| ()))?;
    for vertex in &mut vertices_m {
        *vertex += position_m;
    }
    skin::check_over_origin(&vertices_m, &triangles)?;
    Ok((vertices_m, triangles))
}

fn check_closed(triangles: &[[u32; 3]]) -> Result<(), Phrase> {
    match check_manifold(triangles)? {
        0 => Ok(()),
        open => Err(phrase!("a mesh that is not closed ({open} open edges)", open = open)),
    }
}

/// Returns a surface that passes `check`, repaired if necessary.
///
/// # Errors
/// The flaw of the repaired surface, with its location.
fn mend_unless(
    found: Surface,
    coordinates: Coordinates,
    check: impl Fn(&[[u32; 3]]) -> Result<(), Phrase>,
) -> Result<Surface, Phrase> {
    if check(&found.1).is_ok() {
        return Ok(found);
    }
    let mended = mend::mend(&found);
    if mended.1.is_empty() {
        return Err(phrase!("a mesh whose triangles have no area"));
    }
    match check(&mended.1) {
        Ok(()) => Ok(mended),
        Err(why) => Err(mend::place_flaw(why, &mended, coordinates.axes)),
    }
}

/// Returns unique vertices, in m along the patient's axes, and triangles.
fn surface(file: MeshFile<'_>, coordinates: Coordinates, allowed_m: &RangeInclusive<f64>) -> Result<Surface, Phrase> {
    let raw = file::parse(file.name, file.bytes)?;
    if raw.triangles.is_empty() {
        return Err(phrase!("a mesh without triangles"));
    }
    if raw.triangles.len() > MOST_TRIANGLES {
        return Err(phrase!("{count} triangles", count = raw.triangles.len()));
    }
    let per_m = if coordinates.in_mm { 1e3 } else { 1.0 };
    let turned = |corner: &[f32; 3]| coordinates.axes.to_patient(corner.map(|c| f64::from(c) / per_m));
    let corners: Vec<Point3<f64>> = raw.corners.iter().map(turned).collect();
    check_size(&corners, allowed_m)?;
    let (vertices_m, index) = merge(&corners);
    Ok((vertices_m, raw.triangles.iter().map(|t| t.map(|corner| index[corner])).collect()))
}

fn check_size(corners: &[Point3<f64>], allowed_m: &RangeInclusive<f64>) -> Result<(), Phrase> {
    if let Some(corner) = corners.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        return Err(phrase!("a vertex that is not finite (number {number})", number = corner + 1));
    }
    let extent = |axis: usize| {
        let (least, most) =
            corners.iter().map(|p| p[axis]).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), c| (a.min(c), b.max(c)));
        most - least
    };
    let size_m = (0..3).map(extent).fold(0.0, f64::max);
    if allowed_m.contains(&size_m) {
        Ok(())
    } else {
        Err(phrase!("a mesh of {size} mm; check its unit", size = (size_m * 1e6).round() / 1e3))
    }
}

/// Returns the unique vertices and the new index of each old one.
///
/// An STL file repeats a vertex in each of its triangles, and its reader treats −0 and 0 as
/// different; an OBJ file repeats the vertices along texture seams.
fn merge(corners: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<u32>) {
    let (mut unique, mut known) = (Vec::new(), BTreeMap::new());
    let index = corners
        .iter()
        .map(|p| {
            *known.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                unique.push(*p);
                (unique.len() - 1) as u32
            })
        })
        .collect();
    (unique, index)
}
