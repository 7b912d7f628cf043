//! Options of version 3 of the law, for a layer and for the needle. Without them version 3 is
//! bit-identical to version 2.

use serde::{Deserialize, Serialize};

use super::params::{AxialSpec, Domain, ForceLaw, Layer, ParamError};

/// Maximum number of Maxwell branches per tent: keeps a step bounded and its state of constant
/// size.
pub const MAX_BRANCHES: usize = 3;

/// A spring in series with a dashpot, parallel to the spring of a tented boundary.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaxwellBranch {
    /// Stiffness of its spring as a share g of the boundary's own: g k.
    pub share: f64,
    /// Time constant τ of its force while the needle is held, in s.
    pub time_s: f64,
}

/// Rupture criterion of a boundary that relaxes. Irrelevant for others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RuptureCriterion {
    /// Spring and branches together reach the threshold: the peak does not depend on speed, the
    /// dent is smaller for a faster needle.
    #[default]
    Force,
    /// The spring alone reaches the threshold, so the criterion is the dent: the dent does not
    /// depend on speed, the peak is higher by the remaining force of the branches.
    Dent,
}

/// Optional parameters of a layer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LayerOptions {
    /// κ of a tent that stiffens, F = k w + κ w², in N/m²; 0 for one that does not.
    pub stiffening_n_per_m2: f64,
    /// Branches that relax, parallel to the tents of tip and rim; at most [`MAX_BRANCHES`].
    pub branches: Vec<MaxwellBranch>,
    /// Rupture criterion of the boundary if it relaxes.
    pub gives_way_at: RuptureCriterion,
    /// Friction cap per inserted length before breakaway of the shaft, in N/m; if absent, the
    /// kinetic one.
    pub static_friction_n_per_m: Option<f64>,
    /// Fibres that part under an edge along them; `None` for isotropic tissue.
    pub sheet: Option<FibrousSheet>,
}

/// A sheet of connective tissue. The layer's stiffness and thresholds are those under an edge
/// across its fibres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FibrousSheet {
    /// Direction of the fibres in the plane of the skin, of unit length, in the patient's x and y.
    pub fibres: [f64; 2],
    /// Stiffness under an edge along the fibres, as a share of that across.
    pub along_stiffness: f64,
    /// Thresholds under an edge along the fibres, as a share of those across.
    pub along_threshold: f64,
}

/// Default direction of a needle's cutting edge in the plane of the skin: the patient's x.
pub const PLAIN_EDGE: [f64; 2] = [1.0, 0.0];

/// Conditions for the transition from static to kinetic friction and back. The presliding spring
/// belongs to the needle, so these do too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Breakaway {
    /// Slid length after which friction is kinetic, and backward travel after which it is static
    /// again, in m.
    pub slid_m: f64,
    /// Time without sliding after which it is static again, in s.
    pub rest_s: f64,
}

impl LayerOptions {
    /// Whether all options have their defaults.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the boundary relaxes.
    #[must_use]
    pub fn relaxes(&self) -> bool {
        !self.branches.is_empty()
    }

    /// Maximum force that the boundary holds, as a multiple of its threshold: for an infinitely
    /// fast needle.
    #[must_use]
    pub fn greatest_hold(&self) -> f64 {
        match self.gives_way_at {
            RuptureCriterion::Force => 1.0,
            RuptureCriterion::Dent => 1.0 + self.branch_share(),
        }
    }

    /// Σ g of the branches: relative increase of a boundary's stiffness under fast loading.
    #[must_use]
    pub fn branch_share(&self) -> f64 {
        self.branches.iter().map(|branch| branch.share).sum()
    }
}

impl Layer {
    /// Friction cap per inserted length before breakaway of the shaft, in N/m.
    #[must_use]
    pub fn static_friction_n_per_m(&self) -> f64 {
        self.options.static_friction_n_per_m.unwrap_or(self.friction_n_per_m)
    }

    /// Dent at which spring and branches together hold a force, in m, with the fraction `held` of
    /// the branches' force remaining: 0 for an infinitely slow needle, 1 for an infinitely fast
    /// one. Solves k (1 + held Σg) w + κ w² = F.
    #[must_use]
    pub fn dent_m(&self, force_n: f64, held: f64) -> f64 {
        let k = self.stiffness_n_per_m * (1.0 + held * self.options.branch_share());
        let kappa = self.options.stiffening_n_per_m2;
        if kappa <= 0.0 {
            return force_n / k;
        }
        // The form of the root that is accurate for a small κ, where the textbook form cancels.
        2.0 * force_n / (k + libm::sqrt(k * k + 4.0 * kappa * force_n))
    }

    /// Greatest stiffness that a hand feels at this boundary, in N/m: under fast loading, just
    /// before the rupture.
    #[must_use]
    pub fn greatest_stiffness_n_per_m(&self, has_rim: bool) -> f64 {
        let turned = self.options.sheet.map_or(1.0, |sheet| sheet.along_stiffness.max(1.0));
        let k = self.stiffness_n_per_m * turned * (1.0 + self.options.branch_share());
        let threshold_n = if has_rim { self.tip_rupture_n.max(self.rim_rupture_n) } else { self.tip_rupture_n };
        k + 2.0 * self.options.stiffening_n_per_m2 * self.dent_m(threshold_n, 0.0)
    }
}

impl AxialSpec {
    /// Whether a boundary relaxes, so that the rupture position depends on speed.
    #[must_use]
    pub fn relaxes(&self) -> bool {
        self.layers.iter().any(|layer| layer.options.relaxes())
    }

    /// Whether a layer or the needle has an option of version 3.
    #[must_use]
    pub fn has_options(&self) -> bool {
        self.breakaway.is_some() || self.layers.iter().any(|layer| !layer.options.is_empty())
    }
}

/// Stiffness that a tension T in N/m adds to a sheet's boundary, in N/m: 2πT/ln(R/a) for a disc of
/// radius a in a sheet clamped at R, both in m; R must be larger than a. The tension is isotropic,
/// so it does not depend on the edge.
#[must_use]
pub fn tense_stiffness_n_per_m(tension_n_per_m: f64, held_radius_m: f64, radius_m: f64) -> f64 {
    core::f64::consts::TAU * tension_n_per_m / libm::log(held_radius_m / radius_m)
}

impl FibrousSheet {
    /// cos² of the angle between an edge and the fibres.
    fn along(&self, edge: [f64; 2]) -> f64 {
        let cos = edge[0] * self.fibres[0] + edge[1] * self.fibres[1];
        cos * cos
    }

    /// Factor on the stiffness under an edge: 1 across the fibres, interpolated by cos² to the
    /// value along them.
    #[must_use]
    pub fn stiffness_share(&self, edge: [f64; 2]) -> f64 {
        1.0 + (self.along_stiffness - 1.0) * self.along(edge)
    }

    /// Factor on the thresholds, interpolated in the same way.
    #[must_use]
    pub fn threshold_share(&self, edge: [f64; 2]) -> f64 {
        1.0 + (self.along_threshold - 1.0) * self.along(edge)
    }
}

impl AxialSpec {
    /// Whether a boundary depends on the direction of the needle's edge.
    #[must_use]
    pub fn has_sheets(&self) -> bool {
        self.layers.iter().any(|layer| layer.options.sheet.is_some())
    }

    /// The tissue under an edge of unit length, without fibres: each sheet gets the values for that
    /// edge.
    #[must_use]
    pub fn under_edge(&self, edge: [f64; 2]) -> Self {
        let mut spec = self.clone();
        for layer in &mut spec.layers {
            if let Some(sheet) = layer.options.sheet.take() {
                layer.stiffness_n_per_m *= sheet.stiffness_share(edge);
                layer.tip_rupture_n *= sheet.threshold_share(edge);
                layer.rim_rupture_n *= sheet.threshold_share(edge);
            }
        }
        spec
    }
}

/// Checks the options of version 3.
pub(super) fn check_options(spec: &AxialSpec) -> Result<(), ParamError> {
    for (index, layer) in spec.layers.iter().enumerate() {
        if spec.law < ForceLaw::Version3 && !layer.options.is_empty() {
            return Err(refuse_version(format!("layers[{index}].options"), spec.law));
        }
        check_layer_options(index, layer)?;
    }
    if let (Some(rate), true) = (&spec.rate, spec.relaxes()) {
        return Err(ParamError {
            field: "rate.p_infinity_n".into(),
            value: rate.p_infinity_n,
            unit: "N",
            allowed: "must be absent together with branches, from which the dependence on speed follows",
        });
    }
    let Some(breakaway) = &spec.breakaway else { return check_breakaway_present(spec) };
    if spec.law < ForceLaw::Version3 {
        return Err(refuse_version("breakaway".into(), spec.law));
    }
    Domain::Positive.check("breakaway.slid_m", breakaway.slid_m, "m")?;
    Domain::Positive.check("breakaway.rest_s", breakaway.rest_s, "s")
}

fn refuse_version(field: String, law: ForceLaw) -> ParamError {
    let value = f64::from(u32::from(law));
    ParamError { field, value, unit: "is the law", allowed: "must be absent before version 3 of the law" }
}

/// A static cap requires a breakaway condition.
fn check_breakaway_present(spec: &AxialSpec) -> Result<(), ParamError> {
    for (index, layer) in spec.layers.iter().enumerate() {
        if let Some(value) = layer.options.static_friction_n_per_m {
            let field = format!("layers[{index}].options.static_friction_n_per_m");
            return Err(ParamError { field, value, unit: "N/m", allowed: "needs the breakaway of the needle" });
        }
    }
    Ok(())
}

fn check_layer_options(index: usize, layer: &Layer) -> Result<(), ParamError> {
    let options = &layer.options;
    let field = |name: &str| format!("layers[{index}].options.{name}");
    Domain::NotNegative.check(field("stiffening_n_per_m2"), options.stiffening_n_per_m2, "N/m²")?;
    if options.branches.len() > MAX_BRANCHES {
        let (value, allowed) = (options.branches.len() as f64, "must be at most 3");
        return Err(ParamError { field: field("branches"), value, unit: "branches", allowed });
    }
    for (at, branch) in options.branches.iter().enumerate() {
        Domain::Positive.check(field(&format!("branches[{at}].share")), branch.share, "")?;
        Domain::Positive.check(field(&format!("branches[{at}].time_s")), branch.time_s, "s")?;
    }
    if let Some(sheet) = &options.sheet {
        Domain::Positive.check(field("sheet.along_stiffness"), sheet.along_stiffness, "")?;
        Domain::Positive.check(field("sheet.along_threshold"), sheet.along_threshold, "")?;
        let length = libm::hypot(sheet.fibres[0], sheet.fibres[1]);
        let is_unit = (length - 1.0).abs() <= 1e-9;
        if !is_unit {
            let allowed = "must be of length 1";
            return Err(ParamError { field: field("sheet.fibres"), value: length, unit: "long", allowed });
        }
    }
    if let Some(value) = options.static_friction_n_per_m {
        Domain::NotNegative.check(field("static_friction_n_per_m"), value, "N/m")?;
        if value < layer.friction_n_per_m {
            let allowed = "must be at least the friction that remains after breakaway";
            return Err(ParamError { field: field("static_friction_n_per_m"), value, unit: "N/m", allowed });
        }
    }
    Ok(())
}
