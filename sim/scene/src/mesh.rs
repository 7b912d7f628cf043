//! A closed triangle mesh from an STL file.

use std::collections::BTreeMap;
use std::io::Cursor;

use mechanics::structures::Shape;
use nalgebra::Point3;

/// What a mesh must be, in words.
pub(crate) const ALLOWED: &str =
    "allowed: a binary or text STL file, closed, of 0.1 mm to 1 m, at most 200000 triangles";

const MOST_TRIANGLES: usize = 200_000;
const SMALLEST_M: f64 = 1e-4;
const LARGEST_M: f64 = 1.0;

/// A mesh from the bytes of an STL file whose coordinates are in mm, or else in m.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn read(bytes: &[u8], in_mm: bool) -> Result<Shape, String> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| format!("unreadable as STL ({e})"))?;
    if mesh.faces.is_empty() {
        return Err("a mesh without triangles".to_owned());
    }
    if mesh.faces.len() > MOST_TRIANGLES {
        return Err(format!("{} triangles", mesh.faces.len()));
    }
    let metres = if in_mm { 1e3 } else { 1.0 };
    let corners: Vec<Point3<f64>> =
        mesh.vertices.iter().map(|v| Point3::from(v.0.map(|c| f64::from(c) / metres))).collect();
    check_size(&corners)?;
    let (vertices_m, index) = merge(&corners);
    let triangles: Vec<[u32; 3]> = mesh.faces.iter().map(|f| f.vertices.map(|v| index[v])).collect();
    check_closed(&triangles)?;
    if volume_m3(&vertices_m, &triangles) <= 0.0 {
        return Err("a mesh that is inside out: its triangles run clockwise seen from outside".to_owned());
    }
    Ok(Shape::Mesh { vertices_m, triangles })
}

fn check_size(corners: &[Point3<f64>]) -> Result<(), String> {
    if corners.iter().any(|p| p.iter().any(|c| !c.is_finite())) {
        return Err("a vertex that is not finite".to_owned());
    }
    let extent = |axis: usize| {
        let (least, most) =
            corners.iter().map(|p| p[axis]).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), c| (a.min(c), b.max(c)));
        most - least
    };
    let size = (0..3).map(extent).fold(0.0, f64::max);
    if (SMALLEST_M..=LARGEST_M).contains(&size) {
        Ok(())
    } else {
        Err(format!("a mesh of {} mm; is its unit right?", size * 1e3))
    }
}

/// Vertices without repetition, and the new index of each old one.
///
/// The STL reader tells vertices apart by their bits, and so takes −0 and 0 for two.
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

/// Closed and of one orientation: each edge is walked exactly once in each direction.
fn check_closed(triangles: &[[u32; 3]]) -> Result<(), String> {
    let mut edges: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for [a, b, c] in triangles.iter().copied() {
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    let open = edges.iter().filter(|&(&(a, b), &n)| n != 1 || edges.get(&(b, a)) != Some(&1)).count();
    if open == 0 { Ok(()) } else { Err(format!("a mesh that is not closed ({open} open or repeated edges)")) }
}

/// Volume by the divergence theorem, in m³; positive when triangles run counter-clockwise seen from outside.
fn volume_m3(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    let corner = |v: u32| vertices[v as usize].coords;
    triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0).sum()
}
