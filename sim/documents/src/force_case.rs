//! The JSON of `stylet force`: layers at their effective values, in SI.

use law::axial::{AxialParams, AxialSpec, Breakaway, ForceLaw, Layer, LayerOptions, ParamError, RateDependence};
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::error::DocumentError;
use crate::json::Json;

/// Largest angle of a path to the surface normal, in rad (60°, plus rounding).
const STEEPEST_RAD: f64 = std::f64::consts::FRAC_PI_3 + 1e-9;

/// A parsed case.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceCase {
    /// The axial law.
    pub spec: AxialSpec,
    /// Angle to the surface normal, in rad.
    pub angle_rad: f64,
    /// Direction of the needle's edge in the plane of the skin, in rad from the patient's x towards
    /// y.
    pub edge_rad: f64,
}

/// The file's structure. `name`, `note` and `units` are for readers and are ignored.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCase {
    #[serde(rename = "name")]
    _name: Option<IgnoredAny>,
    #[serde(rename = "note")]
    _note: Option<IgnoredAny>,
    #[serde(rename = "units")]
    _units: Option<IgnoredAny>,
    tip_to_rim_m: f64,
    presliding_stiffness_n_per_m: f64,
    #[serde(default)]
    angle_rad: f64,
    #[serde(default)]
    edge_rad: f64,
    #[serde(default)]
    law: ForceLaw,
    #[serde(default)]
    speed_window_s: f64,
    #[serde(default)]
    damping_time_s: f64,
    rate: Option<RawCaseRate>,
    breakaway: Option<Breakaway>,
    layers: Vec<RawLayer>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCaseRate {
    p_infinity_n: f64,
    v0_m_per_s: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLayer {
    name: String,
    thickness_m: f64,
    stiffness_n_per_m: f64,
    damping_n_s_per_m2: f64,
    tip_rupture_n: f64,
    rim_rupture_n: f64,
    friction_n_per_m: f64,
    cutting_n: f64,
    #[serde(default)]
    options: LayerOptions,
}

/// Parses `SCENE.json`.
///
/// # Errors
/// The first issue found, with line and column.
pub fn parse(file: &str, json: &str) -> Result<ForceCase, DocumentError> {
    let json = Json { file, text: json };
    let raw: RawCase = json.read("reference/force/*.json")?;
    let (angle_rad, edge_rad, spec) = (raw.angle_rad, raw.edge_rad, raw.spec());
    if !(0.0..=STEEPEST_RAD).contains(&angle_rad) {
        let allowed = "allowed: 0 to 1.0472 rad (60°)";
        return Err(json.refused(ParamError { field: "angle_rad".to_owned(), value: angle_rad, unit: "rad", allowed }));
    }
    if !edge_rad.is_finite() {
        let allowed = "allowed: a finite number";
        return Err(json.refused(ParamError { field: "edge_rad".to_owned(), value: edge_rad, unit: "rad", allowed }));
    }
    AxialParams::new(spec.clone()).map_err(|error| json.refused(error))?;
    Ok(ForceCase { spec, angle_rad, edge_rad })
}

impl RawCase {
    fn spec(self) -> AxialSpec {
        let rate = self.rate.map(|r| RateDependence { p_infinity_n: r.p_infinity_n, v0_m_per_s: r.v0_m_per_s });
        AxialSpec {
            law: self.law,
            layers: self.layers.into_iter().map(layer).collect(),
            tip_to_rim_m: self.tip_to_rim_m,
            presliding_stiffness_n_per_m: self.presliding_stiffness_n_per_m,
            speed_window_s: self.speed_window_s,
            damping_time_s: self.damping_time_s,
            rate,
            breakaway: self.breakaway,
        }
    }
}

fn layer(raw: RawLayer) -> Layer {
    Layer {
        name: raw.name,
        thickness_m: raw.thickness_m,
        stiffness_n_per_m: raw.stiffness_n_per_m,
        damping_n_s_per_m2: raw.damping_n_s_per_m2,
        tip_rupture_n: raw.tip_rupture_n,
        rim_rupture_n: raw.rim_rupture_n,
        friction_n_per_m: raw.friction_n_per_m,
        cutting_n: raw.cutting_n,
        options: raw.options,
    }
}
