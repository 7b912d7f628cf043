//! The problem that a tissue model solves: a slab of layers and a load on it.

use law::Judging;
use law::axial::{Domain, MAX_LAYERS, ParamError};
use serde::{Deserialize, Serialize};

use crate::FieldModel;

/// The models of the tissue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// No field: the force law alone.
    None,
    /// Finite elements in (r, z).
    Axisymmetric,
    /// A calibrated lattice of springs.
    MassSpring,
    /// Corotational finite elements in 3-D.
    Volumetric,
}

impl Model {
    /// The name in documents and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Axisymmetric => "axisymmetric",
            Self::MassSpring => "mass-spring",
            Self::Volumetric => "volumetric",
        }
    }
}

/// An isotropic linear elastic layer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ElasticLayer {
    /// Thickness, in m. 0 for a sheet that only has thresholds: it bears no load.
    pub thickness_m: f64,
    /// Young's modulus, in Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson ratio, 0 to 0.499.
    pub poisson_ratio: f64,
    /// Density, in kg/m³. Only the dynamic models use it.
    pub density_kg_per_m3: f64,
}

/// Flat layers bonded to each other, clamped at the base and at the side r = `radius_m`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slab {
    /// Layers from the skin down.
    pub layers: Vec<ElasticLayer>,
    /// Radius of the clamped side, in m.
    pub radius_m: f64,
}

/// Position of a load. Its traction across the axis is Gaussian, p(r) = F/(πa²) exp(−(r/a)²).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LoadKind {
    /// On the horizontal plane at a depth in m: a contactor that tents a boundary.
    Contactor {
        /// Depth, in m.
        depth_m: f64,
    },
    /// Distributed evenly over a stretch of the axis: the shaft's drag.
    Drag {
        /// Upper end, in m.
        from_m: f64,
        /// Lower end, in m.
        to_m: f64,
    },
}

/// A load of the needle on the tissue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Where it acts.
    pub kind: LoadKind,
    /// Radius a of its Gaussian footprint, in m.
    pub radius_m: f64,
}

/// A slab, one load on it, and the sample points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// The tissue.
    pub slab: Slab,
    /// The load, of 1 N.
    pub load: Load,
    /// Radii of the sample points, in m.
    pub sample_r_m: Vec<f64>,
    /// Depths of the sample points, in m.
    pub sample_depth_m: Vec<f64>,
}

impl ElasticLayer {
    /// Lamé's λ and μ, in Pa.
    #[must_use]
    pub fn lame_pa(&self) -> (f64, f64) {
        lame_pa(self.youngs_modulus_pa, self.poisson_ratio)
    }
}

/// Lamé's λ and μ, in Pa, of a material with Young's modulus `e`, in Pa, and Poisson ratio `nu`.
pub(super) fn lame_pa(e: f64, nu: f64) -> (f64, f64) {
    (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
}

impl Slab {
    /// Depth of the upper boundary of every layer and of the base, in m: one more than the number
    /// of layers.
    #[must_use]
    pub fn boundaries_m(&self) -> Vec<f64> {
        let mut boundaries = vec![0.0];
        for layer in &self.layers {
            boundaries.push(boundaries[boundaries.len() - 1] + layer.thickness_m);
        }
        boundaries
    }

    /// Checks that the slab can be modelled.
    ///
    /// # Errors
    /// The first number that is not finite or out of range.
    pub fn check(&self) -> Result<(), ParamError> {
        if self.layers.is_empty() || self.layers.len() > MAX_LAYERS {
            let value = self.layers.len() as f64;
            return Err(ParamError { field: "layers".into(), value, unit: "layers", allowed: "must be from 1 to 64" });
        }
        for (at, layer) in self.layers.iter().enumerate() {
            let field = |name: &str| format!("layers[{at}].{name}");
            Domain::NotNegative.check(field("thickness_m"), layer.thickness_m, "m")?;
            Domain::Positive.check(field("youngs_modulus_pa"), layer.youngs_modulus_pa, "Pa")?;
            Domain::Poisson.check(field("poisson_ratio"), layer.poisson_ratio, "")?;
            Domain::Positive.check(field("density_kg_per_m3"), layer.density_kg_per_m3, "kg/m³")?;
        }
        let depth_m: f64 = self.layers.iter().map(|layer| layer.thickness_m).sum();
        Domain::Positive.check("layers.thickness_m", depth_m, "m in all")?;
        Domain::Positive.check("radius_m", self.radius_m, "m")
    }

    /// The layers with a thickness, which the models are made of.
    #[must_use]
    pub fn solid(&self) -> Self {
        let layers = self.layers.iter().filter(|layer| layer.thickness_m > 0.0).copied().collect();
        Self { layers, radius_m: self.radius_m }
    }
}

impl Load {
    /// Upper and lower end, in m; equal for a contactor.
    #[must_use]
    pub fn ends_m(&self) -> [f64; 2] {
        match self.kind {
            LoadKind::Contactor { depth_m } => [depth_m, depth_m],
            LoadKind::Drag { from_m, to_m } => [from_m, to_m],
        }
    }
}

/// Displacement at every sample of a problem, depth after depth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// Out of the body, in m.
    pub axial_m: Vec<f64>,
    /// Away from the axis, in m.
    pub radial_m: Vec<f64>,
}

impl Sampled {
    /// Relative L2 distance to a better solution, the larger of those of the axial and the radial
    /// displacement, each over all samples and relative to its own norm.
    #[must_use]
    pub fn distance(&self, better: &Self) -> f64 {
        let axial = relative_distance(&self.axial_m, &better.axial_m);
        axial.max(relative_distance(&self.radial_m, &better.radial_m))
    }

    /// The distance under a way of judging: the first considers only the axial displacement.
    #[must_use]
    pub fn distance_by(&self, judging: Judging, better: &Self) -> f64 {
        match judging {
            Judging::First => relative_distance(&self.axial_m, &better.axial_m),
            Judging::Second | Judging::Third | Judging::Fourth => self.distance(better),
        }
    }
}

/// Relative L2 distance ‖a − b‖/‖b‖ of a solution to a better one; 0 if they are equal, even if
/// both are zero.
#[must_use]
pub fn relative_distance(answer: &[f64], better: &[f64]) -> f64 {
    let wrong: f64 = answer.iter().zip(better).map(|(a, b)| (a - b) * (a - b)).sum();
    let whole: f64 = better.iter().map(|b| b * b).sum();
    if wrong == 0.0 { 0.0 } else { (wrong / whole).sqrt() }
}

impl Problem {
    /// Axial displacement of a field's last solution at every sample, in m, in order of depth.
    #[must_use]
    pub fn axial_m(&self, field: &dyn FieldModel) -> Vec<f64> {
        let row = |&depth_m: &f64| self.sample_r_m.iter().map(move |&r_m| field.displacement_m(r_m, depth_m)[0]);
        self.sample_depth_m.iter().flat_map(row).collect()
    }

    /// Axial and radial displacement of a field's last solution at every sample.
    #[must_use]
    pub fn sampled(&self, field: &dyn FieldModel) -> Sampled {
        let places =
            self.sample_depth_m.iter().flat_map(|&depth_m| self.sample_r_m.iter().map(move |&r_m| (r_m, depth_m)));
        let (axial_m, radial_m) = places.map(|(r_m, depth_m)| field.displacement_m(r_m, depth_m).into()).unzip();
        Sampled { axial_m, radial_m }
    }

    /// Checks the problem.
    ///
    /// # Errors
    /// The first number that is not finite or out of range.
    pub fn check(&self) -> Result<(), ParamError> {
        self.slab.check()?;
        Domain::Positive.check("load_radius_m", self.load.radius_m, "m")?;
        let depth_m: f64 = self.slab.layers.iter().map(|layer| layer.thickness_m).sum();
        let inside = |field: String, value: f64, allowed: &'static str, most: f64| {
            let right = value >= 0.0 && value <= most * (1.0 + 1e-9);
            if right { Ok(()) } else { Err(ParamError { field, value, unit: "m", allowed }) }
        };
        let within = "must be from 0 to the depth of the tissue";
        match self.load.kind {
            LoadKind::Contactor { depth_m: at } => inside("load_depth_m".into(), at, within, depth_m)?,
            LoadKind::Drag { from_m, to_m } => {
                inside("drag.to_m".into(), to_m, within, depth_m)?;
                inside("drag.from_m".into(), from_m, "must be from 0 to the lower end of the drag", to_m)?;
            }
        }
        for (at, &depth) in self.sample_depth_m.iter().enumerate() {
            inside(format!("sample_depth_m[{at}]"), depth, within, depth_m)?;
        }
        let within = "must be from 0 to the radius of the tissue";
        let radii = self.sample_r_m.iter().enumerate();
        radii.into_iter().try_for_each(|(at, &r)| inside(format!("sample_r_m[{at}]"), r, within, self.slab.radius_m))
    }
}
