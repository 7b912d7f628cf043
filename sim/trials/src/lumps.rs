//! Tissue without axial symmetry: curved skins and inclusions, with reference solutions on a mesh
//! far finer than any that the planner selects.

use law::{Judging, Skin};
use nalgebra::{Point3, Vector3};
use tissue::follow::{Field, TissueSpec, recoil_time_s};
use tissue::planner::cut_patch;
use tissue::volumetric::{
    Grading, Inclusion, InclusionShape, Material, MeshSpec3, Problem3, Volumetric, VolumetricError,
};
use tissue::{ElasticLayer, FieldModel, Load, LoadKind, Problem, Slab, relative_distance};

/// Extent of a reference, in m; limited to this many radii of the skin, and to this fraction of a
/// radius in depth.
const REACH_M: f64 = 0.08;
const REACH: f64 = 1.2;
const DEEPEST: f64 = 0.9;

/// The lower back of physics section 4 in the middle of a body, under a needle of 2 mm inclined by
/// an angle in degrees towards +x.
#[must_use]
pub fn lower_back_with(tilt_deg: f64, skin: Skin, inclusions: &[Inclusion]) -> TissueSpec {
    let layer = |thickness_m, youngs_modulus_pa, density_kg_per_m3| ElasticLayer {
        thickness_m,
        youngs_modulus_pa,
        poisson_ratio: 0.45,
        density_kg_per_m3,
    };
    let layers = vec![layer(0.8e-3, 132e3, 1090.0), layer(8.4e-3, 33.1e3, 950.0), layer(39e-3, 198e3, 1050.0)];
    let recoil_time_s = layers.iter().map(|layer| recoil_time_s(layer, 1e-3)).collect();
    let slab = Slab { layers, radius_m: 0.25 };
    TissueSpec {
        boundaries_m: slab.boundaries_m(),
        slab,
        load_radius_m: 1e-3,
        tilt_rad: tilt_deg.to_radians(),
        skin,
        inclusions: inclusions.to_vec(),
        model: None,
        tolerance: 0.05,
        judging: Judging::default(),
        coupled: false,
        recoil_time_s,
    }
}

/// Creates a spherical inclusion with a radius in mm and a modulus in kPa, centred at a point in
/// mm.
#[must_use]
pub fn make_ball(centre_mm: [f64; 3], radius_mm: f64, modulus_kpa: f64) -> Inclusion {
    let centre_m = Point3::from(centre_mm.map(|mm| mm * 1e-3));
    let shape = InclusionShape::Sphere { centre_m, radius_m: radius_mm * 1e-3 };
    let material = Material { youngs_modulus_pa: modulus_kpa * 1e3, poisson_ratio: 0.45, density_kg_per_m3: 1000.0 };
    Inclusion { shape, material }
}

/// Returns the displacement of every boundary along the needle under 1 N at one of them, in m,
/// computed with hexahedra of order 3, of size `near_m` near the load, on a mesh built for that
/// load.
///
/// # Errors
/// If the tissue cannot be meshed.
pub fn push_in_three_dimensions_m(tissue: &TissueSpec, push: usize, near_m: f64) -> Result<Vec<f64>, VolumetricError> {
    let depth_m = tissue.boundaries_m[push];
    let bend_m = tissue.skin.radius_m().unwrap_or(f64::INFINITY);
    let slab = cut_patch(&tissue.slab.layers, depth_m, REACH_M.min(DEEPEST * bend_m - depth_m));
    let radius_m = REACH_M.min(REACH * bend_m);
    let load = Load { kind: LoadKind::Contactor { depth_m }, radius_m: tissue.load_radius_m };
    let flat = Problem { slab: Slab { radius_m, ..slab }, load, sample_r_m: Vec::new(), sample_depth_m: Vec::new() };
    let inclusions = tissue.inclusions.clone();
    let problem = Problem3 { tilt_rad: tissue.tilt_rad, skin: tissue.skin, inclusions, ..Problem3::flat(&flat) };
    let grading = Grading { near_m, growth: 0.55 };
    let symmetry = problem.symmetry();
    let mesh = MeshSpec3 { symmetry, order: 3, around: 1, across: grading, along: grading, reach_m: radius_m };
    let mut model = Volumetric::new(&problem, &mesh)?;
    model.solve(1.0);
    let inwards = Vector3::new(libm::sin(tissue.tilt_rad), 0.0, -libm::cos(tissue.tilt_rad));
    let boundaries_m = tissue.boundaries_m.iter().take(tissue.layers());
    Ok(boundaries_m.map(|at_m| model.displacement_at(&problem.on_needle(*at_m)).dot(&inwards)).collect())
}

/// Returns the same for a load at each boundary.
///
/// # Errors
/// As [`push_in_three_dimensions_m`].
pub fn push_everywhere_m(tissue: &TissueSpec, near_m: f64) -> Result<Vec<Vec<f64>>, VolumetricError> {
    (0..tissue.layers()).map(|push| push_in_three_dimensions_m(tissue, push, near_m)).collect()
}

/// Returns the error of a field relative to that reference, for the load with the largest error.
#[must_use]
pub fn worst_push_error(field: &Field, wanted_m: &[Vec<f64>]) -> f64 {
    let error = |(push, wanted_m): (usize, &Vec<f64>)| {
        let found: Vec<f64> = (0..wanted_m.len()).map(|at| field.planned().of_m_per_n(at, push)).collect();
        relative_distance(&found, wanted_m)
    };
    wanted_m.iter().enumerate().map(error).fold(0.0, f64::max)
}
