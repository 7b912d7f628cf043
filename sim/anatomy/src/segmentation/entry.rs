//! Where a needle enters a body, and the layers below.

use law::structures::Surface;
use nalgebra::{Matrix3, Point3, Vector3};

use super::error::SegmentationError;
use super::map::LabelMap;

/// Widest gap between labels, in m, that is taken for a seam. Our choice.
const WIDEST_SEAM_M: f64 = 5e-3;
/// A stated entry may be so far from the skin, in m: a few voxels, or a point that somebody has clicked.
const NEAR_M: f64 = 0.02;
/// The skin's direction is a mean over so much around the entry, in m: more than steps of voxels, less than a body's curvature.
const PATCH_M: f64 = 0.01;
/// Cosine of the most that a stated direction may differ from the skin's own: 60°, as far as a needle may lean.
const LEAST_COSINE: f64 = 0.5;
/// Layers are looked for down to here, in m.
const DEEPEST_M: f64 = 0.25;
/// Depth is sampled at this part of a voxel's shortest edge.
const SAMPLE: f64 = 0.1;
/// Rays about the entry's normal: in rings of so many radii, so that the steps of voxels average out.
const RINGS: usize = 5;
const RAYS_A_RING: usize = 12;
/// The outermost ring, in edges of the longest voxel.
const RING: f64 = 3.0;
/// A layer thinner than this part of a voxel's shortest edge is a stair and no layer.
const LEAST_LAYER: f64 = 0.5;

/// The patient frame of an entry: the origin on the skin, +z out of the body, +y towards the head as far as that is across z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EntryFrame {
    /// The origin in the world, in m.
    pub origin_m: Point3<f64>,
    /// Rows are the axes of the patient frame in the world: it turns the world into the patient.
    pub to_patient: Matrix3<f64>,
    /// The skin's own direction out of the body there, in the world.
    pub normal: Vector3<f64>,
    /// Between that and +z, in radians.
    pub tilt_rad: f64,
}

impl EntryFrame {
    /// The frame at the skin's place nearest to a stated one in the world, in m. +z is `up` (in the world), or the skin's own direction where
    /// none is stated.
    ///
    /// # Errors
    /// An entry far from the skin, or a direction that does not lead out.
    pub fn new(
        (vertices_m, triangles): &Surface,
        at_m: Point3<f64>,
        up: Option<Vector3<f64>>,
    ) -> Result<Self, SegmentationError> {
        let skin = Skin { vertices_m, triangles };
        let near_m = skin.nearest(&at_m);
        let away_m = (near_m - at_m).norm();
        // A place that is no number is near nothing.
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

    /// A surface in the world, turned into the patient frame, in m.
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

    /// The vertex nearest to a place.
    fn nearest(&self, at_m: &Point3<f64>) -> Point3<f64> {
        let squared = |vertex: &&Point3<f64>| (*vertex - at_m).norm_squared();
        self.vertices_m.iter().min_by(|one, other| squared(one).total_cmp(&squared(other))).copied().unwrap_or_default()
    }

    /// The direction of the triangles about a place, by their areas.
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

    /// Where the line through a place along a direction meets the skin nearest to the place.
    fn crossing(&self, at_m: &Point3<f64>, along: &Vector3<f64>) -> Option<Point3<f64>> {
        let distances = self.corners().filter_map(|corners| crossing(corners, at_m, along));
        let nearest = distances.min_by(|one, other| one.abs().total_cmp(&other.abs()))?;
        Some(at_m + along * nearest)
    }
}

/// Where a line meets a triangle, along its direction (Möller and Trumbore 1997).
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
    /// The body, or the image, ends below it, or the search does.
    pub is_last: bool,
    /// The label of what lies below it, where that has no name: the layers end there.
    pub unnamed_below: Option<u16>,
}

/// What a label is to whoever goes through it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelRole {
    /// A layer.
    Layer,
    /// A structure, which lies within the layer around it.
    Structure,
    /// Nothing that was named.
    Unnamed,
}

/// The layers along the skin's normal at an entry, from the skin down, as far as labels have a name: what is not named may be anything, as
/// the organs below the muscles of a back. Seams between labels, and structures, belong to the layer above.
///
/// At each depth below the skin the label that most of 61 rays meet counts, all within three voxels of the normal.
///
/// # Errors
/// No layer at all.
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
            // What lies above the first layer belongs to it.
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

/// Where rays begin: on the normal, and in rings about it.
fn rays_about(frame: &EntryFrame, voxel_m: f64) -> Vec<Point3<f64>> {
    let other = if frame.normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let one = frame.normal.cross(&other).normalize();
    let two = frame.normal.cross(&one);
    let on_ring = |ring: usize, at: usize| {
        // Each ring is turned a little, lest rays stand in rows as voxels do.
        let angle = (at as f64 + 0.37 * ring as f64) * 2.0 * std::f64::consts::PI / RAYS_A_RING as f64;
        let radius_m = RING * voxel_m * ring as f64 / RINGS as f64;
        frame.origin_m + (one * libm::cos(angle) + two * libm::sin(angle)) * radius_m
    };
    let rings = (1..=RINGS).flat_map(|ring| (0..RAYS_A_RING).map(move |at| (ring, at)));
    std::iter::once(frame.origin_m).chain(rings.map(|(ring, at)| on_ring(ring, at))).collect()
}

/// Where a ray enters the body: coming from outside, near its place.
fn find_skin(
    map: &LabelMap,
    to_index: &Matrix3<f64>,
    frame: &EntryFrame,
    at_m: &Point3<f64>,
    step_m: f64,
) -> Option<Point3<f64>> {
    let place = |step: usize| at_m + frame.normal * (NEAR_M - step as f64 * step_m);
    let steps = (2.0 * NEAR_M / step_m) as usize;
    // From the last voxel of air near the entry, so that a fold or a drape further out does not count.
    let is_air = |step: &usize| map.label_at(to_index, &place(*step)) == 0;
    let last = (0..steps / 2 + steps / 8).rev().find(is_air)?;
    Some(place(last) - frame.normal * (0.5 * step_m))
}

/// The label that most have; of equals, the least.
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

/// Gives what is thinner than a stair to the layer above it, and joins what then meets.
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
