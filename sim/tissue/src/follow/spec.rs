//! The tissue of a scene, as input of a field.

use law::axial::{Domain, ParamError};

use crate::volumetric::{Inclusion, Skin};
use crate::{ElasticLayer, Judging, Load, LoadKind, Model, Slab};

/// A slab under a needle, and the positions of the needle's loads. Unchecked.
#[derive(Clone, Debug, PartialEq)]
pub struct TissueSpec {
    /// The body: the layers with a thickness, clamped at a radius. The field models only the part
    /// that the needle moves.
    pub slab: Slab,
    /// Radius of the needle's footprint, in m.
    pub load_radius_m: f64,
    /// Angle of the needle to the surface normal in the exercise, in rad.
    pub tilt_rad: f64,
    /// Shape of the skin, in the frame of its normal at the entry, whose x is the direction of the
    /// needle's inclination.
    pub skin: Skin,
    /// Inclusions in the layers, in the same frame.
    pub inclusions: Vec<Inclusion>,
    /// The model requested by name; if absent, the planner chooses.
    pub model: Option<Model>,
    /// Tolerated relative error of the displacement along the needle, at every boundary, under any
    /// load of an attempt.
    pub tolerance: f64,
    /// How the error is judged. A recording names its own way.
    pub judging: Judging,
    /// Whether the field's stiffness replaces the law's own at each boundary (physics section 4).
    pub coupled: bool,
    /// Depth of each boundary of the force law and of the base, in m, along the surface normal: one
    /// more than the number of layers. Boundaries of layers without thickness coincide.
    pub boundaries_m: Vec<f64>,
    /// Recoil time of each layer of the force law, in s.
    pub recoil_time_s: Vec<f64>,
}

/// Default recoil time of a layer, in s: the time that an elastic wave of speed √(E/ρ) needs to
/// cross it,
///
/// ```text
/// τ = max(d, 2a) √(ρ/E)
/// ```
///
/// A sheet thinner than the needle moves with the tissue around the needle, hence 2a, the load's
/// radius in m being a.
#[must_use]
pub fn recoil_time_s(layer: &ElasticLayer, load_radius_m: f64) -> f64 {
    layer.thickness_m.max(2.0 * load_radius_m) * (layer.density_kg_per_m3 / layer.youngs_modulus_pa).sqrt()
}

impl TissueSpec {
    /// Number of layers of the force law.
    #[must_use]
    pub fn layers(&self) -> usize {
        self.recoil_time_s.len()
    }

    /// Whether the tissue has flat layers only.
    #[must_use]
    pub fn is_even(&self) -> bool {
        self.skin == Skin::Flat && self.inclusions.is_empty()
    }

    /// The same layers, flat and without inclusions.
    #[must_use]
    pub fn leveled(&self) -> Self {
        Self { skin: Skin::Flat, inclusions: Vec::new(), ..self.clone() }
    }

    /// Depth of the deepest boundary, in m.
    #[must_use]
    pub fn deepest_m(&self) -> f64 {
        self.boundaries_m.iter().copied().fold(0.0, f64::max)
    }

    /// Every load in the order of [`law::axial::write_loads`]: contactors, then drags. `None` for
    /// the drag of a layer without thickness.
    #[must_use]
    pub fn loads(&self) -> Vec<Option<Load>> {
        let load = |kind| Load { kind, radius_m: self.load_radius_m };
        let contactors =
            self.boundaries_m.iter().take(self.layers()).map(|&depth_m| Some(LoadKind::Contactor { depth_m }));
        let drags = self.boundaries_m.windows(2).map(|pair| match pair {
            &[from_m, to_m] if to_m > from_m => Some(LoadKind::Drag { from_m, to_m }),
            _ => None,
        });
        contactors.chain(drags).map(|kind| kind.map(load)).collect()
    }

    /// Checks that a field can be computed.
    ///
    /// # Errors
    /// The first number that is not finite or out of range.
    pub fn check(&self) -> Result<(), ParamError> {
        self.slab.check()?;
        Domain::Positive.check("load_radius_m", self.load_radius_m, "m")?;
        Domain::Positive.check("tolerance", self.tolerance, "")?;
        if self.layers() == 0 || self.boundaries_m.len() != self.layers() + 1 {
            let value = self.boundaries_m.len() as f64;
            let allowed = "must be one more than there are layers";
            return Err(ParamError { field: "boundaries_m".into(), value, unit: "boundaries", allowed });
        }
        for (at, &depth_m) in self.boundaries_m.iter().enumerate() {
            Domain::NotNegative.check(format!("boundaries_m[{at}]"), depth_m, "m")?;
        }
        let recoil = self.recoil_time_s.iter().enumerate();
        recoil.into_iter().try_for_each(|(at, &tau)| Domain::Positive.check(format!("recoil_time_s[{at}]"), tau, "s"))
    }
}
