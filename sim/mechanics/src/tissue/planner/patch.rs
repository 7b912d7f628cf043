//! The patch of tissue that a needle moves: no wider and no deeper than its influence.

use crate::tissue::axisymmetric::{Axisymmetric, AxisymmetricError, MeshSpec, Oblique};
use crate::tissue::volumetric::Problem3;
use crate::tissue::{ElasticLayer, FieldModel, Slab, relative_distance};

/// The first patch tried is this many footprints wide.
const NARROWEST: f64 = 10.0;

/// A patch is at most this many times doubled.
const DOUBLINGS: usize = 6;

/// Level of the graded meshes that compare patches: exact to a thousandth or so, below any tolerance of a patch.
const LEVEL: f64 = 6.0;

/// Stations of a drag that leans in each strip of such a mesh.
const STATIONS: usize = 3;

/// How far a needle's influence reaches, and what reaching farther would change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Radius beyond which the tissue may be held, in m.
    pub radius_m: f64,
    /// Relative change of the axial displacement over the sample radii when it is held twice as far away.
    pub relative_change: f64,
}

/// The nearest that tissue may be clamped, beside a load and below it, and change the displacement along the needle at the load's
/// depth, at the question's radii, by no more than a tolerance; or the farthest tried. The layers are the question's, flat,
/// and its slab's radius and sample depths do not count.
///
/// A body has no side. Clamping one at R costs about as much as going from R to 2R brings, since the displacement beyond
/// falls at least with 1/R.
///
/// # Errors
/// When the layers or the load are out of range.
pub fn reach(question: &Problem3, tolerance: f64) -> Result<Reach, AxisymmetricError> {
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

/// Displacement along the needle at the load's depth, at the question's radii, in m, of tissue that is clamped at a radius in m.
fn answer_m(question: &Problem3, radius_m: f64) -> Result<Vec<f64>, AxisymmetricError> {
    let [from_m, to_m] = question.flat.load.ends_m();
    let depth_m = 0.5 * (from_m + to_m);
    let mut near = question.clone();
    near.flat.slab = patch(&question.flat.slab.layers, to_m, radius_m);
    // Where the answer is wanted may lie beyond a narrow patch, which then answers that nothing moves there.
    (near.flat.sample_r_m, near.flat.sample_depth_m) = (Vec::new(), Vec::new());
    let mesh = MeshSpec::graded(&near.flat, LEVEL);
    let model: Box<dyn FieldModel> = match near.tilt_rad {
        0.0 => Box::new(Axisymmetric::new(&near.flat, &mesh)?),
        _ => Box::new(Oblique::new(&near, &mesh, STATIONS)?),
    };
    let radii_m = question.flat.sample_r_m.iter();
    Ok(radii_m.map(|&r_m| near.along_needle_m(model.as_ref(), r_m, depth_m)).collect())
}

/// The tissue within a radius of loads that go down to a depth, both in m: no layer below that, the last one cut there.
#[must_use]
pub fn patch(layers: &[ElasticLayer], deepest_m: f64, radius_m: f64) -> Slab {
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
