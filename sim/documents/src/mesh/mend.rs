//! Repairs common export defects of meshes and locates defects that cannot be repaired.
//!
//! Marching cubes and exporters write a vertex twice, a rounding apart, with degenerate triangles
//! in between. Such vertices are welded and such triangles dropped. A valid mesh is never modified,
//! so that recordings made on it stay bit-identical.

use std::collections::{BTreeMap, BTreeSet};

use law::structures::Surface;
use nalgebra::{Point3, Vector3};
use phrase::{Phrase, phrase};

use super::axes::Axes;

/// Vertices closer than this fraction of the mesh's largest dimension are welded: 1 µm in 100 mm,
/// which is more than the rounding of 32-bit numbers.
const WELD: f64 = 1e-5;

/// Welds near vertices and drops the triangles that this makes degenerate: those with two equal
/// vertices, and pairs that lie back to back.
pub(super) fn mend(surface: &Surface) -> Surface {
    let (vertices, triangles) = surface;
    let (kept, index) = weld(vertices, WELD * largest_dimension(vertices));
    let mut seen: BTreeMap<[u32; 3], i32> = BTreeMap::new();
    let is_real = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    let welded =
        triangles.iter().map(|triangle| triangle.map(|v| index[v as usize])).filter(is_real).collect::<Vec<_>>();
    for triangle in &welded {
        let (key, turns) = sorted(*triangle);
        *seen.entry(key).or_default() += turns;
    }
    // Triangles on the same vertices that face opposite ways cancel; of the rest, one is kept.
    let mut once = Vec::with_capacity(welded.len());
    for triangle in welded {
        let (key, turns) = sorted(triangle);
        if let Some(rest) = seen.get_mut(&key).filter(|rest| **rest * turns > 0) {
            *rest = 0;
            once.push(triangle);
        }
    }
    drop_unused(&kept, once)
}

/// Returns a triangle's sorted indices, and 1 or −1 for the parity of the permutation.
fn sorted(triangle: [u32; 3]) -> ([u32; 3], i32) {
    let [a, b, c] = triangle;
    let mut key = triangle;
    key.sort_unstable();
    let is_even = key == [a, b, c] || key == [b, c, a] || key == [c, a, b];
    (key, if is_even { 1 } else { -1 })
}

fn drop_unused(vertices: &[Point3<f64>], triangles: Vec<[u32; 3]>) -> Surface {
    let used: BTreeSet<u32> = triangles.iter().flatten().copied().collect();
    let new: BTreeMap<u32, u32> = used.iter().copied().zip(0..).collect();
    let vertices = used.iter().map(|&v| vertices[v as usize]).collect();
    (vertices, triangles.into_iter().map(|triangle| triangle.map(|v| new[&v])).collect())
}

fn largest_dimension(vertices: &[Point3<f64>]) -> f64 {
    let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for vertex in vertices {
        (low, high) = (low.inf(&vertex.coords), high.sup(&vertex.coords));
    }
    (high - low).max().max(0.0)
}

/// Returns the vertices that are not within `within_m` of an earlier one, and the new index of each
/// old vertex.
fn weld(vertices: &[Point3<f64>], within_m: f64) -> (Vec<Point3<f64>>, Vec<u32>) {
    let cell = |vertex: &Point3<f64>| [0, 1, 2].map(|axis| libm::floor(vertex[axis] / within_m) as i64);
    let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let mut kept: Vec<Point3<f64>> = Vec::new();
    let index = vertices
        .iter()
        .map(|vertex| {
            let [i, j, k] = cell(vertex);
            let about = (0..27).map(|at| [i + at % 3 - 1, j + at / 3 % 3 - 1, k + at / 9 - 1]);
            let near = about.filter_map(|cell| cells.get(&cell)).flatten().copied();
            let known = near.filter(|&v| (kept[v as usize] - vertex).norm() <= within_m).min();
            known.unwrap_or_else(|| {
                kept.push(*vertex);
                let new = (kept.len() - 1) as u32;
                cells.entry([i, j, k]).or_default().push(new);
                new
            })
        })
        .collect();
    (kept, index)
}

/// Appends the location of the first flaw, in the file's own coordinates, to the reason.
pub(super) fn place_flaw(why: Phrase, (vertices, triangles): &Surface, axes: Axes) -> Phrase {
    let Some(flaw_m) = first_flaw(vertices, triangles) else { return why };
    let [x, y, z] = axes.to_file(&flaw_m).map(|m| Phrase::number(m * 1e3, 3));
    phrase!("{why}, the first at ({x}, {y}, {z}) mm of the file", why = why, x = x, y = y, z = z)
}

/// Returns the middle of the first edge that is not in exactly two triangles, once in each
/// direction, preferring the edge with the most triangles; otherwise a vertex at which fans touch.
fn first_flaw(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Option<Point3<f64>> {
    let mut edges: BTreeMap<(u32, u32), (usize, usize)> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let walks = edges.entry((from.min(to), from.max(to))).or_default();
            if from < to { walks.0 += 1 } else { walks.1 += 1 }
        }
    }
    let worst = edges.iter().filter(|(_, walks)| **walks != (1, 1)).max_by_key(|((a, b), walks)| {
        // On a tie, the first edge.
        (walks.0 + walks.1, std::cmp::Reverse((*a, *b)))
    });
    if let Some(((a, b), _)) = worst {
        return Some(nalgebra::center(&vertices[*a as usize], &vertices[*b as usize]));
    }
    touching_corner(vertices.len(), triangles).map(|corner| vertices[corner])
}

/// Returns a vertex whose triangles form more than one fan: walking from triangle to triangle over
/// shared edges does not reach all of them.
fn touching_corner(corners: usize, triangles: &[[u32; 3]]) -> Option<usize> {
    let mut next: Vec<BTreeMap<u32, u32>> = vec![BTreeMap::new(); corners];
    for &[a, b, c] in triangles {
        for (corner, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            next[corner as usize].insert(from, to);
        }
    }
    next.iter().position(|fan| {
        let Some((&start, _)) = fan.iter().next() else { return false };
        let walk =
            std::iter::successors(
                fan.get(&start).copied(),
                |at| if *at == start { None } else { fan.get(at).copied() },
            );
        walk.take(fan.len() + 1).count() < fan.len()
    })
}
