//! The parameters of the axial law, and their checks.

use serde::{Deserialize, Serialize};

use super::options::{Breakaway, LayerOptions, check_options};

/// Maximum number of layers: keeps a step bounded.
pub const MAX_LAYERS: usize = 64;

/// Maximum window of the speed measurement, in s.
const LONGEST_SPEED_WINDOW_S: f64 = 0.05;

/// Maximum time of the damping's spring and dashpot, in s.
const LONGEST_DAMPING_TIME_S: f64 = 0.05;

/// One tissue layer for the force law, already scaled for the needle and the tissue.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// Name shown to users, for example `skin`.
    pub name: String,
    /// Thickness along the surface normal, in m. May be 0 for a fascia.
    pub thickness_m: f64,
    /// Stiffness of the layer's proximal boundary, in N/m.
    pub stiffness_n_per_m: f64,
    /// Damping per inserted length, in N·s/m².
    pub damping_n_s_per_m2: f64,
    /// Force at which the stylet tip opens the boundary, in N.
    pub tip_rupture_n: f64,
    /// Force at which the cannula rim opens the boundary, in N. Unused by a single contactor.
    pub rim_rupture_n: f64,
    /// Coulomb friction cap per inserted length, in N/m.
    pub friction_n_per_m: f64,
    /// Cutting force, in N, while the tip advances into new material.
    pub cutting_n: f64,
    /// Options of version 3 of the law.
    #[serde(default, skip_serializing_if = "LayerOptions::is_empty")]
    pub options: LayerOptions,
}

/// Rate dependence of the rupture thresholds: P(v) = P∞ + (P0 − P∞)/(1 + |v|/v0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RateDependence {
    /// P∞, the limit of every threshold at high speed, in N.
    pub p_infinity_n: f64,
    /// Speed at half of the change, in m/s.
    pub v0_m_per_s: f64,
}

/// Version of the law for which a scene was made. A recording is re-simulated with the version that
/// its scene names, so an old version is never edited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "u32", into = "u32")]
pub enum ForceLaw {
    /// Cutting acts in the ticks that advance into new material. On an encoder, where most ticks
    /// bring no new position, it rattles.
    Version1,
    /// Cutting is a one-sided presliding spring behind a front dragged by the advance, and speed is
    /// measured over a window.
    #[default]
    Version2,
    /// Version 2 with the options of [`LayerOptions`] and [`Breakaway`]. Without them it is
    /// bit-identical to version 2.
    Version3,
    /// Version 3 with impenetrable bone: the tip slides on its surface. Without bone it is
    /// bit-identical to version 3.
    Version4,
    /// Version 4 with damping by a spring and a dashpot, whose force does not lag behind the
    /// motion. With a time of 0 and without a window it is bit-identical to version 4.
    Version5,
}

/// An unknown version number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("law = {0}; allowed: 1 to 5")]
pub struct UnknownForceLaw(pub u32);

impl TryFrom<u32> for ForceLaw {
    type Error = UnknownForceLaw;

    fn try_from(number: u32) -> Result<Self, UnknownForceLaw> {
        match number {
            1 => Ok(Self::Version1),
            2 => Ok(Self::Version2),
            3 => Ok(Self::Version3),
            4 => Ok(Self::Version4),
            5 => Ok(Self::Version5),
            other => Err(UnknownForceLaw(other)),
        }
    }
}

impl From<ForceLaw> for u32 {
    fn from(law: ForceLaw) -> Self {
        match law {
            ForceLaw::Version1 => 1,
            ForceLaw::Version2 => 2,
            ForceLaw::Version3 => 3,
            ForceLaw::Version4 => 4,
            ForceLaw::Version5 => 5,
        }
    }
}

/// Specification of [`AxialParams`], unchecked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxialSpec {
    /// Version of the law.
    #[serde(default)]
    pub law: ForceLaw,
    /// Layers from the surface down.
    pub layers: Vec<Layer>,
    /// Distance from the stylet tip to the cannula rim, in m; 0 for a single contactor.
    pub tip_to_rim_m: f64,
    /// Stiffness of friction and, from version 2, of cutting before they slide, in N/m.
    pub presliding_stiffness_n_per_m: f64,
    /// Window of the speed measurement, in s, 0 to 0.05: from the newest earlier sample at least
    /// this old; 0 uses the last two samples. Version 1 allows only 0. Speed lags by half of it.
    #[serde(default)]
    pub speed_window_s: f64,
    /// Time τ of the damping's spring and dashpot, in s, 0 to 0.05; 0 for a dashpot alone. From
    /// version 5.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub damping_time_s: f64,
    /// Optional rate dependence of the thresholds.
    #[serde(default)]
    pub rate: Option<RateDependence>,
    /// Conditions for the end of static friction, in version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub breakaway: Option<Breakaway>,
}

/// Whether a time is that of a dashpot alone, which older specifications do not write.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands it so")]
fn is_zero(time_s: &f64) -> bool {
    *time_s == 0.0
}

/// Checked parameters of the axial law, constant for an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct AxialParams {
    spec: AxialSpec,
}

/// A parameter outside its domain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} = {value} {unit}: {allowed}")]
pub struct ParamError {
    /// Name of the parameter, for example `layers[1].thickness_m`.
    pub field: String,
    /// The value found.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Description of the allowed values.
    pub allowed: &'static str,
}

/// Allowed range of a parameter. The upper ends only keep squares and products finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// 0 to 1e9.
    NotNegative,
    /// Above 0, to 1e9.
    Positive,
    /// −100 to 100: a coordinate, in m.
    Coordinate,
    /// 0 to 0.499: a Poisson ratio.
    Poisson,
}

impl Domain {
    /// Checks the value of a field.
    ///
    /// # Errors
    /// If the value is out of the domain.
    pub fn check(self, field: impl Into<String>, value: f64, unit: &'static str) -> Result<(), ParamError> {
        let (inside, allowed) = match self {
            Self::NotNegative => ((0.0..=1e9).contains(&value), "must be a number from 0 to 1e9"),
            Self::Positive => (value > 0.0 && value <= 1e9, "must be a number above 0, to 1e9"),
            Self::Coordinate => ((-100.0..=100.0).contains(&value), "must be a number from -100 to 100"),
            Self::Poisson => ((0.0..=0.499).contains(&value), "must be a number from 0 to 0.499"),
        };
        if inside { Ok(()) } else { Err(ParamError { field: field.into(), value, unit, allowed }) }
    }
}

impl AxialParams {
    /// Checks and freezes a specification.
    ///
    /// # Errors
    /// A [`ParamError`] naming the first parameter that is non-finite or out of range.
    pub fn new(spec: AxialSpec) -> Result<Self, ParamError> {
        if spec.layers.is_empty() || spec.layers.len() > MAX_LAYERS {
            return Err(ParamError {
                field: "layers".into(),
                value: spec.layers.len() as f64,
                unit: "layers",
                allowed: "must be from 1 to 64",
            });
        }
        for (index, layer) in spec.layers.iter().enumerate() {
            check_layer(index, layer)?;
        }
        Domain::NotNegative.check("tip_to_rim_m", spec.tip_to_rim_m, "m")?;
        Domain::Positive.check("presliding_stiffness_n_per_m", spec.presliding_stiffness_n_per_m, "N/m")?;
        check_speed_window(&spec)?;
        check_damping_time(&spec)?;
        if let Some(rate) = &spec.rate {
            Domain::NotNegative.check("rate.p_infinity_n", rate.p_infinity_n, "N")?;
            Domain::Positive.check("rate.v0_m_per_s", rate.v0_m_per_s, "m/s")?;
        }
        check_options(&spec)?;
        Ok(Self { spec })
    }

    /// The specification these parameters were made from.
    #[must_use]
    pub fn spec(&self) -> &AxialSpec {
        &self.spec
    }
}

fn check_speed_window(spec: &AxialSpec) -> Result<(), ParamError> {
    let (longest_s, allowed) = match spec.law {
        ForceLaw::Version1 => (0.0, "must be 0 with version 1 of the law"),
        ForceLaw::Version2 | ForceLaw::Version3 | ForceLaw::Version4 | ForceLaw::Version5 => {
            (LONGEST_SPEED_WINDOW_S, "must be a number from 0 to 0.05")
        }
    };
    let value = spec.speed_window_s;
    if (0.0..=longest_s).contains(&value) {
        Ok(())
    } else {
        Err(ParamError { field: "speed_window_s".into(), value, unit: "s", allowed })
    }
}

fn check_damping_time(spec: &AxialSpec) -> Result<(), ParamError> {
    let (longest_s, allowed) = if spec.law >= ForceLaw::Version5 {
        (LONGEST_DAMPING_TIME_S, "must be a number from 0 to 0.05")
    } else {
        (0.0, "must be 0 before version 5 of the law")
    };
    let value = spec.damping_time_s;
    if (0.0..=longest_s).contains(&value) {
        Ok(())
    } else {
        Err(ParamError { field: "damping_time_s".into(), value, unit: "s", allowed })
    }
}

fn check_layer(index: usize, layer: &Layer) -> Result<(), ParamError> {
    let fields = [
        ("thickness_m", layer.thickness_m, "m", Domain::NotNegative),
        ("stiffness_n_per_m", layer.stiffness_n_per_m, "N/m", Domain::Positive),
        ("damping_n_s_per_m2", layer.damping_n_s_per_m2, "N·s/m²", Domain::NotNegative),
        ("tip_rupture_n", layer.tip_rupture_n, "N", Domain::NotNegative),
        ("rim_rupture_n", layer.rim_rupture_n, "N", Domain::NotNegative),
        ("friction_n_per_m", layer.friction_n_per_m, "N/m", Domain::NotNegative),
        ("cutting_n", layer.cutting_n, "N", Domain::NotNegative),
    ];
    fields
        .into_iter()
        .try_for_each(|(name, value, unit, domain)| domain.check(format!("layers[{index}].{name}"), value, unit))
}
