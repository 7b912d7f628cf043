//! Closed surfaces of shapes: surface nets (Gibson 1998) on a grid. One vertex in each cell that
//! the surface crosses, at the mean of the crossings of the cell's edges; one quad around each
//! crossed edge of the grid.
//!
//! Surface nets are manifold if each cell contains one sheet. Cells with more are repaired first:
//! outer corners are marked inside one after the other until no such cell is left. A corner marked
//! inside never changes back, so the repair terminates.

use nalgebra::Point3;

use super::form::{Bounds, Place};

/// Number of cells of a block along each axis; a block without a surface is skipped after one
/// sample.
const BLOCK: usize = 6;
/// Value of a corner marked inside: just below the surface, in cells.
const TAKEN_INSIDE: f64 = -0.02;

/// A closed surface of triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyMesh {
    /// Vertices, in m.
    pub vertices_m: Vec<Point3<f64>>,
    /// Triangles, as indices of their vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// Samples of a shape at the corners of a grid.
struct Grid {
    counts: [usize; 3],
    least: Place,
    cell: f64,
    values: Vec<f64>,
    /// Whether the surface may pass through a block's cells.
    crossed: Vec<bool>,
}

/// The eight corners of a cell as steps along the axes: bit 0 for x, 1 for y, 2 for z.
fn corner_step(corner: usize) -> [usize; 3] {
    [corner & 1, corner >> 1 & 1, corner >> 2 & 1]
}

impl Grid {
    fn sample(distance: &dyn Fn(&Place) -> f64, bounds: &Bounds, cell: f64) -> Self {
        let span = (bounds.greatest - bounds.least) / cell;
        // Two layers beyond the bounds, all outside, close the surface.
        let counts = [span.x, span.y, span.z].map(|cells| libm::ceil(cells.max(0.0)) as usize + 5);
        let least = bounds.least.add_scalar(-2.0 * cell);
        let mut grid =
            Self { counts, least, cell, values: vec![1e3; counts.iter().product()], crossed: Vec::default() };
        let blocks = grid.blocks();
        for block in 0..blocks.iter().product() {
            let at = [block % blocks[0], block / blocks[0] % blocks[1], block / blocks[0] / blocks[1]];
            let crossed = grid.sample_block(distance, at.map(|index| index * BLOCK));
            grid.crossed.push(crossed);
        }
        grid.close_border();
        grid
    }

    /// Number of blocks along each axis.
    fn blocks(&self) -> [usize; 3] {
        self.counts.map(|count| count.div_ceil(BLOCK))
    }

    /// Index of the block of a cell.
    fn block(&self, at: [usize; 3]) -> usize {
        let ([x, y, z], blocks) = (at.map(|index| index / BLOCK), self.blocks());
        x + blocks[0] * (y + blocks[1] * z)
    }

    /// Samples the corners of a block. Returns whether the surface may cross its cells, whose far
    /// corners belong to the next block.
    fn sample_block(&mut self, distance: &dyn Fn(&Place) -> f64, first: [usize; 3]) -> bool {
        let half = 0.5 * (BLOCK as f64 + 1.0) * self.cell;
        let corner = self.place(first);
        let middle = distance(&corner.add_scalar(half));
        // Half of the block's diagonal, times 1.3 for joined shapes, which are steeper than a
        // distance.
        let empty = middle.abs() > half * 1.733 * 1.3;
        let last: [usize; 3] = std::array::from_fn(|axis| (first[axis] + BLOCK).min(self.counts[axis]));
        for z in first[2]..last[2] {
            for y in first[1]..last[1] {
                for x in first[0]..last[0] {
                    let index = self.index([x, y, z]);
                    let value = if empty { middle } else { distance(&self.place([x, y, z])) };
                    self.values[index] = if value == 0.0 { -1e-9 } else { value };
                }
            }
        }
        // Shapes that extend inside to the border are closed there.
        let at_border = (0..3).any(|axis| first[axis] == 0 || last[axis] + 1 >= self.counts[axis]);
        !empty || middle < 0.0 && at_border
    }

    fn close_border(&mut self) {
        for index in 0..self.values.len() {
            let at = self.at(index);
            if (0..3).any(|axis| at[axis] == 0 || at[axis] + 1 == self.counts[axis]) {
                self.values[index] = self.values[index].max(self.cell);
            }
        }
    }

    fn index(&self, at: [usize; 3]) -> usize {
        at[0] + self.counts[0] * (at[1] + self.counts[1] * at[2])
    }

    fn at(&self, index: usize) -> [usize; 3] {
        let [x, y, _] = self.counts;
        [index % x, index / x % y, index / x / y]
    }

    fn place(&self, at: [usize; 3]) -> Place {
        self.least + Place::new(at[0] as f64, at[1] as f64, at[2] as f64) * self.cell
    }

    /// The cells, by index, of the blocks that the surface may cross.
    fn cells(&self) -> impl Iterator<Item = [usize; 3]> {
        let [width, height, depth] = self.counts;
        let rows = (0..depth).flat_map(move |z| (0..height).map(move |y| [y, z]));
        rows.flat_map(move |[y, z]| {
            let pieces = (0..width).step_by(BLOCK).filter(move |x| self.crossed[self.block([*x, y, z])]);
            pieces.flat_map(move |x| (x..width.min(x + BLOCK)).map(move |x| [x, y, z]))
        })
    }

    /// Bits of the corners of a cell that are inside; `None` for a cell beyond the grid.
    fn signs(&self, at: [usize; 3]) -> Option<u8> {
        (0..3).all(|axis| at[axis] + 1 < self.counts[axis]).then(|| {
            (0..8).fold(0, |bits, corner| {
                let inside = self.values[self.corner(at, corner)] < 0.0;
                bits | u8::from(inside) << corner
            })
        })
    }

    fn corner(&self, at: [usize; 3], corner: usize) -> usize {
        let step = corner_step(corner);
        self.index([at[0] + step[0], at[1] + step[1], at[2] + step[2]])
    }

    /// Marks corners inside until each cell contains one sheet.
    fn mend(&mut self) {
        let mut open: Vec<usize> = self.cells().map(|at| self.index(at)).collect();
        while let Some(cell) = open.pop() {
            let at = self.at(cell);
            let Some(signs) = self.signs(at) else { continue };
            if signs == 0 || signs == u8::MAX || is_one_sheet(signs) {
                continue;
            }
            let outside = (0..8).filter(|corner| signs >> corner & 1 == 0).map(|corner| self.corner(at, corner));
            let Some(nearest) = outside.min_by(|&a, &b| self.values[a].total_cmp(&self.values[b])) else { continue };
            self.values[nearest] = TAKEN_INSIDE * self.cell;
            let [x, y, z] = self.at(nearest);
            for corner in 0..8 {
                let [i, j, k] = corner_step(corner);
                let (Some(x), Some(y), Some(z)) = (x.checked_sub(i), y.checked_sub(j), z.checked_sub(k)) else {
                    continue;
                };
                let block = self.block([x, y, z]);
                self.crossed[block] = true;
                open.push(self.index([x, y, z]));
            }
        }
    }

    /// The vertex of a cell: the mean of the crossings of its edges.
    fn vertex(&self, at: [usize; 3]) -> Point3<f64> {
        let (mut sum, mut crossed) = (Place::zeros(), 0.0);
        for (from, to) in edges() {
            let (a, b) = (self.values[self.corner(at, from)], self.values[self.corner(at, to)]);
            if (a < 0.0) != (b < 0.0) {
                let place = |corner: usize| {
                    let step = corner_step(corner);
                    self.place([at[0] + step[0], at[1] + step[1], at[2] + step[2]])
                };
                // Kept away from corners: two vertices could coincide there.
                sum += place(from).lerp(&place(to), (a / (a - b)).clamp(0.02, 0.98));
                crossed += 1.0;
            }
        }
        Point3::from(sum / crossed * 1e-3)
    }
}

/// The twelve edges of a cell, as pairs of corners.
fn edges() -> impl Iterator<Item = (usize, usize)> {
    (0..8_usize).flat_map(|corner| {
        [1, 2, 4].into_iter().filter(move |step| corner & step == 0).map(move |step| (corner, corner | step))
    })
}

/// Whether the inner corners are connected along edges, so are the outer ones, and no face has them
/// diagonally opposite.
fn is_one_sheet(signs: u8) -> bool {
    let crosswise = [(1, 2), (1, 4), (2, 4)].into_iter().any(|(one, two): (usize, usize)| {
        let normal = 7 & !(one | two);
        [0, normal].into_iter().any(|face| {
            let bit = |corner: usize| signs >> (face | corner) & 1;
            bit(0) == bit(one | two) && bit(one) == bit(two) && bit(0) != bit(one)
        })
    });
    !crosswise && hang_together(signs) && hang_together(!signs)
}

fn hang_together(corners: u8) -> bool {
    let mut reached = corners & corners.wrapping_neg();
    for _ in 0..8 {
        for (a, b) in edges() {
            if reached >> a & 1 == 1 || reached >> b & 1 == 1 {
                reached |= corners & (1 << a | 1 << b);
            }
        }
    }
    reached == corners
}

/// The surface of a shape, sampled every `cell` mm.
pub(super) fn mesh_surface(distance: &dyn Fn(&Place) -> f64, bounds: &Bounds, cell: f64) -> BodyMesh {
    let mut grid = Grid::sample(distance, bounds, cell);
    grid.mend();
    let mut mesh = BodyMesh::default();
    let mut vertex_of = vec![u32::MAX; grid.values.len()];
    for at in grid.cells() {
        if grid.signs(at).is_some_and(|signs| signs != 0 && signs != u8::MAX) {
            vertex_of[grid.index(at)] = mesh.vertices_m.len() as u32;
            mesh.vertices_m.push(grid.vertex(at));
        }
    }
    for at in grid.cells() {
        for axis in 0..3 {
            quad_around_edge(&grid, &vertex_of, at, axis).into_iter().for_each(|quad| split(quad, &mut mesh));
        }
    }
    mesh
}

/// The vertices of the cells around an edge of the grid that starts at a corner along an axis,
/// counter-clockwise seen from outside.
fn quad_around_edge(grid: &Grid, vertex_of: &[u32], at: [usize; 3], axis: usize) -> Option<[u32; 4]> {
    let mut next = at;
    next[axis] += 1;
    if next[axis] >= grid.counts[axis] {
        return None;
    }
    let (here, there) = (grid.values[grid.index(at)] < 0.0, grid.values[grid.index(next)] < 0.0);
    if here == there {
        return None;
    }
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let cell = |back_u: usize, back_v: usize| {
        let mut cell = at;
        cell[u] -= back_u;
        cell[v] -= back_v;
        vertex_of[grid.index(cell)]
    };
    let quad = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)];
    Some(if here { quad } else { [quad[3], quad[2], quad[1], quad[0]] })
}

/// Splits a quad along its shorter diagonal.
fn split(quad: [u32; 4], mesh: &mut BodyMesh) {
    let [a, b, c, d] = quad;
    let apart = |from: u32, to: u32| (mesh.vertices_m[from as usize] - mesh.vertices_m[to as usize]).norm_squared();
    let two = if apart(a, c) <= apart(b, d) { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] };
    mesh.triangles.extend(two);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{check_manifold, volume_m3};

    #[test]
    fn a_ball_is_closed_and_has_its_volume() {
        let bounds = Bounds::NOTHING.grown_by_ball(&Place::zeros(), 20.0);
        let mesh = mesh_surface(&|p| p.norm() - 20.0, &bounds, 1.0);
        assert_eq!(check_manifold(&mesh.triangles), Ok(0));
        let volume = volume_m3(&mesh.vertices_m, &mesh.triangles) * 1e9;
        assert!((volume / 33_510.3 - 1.0).abs() < 0.01, "{volume}");
    }

    #[test]
    fn noise_is_a_manifold_too() {
        let noise = |p: &Place| libm::sin(p.x * 12.9 + p.y * 78.2 + p.z * 37.7 + 3.0 * libm::sin(p.x * p.y));
        let bounds = Bounds::NOTHING.grown_by_ball(&Place::zeros(), 9.0);
        assert_eq!(check_manifold(&mesh_surface(&|p| 0.1 * noise(p), &bounds, 1.0).triangles), Ok(0));
    }
}
