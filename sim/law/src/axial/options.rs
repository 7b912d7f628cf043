//! What version 3 of the law adds: options of a layer and of the needle. Without them version 3 is version 2 to the bit.

use serde::{Deserialize, Serialize};

use super::params::{AxialSpec, Domain, ForceLaw, Layer, ParamError};

/// Most Maxwell branches beside a tent: keeps a step bounded and its state of one size.
pub const MAX_BRANCHES: usize = 3;

/// A spring in series with a dashpot, beside the spring of a tented boundary.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaxwellBranch {
    /// Stiffness of its spring as a share g of the boundary's own: g k.
    pub share: f64,
    /// Time τ in which its force falls to 1/e while the needle is held, in s.
    pub time_s: f64,
}

/// What opens a boundary that relaxes. One that does not knows no difference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RuptureCriterion {
    /// Its spring and branches together hold the threshold: the peak is the same at any speed, the dent smaller the faster the needle.
    #[default]
    Force,
    /// Its spring alone holds the threshold, so that it is dented by so much: the dent is the same at any speed, the peak higher by what the
    /// branches still hold.
    Dent,
}

/// What a layer may have beside the numbers that every layer has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LayerOptions {
    /// κ of a tent that stiffens, F = k w + κ w², in N/m²; 0 for one that does not.
    pub stiffening_n_per_m2: f64,
    /// Branches that relax, beside the tent of tip and of rim; at most [`MAX_BRANCHES`].
    pub branches: Vec<MaxwellBranch>,
    /// What opens the boundary where it relaxes.
    pub gives_way_at: RuptureCriterion,
    /// Cap of friction per inserted length until the shaft has broken away, in N/m; none where it is the kinetic one.
    pub static_friction_n_per_m: Option<f64>,
    /// Fibres that part under an edge along them; none in tissue alike all round.
    pub sheet: Option<FibrousSheet>,
}

/// A sheet of connective tissue. The layer's stiffness and thresholds are those under an edge across its fibres.
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

/// Direction of a needle's cutting edge in the plane of the skin where nobody says another: the patient's x.
pub const PLAIN_EDGE: [f64; 2] = [1.0, 0.0];

/// When static friction gives way to kinetic friction, and when it is back. The presliding spring is the needle's, so these are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Breakaway {
    /// Slid length after which friction is kinetic, and travel backwards after which it is static again, in m.
    pub slid_m: f64,
    /// Time without sliding after which it is static again, in s.
    pub rest_s: f64,
}

impl LayerOptions {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the boundary relaxes.
    #[must_use]
    pub fn relaxes(&self) -> bool {
        !self.branches.is_empty()
    }

    /// The most that the boundary holds, as a multiple of its threshold: that of a needle infinitely fast.
    #[must_use]
    pub fn greatest_hold(&self) -> f64 {
        match self.gives_way_at {
            RuptureCriterion::Force => 1.0,
            RuptureCriterion::Dent => 1.0 + self.branch_share(),
        }
    }

    /// Σ g of the branches: how much stiffer than slowly a boundary is when it is dented at once.
    #[must_use]
    pub fn branch_share(&self) -> f64 {
        self.branches.iter().map(|branch| branch.share).sum()
    }
}

impl Layer {
    /// Cap of friction per inserted length before the shaft has broken away, in N/m.
    #[must_use]
    pub fn static_friction_n_per_m(&self) -> f64 {
        self.options.static_friction_n_per_m.unwrap_or(self.friction_n_per_m)
    }

    /// Dent at which spring and branches together hold a force, in m, where so much of the branches' force is there still: 0 for a
    /// needle infinitely slow, 1 for one infinitely fast. Solves k (1 + held Σg) w + κ w² = F.
    #[must_use]
    pub fn dent_m(&self, force_n: f64, held: f64) -> f64 {
        let k = self.stiffness_n_per_m * (1.0 + held * self.options.branch_share());
        let kappa = self.options.stiffening_n_per_m2;
        if kappa <= 0.0 {
            return force_n / k;
        }
        // The root that is exact for a small κ, where the textbook's loses its digits.
        2.0 * force_n / (k + libm::sqrt(k * k + 4.0 * kappa * force_n))
    }

    /// Greatest stiffness that a hand feels at this boundary, in N/m: fast, and just before it gives way.
    #[must_use]
    pub fn greatest_stiffness_n_per_m(&self, has_rim: bool) -> f64 {
        let turned = self.options.sheet.map_or(1.0, |sheet| sheet.along_stiffness.max(1.0));
        let k = self.stiffness_n_per_m * turned * (1.0 + self.options.branch_share());
        let threshold_n = if has_rim { self.tip_rupture_n.max(self.rim_rupture_n) } else { self.tip_rupture_n };
        k + 2.0 * self.options.stiffening_n_per_m2 * self.dent_m(threshold_n, 0.0)
    }
}

impl AxialSpec {
    /// Whether some boundary relaxes, so that where it gives way depends on speed.
    #[must_use]
    pub fn relaxes(&self) -> bool {
        self.layers.iter().any(|layer| layer.options.relaxes())
    }

    /// Whether a layer or the needle names an option of version 3.
    #[must_use]
    pub fn has_options(&self) -> bool {
        self.breakaway.is_some() || self.layers.iter().any(|layer| !layer.options.is_empty())
    }
}

/// What a tension T in N/m adds to the stiffness of a sheet's boundary, in N/m: 2πT/ln(R/a) for a disc of radius a in a sheet that is held at
/// R, both in m; R must be larger than a. The tension pulls alike all round, so it does not depend on the edge.
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

    /// Factor on the stiffness under an edge: 1 across the fibres, cos² of the way to that along them.
    #[must_use]
    pub fn stiffness_share(&self, edge: [f64; 2]) -> f64 {
        1.0 + (self.along_stiffness - 1.0) * self.along(edge)
    }

    /// Factor on the thresholds, likewise.
    #[must_use]
    pub fn threshold_share(&self, edge: [f64; 2]) -> f64 {
        1.0 + (self.along_threshold - 1.0) * self.along(edge)
    }
}

impl AxialSpec {
    /// Whether some boundary depends on how the needle's edge is turned.
    #[must_use]
    pub fn has_sheets(&self) -> bool {
        self.layers.iter().any(|layer| layer.options.sheet.is_some())
    }

    /// The same tissue as it is under an edge of unit length, without fibres: each sheet's numbers are those of that edge.
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

/// Checks what version 3 adds.
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
            allowed: "must be absent beside branches, from which the dependence on speed follows",
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

/// A static cap needs to be told when it ends.
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
            let allowed = "must be at least the friction that is left after breaking away";
            return Err(ParamError { field: field("static_friction_n_per_m"), value, unit: "N/m", allowed });
        }
    }
    Ok(())
}
