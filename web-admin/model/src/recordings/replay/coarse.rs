//! Simplification of surfaces for the browser.

use std::collections::BTreeMap;

use law::structures::Surface;
use nalgebra::{Point3, Vector3};

/// Edge length of the first grid cells, in m, and the factor between successive grids.
const FIRST_M: f64 = 0.5e-3;
const LARGER: f64 = 1.3;

/// Simplifies a surface to at most `most` triangles. A smaller surface is returned unchanged;
/// otherwise the vertices in each cell of a grid are merged at their mean, which moves none by more
/// than the diagonal of a cell. The grid is the finest of a geometric series that suffices.
pub(super) fn coarsen_to(corners_m: &[Point3<f64>], triangles: &[[u32; 3]], most: usize) -> Surface {
    let (mut coarse, mut cell_m) = ((corners_m.to_vec(), triangles.to_vec()), FIRST_M);
    while coarse.1.len() > most {
        coarse = draw_together(corners_m, triangles, cell_m);
        cell_m *= LARGER;
    }
    coarse
}

/// Merges the vertices of each cell and removes degenerate triangles.
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
    //! Checks that large meshes are simplified, that vertices stay close to the surface, and that
    //! small meshes are unchanged.

    use law::structures::{Shape, StructureKind, StructureSpec};

    use super::*;

    /// A sphere of radius 20 mm with about a thousand triangles.
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
