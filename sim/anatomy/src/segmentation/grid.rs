//! The fraction of each cell of a grid that a label fills.

use nalgebra::Vector3;

use super::map::LabelMap;
use super::survey::LabelExtent;

/// Samples of a label around its voxels, with an empty rim that closes structures cut by the image.
pub(super) struct Filling {
    pub size: [usize; 3],
    /// Fraction of each cell that the label fills, the first index fastest.
    pub parts: Vec<f32>,
    /// Position of the first cell's centre, in voxels.
    low: Vector3<f64>,
    /// Edge of a cell, in voxels.
    pub edge: usize,
}

impl Filling {
    /// Cells of `edge` voxels along each axis.
    pub fn new(map: &LabelMap, label: u16, extent: &LabelExtent, edge: usize) -> Self {
        let size = [0, 1, 2].map(|axis| (extent.high[axis] - extent.low[axis]) / edge + 3);
        let mut counts = vec![0_u32; size.iter().product()];
        let [along, across, _] = map.size;
        for k in extent.low[2]..=extent.high[2] {
            for j in extent.low[1]..=extent.high[1] {
                let row = along * (j + across * k);
                let cell = |at: usize, axis: usize| (at - extent.low[axis]) / edge + 1;
                let cells = size[0] * (cell(j, 1) + size[1] * cell(k, 2));
                for i in extent.low[0]..=extent.high[0] {
                    if map.labels[row + i] == label {
                        counts[cells + cell(i, 0)] += 1;
                    }
                }
            }
        }
        let whole = (edge * edge * edge) as f32;
        let parts = counts.into_iter().map(|count| count as f32 / whole).collect();
        let middle = (edge as f64 - 1.0) / 2.0 - edge as f64;
        let low = Vector3::from_fn(|axis, _| extent.low[axis] as f64 + middle);
        Self { size, parts, low, edge }
    }

    /// Converts a position from cells to voxels.
    pub fn to_voxels(&self, cells: &Vector3<f64>) -> Vector3<f64> {
        self.low + cells * self.edge as f64
    }
}

#[cfg(test)]
impl Filling {
    /// Cells of one voxel with given fractions.
    pub fn of_parts(size: [usize; 3], parts: Vec<f32>) -> Self {
        Self { size, parts, low: Vector3::zeros(), edge: 1 }
    }
}
