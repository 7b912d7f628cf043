//! The entry of a needle into a body, and the layers below it.

use law::structures::Surface;
use nalgebra::{Matrix3, Point3, Vector3};

use super::error::SegmentationError;
use super::map::LabelMap;

/// Widest gap between labels that counts as a seam, in m. Our choice.
const WIDEST_SEAM_M: f64 = 5e-3;
/// Maximum distance of a stated entry from the skin, in m: a few voxels, or the precision of a
/// clicked point.
const NEAR_M: f64 = 0.02;
/// Radius around the entry over which the skin's direction is averaged, in m: larger than voxel
/// steps, smaller than a body's curvature.
const PATCH_M: f64 = 0.01;
/// Cosine of the maximum angle between a stated direction and the skin's own: 60°, the maximum
/// inclination of a needle.
const LEAST_COSINE: f64 = 0.5;
/// Maximum depth of the search for layers, in m.
const DEEPEST_M: f64 = 0.25;
/// Sampling step of the depth, as a fraction of a voxel's shortest edge.
const SAMPLE: f64 = 0.1;
/// Number of rings of rays around the entry's normal, and of rays per ring, so that voxel steps
/// average out.
const RINGS: usize = 5;
const RAYS_A_RING: usize = 12;
/// Radius of the outermost ring, in edges of the longest voxel.
const RING: f64 = 3.0;
/// Minimum thickness of a layer, as a fraction of a voxel's shortest edge: a thinner one is a voxel
/// step.
const LEAST_LAYER: f64 = 0.5;

/// The patient frame of an entry: the origin on the skin, +z out of the body, +y towards the head,
/// projected perpendicular to z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EntryFrame {
    /// The origin in the world, in m.
    pub origin_m: Point3<f64>,
    /// Rotation from the world to the patient frame: the rows are the axes of the patient frame in
    /// the world.
    pub to_patient: Matrix3<f64>,
    /// The skin's own outward direction at the entry, in the world.
    pub normal: Vector3<f64>,
    /// Angle between that and +z, in radians.
    pub tilt_rad: f64,
}

impl EntryFrame {
    /// The frame at the point of the skin nearest to a stated one in the world, in m. +z is `up`
    /// (in the world), or the skin's own direction if `up` is absent.
    ///
    /// # Errors
    /// If the entry is far from the skin, or the direction does not point outwards.
    pub fn new(
        (vertices_m, triangles): &Surface,
        at_m: Point3<f64>,
        up: Option<Vector3<f64>>,
    ) -> Result<Self, SegmentationError> {
        let skin = Skin { vertices_m, triangles };
        let near_m = skin.nearest(&at_m);
        let away_m = (near_m - at_m).norm();
        // Written so that a NaN distance fails.
        let is_near = away_m <= NEAR_M;
        if !is_near {
            return Err(SegmentationError::EntryAway { away_mm: away_m * 1e3, most_mm: NEAR_M * 1e3 });
        }
        let normal = skin.normal_about(&near_m);
        let z = up.and_then(|up| up.try_normalize(1e-9)).unwrap_or(normal);
        let cosine = z.dot(&normal);
        let leads_out = cosine > LEAST_COSINE;
        if !leads_out {
            let angle_deg = libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees();
            return Err(SegmentationError::UpInwards { angle_deg });
        }
        let origin_m = skin.crossing(&near_m, &z).unwrap_or(near_m);
        let head = if z.z.abs() < 0.9 { Vector3::z() } else { Vector3::y() };
        let y = (head - z * head.dot(&z)).normalize();
        let to_patient = Matrix3::from_rows(&[y.cross(&z).transpose(), y.transpose(), z.transpose()]);
        Ok(Self { origin_m, to_patient, normal, tilt_rad: libm::acos(cosine.clamp(-1.0, 1.0)) })
    }

    /// Transforms a surface from the world to the patient frame, in m.
    #[must_use]
    pub fn place(&self, (vertices_m, triangles): &Surface) -> Surface {
        let place = |vertex: &Point3<f64>| Point3::from(self.to_patient * (vertex - self.origin_m));
        (vertices_m.iter().map(place).collect(), triangles.clone())
    }
}

struct Skin<'s> {
    vertices_m: &'s [Point3<f64>],
    triangles: &'s [[u32; 3]],
}

impl Skin<'_> {
    fn corners(&self) -> impl Iterator<Item = [&Point3<f64>; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|v| &self.vertices_m[v as usize]))
    }

    /// The vertex nearest to a point.
    fn nearest(&self, at_m: &Point3<f64>) -> Point3<f64> {
        let squared = |vertex: &&Point3<f64>| (*vertex - at_m).norm_squared();
        self.vertices_m.iter().min_by(|one, other| squared(one).total_cmp(&squared(other))).copied().unwrap_or_default()
    }

    /// Area-weighted mean normal of the triangles around a point.
    fn normal_about(&self, at_m: &Point3<f64>) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for [a, b, c] in self.corners() {
            let middle = (a.coords + b.coords + c.coords) / 3.0;
            if (middle - at_m.coords).norm() <= PATCH_M {
                sum += (b - a).cross(&(c - a));
            }
        }
        sum.try_normalize(1e-15).unwrap_or_else(Vector3::z)
    }

    /// The intersection of the skin with a line through a point, nearest to the point.
    fn crossing(&self, at_m: &Point3<f64>, along: &Vector3<f64>) -> Option<Point3<f64>> {
        let distances = self.corners().filter_map(|corners| crossing(corners, at_m, along));
        let nearest = distances.min_by(|one, other| one.abs().total_cmp(&other.abs()))?;
        Some(at_m + along * nearest)
    }
}

/// Parameter along a line of its intersection with a triangle (Möller and Trumbore 1997).
fn crossing([a, b, c]: [&Point3<f64>; 3], from: &Point3<f64>, along: &Vector3<f64>) -> Option<f64> {
    let (one, other) = (b - a, c - a);
    let normal = along.cross(&other);
    let whole = one.dot(&normal);
    let offset = from - a;
    let across = offset.cross(&one);
    let (u, v) = (offset.dot(&normal) / whole, along.dot(&across) / whole);
    let is_inside = u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9;
    (whole != 0.0 && is_inside).then(|| other.dot(&across) / whole)
}

/// A layer below an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredLayer {
    /// Its label.
    pub label: u16,
    /// Its thickness along the skin's normal, in m.
    pub thickness_m: f64,
    /// Whether it is the last layer: the body, the image or the search ends below it.
    pub is_last: bool,
    /// The label below it, if that is unnamed: the layers end there.
    pub unnamed_below: Option<u16>,
}

/// Role of a label for a needle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelRole {
    /// A layer.
    Layer,
    /// A structure, which lies within a surrounding layer.
    Structure,
    /// Not named by the user.
    Unnamed,
}

/// Measures the layers along the skin's normal at an entry, from the skin down, as far as labels
/// are named: an unnamed label may be anything, such as the organs below the muscles of a back.
/// Seams between labels, and structures, belong to the layer above.
///
/// At each depth below the skin the most frequent label of 61 rays counts, all within three voxels
/// of the normal.
///
/// # Errors
/// If there is no layer.
#[expect(clippy::expect_used, reason = "the header's check refuses voxels that span no volume")]
pub fn measure_layers(
    map: &LabelMap,
    frame: &EntryFrame,
    role: &dyn Fn(u16) -> LabelRole,
) -> Result<Vec<MeasuredLayer>, SegmentationError> {
    let edges_m = map.edges_m();
    let [shortest_m, longest_m] =
        [edges_m.into_iter().fold(f64::INFINITY, f64::min), edges_m.into_iter().fold(0.0, f64::max)];
    let step_m = SAMPLE * shortest_m;
    let to_index = map.placement.steps_m.try_inverse().expect("the header's check has found a volume");
    let rays = rays_about(frame, longest_m);
    let starts: Vec<_> = rays.iter().filter_map(|from| find_skin(map, &to_index, frame, from, step_m)).collect();
    let mut runs: Vec<(u16, f64)> = Vec::new();
    let (mut unnamed_m, mut unnamed_below) = (0.0, None);
    let steps = (DEEPEST_M / step_m) as usize;
    for step in 0..steps {
        let depth_m = (step as f64 + 0.5) * step_m;
        let met = starts.iter().map(|start| map.label_at(&to_index, &(start - frame.normal * depth_m)));
        let Some(most) = most_frequent(met) else { break };
        if most == 0 {
            break;
        }
        match (role(most), runs.last_mut()) {
            // Labels above the first layer belong to it.
            (LabelRole::Structure | LabelRole::Unnamed, None) => {}
            (LabelRole::Layer, None) => runs.push((most, step_m)),
            (LabelRole::Unnamed, Some(_)) => {
                unnamed_m += step_m;
                if unnamed_m > WIDEST_SEAM_M {
                    unnamed_below = Some(most);
                    break;
                }
            }
            (found, Some((label, thickness_m))) => {
                *thickness_m += std::mem::take(&mut unnamed_m);
                if found == LabelRole::Structure || *label == most {
                    *thickness_m += step_m;
                } else {
                    runs.push((most, step_m));
                }
            }
        }
    }
    let runs = drop_stairs(runs, LEAST_LAYER * shortest_m);
    let count = runs.len();
    let layer = |(at, (label, thickness_m)): (usize, (u16, f64))| MeasuredLayer {
        label,
        thickness_m,
        is_last: at + 1 == count,
        unnamed_below: unnamed_below.filter(|_| at + 1 == count),
    };
    if count == 0 { Err(SegmentationError::NoLayers) } else { Ok(runs.into_iter().enumerate().map(layer).collect()) }
}

/// Origins of the rays: on the normal, and in rings around it.
fn rays_about(frame: &EntryFrame, voxel_m: f64) -> Vec<Point3<f64>> {
    let other = if frame.normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let one = frame.normal.cross(&other).normalize();
    let two = frame.normal.cross(&one);
    let on_ring = |ring: usize, at: usize| {
        // Each ring is rotated slightly, so that rays are not aligned with the voxels.
        let angle = (at as f64 + 0.37 * ring as f64) * 2.0 * std::f64::consts::PI / RAYS_A_RING as f64;
        let radius_m = RING * voxel_m * ring as f64 / RINGS as f64;
        frame.origin_m + (one * libm::cos(angle) + two * libm::sin(angle)) * radius_m
    };
    let rings = (1..=RINGS).flat_map(|ring| (0..RAYS_A_RING).map(move |at| (ring, at)));
    std::iter::once(frame.origin_m).chain(rings.map(|(ring, at)| on_ring(ring, at))).collect()
}

/// The point at which a ray enters the body from outside, near its origin.
fn find_skin(
    map: &LabelMap,
    to_index: &Matrix3<f64>,
    frame: &EntryFrame,
    at_m: &Point3<f64>,
    step_m: f64,
) -> Option<Point3<f64>> {
    let place = |step: usize| at_m + frame.normal * (NEAR_M - step as f64 * step_m);
    let steps = (2.0 * NEAR_M / step_m) as usize;
    // Starts at the last voxel of air near the entry, so that a fold or a drape further out is
    // ignored.
    let is_air = |step: &usize| map.label_at(to_index, &place(*step)) == 0;
    let last = (0..steps / 2 + steps / 8).rev().find(is_air)?;
    Some(place(last) - frame.normal * (0.5 * step_m))
}

/// The most frequent label; the smallest of equally frequent ones.
fn most_frequent(labels: impl Iterator<Item = u16>) -> Option<u16> {
    let mut all: Vec<u16> = labels.collect();
    all.sort_unstable();
    let runs = all.chunk_by(|one, other| one == other);
    runs.fold(None, |best: Option<&[u16]>, run| match best {
        Some(most) if most.len() >= run.len() => Some(most),
        _ => Some(run),
    })
    .map(|run| run[0])
}

/// Merges layers thinner than a voxel step into the layer above, and joins equal neighbours.
fn drop_stairs(runs: Vec<(u16, f64)>, least_m: f64) -> Vec<(u16, f64)> {
    let mut kept: Vec<(u16, f64)> = Vec::new();
    for (label, thickness_m) in runs {
        match kept.last_mut() {
            Some((above, whole_m)) if *above == label || thickness_m < least_m => *whole_m += thickness_m,
            _ => kept.push((label, thickness_m)),
        }
    }
    kept
}
