//! The JSON of `stylet field`: a slab of layers, a load at given depths, and the sample points, in
//! SI.

use law::axial::ParamError;
use serde::Deserialize;
use serde::de::IgnoredAny;
use tissue::{ElasticLayer, Load, LoadKind, Problem, Slab};

use crate::error::DocumentError;
use crate::json::Json;

/// Depths closer than this are the same, in m: boundaries are running sums and may differ from the
/// written digits by rounding.
const SAME_DEPTH_M: f64 = 1e-9;

/// Density of a layer whose case gives none, in kg/m³. Static results do not depend on it.
const DENSITY_KG_PER_M3: f64 = 1050.0;

/// A parsed case.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldCase {
    /// Magnitude of the load, in N; positive pushes into the body.
    pub force_n: f64,
    /// Depths of the load, in m.
    pub load_depths_m: Vec<f64>,
    /// One problem for each load depth, with a load of 1 N.
    pub problems: Vec<Problem>,
}

/// The file's structure. Text fields are for readers and are ignored.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFieldCase {
    #[serde(rename = "name")]
    _name: Option<IgnoredAny>,
    #[serde(rename = "note")]
    _note: Option<IgnoredAny>,
    #[serde(rename = "units")]
    _units: Option<IgnoredAny>,
    #[serde(rename = "boundary")]
    _boundary: Option<IgnoredAny>,
    #[serde(rename = "load")]
    _load: Option<IgnoredAny>,
    layers: Vec<RawElasticLayer>,
    radius_m: f64,
    load_radius_m: f64,
    force_n: f64,
    load_depths_m: Option<Vec<f64>>,
    sample_r_m: Vec<f64>,
    sample_depth_m: Vec<f64>,
    #[serde(default)]
    solutions: Vec<RawSolution>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawElasticLayer {
    #[serde(rename = "name")]
    _name: Option<IgnoredAny>,
    thickness_m: f64,
    youngs_modulus_pa: f64,
    poisson_ratio: f64,
    #[serde(default = "default_density")]
    density_kg_per_m3: f64,
}

fn default_density() -> f64 {
    DENSITY_KG_PER_M3
}

/// Only the depth of a stored solution is read; its result is not used.
#[derive(Deserialize)]
struct RawSolution {
    depth_m: f64,
}

/// Parses `CASE.json`.
///
/// # Errors
/// The first issue found, with line and column.
pub fn parse(file: &str, json: &str) -> Result<FieldCase, DocumentError> {
    let json = Json { file, text: json };
    json.read::<RawFieldCase>("reference/field/*.json")?.into_case().map_err(|error| json.refused(error))
}

impl RawFieldCase {
    fn into_case(self) -> Result<FieldCase, ParamError> {
        let refused =
            |field: &str, value, unit, allowed| Err(ParamError { field: field.to_owned(), value, unit, allowed });
        let depths = self.load_depths_m.unwrap_or_else(|| self.solutions.iter().map(|s| s.depth_m).collect());
        if depths.is_empty() {
            return refused("load_depths_m", 0.0, "depths", "must hold at least one, or solutions must");
        }
        if self.sample_r_m.is_empty() || self.sample_depth_m.is_empty() {
            return refused("sample_r_m", 0.0, "samples", "sample_r_m and sample_depth_m must hold at least one each");
        }
        if !(-1e6..=1e6).contains(&self.force_n) {
            return refused("force_n", self.force_n, "N", "must be a number from -1e6 to 1e6");
        }
        let slab = Slab { layers: self.layers.into_iter().map(layer).collect(), radius_m: self.radius_m };
        slab.check()?;
        let boundaries = slab.boundaries_m();
        let snapped = |depths: &[f64]| depths.iter().map(|&depth| snap(depth, &boundaries)).collect::<Vec<_>>();
        let sample_depth_m = snapped(&self.sample_depth_m);
        let problem = |depth_m: f64| Problem {
            slab: slab.solid(),
            load: Load { kind: LoadKind::Contactor { depth_m }, radius_m: self.load_radius_m },
            sample_r_m: self.sample_r_m.clone(),
            sample_depth_m: sample_depth_m.clone(),
        };
        let problems: Vec<Problem> = snapped(&depths).into_iter().map(problem).collect();
        problems.iter().try_for_each(Problem::check)?;
        Ok(FieldCase { force_n: self.force_n, load_depths_m: depths, problems })
    }
}

fn layer(raw: RawElasticLayer) -> ElasticLayer {
    ElasticLayer {
        thickness_m: raw.thickness_m,
        youngs_modulus_pa: raw.youngs_modulus_pa,
        poisson_ratio: raw.poisson_ratio,
        density_kg_per_m3: raw.density_kg_per_m3,
    }
}

/// Returns the boundary at a depth, or the depth itself without one.
fn snap(depth_m: f64, boundaries_m: &[f64]) -> f64 {
    boundaries_m.iter().copied().find(|b| (b - depth_m).abs() <= SAME_DEPTH_M).unwrap_or(depth_m)
}
