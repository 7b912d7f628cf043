//! Removes the voxel steps from a surface, within a distance and at constant volume.
//!
//! Each vertex moves towards the mean of its neighbours and then slightly back (Taubin 1995), a
//! low-pass filter that keeps curvature and removes steps. The remaining loss of volume is
//! compensated along the normals. No vertex leaves the ball around its original position.

use nalgebra::Vector3;

use super::contour::Contour;

/// Fraction of the distance to the neighbours' mean, and of the step back. Taubin's own choice is
/// 0.33 and −0.34; larger steps need fewer rounds.
const THERE: f64 = 0.6;
const BACK: f64 = -0.62;
/// Number of smoothing rounds: enough for a step of one voxel in eight.
const ROUNDS: usize = 20;
/// Rounds of volume compensation.
const VOLUME_ROUNDS: usize = 6;
/// Relative volume error that needs no compensation.
const VOLUME_ENOUGH: f64 = 1e-6;

/// Smooths a surface of cells by at most `most` cells, towards a volume in cells.
pub(super) fn smooth(contour: &mut Contour, most: f64, volume: f64) {
    let before = contour.vertices.clone();
    let neighbours = Neighbours::new(contour);
    let hold = |at: usize, place: Vector3<f64>| {
        let way = place - before[at];
        let length = way.norm();
        if length > most { before[at] + way * (most / length) } else { place }
    };
    for _ in 0..ROUNDS {
        for part in [THERE, BACK] {
            let middles = neighbours.middles(&contour.vertices);
            for (at, (vertex, middle)) in contour.vertices.iter_mut().zip(middles).enumerate() {
                *vertex = hold(at, *vertex + (middle - *vertex) * part);
            }
        }
    }
    for _ in 0..VOLUME_ROUNDS {
        let (now, area) = volume_and_area(contour);
        if area <= 0.0 || (volume - now).abs() <= VOLUME_ENOUGH * volume {
            break;
        }
        let by = ((volume - now) / area).clamp(-most, most);
        let normals = vertex_normals(contour);
        for (at, (vertex, normal)) in contour.vertices.iter_mut().zip(normals).enumerate() {
            *vertex = hold(at, *vertex + normal * by);
        }
    }
}

/// Volume and area of a closed surface.
pub(super) fn volume_and_area(contour: &Contour) -> (f64, f64) {
    let corner = |v: u32| contour.vertices[v as usize];
    contour.triangles.iter().fold((0.0, 0.0), |(volume, area), &[a, b, c]| {
        let (a, b, c) = (corner(a), corner(b), corner(c));
        (volume + a.dot(&b.cross(&c)) / 6.0, area + (b - a).cross(&(c - a)).norm() / 2.0)
    })
}

/// Unit normals, or zero where the triangles around a vertex cancel each other.
fn vertex_normals(contour: &Contour) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); contour.vertices.len()];
    for triangle in &contour.triangles {
        let [a, b, c] = triangle.map(|v| contour.vertices[v as usize]);
        let twice = (b - a).cross(&(c - a));
        triangle.iter().for_each(|&v| normals[v as usize] += twice);
    }
    normals.iter().map(|normal: &Vector3<f64>| normal.try_normalize(1e-12).unwrap_or_default()).collect()
}

/// The neighbours of each vertex, concatenated.
struct Neighbours {
    /// Index of the first neighbour of each vertex.
    starts: Vec<usize>,
    others: Vec<u32>,
}

impl Neighbours {
    /// On a closed surface each neighbour follows in exactly one triangle.
    fn new(contour: &Contour) -> Self {
        let edges = || contour.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let mut starts = vec![0; contour.vertices.len() + 1];
        edges().for_each(|(from, _)| starts[from as usize + 1] += 1);
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut others = vec![0; 3 * contour.triangles.len()];
        for (from, to) in edges() {
            others[next[from as usize]] = to;
            next[from as usize] += 1;
        }
        Self { starts, others }
    }

    fn middles(&self, vertices: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let middle = |bounds: &[usize]| {
            let about = &self.others[bounds[0]..bounds[1]];
            about.iter().map(|&v| vertices[v as usize]).sum::<Vector3<f64>>() / about.len() as f64
        };
        self.starts.windows(2).map(middle).collect()
    }
}
