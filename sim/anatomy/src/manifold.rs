//! Topology checks of triangle meshes.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point3;
use phrase::{Phrase, phrase};

/// Checks that a mesh is a consistently oriented manifold: at most two triangles at an edge, which
/// traverse it in opposite directions, and one fan of triangles around each vertex. Returns the
/// number of open edges.
///
/// # Errors
/// The violated condition and the number of violations.
pub fn check_manifold(triangles: &[[u32; 3]]) -> Result<usize, Phrase> {
    let without_area = triangles.iter().filter(|[a, b, c]| a == b || b == c || c == a).count();
    if without_area > 0 {
        return Err(phrase!(
            "a mesh that is not manifold ({count} triangles with two corners in one place)",
            count = without_area
        ));
    }
    let open = check_edges(triangles)?;
    match pinched(triangles) {
        0 => Ok(open),
        count => Err(phrase!(
            "a mesh that is not manifold ({count} vertices at which only corners of the surface touch)",
            count = count
        )),
    }
}

fn check_edges(triangles: &[[u32; 3]]) -> Result<usize, Phrase> {
    /// Number of times that an edge is traversed from its lower vertex to its higher one, and back.
    type Walks = (usize, usize);
    let mut edges: BTreeMap<(u32, u32), Walks> = BTreeMap::new();
    for [a, b, c] in triangles.iter().copied() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let walks = edges.entry((from.min(to), from.max(to))).or_default();
            if from < to { walks.0 += 1 } else { walks.1 += 1 }
        }
    }
    let count = |is: fn(&Walks) -> bool| edges.values().filter(|walks| is(walks)).count();
    let crowded = count(|(there, back)| there + back > 2);
    if crowded > 0 {
        return Err(phrase!("a mesh that is not manifold ({count} edges in three or more triangles)", count = crowded));
    }
    let turned = count(|walks| matches!(walks, (2, 0) | (0, 2)));
    if turned > 0 {
        return Err(phrase!(
            "a mesh that is not consistently oriented ({count} edges between triangles of opposite orientation)",
            count = turned
        ));
    }
    Ok(count(|(there, back)| there + back == 1))
}

/// Number of vertices whose triangles form more than one fan.
///
/// The far edges of a fan form one chain. The edges have been checked, so each vertex of the chain
/// has at most one successor.
fn pinched(triangles: &[[u32; 3]]) -> usize {
    let corners = triangles.iter().flat_map(|&[a, b, c]| [(a, b, c), (b, c, a), (c, a, b)]);
    let mut links: Vec<(u32, u32, u32)> = corners.collect();
    links.sort_unstable();
    links.chunk_by(|one, next| one.0 == next.0).filter(|fan| chain(fan) < fan.len()).count()
}

/// Length of the first chain of a fan's far edges: one that begins where no other ends, otherwise a
/// ring.
fn chain(fan: &[(u32, u32, u32)]) -> usize {
    let ends: BTreeSet<u32> = fan.iter().map(|&(_, _, to)| to).collect();
    let Some(first) = fan.iter().find(|(_, from, _)| !ends.contains(from)).or(fan.first()) else { return 0 };
    let follow = |&(_, _, to): &(u32, u32, u32)| {
        let next = fan.binary_search_by_key(&to, |&(_, from, _)| from).ok()?;
        fan.get(next).filter(|link| *link != first).copied()
    };
    std::iter::successors(Some(*first), follow).count()
}

/// Volume by the divergence theorem, in m³; positive if triangles are counter-clockwise seen from
/// outside.
#[must_use]
pub fn volume_m3(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    let corner = |v: u32| vertices[v as usize].coords;
    triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0).sum()
}
