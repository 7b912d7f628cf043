//! The entry of a needle into a body, as the frame for the layers and meshes below it.

use nalgebra::{Matrix3, Point3, Vector3};

use super::form::Place;
use super::part::{AnatomyPart, Level};
use super::surface::BodyMesh;
use super::{Body, BodyQuality, LayerOnPath};

/// Radius around the entry, in mm, over which the slope of the skin is averaged: the scale at which
/// a hand feels it.
const LEAN_OVER: f64 = 12.0;
/// Maximum distance between a mesh and its shape, in cells of its grid.
const MARGIN_CELLS: f64 = 2.0;
/// Maximum slope of the signed distances, at joined shapes.
const STEEPEST: f64 = 1.3;

/// A point on a body's skin and the frame of a needle that enters there.
#[derive(Clone, Copy, Debug)]
pub struct BodyEntry {
    /// The point on the skin, in the body's frame, in m.
    pub origin_m: Point3<f64>,
    /// Columns: towards the patient's right, towards the head, out of the skin, each of unit
    /// length.
    pub axes: Matrix3<f64>,
}

impl BodyEntry {
    /// Converts a point from the body's frame to this one, in m.
    #[must_use]
    pub fn to_own(&self, body_m: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.axes.tr_mul(&(body_m - self.origin_m)))
    }

    /// Converts a direction from this frame to the body's.
    #[must_use]
    pub fn to_body(&self, own: &Vector3<f64>) -> Vector3<f64> {
        self.axes * own
    }
}

impl Body {
    /// The entry at an offset from the palpated middle of an interspace, in m to the patient's
    /// right and towards the head.
    #[must_use]
    pub fn enter(&self, level: Level, right_m: f64, head_m: f64) -> BodyEntry {
        let felt = self.midline_path(level, 0.0).entry_m;
        let inside = self.inner(&felt) + Place::new(right_m * 1e3, head_m * 1e3, -40.0);
        let depth = |right: f64, head: f64| self.skin_depth(&(inside + Place::new(right, head, 0.0)));
        let on_skin = Place::new(inside.x, inside.y, depth(0.0, 0.0));
        let rise = |right: f64, head: f64| depth(right, head) - depth(-right, -head);
        let (along_right, along_head) = (rise(LEAN_OVER, 0.0), rise(0.0, LEAN_OVER));
        let out = Vector3::new(-along_right, -along_head, 2.0 * LEAN_OVER).normalize();
        let head = (Vector3::y() - out * out.y).normalize();
        let axes = Matrix3::from_columns(&[head.cross(&out), head, out]);
        BodyEntry { origin_m: Point3::from((on_skin - self.origin) * 1e-3), axes }
    }

    /// Lists the tissues along a straight needle from an entry, in a direction of the entry's
    /// frame, over a length in m.
    #[must_use]
    pub fn list_layers_from(&self, entry: &BodyEntry, own: &Vector3<f64>, length_m: f64) -> Vec<LayerOnPath> {
        self.list_layers(&(entry.origin_m + entry.to_body(own) * -1e-6), &entry.to_body(own), length_m)
    }

    /// The closed surface of a part in the frame of an entry, in m.
    #[must_use]
    pub fn mesh_from(&self, entry: &BodyEntry, part: AnatomyPart, quality: BodyQuality) -> BodyMesh {
        let mut mesh = self.mesh(part, quality);
        mesh.vertices_m.iter_mut().for_each(|vertex| *vertex = entry.to_own(vertex));
        mesh
    }

    /// A lower bound of the distance from a point of the body to any vertex of a part's mesh, in m,
    /// computed from the shape without making the mesh.
    #[must_use]
    pub fn least_distance_m(&self, part: AnatomyPart, quality: BodyQuality, body_m: &Point3<f64>) -> f64 {
        let place = self.inner(body_m);
        let off_mesh = MARGIN_CELLS * Self::cell_of(part, quality);
        let bone = match part {
            AnatomyPart::LastThoracic => Some(0),
            AnatomyPart::Vertebra(level) => Some(level as usize + 1),
            _ => None,
        };
        let distance = match bone {
            // Without the subtraction of the bone above, which could only increase the distance.
            Some(at) => self.column[at].shape_distance(&place),
            None => self.part_distance(part, &place),
        };
        (distance / STEEPEST - off_mesh) * 1e-3
    }
}
