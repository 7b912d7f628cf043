//! Shapes inside the body, through parry3d. The only module that uses parry3d's types.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::{self, PointProjection, PointQueryWithLocation};
use parry3d_f64::shape::{self, Ball, Cuboid, Segment, TriMesh, TriMeshFlags, TrianglePointLocation};
use serde::{Deserialize, Serialize};

use crate::axial::{Domain, ParamError};

/// Role of a structure in the exercise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StructureKind {
    /// The target of the needle.
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

impl StructureKind {
    /// Names in documents, in their order.
    pub const WORDS: [&str; 5] = ["target", "vessel", "nerve", "bone", "organ"];

    /// Name in documents.
    #[must_use]
    pub const fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }
}

/// A shape in the patient frame, in m.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A sphere around the structure's position.
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
    /// An axis-aligned box around the position.
    Box {
        /// Half of each edge, in m.
        half_extents_m: Vector3<f64>,
    },
    /// A closed triangle mesh, with its origin at the position.
    Mesh {
        /// Vertices, in m.
        vertices_m: Vec<Point3<f64>>,
        /// Triangles, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
}

/// Specification of a structure in a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct StructureSpec {
    /// Name shown to users.
    pub name: String,
    /// Its role.
    pub kind: StructureKind,
    /// Its shape.
    pub shape: Shape,
    /// Position, in the patient frame, in m.
    pub position_m: Point3<f64>,
    /// The wall that the tip feels before it is inside; `None` if nothing is felt.
    pub wall: Option<Wall>,
}

/// The wall of a vessel or an organ: the tip tents it from outside until it ruptures, after which
/// it is open for the track. From inside, on the far side, nothing is felt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Stiffness against the tip's penetration, in N/m.
    pub stiffness_n_per_m: f64,
    /// Rupture force, in N.
    pub rupture_n: f64,
}

/// Vertices in m, patient frame, and triangles, counter-clockwise seen from outside.
pub type Surface = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// Number of segments per turn when a round shape is triangulated.
const STEPS_A_TURN: u32 = 32;

impl StructureSpec {
    /// Its surface, for display.
    #[must_use]
    pub fn surface(&self) -> Surface {
        let (corners, triangles) = match &self.shape {
            Shape::Sphere { radius_m } => Ball::new(*radius_m).to_trimesh(STEPS_A_TURN, STEPS_A_TURN / 2),
            Shape::Capsule { half_axis_m, radius_m } => {
                let half = parry_vector(half_axis_m);
                shape::Capsule::new(-half, half, *radius_m).to_trimesh(STEPS_A_TURN, STEPS_A_TURN / 2)
            }
            Shape::Box { half_extents_m } => Cuboid::new(parry_vector(half_extents_m)).to_trimesh(),
            Shape::Mesh { vertices_m, triangles } => {
                (vertices_m.iter().map(|vertex| parry_vector(&vertex.coords)).collect(), triangles.clone())
            }
        };
        let place = |corner: Vector| self.position_m + Vector3::new(corner.x, corner.y, corner.z);
        (corners.into_iter().map(place).collect(), triangles)
    }
}

/// Stiffness of bone under the tip, in N/m.
pub(crate) const BONE_N_PER_M: f64 = 2500.0;

/// The part of the needle that can meet a structure: from the entry (or the tip itself, in the air)
/// to the tip.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shaft {
    pub entry_m: Point3<f64>,
    pub tip_m: Point3<f64>,
}

/// The point of a structure's surface nearest to a query point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestPlace {
    /// The point, in the patient frame, in m.
    pub at_m: Point3<f64>,
    /// Whether the query point is inside.
    pub inside: bool,
}

/// Relation of a needle to a structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    /// Smallest distance of the shaft, in m, or a lower bound of it if it was not searched; 0 if it
    /// touches.
    pub distance_m: f64,
    /// Whether the tip itself is inside.
    pub tip_inside: bool,
}

/// The last search for a distance, and its result.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sighting {
    pub shaft: Shaft,
    pub distance_m: f64,
}

/// Error bound of a distance search, in m; far above round-off, far below perception.
const SEARCH_ERROR_M: f64 = 1e-6;

impl Sighting {
    /// Lower bound of the distance for another shaft, in m: no point of a segment moves farther
    /// than one of its ends.
    pub fn least_m(&self, now: &Shaft) -> f64 {
        let moved_m = (now.tip_m - self.shaft.tip_m).norm().max((now.entry_m - self.shaft.entry_m).norm());
        self.distance_m - moved_m - SEARCH_ERROR_M
    }
}

/// A checked structure, ready for queries. Queries run in coordinates relative to its position.
#[derive(Debug)]
pub(crate) struct Structure {
    kind: StructureKind,
    wall: Option<Wall>,
    position: Vector,
    solid: Solid,
}

#[derive(Debug)]
enum Solid {
    Ball(Ball),
    Capsule(shape::Capsule),
    Cuboid(Cuboid),
    Mesh(Box<ClosedMesh>),
}

/// A closed mesh, with a normal at every vertex.
#[derive(Debug)]
struct ClosedMesh {
    mesh: TriMesh,
    /// Sums of the normals of the triangles at each vertex, weighted by their angles there
    /// (Bærentzen and Aanæs 2005): they decide between inside and outside if a vertex is nearest.
    /// The library's own depend on the platform's arc cosine.
    normals: Vec<Vector>,
}

impl ClosedMesh {
    fn new(mesh: TriMesh) -> Self {
        let mut normals = vec![Vector::ZERO; mesh.vertices().len()];
        for (triangle, corners) in mesh.triangles().zip(mesh.indices()) {
            let Some(normal) = triangle.normal() else { continue };
            let at = [triangle.a, triangle.b, triangle.c];
            for (corner, &vertex) in corners.iter().enumerate() {
                let [one, other] = [1, 2].map(|next| at[(corner + next) % 3] - at[corner]);
                let cosine = one.dot(other) / (one.length() * other.length());
                normals[vertex as usize] += normal * libm::acos(cosine.clamp(-1.0, 1.0));
            }
        }
        Self { mesh, normals }
    }

    /// The nearest point of the surface, and whether the query point is inside.
    fn project(&self, point: Vector) -> PointProjection {
        let (mut nearest, (triangle, location)) = self.mesh.project_local_point_and_get_location(point, false);
        if let TrianglePointLocation::OnVertex(corner) = location {
            let vertex = self.mesh.indices()[triangle as usize][corner as usize];
            nearest.is_inside = (point - nearest.point).dot(self.normals[vertex as usize]) <= 0.0;
        }
        nearest
    }
}

impl Solid {
    fn shape(&self) -> &dyn shape::Shape {
        match self {
            Self::Ball(ball) => ball,
            Self::Capsule(capsule) => capsule,
            Self::Cuboid(cuboid) => cuboid,
            Self::Mesh(closed) => &closed.mesh,
        }
    }

    /// The nearest point of the surface, or of the whole volume if `solid`; and whether the query
    /// point is inside.
    fn project(&self, point: Vector, solid: bool) -> PointProjection {
        match self {
            Self::Mesh(closed) => closed.project(point),
            Self::Ball(_) | Self::Capsule(_) | Self::Cuboid(_) => self.shape().project_local_point(point, solid),
        }
    }
}

/// Structures of one kind, to be searched along straight lines.
#[derive(Debug)]
pub struct Obstacles {
    structures: Vec<(String, Structure)>,
}

impl Obstacles {
    /// The structures of a kind among some.
    ///
    /// # Errors
    /// As [`crate::puncture::PunctureParams::new`], of the first that makes no sense.
    pub fn new(specs: &[StructureSpec], kind: StructureKind) -> Result<Self, ParamError> {
        let of_kind = specs.iter().enumerate().filter(|(_, spec)| spec.kind == kind);
        let built = of_kind.map(|(index, spec)| Ok((spec.name.clone(), Structure::new(index, spec)?)));
        Ok(Self { structures: built.collect::<Result<_, ParamError>>()? })
    }

    /// The first structure that a point meets on its way along an axis of unit length, and how far it has come by then, in m; none within
    /// `length_m`. Found by steps as long as the distance to the nearest one, to a hundredth of a millimetre.
    #[must_use]
    pub fn first_met(&self, from_m: &Point3<f64>, axis: &Vector3<f64>, length_m: f64) -> Option<(&str, f64)> {
        const NEAR_M: f64 = 1e-5;
        let mut way_m = 0.0;
        while way_m <= length_m {
            let at_m = from_m + axis * way_m;
            let distances = self.structures.iter().map(|(name, structure)| {
                let meeting = structure.meet(&Shaft { entry_m: at_m, tip_m: at_m });
                (name.as_str(), meeting.distance_m)
            });
            let (name, distance_m) = distances.min_by(|a, b| a.1.total_cmp(&b.1))?;
            if distance_m < NEAR_M {
                return Some((name, way_m));
            }
            way_m += distance_m;
        }
        None
    }
}

impl Structure {
    /// Checks a structure and builds its shape; `index` is used for errors only.
    pub fn new(index: usize, spec: &StructureSpec) -> Result<Self, ParamError> {
        let name = format!("structures[{index}] ({})", spec.name);
        check_vector(&format!("{name}.position_m"), &spec.position_m.coords)?;
        if let Some(wall) = &spec.wall {
            Domain::Positive.check(format!("{name}.wall.stiffness_n_per_m"), wall.stiffness_n_per_m, "N/m")?;
            Domain::NotNegative.check(format!("{name}.wall.rupture_n"), wall.rupture_n, "N")?;
        }
        let solid = build_solid(&name, &spec.shape)?;
        Ok(Self { kind: spec.kind, wall: spec.wall, position: parry_vector(&spec.position_m.coords), solid })
    }

    pub fn kind(&self) -> StructureKind {
        self.kind
    }

    /// Distance of the shaft, and whether the tip is inside.
    pub fn meet(&self, shaft: &Shaft) -> Meeting {
        let tip = parry_vector(&shaft.tip_m.coords) - self.position;
        let entry = parry_vector(&shaft.entry_m.coords) - self.position;
        let nearest = self.solid.project(tip, true);
        if nearest.is_inside {
            return Meeting { distance_m: 0.0, tip_inside: true };
        }
        // A segment of zero length has no direction for the closest-point search; the tip's own
        // distance also bounds the shaft's from above if that search fails.
        let from_tip = (nearest.point - tip).length();
        let from_shaft = if entry == tip { from_tip } else { self.shaft_distance(Segment::new(entry, tip)) };
        Meeting { distance_m: from_shaft.min(from_tip), tip_inside: false }
    }

    fn shaft_distance(&self, shaft: Segment) -> f64 {
        query::distance(&Pose::IDENTITY, &shaft, &Pose::IDENTITY, self.solid.shape())
            .map_or(f64::INFINITY, |found| found.distance)
    }

    /// The nearest point of the surface.
    pub fn nearest(&self, point_m: &Point3<f64>) -> NearestPlace {
        let found = self.solid.project(parry_vector(&point_m.coords) - self.position, false);
        let at = found.point + self.position;
        NearestPlace { at_m: Point3::new(at.x, at.y, at.z), inside: found.is_inside }
    }

    /// Force on a needle's tip that is inside, in N: of bone, or of a wall that is still closed; 0
    /// for any other structure.
    pub fn tip_force_n(&self, tip_m: &Point3<f64>, wall_open: bool) -> Vector3<f64> {
        let stiffness_n_per_m = match (self.kind, self.wall) {
            (StructureKind::Bone, _) => BONE_N_PER_M,
            (_, Some(wall)) if !wall_open => wall.stiffness_n_per_m,
            _ => return Vector3::zeros(),
        };
        self.outward_m(tip_m) * stiffness_n_per_m
    }

    /// Whether the tip presses on the wall with at least its rupture force.
    pub fn opens_wall(&self, tip_m: &Point3<f64>) -> bool {
        self.wall.is_some_and(|wall| {
            let force_n = self.outward_m(tip_m).norm() * wall.stiffness_n_per_m;
            force_n > 0.0 && force_n >= wall.rupture_n
        })
    }

    /// The shortest displacement that moves a tip inside to the surface, in m; 0 for one outside.
    pub fn outward_m(&self, tip_m: &Point3<f64>) -> Vector3<f64> {
        let tip = parry_vector(&tip_m.coords) - self.position;
        let nearest = self.solid.project(tip, false);
        let outward = nearest.point - tip;
        // At the very centre of a sphere no direction is outward.
        if nearest.is_inside && outward.is_finite() {
            Vector3::new(outward.x, outward.y, outward.z)
        } else {
            Vector3::zeros()
        }
    }
}

fn parry_vector(vector: &Vector3<f64>) -> Vector {
    Vector::new(vector.x, vector.y, vector.z)
}

fn check_vector(field: &str, vector: &Vector3<f64>) -> Result<(), ParamError> {
    vector.iter().try_for_each(|&coordinate| Domain::Coordinate.check(field, coordinate, "m"))
}

fn build_solid(name: &str, shape: &Shape) -> Result<Solid, ParamError> {
    match shape {
        Shape::Sphere { radius_m } => {
            Domain::Positive.check(format!("{name}.radius_m"), *radius_m, "m")?;
            Ok(Solid::Ball(Ball::new(*radius_m)))
        }
        Shape::Capsule { half_axis_m, radius_m } => {
            Domain::Positive.check(format!("{name}.radius_m"), *radius_m, "m")?;
            check_vector(&format!("{name}.half_axis_m"), half_axis_m)?;
            let half = parry_vector(half_axis_m);
            Ok(Solid::Capsule(shape::Capsule::new(-half, half, *radius_m)))
        }
        Shape::Box { half_extents_m } => {
            half_extents_m
                .iter()
                .try_for_each(|&half| Domain::Positive.check(format!("{name}.half_extents_m"), half, "m"))?;
            Ok(Solid::Cuboid(Cuboid::new(parry_vector(half_extents_m))))
        }
        Shape::Mesh { vertices_m, triangles } => build_mesh(name, vertices_m, triangles),
    }
}

/// Builds a closed, outward-oriented mesh. Vertices at the same position are merged first: file
/// formats such as STL repeat them.
fn build_mesh(name: &str, vertices_m: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Solid, ParamError> {
    let refuse = |value: f64, unit, allowed| ParamError { field: format!("{name}.mesh"), value, unit, allowed };
    vertices_m.iter().try_for_each(|vertex| check_vector(&format!("{name}.mesh.vertices_m"), &vertex.coords))?;
    if triangles.is_empty() {
        return Err(refuse(0.0, "triangles", "must have at least 4 triangles"));
    }
    let known = vertices_m.len();
    if let Some(index) = triangles.iter().flatten().find(|index| **index as usize >= known) {
        return Err(refuse(f64::from(*index), "(vertex index)", "must be the index of a vertex"));
    }
    let vertices = vertices_m.iter().map(|vertex| parry_vector(&vertex.coords)).collect();
    let flags = TriMeshFlags::ORIENTED | TriMeshFlags::MERGE_DUPLICATE_VERTICES;
    let mesh = TriMesh::with_flags(vertices, triangles.to_vec(), flags)
        .map_err(|_| refuse(triangles.len() as f64, "triangles", "must form a surface"))?;
    let open = open_edges(mesh.indices());
    if open > 0 {
        return Err(refuse(open as f64, "open edges", "must be closed: each edge in two triangles, once each way"));
    }
    let volume_m3 = signed_volume(&mesh);
    if volume_m3 <= 0.0 {
        return Err(refuse(volume_m3, "m³", "must have triangles counter-clockwise seen from outside"));
    }
    Ok(Solid::Mesh(Box::new(ClosedMesh::new(mesh))))
}

/// Number of directed edges that occur twice, or lack the opposite one.
fn open_edges(triangles: &[[u32; 3]]) -> usize {
    let edges = || triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let mut seen = BTreeSet::new();
    let repeated = edges().filter(|edge| !seen.insert(*edge)).count();
    repeated + seen.iter().filter(|(a, b)| !seen.contains(&(*b, *a))).count()
}

/// Volume by the divergence theorem, in m³; negative if the triangles face inwards.
fn signed_volume(mesh: &TriMesh) -> f64 {
    mesh.triangles().map(|triangle| triangle.a.dot(triangle.b.cross(triangle.c)) / 6.0).sum()
}
