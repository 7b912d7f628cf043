//! Problems that need three dimensions: a tilted needle, a curved skin, inclusions.

use law::axial::{Domain, ParamError};
use law::{Incidence, Skin};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::problem::lame_pa;
use crate::{ElasticLayer, FieldModel, Problem};

/// A problem without an axis of symmetry. With all fields at their defaults it is the flat problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem3 {
    /// Layers, load and sample points. Depths are along the normal of the skin.
    pub flat: Problem,
    /// Angle of the needle to the normal of the skin, in rad: the force is inclined towards `+x`,
    /// and a boundary is met at x = depth · tan(tilt).
    pub tilt_rad: f64,
    /// Shape of the skin.
    pub skin: Skin,
    /// Inclusions in the layers; where they overlap, the last one counts.
    pub inclusions: Vec<Inclusion>,
    /// Where the footprint of the load is measured.
    #[serde(default)]
    pub footprint: Footprint,
}

/// Where the footprint of a load, a Gaussian around the needle, is measured. For a flat skin both are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Footprint {
    /// Before the skin is bent. Under a skin of radius R a footprint at depth d then shrinks by 1 − d/R, and a dent grows as much: the way
    /// of [`crate::Judging::Third`] and earlier ones.
    Flat,
    /// On the bent body.
    #[default]
    Bent,
}

/// A body of another material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inclusion {
    /// Its shape and position.
    pub shape: InclusionShape,
    /// Its material.
    pub material: Material,
}

/// An isotropic linear elastic material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Young's modulus, in Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson ratio, 0 to 0.499.
    pub poisson_ratio: f64,
    /// Density, in kg/m³.
    pub density_kg_per_m3: f64,
}

/// Shape and position of an inclusion, in the patient frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum InclusionShape {
    /// A sphere.
    Sphere {
        /// Centre, in m.
        centre_m: Point3<f64>,
        /// Radius, in m.
        radius_m: f64,
    },
    /// All points within a distance of a line segment.
    Capsule {
        /// One end of the segment, in m.
        from_m: Point3<f64>,
        /// The other end, in m.
        to_m: Point3<f64>,
        /// Distance, in m.
        radius_m: f64,
    },
    /// An axis-aligned box.
    Box {
        /// Centre, in m.
        centre_m: Point3<f64>,
        /// Half of each side, in m.
        half_m: Vector3<f64>,
    },
}

/// The part of the tissue that is meshed; the rest is its mirror image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Symmetry {
    /// x ≥ 0 and y ≥ 0: a perpendicular needle, layers only.
    Quarter,
    /// y ≥ 0: an oblique needle.
    Half,
    /// The whole tissue.
    Full,
}

impl Symmetry {
    /// Fraction of the tissue that is meshed.
    #[must_use]
    pub fn share(self) -> f64 {
        match self {
            Self::Quarter => 0.25,
            Self::Half => 0.5,
            Self::Full => 1.0,
        }
    }
}

impl From<&ElasticLayer> for Material {
    fn from(layer: &ElasticLayer) -> Self {
        Self {
            youngs_modulus_pa: layer.youngs_modulus_pa,
            poisson_ratio: layer.poisson_ratio,
            density_kg_per_m3: layer.density_kg_per_m3,
        }
    }
}

impl Material {
    /// Lamé's λ and μ, in Pa.
    #[must_use]
    pub fn lame_pa(&self) -> (f64, f64) {
        lame_pa(self.youngs_modulus_pa, self.poisson_ratio)
    }
}

impl InclusionShape {
    /// Whether a point is inside or on it.
    #[must_use]
    pub fn contains(&self, point: &Point3<f64>) -> bool {
        match self {
            Self::Sphere { centre_m, radius_m } => (point - centre_m).norm() <= *radius_m,
            Self::Capsule { from_m, to_m, radius_m } => {
                let along = to_m - from_m;
                let square = along.norm_squared();
                let t = if square > 0.0 { (along.dot(&(point - from_m)) / square).clamp(0.0, 1.0) } else { 0.0 };
                (point - (from_m + along * t)).norm() <= *radius_m
            }
            Self::Box { centre_m, half_m } => (point - centre_m).abs() <= *half_m,
        }
    }

    fn numbers(&self) -> ([f64; 6], [f64; 3]) {
        match *self {
            Self::Sphere { centre_m: c, radius_m } => ([c.x, c.y, c.z, 0.0, 0.0, 0.0], [radius_m; 3]),
            Self::Capsule { from_m: a, to_m: b, radius_m } => ([a.x, a.y, a.z, b.x, b.y, b.z], [radius_m; 3]),
            Self::Box { centre_m: c, half_m } => ([c.x, c.y, c.z, 0.0, 0.0, 0.0], half_m.into()),
        }
    }

    /// Whether it is symmetric about the plane y = 0.
    fn is_halved(&self) -> bool {
        let off = match self {
            Self::Sphere { centre_m, .. } | Self::Box { centre_m, .. } => centre_m.y.abs(),
            Self::Capsule { from_m, to_m, .. } => from_m.y.abs() + to_m.y.abs(),
        };
        off < 1e-12
    }
}

impl Problem3 {
    /// The flat problem with a perpendicular needle.
    #[must_use]
    pub fn flat(problem: &Problem) -> Self {
        Self {
            flat: problem.clone(),
            tilt_rad: 0.0,
            skin: Skin::Flat,
            inclusions: Vec::new(),
            footprint: Footprint::Bent,
        }
    }

    /// The smallest part that must be meshed.
    #[must_use]
    pub fn symmetry(&self) -> Symmetry {
        let skin_is_halved = match self.skin {
            Skin::Flat | Skin::Sphere { .. } => true,
            // Its line lies in the plane of the needle, or perpendicular to it.
            Skin::Cylinder { along_rad, .. } => libm::sin(2.0 * along_rad).abs() < 1e-9,
        };
        let halved = skin_is_halved && self.inclusions.iter().all(|inclusion| inclusion.shape.is_halved());
        match (self.tilt_rad == 0.0 && self.inclusions.is_empty() && halved, halved) {
            (true, _) => Symmetry::Quarter,
            (false, true) => Symmetry::Half,
            (false, false) => Symmetry::Full,
        }
    }

    /// The incidence of the needle on the layers.
    fn incidence(&self) -> Incidence {
        let axis = Vector3::new(libm::sin(self.tilt_rad), 0.0, -libm::cos(self.tilt_rad));
        self.skin.incidence(&Point3::origin(), &axis)
    }

    /// The point where the needle reaches a depth, in m, patient frame. The needle is straight for
    /// any shape of the skin.
    #[must_use]
    pub fn on_needle(&self, depth_m: f64) -> Point3<f64> {
        let out = Vector3::new(-libm::sin(self.tilt_rad), 0.0, libm::cos(self.tilt_rad));
        Point3::from(out * -self.incidence().way_m(depth_m))
    }

    /// The same point in the flattened tissue.
    #[must_use]
    pub(super) fn on_flat_needle(&self, depth_m: f64) -> Point3<f64> {
        match self.skin {
            Skin::Flat => Point3::new(libm::tan(self.tilt_rad) * depth_m, 0.0, -depth_m),
            Skin::Sphere { .. } | Skin::Cylinder { .. } => self.skin.flatten(&self.on_needle(depth_m)),
        }
    }

    /// How many times as long a length along the skin becomes at the needle at a depth, in m, when the skin is bent: the square root of what
    /// an area becomes.
    #[must_use]
    pub(crate) fn lateral_scale(&self, depth_m: f64) -> f64 {
        const APART_M: f64 = 1e-5;
        let at = self.on_flat_needle(depth_m);
        let [along, across] = [Vector3::x(), Vector3::y()]
            .map(|way| self.skin.bend(&(at + way * APART_M)) - self.skin.bend(&(at - way * APART_M)));
        libm::sqrt(along.cross(&across).norm()) / (2.0 * APART_M)
    }

    /// Displacement along the needle of a field's last answer, in m, positive into the body: at a depth, at a distance from the
    /// needle along the skin, towards where it leans, both in m. For a flat skin.
    #[must_use]
    pub fn along_needle_m(&self, field: &dyn FieldModel, r_m: f64, depth_m: f64) -> f64 {
        let [axial_m, across_m] = field.displacement_m(r_m + depth_m * libm::tan(self.tilt_rad), depth_m);
        libm::sin(self.tilt_rad) * across_m - libm::cos(self.tilt_rad) * axial_m
    }

    /// The same at every sample depth and radius, ordered by depth.
    #[must_use]
    pub fn all_along_needle_m(&self, field: &dyn FieldModel) -> Vec<f64> {
        let radii_m = &self.flat.sample_r_m;
        let places =
            self.flat.sample_depth_m.iter().flat_map(|&depth_m| radii_m.iter().map(move |&r_m| (r_m, depth_m)));
        places.map(|(r_m, depth_m)| self.along_needle_m(field, r_m, depth_m)).collect()
    }

    /// Checks the problem.
    ///
    /// # Errors
    /// The first number that is not finite or out of range.
    pub fn check(&self) -> Result<(), ParamError> {
        self.flat.check()?;
        let steepest = 75_f64.to_radians();
        if !(-steepest..=steepest).contains(&self.tilt_rad) {
            let allowed = "must be a number from -1.309 to 1.309 (75°)";
            return Err(ParamError { field: "tilt_rad".into(), value: self.tilt_rad, unit: "rad", allowed });
        }
        if let Some(radius_m) = self.skin.radius_m() {
            let deepest: f64 = self.flat.slab.layers.iter().map(|layer| layer.thickness_m).sum();
            let least = deepest.max(self.flat.slab.radius_m / 3.0);
            if !(radius_m > least && radius_m.is_finite()) {
                let allowed = "must be more than the depth of the tissue and than a third of its radius";
                return Err(ParamError { field: "skin.radius_m".into(), value: radius_m, unit: "m", allowed });
            }
        }
        self.inclusions.iter().enumerate().try_for_each(|(at, inclusion)| inclusion.check(at))
    }

    /// The material at a point of the flat tissue that lies at `bent` in the curved tissue.
    pub(super) fn material(&self, depth_m: f64, bent: &Point3<f64>) -> Material {
        if let Some(inclusion) = self.inclusions.iter().rev().find(|inclusion| inclusion.shape.contains(bent)) {
            return inclusion.material;
        }
        let mut bottom = 0.0;
        let layers = &self.flat.slab.layers;
        let found = layers.iter().find(|layer| {
            bottom += layer.thickness_m;
            depth_m < bottom
        });
        Material::from(found.unwrap_or(&layers[layers.len() - 1]))
    }
}

impl Inclusion {
    fn check(&self, at: usize) -> Result<(), ParamError> {
        let field = |name: &str| format!("inclusions[{at}].{name}");
        let (places, sizes) = self.shape.numbers();
        places.into_iter().try_for_each(|value| Domain::Coordinate.check(field("shape"), value, "m"))?;
        sizes.into_iter().try_for_each(|value| Domain::Positive.check(field("shape"), value, "m"))?;
        Domain::Positive.check(field("youngs_modulus_pa"), self.material.youngs_modulus_pa, "Pa")?;
        Domain::Poisson.check(field("poisson_ratio"), self.material.poisson_ratio, "")?;
        Domain::Positive.check(field("density_kg_per_m3"), self.material.density_kg_per_m3, "kg/m³")
    }
}
