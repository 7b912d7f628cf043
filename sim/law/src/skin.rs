//! The skin's shape, and the positions of layers that follow it along a straight needle.
//!
//! Layers are concentric with the skin. In the plane across a skin of radius R let a needle enter
//! at an angle θ to the normal, and let t be the square of the component of its direction along the
//! skin in the direction of curvature (sin²θ on a sphere, less on a cylinder). After a distance s
//! it is R − d from the centre, (R − d)² = (R − s cos θ)² + s² t, so that with κ = 1/R
//!
//! ```text
//! s(d) = (2d − κd²) / (cos θ + √(cos²θ − κ (cos²θ + t) (2d − κd²)))
//! ```
//!
//! which is d/cos θ for a flat skin.

use core::f64::consts::FRAC_PI_2;

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// cos 80°. A needle at a flatter angle to the skin, or to a layer below it, is treated as one at
/// 80°: its path would otherwise have no end.
pub(crate) const MIN_COS: f64 = 0.173_648_177_666_930_33;

/// Shape of the skin; the layers follow it. It touches z = 0 at the origin of the patient frame and
/// curves towards the inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Skin {
    /// The plane z = 0.
    #[default]
    Flat,
    /// A sphere of this radius, in m.
    Sphere {
        /// Radius, in m.
        radius_m: f64,
    },
    /// A cylinder of this radius, in m.
    Cylinder {
        /// Radius, in m.
        radius_m: f64,
        /// Direction of its axis in the plane z = 0, from +x towards +y, in rad.
        along_rad: f64,
    },
}

/// Incidence of a straight needle on layers that follow the skin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Incidence {
    /// 1/cos θ at the skin: the length of a needle's path through a thin layer divided by its
    /// thickness, from 1 to the value at 80°.
    pub path_factor: f64,
    /// Curvature of the skin, in 1/m; 0 if it is flat.
    #[serde(default)]
    pub curvature_per_m: f64,
    /// The square of the component of the needle's direction along the skin in the direction of
    /// curvature, from 0 to sin²θ.
    #[serde(default)]
    pub along_bend: f64,
}

impl Skin {
    /// A cylinder along y: a back, seen from behind.
    #[must_use]
    pub fn cylinder_along_y(radius_m: f64) -> Self {
        Self::Cylinder { radius_m, along_rad: FRAC_PI_2 }
    }

    /// Its radius, in m; `None` if it is flat.
    #[must_use]
    pub fn radius_m(&self) -> Option<f64> {
        match *self {
            Self::Flat => None,
            Self::Sphere { radius_m } | Self::Cylinder { radius_m, .. } => Some(radius_m),
        }
    }

    /// The component of a horizontal position in the direction of curvature, and the rest: all of
    /// it on a sphere.
    fn across_and_along(&self, place: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let level = Vector3::new(place.x, place.y, 0.0);
        match *self {
            Self::Flat => (Vector3::zeros(), level),
            Self::Sphere { .. } => (level, Vector3::zeros()),
            Self::Cylinder { along_rad, .. } => {
                let line = line_of(along_rad);
                let along = line * line.dot(&level);
                (level - along, along)
            }
        }
    }

    /// Direction of a cylinder's axis, of unit length; `None` for other shapes.
    #[must_use]
    pub fn line(&self) -> Option<Vector3<f64>> {
        match *self {
            Self::Flat | Self::Sphere { .. } => None,
            Self::Cylinder { along_rad, .. } => Some(line_of(along_rad)),
        }
    }

    /// Maps a point x, y along the flat skin and z above it to the curved skin, in m.
    #[must_use]
    pub fn bend(&self, flat: &Point3<f64>) -> Point3<f64> {
        let Some(radius_m) = self.radius_m() else { return *flat };
        let (across, along) = self.across_and_along(&flat.coords);
        let arc_m = across.norm();
        let angle = arc_m / radius_m;
        // sin(angle)/arc, and its limit on the axis.
        let per_metre = if angle > 0.0 { libm::sin(angle) / arc_m } else { 1.0 / radius_m };
        // R(1 − cos) as 2R sin²(angle/2): the difference would lose all digits of a nearly flat
        // skin.
        let half = libm::sin(0.5 * angle);
        let z = flat.z - 2.0 * (radius_m + flat.z) * half * half;
        Point3::from(across * ((radius_m + flat.z) * per_metre) + along + Vector3::z() * z)
    }

    /// Maps a point to the flattened skin, in m: the inverse of [`Skin::bend`]. Its z is the height
    /// above the skin.
    #[must_use]
    pub fn flatten(&self, bent: &Point3<f64>) -> Point3<f64> {
        let Some(radius_m) = self.radius_m() else { return *bent };
        let (across, along) = self.across_and_along(&bent.coords);
        let aside_m = across.norm();
        let up_m = radius_m + bent.z;
        let angle = libm::atan2(aside_m, up_m);
        let arc = if aside_m > 0.0 { across * (radius_m * angle / aside_m) } else { across };
        // √(a² + u²) − R as (a² + (u − R)(u + R)) / (√(a² + u²) + R), for the same reason.
        let from_centre_m = libm::hypot(aside_m, up_m);
        let height_m = (aside_m * aside_m + bent.z * (up_m + radius_m)) / (from_centre_m + radius_m);
        Point3::from(arc + along + Vector3::z() * height_m)
    }

    /// Height of a point above the skin, in m; negative in the body.
    #[must_use]
    pub fn height_m(&self, point: &Point3<f64>) -> f64 {
        self.flatten(point).z
    }

    /// Outward direction at a point, of unit length.
    #[must_use]
    pub fn outward(&self, point: &Point3<f64>) -> Vector3<f64> {
        let Some(radius_m) = self.radius_m() else { return Vector3::z() };
        let from_line = self.across_and_along(&point.coords).0 + Vector3::z() * (radius_m + point.z);
        from_line.try_normalize(0.0).unwrap_or_else(Vector3::z)
    }

    /// The point of the skin nearest to a point.
    #[must_use]
    pub fn nearest(&self, point: &Point3<f64>) -> Point3<f64> {
        match self {
            Self::Flat => Point3::new(point.x, point.y, 0.0),
            Self::Sphere { .. } | Self::Cylinder { .. } => point - self.outward(point) * self.height_m(point),
        }
    }

    /// The point of the skin above or below a horizontal position, in m; the outermost point if the
    /// skin does not extend so far.
    #[must_use]
    pub fn above(&self, x_m: f64, y_m: f64) -> Point3<f64> {
        let place = Vector3::new(x_m, y_m, 0.0);
        let Some(radius_m) = self.radius_m() else { return Point3::from(place) };
        let (across, along) = self.across_and_along(&place);
        let aside_m = across.norm();
        let reached = across * (radius_m / aside_m.max(radius_m));
        let up_m = libm::sqrt((radius_m * radius_m - reached.norm_squared()).max(0.0));
        let down_m = reached.norm_squared() / (radius_m + up_m);
        Point3::from(reached + along - Vector3::z() * down_m)
    }

    /// Incidence at the skin of a needle whose line passes through a point. `axis` is of unit
    /// length, from hub to tip.
    #[must_use]
    pub fn incidence(&self, point: &Point3<f64>, axis: &Vector3<f64>) -> Incidence {
        let cosine = self.cosine(point, axis);
        let Some(radius_m) = self.radius_m() else { return Incidence::of_factor(1.0 / cosine) };
        Incidence {
            path_factor: 1.0 / cosine,
            curvature_per_m: 1.0 / radius_m,
            along_bend: self.along_bend(point, axis),
        }
    }

    /// cos θ between an axis and the inward normal, at least that of 80°.
    fn cosine(&self, point: &Point3<f64>, axis: &Vector3<f64>) -> f64 {
        (-axis.dot(&self.outward(point))).max(MIN_COS)
    }

    fn along_bend(&self, point: &Point3<f64>, axis: &Vector3<f64>) -> f64 {
        let out = self.outward(point);
        let level = Vector3::new(axis.x, axis.y, 0.0);
        let bending = match self {
            Self::Flat => return 0.0,
            Self::Sphere { .. } => *axis,
            Self::Cylinder { .. } => axis - (level - self.across_and_along(&level).0),
        };
        (bending - out * bending.dot(&out)).norm_squared()
    }

    /// Distance along a needle from the intersection of its line with the skin to a tip, in m;
    /// negative above it. A line that misses the skin, or meets it flatter than at 80°, is treated
    /// as one at 80°.
    #[must_use]
    pub fn displacement_m(&self, tip_m: &Point3<f64>, axis: &Vector3<f64>) -> f64 {
        let Some(radius_m) = self.radius_m() else { return -tip_m.z / self.cosine(tip_m, axis) };
        let height_m = self.height_m(tip_m);
        let flattest_m = -height_m / MIN_COS;
        let cosine = -axis.dot(&self.outward(tip_m));
        // With s the remaining distance from the tip, (r − s cos)² + s² t = R², r = R + height.
        let from_centre_m = radius_m + height_m;
        let over_m2 = height_m * (from_centre_m + radius_m);
        let toward_m = from_centre_m * cosine;
        let root = toward_m * toward_m - (cosine * cosine + self.along_bend(tip_m, axis)) * over_m2;
        if cosine <= MIN_COS || root < 0.0 {
            return flattest_m;
        }
        let way_m = -over_m2 / (toward_m + libm::sqrt(root));
        if height_m > 0.0 { way_m.max(flattest_m) } else { way_m.min(flattest_m) }
    }

    /// The intersection with the skin of a tip's path from a point above to a point below it.
    pub(crate) fn crossing(&self, above_m: &Point3<f64>, below_m: &Point3<f64>) -> Point3<f64> {
        let (above, below) = (self.height_m(above_m), self.height_m(below_m));
        self.nearest(&(above_m + (below_m - above_m) * (above / (above - below))))
    }
}

fn line_of(along_rad: f64) -> Vector3<f64> {
    Vector3::new(libm::cos(along_rad), libm::sin(along_rad), 0.0)
}

impl Default for Incidence {
    fn default() -> Self {
        Self::UPRIGHT
    }
}

impl Incidence {
    /// A needle perpendicular to flat layers.
    pub const UPRIGHT: Self = Self::of_factor(1.0);

    /// A needle through flat layers whose path is longer by a factor.
    #[must_use]
    pub const fn of_factor(path_factor: f64) -> Self {
        Self { path_factor, curvature_per_m: 0.0, along_bend: 0.0 }
    }

    /// cos θ at the skin.
    #[must_use]
    pub fn cosine(&self) -> f64 {
        1.0 / self.path_factor
    }

    /// Whether the layers are flat.
    pub(crate) fn is_flat(&self) -> bool {
        self.curvature_per_m <= 0.0
    }

    pub(crate) fn is_believable(&self, most_factor: f64) -> bool {
        self.path_factor > 0.0
            && self.path_factor <= most_factor
            && (0.0..=1e3).contains(&self.curvature_per_m)
            && (0.0..=1.0).contains(&self.along_bend)
    }

    /// Distance from which on the needle is flatter than 80° to the layers below, and is treated as
    /// one at 80°, in m.
    fn flattest_m(&self) -> f64 {
        let (cosine, square) = (self.cosine(), MIN_COS * MIN_COS);
        let whole = cosine * cosine + self.along_bend;
        // cos − κ s w = m √(1 − 2κ s cos + κ² s² w), squared: w σ² − 2 cos σ + (cos² − m²)/(w − m²)
        // = 0 for σ = κ s, w = cos² + t.
        let over = (cosine * cosine - square) / (whole - square);
        let root = cosine * cosine - whole * over;
        if over.is_finite() && over > 0.0 && root >= 0.0 {
            (cosine - libm::sqrt(root)) / whole / self.curvature_per_m
        } else {
            0.0
        }
    }

    /// Depth below the skin after a distance along the needle, along the skin's normal there; both
    /// in m.
    #[must_use]
    pub fn depth_m(&self, way_m: f64) -> f64 {
        if self.is_flat() {
            return way_m / self.path_factor;
        }
        let last_m = self.flattest_m();
        self.bent_depth_m(way_m.min(last_m)) + (way_m - last_m).max(0.0) * MIN_COS
    }

    fn bent_depth_m(&self, way_m: f64) -> f64 {
        let whole = self.cosine() * self.cosine() + self.along_bend;
        let sunk_m = 2.0 * way_m * self.cosine() - self.curvature_per_m * way_m * way_m * whole;
        sunk_m / (1.0 + libm::sqrt((1.0 - self.curvature_per_m * sunk_m).max(0.0)))
    }

    /// Distance along the needle to a depth below the skin, both in m.
    #[must_use]
    pub fn way_m(&self, depth_m: f64) -> f64 {
        if self.is_flat() {
            return depth_m * self.path_factor;
        }
        let last_m = self.flattest_m();
        let deepest_m = self.bent_depth_m(last_m);
        if depth_m > deepest_m {
            return last_m + (depth_m - deepest_m) / MIN_COS;
        }
        let cosine = self.cosine();
        let whole = cosine * cosine + self.along_bend;
        let sunk_m = 2.0 * depth_m - self.curvature_per_m * depth_m * depth_m;
        let root = cosine * cosine - self.curvature_per_m * whole * sunk_m;
        sunk_m / (cosine + libm::sqrt(root.max(0.0)))
    }

    /// Writes the start of each layer with these thicknesses along the needle, and the far side of
    /// the last, in m.
    pub fn lay_layers(&self, thicknesses_m: impl IntoIterator<Item = f64>, boundaries_m: &mut Vec<f64>) {
        boundaries_m.clear();
        boundaries_m.push(0.0);
        let (mut flat_m, mut depth_m) = (0.0, 0.0);
        for thickness_m in thicknesses_m {
            flat_m += thickness_m * self.path_factor;
            depth_m += thickness_m;
            boundaries_m.push(if self.is_flat() { flat_m } else { self.way_m(depth_m) });
        }
    }
}
