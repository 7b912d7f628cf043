//! Checks that the skin lies over the origin, where needles enter.

use nalgebra::Point3;
use phrase::{Phrase, phrase};

/// Largest distance of the skin over the origin from the plane of the force law, in m.
const NEAR_M: f64 = 5e-3;

/// Checks that the highest surface over the origin is near the force law's plane and faces up.
///
/// # Errors
/// The distance, or that the surface faces down.
pub(super) fn check_over_origin(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), Phrase> {
    let crossings = triangles.iter().filter_map(|t| crossing(t.map(|v| &vertices[v as usize]), &Point3::origin()));
    match crossings.max_by(|(one, _), (other, _)| one.total_cmp(other)) {
        None => {
            let nearest_m = vertices.iter().map(|v| v.coords.norm()).fold(f64::INFINITY, f64::min);
            Err(phrase!(
                "a skin that is not over the origin (its nearest vertex is {away} mm away); check position_mm and axes",
                away = Phrase::number(nearest_m * 1e3, 1)
            ))
        }
        Some((height_m, _)) if height_m.abs() > NEAR_M => {
            let height = Phrase::number(height_m * 1e3, 1);
            Err(phrase!("a skin at z = {height} mm over the origin; check position_mm and axes", height = height))
        }
        Some((_, false)) => Err(phrase!(
            "a skin that is inside out over the origin: its triangles run clockwise seen from outside; check axes"
        )),
        Some((_, true)) => Ok(()),
    }
}

/// Returns the height in m at which a line along z through `place` crosses a triangle, and whether
/// the triangle faces up.
pub(crate) fn crossing([a, b, c]: [&Point3<f64>; 3], place: &Point3<f64>) -> Option<(f64, bool)> {
    // Barycentric coordinates: twice the area, seen from above, of `place` with the edge opposite
    // each vertex.
    let twice =
        |p: &Point3<f64>, q: &Point3<f64>| (p.x - place.x) * (q.y - place.y) - (p.y - place.y) * (q.x - place.x);
    let weights = [twice(b, c), twice(c, a), twice(a, b)];
    let whole: f64 = weights.iter().sum();
    let is_inside = weights.iter().all(|w| *w >= 0.0) || weights.iter().all(|w| *w <= 0.0);
    let height = || (weights[0] * a.z + weights[1] * b.z + weights[2] * c.z) / whole;
    (is_inside && whole != 0.0).then(|| (height(), whole > 0.0))
}
