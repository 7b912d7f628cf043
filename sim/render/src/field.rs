//! The field's table in the layout of the GPU, its loads, and the positions of the boundaries on
//! the needle's line.

use crate::frame::{FieldTable, MOST_LAYERS};

/// Number of samples along the radius, denser near the axis: sample i lies at reach (i/(n-1))².
pub const SAMPLES: usize = 256;
/// Maximum number of loads.
pub const MOST_LOADS: usize = 48;

/// Responses of every boundary to 1 N of every load.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnResponses {
    /// Number of boundaries.
    pub boundaries: usize,
    /// Number of loads.
    pub loads: usize,
    /// Maximum radius of the table, in m.
    pub reach_m: f32,
    /// Ordered by boundary, then load, [`SAMPLES`] each, in m/N.
    pub samples: Vec<f32>,
}

impl DrawnResponses {
    /// Resamples a table. An empty table gives zero displacements.
    #[must_use]
    pub fn resampled(table: &FieldTable, boundaries: usize) -> Self {
        let (radii, loads) = (&table.radii_m, table.loads);
        let reach_m = radii.last().copied().unwrap_or(0.0);
        let rows = table.axial_m_per_n.chunks_exact(radii.len().max(1)).take(boundaries * loads);
        let samples = rows.flat_map(|row| (0..SAMPLES).map(|i| at(radii, row, radius_m(reach_m, i)))).collect();
        match reach_m > 0.0 {
            true => Self { boundaries, loads, reach_m, samples },
            false => Self { boundaries, loads: 0, reach_m: 1.0, samples: Vec::new() },
        }
    }

    /// Response of a boundary to a load on the axis, in m/N.
    fn on_axis(&self, boundary: usize, load: usize) -> f32 {
        self.samples.get((boundary * self.loads + load) * SAMPLES).copied().unwrap_or(0.0)
    }

    /// Displacement of a boundary on the axis under these loads (N), in m.
    fn under(&self, boundary: usize, loads_n: &[f32]) -> f32 {
        loads_n.iter().enumerate().map(|(load, newton)| newton * self.on_axis(boundary, load)).sum()
    }
}

fn radius_m(reach_m: f32, sample: usize) -> f32 {
    let share = sample as f32 / (SAMPLES - 1) as f32;
    reach_m * share * share
}

/// Linear interpolation.
fn at(radii: &[f32], row: &[f32], radius_m: f32) -> f32 {
    let above = radii.partition_point(|r| *r < radius_m).clamp(1, radii.len().max(2) - 1);
    let (Some(low), Some(high)) = (radii.get(above - 1), radii.get(above)) else {
        return row.first().copied().unwrap_or(0.0);
    };
    let share = ((radius_m - low) / (high - low).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    row[above - 1] + share * (row[above] - row[above - 1])
}

/// The frame's loads, in N, limited to the maximum number; 0 for values that are not finite.
#[must_use]
pub fn pack_loads(responses: &DrawnResponses, loads_n: &[f32]) -> [f32; MOST_LOADS] {
    let mut loads = [0.0; MOST_LOADS];
    for (load, newton) in loads.iter_mut().zip(loads_n).take(responses.loads) {
        *load = if newton.is_finite() { *newton } else { 0.0 };
    }
    loads
}

/// Positions of all boundaries on the needle's line, in m: as given by the frame, otherwise from
/// the field under these loads (N).
#[must_use]
pub fn pack_dents(responses: &DrawnResponses, loads_n: &[f32], dents_m: &[f32]) -> [f32; MOST_LAYERS] {
    let mut dents = [0.0; MOST_LAYERS];
    for (boundary, dent) in dents.iter_mut().enumerate().take(responses.boundaries) {
        let told = dents_m.get(boundary).copied().filter(|dent_m| dent_m.is_finite());
        *dent = told.unwrap_or_else(|| responses.under(boundary, loads_n));
    }
    dents
}
