//! The patch of tissue that a needle moves: no wider and no deeper than its influence.

use crate::tissue::axisymmetric::{Axisymmetric, AxisymmetricError, MeshSpec};
use crate::tissue::{ElasticLayer, FieldModel, Load, Problem, Slab, relative_distance};

/// The first patch tried is this many footprints wide.
const NARROWEST: f64 = 10.0;

/// A patch is at most this many times doubled.
const DOUBLINGS: usize = 6;

/// Level of the graded meshes that compare patches: exact to a thousandth or so, below any tolerance of a patch.
const LEVEL: f64 = 6.0;

/// How far a needle's influence reaches, and what reaching farther would change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Radius beyond which the tissue may be held, in m.
    pub radius_m: f64,
    /// Relative change of the axial displacement over the sample radii when it is held twice as far away.
    pub relative_change: f64,
}

/// The nearest that tissue may be clamped, beside a load and below it, and change the axial displacement at its depth, over
/// radii in m, by no more than a tolerance; or the farthest tried.
///
/// A body has no side. Clamping one at R costs about as much as going from R to 2R brings, since the displacement beyond
/// falls at least with 1/R.
///
/// # Errors
/// When the layers or the load are out of range.
pub fn reach(
    layers: &[ElasticLayer],
    load: &Load,
    sample_r_m: &[f64],
    tolerance: f64,
) -> Result<Reach, AxisymmetricError> {
    let [from_m, to_m] = load.ends_m();
    let depth_m = 0.5 * (from_m + to_m);
    let answer = |radius_m: f64| -> Result<Vec<f64>, AxisymmetricError> {
        let slab = patch(layers, to_m, radius_m);
        let problem = Problem { slab, load: *load, sample_r_m: Vec::new(), sample_depth_m: vec![depth_m] };
        let model = Axisymmetric::new(&problem, &MeshSpec::graded(&problem, LEVEL))?;
        Ok(sample_r_m.iter().map(|&r_m| model.displacement_m(r_m, depth_m)[0]).collect())
    };
    let mut radius_m = NARROWEST * load.radius_m;
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
