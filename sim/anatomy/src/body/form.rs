//! Shapes as signed distances, in mm: negative inside. Never more than the true distance, so that a
//! block of a grid can be skipped after sampling its middle.

use nalgebra::{Matrix3, Vector3};

/// A point or a direction, in mm.
pub(super) type Place = Vector3<f64>;

/// Pose of a shape: its own axes as columns, and its middle.
#[derive(Clone, Debug)]
pub(super) struct Pose {
    axes: Matrix3<f64>,
    middle: Place,
}

impl Pose {
    /// Rotated about x by an angle in rad, which inclines the shape's up axis towards dorsal.
    pub(super) fn leaning(middle: Place, angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { axes: Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos), middle }
    }

    /// First axis along a direction, second as close as possible to `up`.
    pub(super) fn along(middle: Place, first: Place, up: Place) -> Self {
        let first = first.normalize();
        let third = first.cross(&up).normalize();
        Self { axes: Matrix3::from_columns(&[first, third.cross(&first), third]), middle }
    }

    /// Converts a point from the own frame to the outer one.
    pub(super) fn to_outer(&self, own: Place) -> Place {
        self.middle + self.axes * own
    }

    /// Converts a point from the outer frame to the own one.
    pub(super) fn to_own(&self, outer: &Place) -> Place {
        self.axes.tr_mul(&(outer - self.middle))
    }

    /// The second axis.
    pub(super) fn up(&self) -> Place {
        self.axes.column(1).into()
    }

    /// The third axis.
    pub(super) fn dorsal(&self) -> Place {
        self.axes.column(2).into()
    }
}

/// Primitive of a solid.
#[derive(Clone, Debug)]
pub(super) enum Form {
    /// The cone that joins two spheres.
    Cone { from: Place, to: Place, from_radius: f64, to_radius: f64 },
    /// A box with rounded edges; `half` includes the rounding.
    Slab { half: Place, rounding: f64 },
    /// An ellipsoid.
    Egg { half: Place },
    /// A vertebral body: round in front, squarer behind, with a waist, higher in front than behind
    /// by `wedge`.
    Drum { half: Place, waist: f64, wedge: f64 },
    /// A tube of elliptic section, infinite along the second axis.
    Tube { half_x: f64, half_z: f64 },
}

impl Form {
    fn distance(&self, p: &Place) -> f64 {
        match *self {
            Self::Cone { from, to, from_radius, to_radius } => {
                let (along, off) = (to - from, p - from);
                let share = (off.dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
                (off - along * share).norm() - (from_radius + (to_radius - from_radius) * share)
            }
            Self::Slab { half, rounding } => {
                let over = p.abs() - half.add_scalar(-rounding);
                over.sup(&Place::zeros()).norm() + over.max().min(0.0) - rounding
            }
            Self::Egg { half } => (p.component_div(&half).norm() - 1.0) * half.min(),
            Self::Drum { half, waist, wedge } => {
                let middle = 0.1 * half.z;
                let (x, z) =
                    (p.x / half.x, (p.z - middle) / if p.z < middle { half.z + middle } else { half.z - middle });
                let (x, z) = (x * x, z * z);
                let round = if p.z < middle { (x + z).sqrt() } else { (x * x + z * z).sqrt().sqrt() };
                let height = half.y - 0.25 * wedge * (p.z / half.z).clamp(-1.0, 1.0);
                let level = (p.y / height).abs().min(1.0);
                let side = (round - 1.0 + waist * (1.0 - level * level)) * half.x.min(half.z);
                join_inside(side, p.y.abs() - height, 1.5)
            }
            Self::Tube { half_x, half_z } => {
                (((p.x / half_x).powi(2) + (p.z / half_z).powi(2)).sqrt() - 1.0) * half_x.min(half_z)
            }
        }
    }

    /// Radius of a ball around the middle that contains the form; infinite for an infinite form.
    fn reach(&self) -> f64 {
        match self {
            Self::Cone { from, to, from_radius, to_radius } => (from.norm() + from_radius).max(to.norm() + to_radius),
            Self::Slab { half, .. } | Self::Egg { half } => half.norm(),
            Self::Drum { half, wedge, .. } => half.norm() + wedge.abs(),
            Self::Tube { .. } => f64::INFINITY,
        }
    }
}

/// The union of two shapes, with a rounded seam.
pub(super) fn join(a: f64, b: f64, rounding: f64) -> f64 {
    let overlap = (rounding - (a - b).abs()).max(0.0);
    a.min(b) - 0.25 * overlap * overlap / rounding.max(1e-9)
}

/// The intersection of two shapes, with a rounded seam.
pub(super) fn join_inside(a: f64, b: f64, rounding: f64) -> f64 {
    -join(-a, -b, rounding)
}

/// A form in its pose, scaled along its own axes.
#[derive(Clone, Debug)]
struct Piece {
    form: Form,
    pose: Pose,
    squeeze: Place,
    rounding: f64,
    /// Radius of a ball around the pose's middle that contains it.
    reach: f64,
}

impl Piece {
    fn distance(&self, p: &Place) -> f64 {
        self.form.distance(&self.pose.to_own(p).component_div(&self.squeeze)) * self.squeeze.min()
    }
}

/// Distance, in mm, beyond which a form is skipped if others are nearer.
const FAR: f64 = 6.0;

/// A union of forms, and the forms subtracted from it.
#[derive(Clone, Debug, Default)]
pub(super) struct Solid {
    pieces: Vec<Piece>,
    cuts: Vec<Piece>,
}

impl Solid {
    /// Adds a form; `rounding` smooths the seam.
    pub(super) fn add(&mut self, form: Form, pose: &Pose, rounding: f64) {
        self.add_squeezed(form, pose, rounding, Place::repeat(1.0));
    }

    /// Adds a form that is scaled along its own axes.
    pub(super) fn add_squeezed(&mut self, form: Form, pose: &Pose, rounding: f64, squeeze: Place) {
        let reach = form.reach() * squeeze.max();
        self.pieces.push(Piece { form, pose: pose.clone(), squeeze, rounding, reach });
    }

    /// Subtracts a form.
    pub(super) fn cut(&mut self, form: Form, pose: &Pose, rounding: f64) {
        let reach = form.reach();
        self.cuts.push(Piece { form, pose: pose.clone(), squeeze: Place::repeat(1.0), rounding, reach });
    }

    /// Signed distance, in mm.
    pub(super) fn distance(&self, p: &Place) -> f64 {
        let joined = self.pieces.iter().fold(f64::INFINITY, |all, piece| {
            let least = (p - piece.pose.middle).norm() - piece.reach;
            if !all.is_finite() {
                piece.distance(p)
            } else if least > (all + piece.rounding).max(FAR) {
                all
            } else {
                join(all, piece.distance(p), piece.rounding)
            }
        });
        self.cuts.iter().fold(joined, |all, cut| join_inside(all, -cut.distance(p), cut.rounding))
    }

    /// A bounding box.
    pub(super) fn bounds(&self) -> Bounds {
        self.pieces.iter().fold(Bounds::NOTHING, |all, piece| all.grown_by_ball(&piece.pose.middle, piece.reach + 1.0))
    }
}

/// An axis-aligned box, in mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// The minimum corner.
    pub(super) least: Place,
    /// The maximum corner.
    pub(super) greatest: Place,
}

impl Bounds {
    /// The empty box.
    pub(super) const NOTHING: Self = Self {
        least: Place::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        greatest: Place::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Extends the box by a ball.
    pub(super) fn grown_by_ball(self, middle: &Place, radius: f64) -> Self {
        Self {
            least: self.least.inf(&middle.add_scalar(-radius)),
            greatest: self.greatest.sup(&middle.add_scalar(radius)),
        }
    }

    /// Distance of a point outside the box; zero inside.
    pub(super) fn distance(&self, p: &Place) -> f64 {
        (self.least - p).sup(&(p - self.greatest)).sup(&Place::zeros()).norm()
    }
}
