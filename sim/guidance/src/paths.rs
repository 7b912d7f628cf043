//! Lengths of rays inside closed surfaces.
//!
//! Each triangle is projected onto the detector. At each pixel that it covers, the distance from the source is added where
//! the ray leaves the surface and subtracted where it enters. The sum is the length inside, in any order of triangles. An
//! edge is evaluated in the same direction for both of its triangles, so a pixel belongs to exactly one of them.

use std::fmt;

use anatomy::BodyMesh;
use nalgebra::{Point3, Vector3};

use crate::c_arm::{Detector, SOURCE_DETECTOR_M};

/// Least distance of a body from the source, in m.
const NEAREST_M: f64 = 0.05;

/// Length of each ray inside a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathImage {
    /// Pixels along an edge.
    pub pixels: usize,
    /// Lengths in m, by rows from the upper left.
    pub lengths_m: Vec<f64>,
}

/// A body that extends to the tube or to the detector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfReach {
    /// Distance of the vertex from the source along the central ray, in m.
    pub along_m: f64,
}

impl fmt::Display for OutOfReach {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = [NEAREST_M, SOURCE_DETECTOR_M].map(|m| m * 1e3);
        write!(
            out,
            "a part of the body {:.0} mm from the source; allowed: {least:.0} to {most:.0} mm",
            self.along_m * 1e3
        )
    }
}

impl std::error::Error for OutOfReach {}

/// Returns the length of each ray inside a closed surface whose triangles are counter-clockwise seen from outside.
///
/// # Errors
/// If a vertex is not between tube and detector.
pub fn project(detector: &Detector, mesh: &BodyMesh) -> Result<PathImage, OutOfReach> {
    let corners = project_vertices(detector, &mesh.vertices_m)?;
    let mut image = PathImage { pixels: detector.pixels, lengths_m: vec![0.0; detector.pixels * detector.pixels] };
    let raster = Raster { detector, scale: scale_columns(detector) };
    for triangle in &mesh.triangles {
        raster.add(triangle.map(|vertex| corners[vertex as usize]), &mut image.lengths_m);
    }
    Ok(image)
}

fn project_vertices(detector: &Detector, vertices_m: &[Point3<f64>]) -> Result<Vec<Vector3<f64>>, OutOfReach> {
    let corners: Vec<_> = vertices_m.iter().map(|vertex| detector.project(vertex)).collect();
    let allowed = NEAREST_M..=SOURCE_DETECTOR_M;
    match corners.iter().find(|corner| !allowed.contains(&corner.z)) {
        Some(corner) => Err(OutOfReach { along_m: corner.z }),
        None => Ok(corners),
    }
}

/// Squared distances of columns and rows from the middle, in units of the distance to the detector.
fn scale_columns(detector: &Detector) -> Vec<f64> {
    let middle = 0.5 * detector.pixels as f64;
    let off = |at: usize| (at as f64 + 0.5 - middle) * detector.pixel_m() / SOURCE_DETECTOR_M;
    (0..detector.pixels).map(|at| off(at) * off(at)).collect()
}

struct Raster<'d> {
    detector: &'d Detector,
    scale: Vec<f64>,
}

impl Raster<'_> {
    /// Adds the distances at which rays cross a triangle: corners as column, row and distance along the central ray.
    fn add(&self, corners: [Vector3<f64>; 3], lengths_m: &mut [f64]) {
        let [a, b, c] = corners;
        let twice_area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if twice_area == 0.0 {
            return;
        }
        // Rows count downwards: a triangle that faces the source turns to the left there.
        let sign = if twice_area > 0.0 { -1.0 } else { 1.0 };
        let edges = [Edge::new(&b, &c), Edge::new(&c, &a), Edge::new(&a, &b)];
        let inverse = corners.map(|corner| 1.0 / corner.z);
        let [columns, rows] = [0, 1].map(|axis| self.span(corners.map(|corner| corner[axis])));
        for row in rows {
            for column in columns.clone() {
                let place = [column as f64 + 0.5, row as f64 + 0.5];
                let sides = edges.map(|edge| edge.side(place));
                let covered = if twice_area > 0.0 {
                    sides.iter().all(|side| side.is_left())
                } else {
                    sides.iter().all(|side| !side.is_left())
                };
                if covered {
                    // 1 / distance is linear on the detector.
                    let total: f64 = sides.iter().map(|side| side.value).sum();
                    let over: f64 = sides.iter().zip(inverse).map(|(side, inverse)| side.value * inverse).sum();
                    let along_m = if over == 0.0 { a.z } else { total / over };
                    let slant = libm::sqrt(1.0 + self.scale[column] + self.scale[row]);
                    lengths_m[row * self.detector.pixels + column] += sign * along_m * slant;
                }
            }
        }
    }

    /// Pixels whose middles lie between the least and the greatest of three values.
    fn span(&self, values: [f64; 3]) -> std::ops::Range<usize> {
        let limit = |value: f64| libm::ceil(value - 0.5).clamp(0.0, self.detector.pixels as f64) as usize;
        let least = values.into_iter().fold(f64::INFINITY, f64::min);
        let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        limit(least)..limit(most + 1.0)
    }
}

/// An edge of a triangle, evaluated from its lesser end whichever triangle it belongs to.
#[derive(Clone, Copy)]
struct Edge {
    from: [f64; 2],
    along: [f64; 2],
    reversed: bool,
}

/// Position of a place relative to an edge.
#[derive(Clone, Copy)]
struct Side {
    /// Twice the area of the triangle of edge and place, with its sign in the direction of the triangle.
    value: f64,
    reversed: bool,
}

impl Side {
    /// Whether the place is on the left of the edge. A place on the edge counts as left of it in its lesser direction.
    fn is_left(self) -> bool {
        if self.reversed { self.value > 0.0 } else { self.value >= 0.0 }
    }
}

impl Edge {
    fn new(from: &Vector3<f64>, to: &Vector3<f64>) -> Self {
        let reversed = (from.x, from.y) > (to.x, to.y);
        let (low, high) = if reversed { (to, from) } else { (from, to) };
        Self { from: [low.x, low.y], along: [high.x - low.x, high.y - low.y], reversed }
    }

    fn side(self, [column, row]: [f64; 2]) -> Side {
        let value = self.along[0] * (row - self.from[1]) - self.along[1] * (column - self.from[0]);
        Side { value: if self.reversed { -value } else { value }, reversed: self.reversed }
    }
}
