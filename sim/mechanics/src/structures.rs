//! Shapes inside the body, through parry3d. The only module that sees parry3d's types.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// What a structure is to the exercise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StructureKind {
    /// Where the needle should go.
    Target,
    /// A vessel to avoid.
    Vessel,
    /// A nerve to avoid.
    Nerve,
    /// Stiff and impenetrable, 2500 N/m.
    Bone,
    /// An organ to avoid.
    Organ,
}

/// A shape in the patient frame, in m.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A ball about the structure's position.
    Sphere {
        /// Radius, in m.
        radius_m: f64,
    },
    /// A capsule from `position − half_axis` to `position + half_axis`.
    Capsule {
        /// Half of the axis vector, in m.
        half_axis_m: Vector3<f64>,
        /// Radius, in m.
        radius_m: f64,
    },
    /// An axis-aligned box about the position.
    Box {
        /// Half of each edge, in m.
        half_extents_m: Vector3<f64>,
    },
    /// A closed triangle mesh, placed with its own origin at the position.
    Mesh {
        /// Vertices, in m.
        vertices_m: Vec<Point3<f64>>,
        /// Triangles, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
}

/// A structure as a scene states it.
#[derive(Clone, Debug, PartialEq)]
pub struct StructureSpec {
    /// Name shown to people.
    pub name: String,
    /// What it is.
    pub kind: StructureKind,
    /// Its shape.
    pub shape: Shape,
    /// Where it is, in the patient frame, in m.
    pub position_m: Point3<f64>,
}
