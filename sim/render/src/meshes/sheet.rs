//! A flat grid, for light that is computed at its vertices.

use glam::Vec3;

use super::{Corner, MeshShape};

/// Builds a grid with these numbers of columns and rows, from -1 to 1 in x and y.
#[must_use]
pub fn build_sheet([columns, rows]: [u32; 2]) -> MeshShape {
    let mut shape = MeshShape::default();
    let place = |i: u32, count: u32| 2.0 * i as f32 / count as f32 - 1.0;
    for row in 0..=rows {
        for column in 0..=columns {
            shape.corner(Corner::new(Vec3::new(place(column, columns), place(row, rows), 0.0), 0.0, Vec3::Z));
        }
    }
    shape.join(0, columns + 1, rows + 1);
    shape
}
