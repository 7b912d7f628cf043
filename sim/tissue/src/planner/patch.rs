//! The patch of tissue that a needle moves: no wider and no deeper than its influence.

use crate::axisymmetric::{AxisymmetricError, MeshSpec, each_along_needle_m};
use crate::volumetric::Problem3;
use crate::{ElasticLayer, Load, Slab, relative_distance};

/// Radius of the first patch tried, in footprints.
const NARROWEST: f64 = 10.0;

/// Maximum number of times that a patch is doubled.
const DOUBLINGS: usize = 6;

/// Level of the graded meshes that compare patches: accurate to about a thousandth, below any
/// tolerance of a patch.
const LEVEL: f64 = 6.0;

/// Stations of an inclined drag in each strip of such a mesh.
const STATIONS: usize = 3;

/// Reach of a needle's influence, and the change that a larger reach would make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Radius beyond which the tissue may be clamped, in m.
    pub radius_m: f64,
    /// Relative change of the axial displacement over the sample radii when the clamp is twice as
    /// far away.
    pub relative_change: f64,
}

/// The smallest radius at which the tissue may be clamped, around a load and below it, without
/// changing the displacement along the needle at the load's depth, at the question's radii, by more
/// than a tolerance; or the largest tried. The layers are those of the question, flat; its slab's
/// radius and sample depths are ignored.
///
/// A body has no side. The error of a clamp at R is about the change from R to 2R, since the
/// displacement beyond falls at least with 1/R.
///
/// # Errors
/// If the layers or the load are out of range.
pub fn find_reach(question: &Problem3, tolerance: f64) -> Result<Reach, AxisymmetricError> {
    let answer = |radius_m: f64| answer_m(question, radius_m);
    let mut radius_m = NARROWEST * question.flat.load.radius_m;
    let (mut narrow, mut relative_change) = (answer(radius_m)?, f64::INFINITY);
    for _ in 0..DOUBLINGS {
        let wide = answer(2.0 * radius_m)?;
        relative_change = relative_distance(&narrow, &wide);
        if relative_change <= tolerance {
            break;
        }
        (radius_m, narrow) = (2.0 * radius_m, wide);
    }
    Ok(Reach { radius_m, relative_change })
}

/// The narrowest patch down to a depth, in m, that is accurate enough for several loads of one
/// needle: under each of them the displacement along the needle at the question's radii and depths
/// differs from that on the whole body, in m/N, by no more than a tolerance. At most as wide as the
/// body. The question's own load is a drag over all of them. Returns its radius, in m.
///
/// # Errors
/// If the layers or a load are out of range.
pub fn reach_of_all(
    question: &Problem3,
    on_body_m: &[(Load, Vec<f64>)],
    deepest_m: f64,
    tolerance: f64,
) -> Result<f64, AxisymmetricError> {
    let (body_m, mut radius_m) = (question.flat.slab.radius_m, NARROWEST * question.flat.load.radius_m);
    let loads: Vec<Load> = on_body_m.iter().map(|(load, _)| *load).collect();
    while radius_m < body_m {
        let slab = cut_patch(&question.flat.slab.layers, deepest_m, radius_m);
        let on_patch_m = on_patch_m(question, &loads, slab, &question.flat.sample_depth_m)?;
        let mut pairs = on_patch_m.iter().zip(on_body_m);
        if pairs.all(|(on_patch_m, (_, on_body_m))| relative_distance(on_patch_m, on_body_m) <= tolerance) {
            break;
        }
        radius_m *= 2.0;
    }
    Ok(radius_m.min(body_m))
}

/// Displacement along the needle at the load's depth, at the question's radii, in m, in tissue
/// clamped at a radius in m.
fn answer_m(question: &Problem3, radius_m: f64) -> Result<Vec<f64>, AxisymmetricError> {
    let [from_m, to_m] = question.flat.load.ends_m();
    let slab = cut_patch(&question.flat.slab.layers, to_m, radius_m);
    let answers_m = on_patch_m(question, &[question.flat.load], slab, &[0.5 * (from_m + to_m)])?;
    Ok(answers_m.concat())
}

/// Displacement along the needle at some depths, at the question's radii, in m, in a patch of its
/// tissue, under each load.
fn on_patch_m(
    question: &Problem3,
    loads: &[Load],
    slab: Slab,
    depths_m: &[f64],
) -> Result<Vec<Vec<f64>>, AxisymmetricError> {
    let mut near = question.clone();
    near.flat.slab = slab;
    near.flat.sample_depth_m = depths_m.to_vec();
    let mesh = MeshSpec::graded(&near.flat, LEVEL);
    each_along_needle_m(&near, loads, &mesh, STATIONS)
}

/// The tissue within a radius of loads down to a depth, both in m: layers below that are removed,
/// the last one is cut there.
#[must_use]
pub fn cut_patch(layers: &[ElasticLayer], deepest_m: f64, radius_m: f64) -> Slab {
    let mut left_m = deepest_m + radius_m;
    let mut kept = Vec::new();
    for layer in layers.iter().filter(|layer| layer.thickness_m > 0.0) {
        if left_m <= 0.0 {
            break;
        }
        kept.push(ElasticLayer { thickness_m: layer.thickness_m.min(left_m), ..*layer });
        left_m -= layer.thickness_m;
    }
    Slab { layers: kept, radius_m }
}
