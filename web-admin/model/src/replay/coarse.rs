//! Surfaces with fewer triangles, for a browser.

use std::collections::BTreeMap;

use law::structures::Surface;
use nalgebra::{Point3, Vector3};

/// Edge of the first cells that are tried, in m, and how much larger the next are.
const FIRST_M: f64 = 0.5e-3;
const LARGER: f64 = 1.3;

/// A surface of at most so many triangles: as it is where it has no more, otherwise with the corners of each cell of a grid drawn together
/// to their mean, which moves none by more than a cell's diagonal. The cells are the smallest that do.
pub(super) fn coarsen_to(corners_m: &[Point3<f64>], triangles: &[[u32; 3]], most: usize) -> Surface {
    let (mut coarse, mut cell_m) = ((corners_m.to_vec(), triangles.to_vec()), FIRST_M);
    while coarse.1.len() > most {
        coarse = draw_together(corners_m, triangles, cell_m);
        cell_m *= LARGER;
    }
    coarse
}

/// The corners of each cell drawn together, without the triangles that so lose a corner.
fn draw_together(corners_m: &[Point3<f64>], triangles: &[[u32; 3]], cell_m: f64) -> Surface {
    let mut cells: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    let mut sums: Vec<(Vector3<f64>, f64)> = Vec::new();
    let mut drawn = Vec::with_capacity(corners_m.len());
    for corner in corners_m {
        let cell = [corner.x, corner.y, corner.z].map(|m| (m / cell_m).floor() as i64);
        let at = *cells.entry(cell).or_insert(sums.len());
        if at == sums.len() {
            sums.push((Vector3::zeros(), 0.0));
        }
        sums[at].0 += corner.coords;
        sums[at].1 += 1.0;
        drawn.push(at as u32);
    }
    let corners = sums.into_iter().map(|(sum, count)| Point3::from(sum / count)).collect();
    let kept = triangles.iter().map(|triangle| triangle.map(|corner| drawn[corner as usize]));
    (corners, kept.filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

#[cfg(test)]
mod tests {
    //! Fails when a mesh of any size would be sent, when a corner strays, or when a small mesh is touched.

    use law::structures::{Shape, StructureKind, StructureSpec};

    use super::*;

    /// A ball of 20 mm, of about a thousand triangles.
    fn ball() -> Surface {
        let shape = Shape::Sphere { radius_m: 0.02 };
        let name = "ball".to_owned();
        StructureSpec { name, kind: StructureKind::Organ, shape, position_m: Point3::origin(), wall: None }.surface()
    }

    #[test]
    fn a_fine_mesh_is_made_coarser_and_stays_where_it_is() {
        let (corners, triangles) = ball();
        for most in [triangles.len() / 2, 200, 60] {
            let (coarse, kept) = coarsen_to(&corners, &triangles, most);
            assert!((8..=most).contains(&kept.len()) && coarse.len() < corners.len(), "{} of {most}", kept.len());
            let radii = || coarse.iter().map(|corner| corner.coords.norm());
            assert!(radii().all(|radius_m| (0.012..=0.0201).contains(&radius_m)), "{most}");
        }
    }

    #[test]
    fn a_coarse_mesh_and_none_are_left_alone() {
        let (corners, triangles) = ball();
        assert_eq!(coarsen_to(&corners, &triangles, triangles.len()), (corners, triangles));
        assert_eq!(coarsen_to(&[], &[], 0), (vec![], vec![]));
    }
}
