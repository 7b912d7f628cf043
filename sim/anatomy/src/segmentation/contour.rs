//! A closed surface around the cells that are more than half full: marching cubes (Lorensen and
//! Cline 1987).
//!
//! The table of cases is generated here instead of copied. On a face with diagonally opposite full
//! corners, the full corners are separated, identically on both sides of the face: so each piece of
//! an outline is traversed once in each direction, and around each vertex the four cubes of its
//! edge make one fan. A polygon is cut into triangles by diagonals that lie in no face of its cube,
//! or otherwise from a central vertex; so no two cubes share a diagonal. Hence the surface is
//! closed, manifold and consistently oriented for any content of the cells.

use nalgebra::Vector3;

use super::grid::Filling;

/// Corners of a cube's faces, counter-clockwise seen from outside; bit 0 of a corner is x, bit 1 is
/// y, bit 2 is z.
const FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// Minimum distance of a vertex from either end of its edge, as a fraction of the edge: two would
/// otherwise coincide at a corner.
const KEEP: f64 = 0.05;

/// No vertex yet.
const NONE: u32 = u32::MAX;

/// Vertices in cell coordinates, and triangles.
#[derive(Default)]
pub(super) struct Contour {
    pub vertices: Vec<Vector3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

/// An edge of a cube: its lower corner, and the axis along which it runs.
type CubeEdge = (usize, usize);

/// A polygon of a case: the edges that contain its corners, and the corner from which all its
/// diagonals leave; `None` if it needs a central vertex.
struct Polygon {
    edges: Vec<CubeEdge>,
    apex: Option<usize>,
}

fn edge_between(one: usize, other: usize) -> CubeEdge {
    (one.min(other), (one ^ other).trailing_zeros() as usize)
}

/// The polygons for every set of full corners.
fn make_cases() -> Vec<Vec<Polygon>> {
    (0..256).map(polygons).collect()
}

fn polygons(full: usize) -> Vec<Polygon> {
    let is_full = |corner: usize| full >> corner & 1 == 1;
    let mut ways: Vec<(CubeEdge, CubeEdge)> = Vec::new();
    for face in FACES {
        let step = |at: usize| (face[at % 4], face[(at + 1) % 4]);
        for start in (0..4).filter(|at| is_full(step(*at).1) && !is_full(step(*at).0)) {
            // A run of full corners begins here; find its end.
            let Some(end) = (start + 1..start + 4).find(|at| !is_full(step(*at).1)) else { continue };
            let edge = |at: usize| edge_between(step(at).0, step(at).1);
            ways.push((edge(start), edge(end)));
        }
    }
    let mut found = Vec::new();
    while let Some((first, mut next)) = ways.pop() {
        let mut edges = vec![first];
        while next != first {
            edges.push(next);
            let Some(at) = ways.iter().position(|(from, _)| *from == next) else { break };
            next = ways.swap_remove(at).1;
        }
        let apex = (0..edges.len()).find(|apex| fans_freely(&edges, *apex));
        found.push(Polygon { edges, apex });
    }
    found
}

/// Whether no diagonal from a corner of the polygon lies in a face.
fn fans_freely(edges: &[CubeEdge], apex: usize) -> bool {
    let count = edges.len();
    (2..count - 1).all(|step| !share_a_face(edges[apex], edges[(apex + step) % count]))
}

fn share_a_face((one, along): CubeEdge, (other, across): CubeEdge) -> bool {
    (0..3).any(|axis| axis != along && axis != across && one >> axis & 1 == other >> axis & 1)
}

/// The vertices on the edges of two neighbouring planes of cells.
struct Slab {
    /// By axis and by plane, lower or upper; edges along z are stored in the first plane only.
    ids: [[Vec<u32>; 2]; 3],
}

impl Slab {
    fn new(cells: usize) -> Self {
        let plane = || [vec![NONE; cells], vec![NONE; cells]];
        Self { ids: [plane(), plane(), plane()] }
    }

    /// Moves up by one plane.
    fn rise(&mut self) {
        for [below, above] in &mut self.ids {
            std::mem::swap(below, above);
            above.fill(NONE);
        }
    }
}

/// The surface around the cells that are more than half full.
pub(super) fn contour(filling: &Filling) -> Contour {
    let cases = make_cases();
    let [along, across, deep] = filling.size;
    let mut march = March { filling, slab: Slab::new(along * across), contour: Contour::default() };
    for k in 0..deep - 1 {
        for j in 0..across - 1 {
            for i in 0..along - 1 {
                march.take_cube([i, j, k], &cases);
            }
        }
        march.slab.rise();
    }
    march.contour
}

struct March<'f> {
    filling: &'f Filling,
    slab: Slab,
    contour: Contour,
}

impl March<'_> {
    fn part(&self, at: [usize; 3]) -> f32 {
        self.filling.parts[at[0] + self.filling.size[0] * (at[1] + self.filling.size[1] * at[2])]
    }

    fn take_cube(&mut self, at: [usize; 3], cases: &[Vec<Polygon>]) {
        let is_full = |corner: usize| usize::from(self.part(corner_of(at, corner)) > 0.5) << corner;
        let full: usize = (0..8).map(is_full).sum();
        for polygon in &cases[full] {
            let corners: Vec<u32> = polygon.edges.iter().map(|edge| self.vertex(at, *edge)).collect();
            let count = corners.len();
            let Some(apex) = polygon.apex else {
                let middle = self.add_middle(&corners);
                let round = (0..count).map(|c| [middle, corners[c], corners[(c + 1) % count]]);
                self.contour.triangles.extend(round);
                continue;
            };
            let fan =
                (1..count - 1).map(|c| [corners[apex], corners[(apex + c) % count], corners[(apex + c + 1) % count]]);
            self.contour.triangles.extend(fan);
        }
    }

    /// The vertex on an edge of the cube at a position.
    fn vertex(&mut self, at: [usize; 3], (corner, axis): CubeEdge) -> u32 {
        let from = corner_of(at, corner);
        let plane = if axis == 2 { 0 } else { corner >> 2 };
        let cell = from[0] + self.filling.size[0] * from[1];
        let known = self.slab.ids[axis][plane][cell];
        if known != NONE {
            return known;
        }
        let to = corner_of(at, corner | 1 << axis);
        let (here, there) = (f64::from(self.part(from)), f64::from(self.part(to)));
        let mut place = Vector3::from_fn(|axis, _| from[axis] as f64);
        place[axis] += ((0.5 - here) / (there - here)).clamp(KEEP, 1.0 - KEEP);
        let id = self.add(place);
        self.slab.ids[axis][plane][cell] = id;
        id
    }

    fn add_middle(&mut self, corners: &[u32]) -> u32 {
        let sum: Vector3<f64> = corners.iter().map(|corner| self.contour.vertices[*corner as usize]).sum();
        self.add(sum / corners.len() as f64)
    }

    fn add(&mut self, place: Vector3<f64>) -> u32 {
        self.contour.vertices.push(place);
        (self.contour.vertices.len() - 1) as u32
    }
}

fn corner_of(at: [usize; 3], corner: usize) -> [usize; 3] {
    [0, 1, 2].map(|axis| at[axis] + (corner >> axis & 1))
}

#[cfg(test)]
mod tests {
    //! Fails if a case leaves a hole, flips a triangle or shares a diagonal with its neighbour.

    use rand_core::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::{Contour, contour};
    use crate::segmentation::grid::Filling;
    use crate::{check_manifold, volume_m3};

    #[test]
    fn any_cells_have_a_closed_manifold_surface_that_faces_outwards() {
        let mut random = Pcg64Mcg::seed_from_u64(7);
        for _ in 0..200 {
            let filling = Filling::of_noise(&mut || random.next_u32());
            let Contour { vertices, triangles } = contour(&filling);
            assert_eq!(check_manifold(&triangles), Ok(0));
            let places: Vec<_> = vertices.iter().map(|v| (*v).into()).collect();
            assert!(volume_m3(&places, &triangles) > 0.0);
        }
    }

    impl Filling {
        /// Six cells along each axis, randomly full or empty within the rim.
        fn of_noise(next: &mut dyn FnMut() -> u32) -> Self {
            let size = [6; 3];
            let is_rim = |at: usize| [at % 6, at / 6 % 6, at / 36].iter().any(|c| *c == 0 || *c == 5);
            let parts = (0..216).map(|at| if is_rim(at) || next().is_multiple_of(2) { 0.0 } else { 1.0 }).collect();
            Self::of_parts(size, parts)
        }
    }
}
