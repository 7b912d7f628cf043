//! Distance between a straight shaft and a structure, 0 if they intersect.

use documents::{Shape, StructureSpec};
use nalgebra::{Point3, Vector3};

/// A line segment of the needle, in m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// One end.
    pub(crate) from: Point3<f64>,
    /// The other end.
    pub(crate) to: Point3<f64>,
}

impl Segment {
    /// Returns the largest distance between the ends of two segments, in m: no point has moved
    /// farther from its counterpart.
    pub(crate) fn moved_m(&self, other: &Self) -> f64 {
        (other.from - self.from).norm().max((other.to - self.to).norm())
    }

    fn at(&self, share: f64) -> Point3<f64> {
        self.from + (self.to - self.from) * share
    }
}

/// Returns the resolution to which the smallest distance to a shape is searched, in m. A mesh has
/// no closed form and may have thousands of triangles, so it is evaluated every 0.05 mm.
pub(crate) fn resolution_m(shape: &Shape) -> f64 {
    if matches!(shape, Shape::Mesh { .. }) { 0.05e-3 } else { 0.0 }
}

/// Number of triangles of a mesh that share a bounding sphere: neighbours in a file are mostly
/// neighbours in space.
const GROUP: usize = 32;
/// Margin for rounding errors of a bound, in m.
const ROUNDING_M: f64 = 1e-12;

/// A structure prepared for many distance queries.
pub(crate) struct MeasuredStructure<'a> {
    spec: &'a StructureSpec,
    groups: Vec<TriangleGroup>,
}

/// A group of triangles with its bounding sphere.
struct TriangleGroup {
    centre: Point3<f64>,
    radius_m: f64,
    triangles: Vec<[Point3<f64>; 3]>,
}

impl<'a> MeasuredStructure<'a> {
    pub(crate) fn new(spec: &'a StructureSpec) -> Self {
        let groups = match &spec.shape {
            Shape::Mesh { vertices_m, triangles } => {
                let vertex = |i: u32| vertices_m.get(i as usize).map(|v| spec.position_m + v.coords);
                let corners = |t: &[u32; 3]| Some([vertex(t[0])?, vertex(t[1])?, vertex(t[2])?]);
                let triangles: Vec<_> = triangles.iter().filter_map(corners).collect();
                triangles.chunks(GROUP).map(TriangleGroup::new).collect()
            }
            Shape::Sphere { .. } | Shape::Capsule { .. } | Shape::Box { .. } => Vec::new(),
        };
        Self { spec, groups }
    }

    /// Returns the distance of a segment, in m. A mesh is its surface: a shaft that enters through
    /// the skin crosses it on the way in.
    pub(crate) fn distance_m(&self, segment: &Segment) -> f64 {
        let centre = self.spec.position_m;
        match &self.spec.shape {
            Shape::Sphere { radius_m } => (distance_to_point(segment, centre) - radius_m).max(0.0),
            Shape::Capsule { half_axis_m, radius_m } => {
                let core = Segment { from: centre - half_axis_m, to: centre + half_axis_m };
                (between_segments(segment, &core) - radius_m).max(0.0)
            }
            Shape::Box { half_extents_m } => distance_to_box(segment, centre, half_extents_m),
            Shape::Mesh { .. } => self.to_mesh_m(segment),
        }
    }

    /// Visits the groups in order of their lower bounds until none can be nearer than the smallest
    /// distance found.
    fn to_mesh_m(&self, segment: &Segment) -> f64 {
        let mut groups: Vec<(f64, &TriangleGroup)> = self
            .groups
            .iter()
            .map(|group| (distance_to_point(segment, group.centre) - group.radius_m - ROUNDING_M, group))
            .collect();
        groups.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let mut least_m = f64::INFINITY;
        for (at_least_m, group) in groups {
            if at_least_m > least_m {
                break;
            }
            for triangle in &group.triangles {
                if may_be_nearer(segment, triangle, least_m) {
                    least_m = least_m.min(distance_to_triangle(segment, triangle));
                }
            }
        }
        least_m
    }
}

impl TriangleGroup {
    fn new(triangles: &[[Point3<f64>; 3]]) -> Self {
        let corners = || triangles.iter().flatten();
        let sum: Vector3<f64> = corners().map(|corner| corner.coords).sum();
        let centre = Point3::from(sum / (3 * triangles.len()).max(1) as f64);
        let radius_m = corners().map(|corner| (corner - centre).norm()).fold(0.0, f64::max);
        Self { centre, radius_m, triangles: triangles.to_vec() }
    }
}

/// Returns the parameter (0–1) of the segment's point nearest to `point`.
fn nearest_share(segment: &Segment, point: Point3<f64>) -> f64 {
    let along = segment.to - segment.from;
    let length_squared = along.norm_squared();
    if length_squared > 0.0 { ((point - segment.from).dot(&along) / length_squared).clamp(0.0, 1.0) } else { 0.0 }
}

fn distance_to_point(segment: &Segment, point: Point3<f64>) -> f64 {
    (segment.at(nearest_share(segment, point)) - point).norm()
}

/// Returns the distance of two segments: nearest points of the two lines, clamped to the segments
/// (Ericson, Real-Time Collision Detection, section 5.1.9).
fn between_segments(a: &Segment, b: &Segment) -> f64 {
    let (u, v, w) = (a.to - a.from, b.to - b.from, a.from - b.from);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let determinant = uu * vv - uv * uv;
    let crossing = (uv * v.dot(&w) - vv * u.dot(&w)) / determinant;
    let inner = if determinant > 0.0 { crossing.clamp(0.0, 1.0) } else { 0.0 };
    // Each end against the other segment covers parallel, degenerate and skew pairs whose nearest
    // points lie beyond an end.
    let ends = [
        distance_to_point(a, b.from),
        distance_to_point(a, b.to),
        distance_to_point(b, a.from),
        distance_to_point(b, a.to),
    ];
    ends.into_iter().fold(distance_to_point(b, a.at(inner)), f64::min)
}

/// Returns the distance of a segment to a box. The squared distance along the segment is convex
/// and, between the planes of the box's faces, a parabola: the minimum is at an end, at a plane, or
/// at a parabola's vertex.
fn distance_to_box(segment: &Segment, centre: Point3<f64>, half: &Vector3<f64>) -> f64 {
    let (start, along) = (segment.from - centre, segment.to - segment.from);
    let outside = |share: f64| (start + along * share).zip_map(half, |c, h| c - c.clamp(-h, h));
    let mut shares = vec![0.0, 1.0];
    for (i, half_extent_m) in half.iter().enumerate().filter(|(i, _)| along[*i].abs() > 0.0) {
        shares.extend([-half_extent_m, *half_extent_m].map(|face| (face - start[i]) / along[i]));
    }
    shares.retain(|share| (0.0..=1.0).contains(share));
    shares.sort_by(f64::total_cmp);
    let vertices = shares.windows(2).map(|piece| {
        let middle = (piece[0] + piece[1]) / 2.0;
        let beyond = outside(middle);
        let slope = along.zip_map(&beyond, |a, o| if o.abs() > 0.0 { a } else { 0.0 });
        let curvature = slope.norm_squared();
        if curvature > 0.0 { (middle - beyond.dot(&slope) / curvature).clamp(piece[0], piece[1]) } else { middle }
    });
    let candidates: Vec<f64> = vertices.chain(shares.iter().copied()).collect();
    candidates.into_iter().map(|share| outside(share).norm()).fold(f64::INFINITY, f64::min)
}

/// Returns whether a triangle may be nearer than a distance in m. None of its points is farther
/// from its first vertex than the longer edge there. This bound avoids the full computation for
/// most of a mesh's thousands of triangles at each position of the needle.
fn may_be_nearer(segment: &Segment, [a, b, c]: &[Point3<f64>; 3], least_m: f64) -> bool {
    let reach_m = (b - a).norm().max((c - a).norm());
    distance_to_point(segment, *a) - reach_m <= least_m + ROUNDING_M
}

/// Returns 0 if the segment crosses the triangle; otherwise the smallest distance of its ends to
/// the face and of itself to the edges.
fn distance_to_triangle(segment: &Segment, triangle: &[Point3<f64>; 3]) -> f64 {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(&(c - a));
    let (from_side, to_side) = (normal.dot(&(segment.from - a)), normal.dot(&(segment.to - a)));
    if from_side * to_side < 0.0 && is_above_triangle(segment.at(from_side / (from_side - to_side)), triangle, &normal)
    {
        return 0.0;
    }
    let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| between_segments(segment, &Segment { from, to }));
    let length = normal.norm();
    let faces = [(segment.from, from_side), (segment.to, to_side)]
        .map(|(end, side)| if is_above_triangle(end, triangle, &normal) { side.abs() / length } else { f64::INFINITY });
    edges.into_iter().chain(faces).fold(f64::INFINITY, f64::min)
}

/// Returns whether a point's projection to the triangle's plane lies in the triangle; `false` for a
/// degenerate triangle.
fn is_above_triangle(point: Point3<f64>, triangle: &[Point3<f64>; 3], normal: &Vector3<f64>) -> bool {
    let edge = |i: usize| (triangle[(i + 1) % 3] - triangle[i]).cross(&(point - triangle[i])).dot(normal) >= 0.0;
    normal.norm_squared() > 0.0 && (0..3).all(edge)
}

#[cfg(test)]
mod tests {
    //! The distance of a segment is the smallest distance of its points; this covers every edge,
    //! face, parabola and crossing of the closed forms.

    use documents::StructureKind;
    use proptest::prelude::*;

    use super::*;

    fn point() -> impl Strategy<Value = Point3<f64>> {
        prop::array::uniform3(prop_oneof![4 => -3.0..3.0_f64, 1 => Just(0.0), 1 => Just(1.0)]).prop_map(Point3::from)
    }

    fn shape() -> impl Strategy<Value = Shape> {
        prop_oneof![
            Just(Shape::Sphere { radius_m: 0.7 }),
            point().prop_map(|p| Shape::Capsule { half_axis_m: p.coords, radius_m: 0.3 }),
            point().prop_map(|p| Shape::Box { half_extents_m: p.coords.abs() }),
            [point(), point(), point()]
                .prop_map(|corners| Shape::Mesh { vertices_m: corners.to_vec(), triangles: vec![[0, 1, 2]] }),
        ]
    }

    fn mesh(corners: &[[Point3<f64>; 3]]) -> StructureSpec {
        let vertices_m = corners.iter().flatten().copied().collect();
        let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let shape = Shape::Mesh { vertices_m, triangles };
        StructureSpec {
            name: String::new(),
            kind: StructureKind::Organ,
            shape,
            position_m: Point3::origin(),
            wall: None,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

        #[test]
        fn a_mesh_is_as_near_as_the_nearest_of_its_triangles(
            (from, to) in (point(), point()),
            corners in prop::collection::vec([point(), point(), point()], 1..200),
        ) {
            let segment = Segment { from, to };
            let nearest_m = |triangles: &[[Point3<f64>; 3]]| MeasuredStructure::new(&mesh(triangles)).distance_m(&segment);
            let alone_m = corners.iter().map(|corners| nearest_m(&[*corners])).fold(f64::INFINITY, f64::min);
            prop_assert_eq!(nearest_m(&corners).to_bits(), alone_m.to_bits());
        }

        #[test]
        fn no_point_of_the_segment_is_nearer_and_one_is_as_near(
            (from, to) in (point(), point()), shape in shape(), position_m in point(),
        ) {
            let spec = StructureSpec { name: String::new(), kind: StructureKind::Organ, shape, position_m, wall: None };
            let segment = Segment { from, to };
            let measured = MeasuredStructure::new(&spec);
            let distance = measured.distance_m(&segment);
            let steps = 500;
            let of_point = |i: i32| {
                let at = segment.at(f64::from(i) / f64::from(steps));
                measured.distance_m(&Segment { from: at, to: at })
            };
            let nearest = (0..=steps).map(of_point).fold(f64::INFINITY, f64::min);
            let step_m = (to - from).norm() / f64::from(steps);
            prop_assert!(distance <= nearest + 1e-9, "{} but a point is at {}", distance, nearest);
            prop_assert!(distance >= nearest - step_m, "{} but no point is nearer than {}", distance, nearest);
        }
    }
}
