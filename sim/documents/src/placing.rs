//! Checks that structures lie in the body, and that the skin agrees with that of the force law.

use law::Skin;
use law::structures::StructureSpec;
use nalgebra::{Point3, Vector3};
use phrase::{Phrase, phrase};

use crate::error::Remark;
use crate::mesh::crossing;
use crate::model::{Scene, SceneSkin};

/// Distance by which a structure may extend out of the body, in m: where the image ends, mesh and
/// skin are closed and smoothed independently.
const OUT_M: f64 = 2e-3;
/// Number of vertices of a structure that are checked.
const CORNERS: usize = 400;
/// Radius around the entry within which the picture's skin must agree with that of the force law,
/// in m.
const FLAT_M: f64 = 16e-3;
/// Cosine of the largest inclination of the skin there: 12°, which makes a layer 2 % thicker along
/// z. Our choice.
const LEAST_COSINE: f64 = 0.978_147_600_733_805_6;

/// Returns a remark for each misplaced structure and for a misplaced skin.
pub(crate) fn list_misplaced(scene: &Scene) -> Vec<Remark> {
    let (skin, shape) = (scene.skin.as_ref(), &scene.skin_shape);
    let outside = scene.structures.iter().enumerate().filter_map(|(at, structure)| {
        let (out_m, corner) = farthest_out(&structure.spec, &|place| out_m(place, skin, shape))?;
        let [x, y, z] = [corner.x, corner.y, corner.z].map(|m| Phrase::number(m * 1e3, 1));
        Some(Remark {
            field: format!("structure[{at}].position_mm"),
            found: phrase!(
                "\"{name}\" protrudes {out} mm from the body at ({x}, {y}, {z}) mm",
                name = structure.spec.name.as_str(),
                out = Phrase::number(out_m * 1e3, 1),
                x = x,
                y = y,
                z = z
            ),
            allowed: phrase!(
                "allowed: at most 2 mm outside the skin; +z points out of the body, so z is negative inside"
            ),
        })
    });
    outside.chain(skin.and_then(remark_steep)).collect()
}

/// Returns how far a structure extends out of the body, in m, and the vertex; `None` within the
/// tolerance.
fn farthest_out(structure: &StructureSpec, out_m: &dyn Fn(&Point3<f64>) -> f64) -> Option<(f64, Point3<f64>)> {
    let (corners, _) = structure.surface();
    let step = corners.len().div_ceil(CORNERS).max(1);
    let highest = corners.iter().max_by(|one, other| one.z.total_cmp(&other.z));
    let some = corners.iter().step_by(step).chain(highest);
    let outs = some.map(|corner| (out_m(corner), *corner)).filter(|(out_m, _)| *out_m > OUT_M);
    outs.max_by(|one, other| one.0.total_cmp(&other.0))
}

/// Returns the distance of a point from the body, in m; 0 inside. Where there is no skin above or
/// below the point, the body ends at the skin of the force law.
fn out_m(place: &Point3<f64>, skin: Option<&SceneSkin>, shape: &Skin) -> f64 {
    let above_m = shape.height_m(place).max(0.0);
    let Some(skin) = skin else { return above_m };
    // Shift the point slightly, so that the line through it does not run along an edge, which
    // belongs to two triangles.
    let aside = place + Vector3::new(1.3e-9, 0.7e-9, 0.0);
    let heights: Vec<f64> =
        triangles(skin).filter_map(|corners| crossing(corners, &aside)).map(|(height, _)| height).collect();
    let above = heights.iter().filter(|height| **height > place.z).count();
    match (heights.is_empty(), above % 2) {
        (true, _) => above_m,
        (_, 1) => 0.0,
        _ => nearest_m(skin, place),
    }
}

fn triangles(skin: &SceneSkin) -> impl Iterator<Item = [&Point3<f64>; 3]> {
    skin.triangles.iter().map(|triangle| triangle.map(|v| &skin.vertices_m[v as usize]))
}

/// Returns the distance to the nearest vertex or centroid of the skin's triangles, in m.
fn nearest_m(skin: &SceneSkin, place: &Point3<f64>) -> f64 {
    let of = |[a, b, c]: [&Point3<f64>; 3]| {
        let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        [*a, *b, *c, middle].iter().map(|point| (point - place).norm_squared()).fold(f64::INFINITY, f64::min)
    };
    libm::sqrt(triangles(skin).map(of).fold(f64::INFINITY, f64::min))
}

/// Returns a remark if the skin's mean normal around the entry deviates too far from z.
fn remark_steep(skin: &SceneSkin) -> Option<Remark> {
    let mut sum = Vector3::zeros();
    let mut over = Vector3::zeros();
    for [a, b, c] in triangles(skin) {
        let middle = (a.coords + b.coords + c.coords) / 3.0;
        let area = (b - a).cross(&(c - a));
        if middle.norm() <= FLAT_M {
            sum += area;
        }
        // A skin of large triangles may have no centroid near the entry: use the triangle over the
        // entry.
        if crossing([a, b, c], &Point3::origin()).is_some_and(|(height, _)| height.abs() <= FLAT_M) {
            over = area;
        }
    }
    let normal = sum.try_normalize(0.0).or_else(|| over.try_normalize(0.0))?;
    (normal.z < LEAST_COSINE).then(|| Remark {
        field: "skin.file".to_owned(),
        found: phrase!(
            "a skin inclined by {angle}° at the entry",
            angle = Phrase::number(libm::acos(normal.z.clamp(-1.0, 1.0)).to_degrees(), 0)
        ),
        allowed: phrase!(
            "allowed: at most 12°, because the force law treats the skin as the plane z = 0; rotate the meshes, or \
             choose another entry"
        ),
    })
}
