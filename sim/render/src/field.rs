//! The field's table as the graphics card reads it, its loads, and where the boundaries stand on the needle's line.

use crate::frame::{FieldTable, MOST_LAYERS};

/// Samples along the radius, close to each other near the axis: sample i lies at reach (i/(n-1))².
pub const SAMPLES: usize = 256;
/// Loads that a picture takes.
pub const MOST_LOADS: usize = 48;

/// Responses of every boundary to 1 N of every load.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnResponses {
    /// Boundaries.
    pub boundaries: usize,
    /// Loads.
    pub loads: usize,
    /// How far the table reaches, in m.
    pub reach_m: f32,
    /// Boundary by boundary, load by load, [`SAMPLES`] each, in m/N.
    pub samples: Vec<f32>,
}

impl DrawnResponses {
    /// Resamples a table. Without one nothing gives way.
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

    /// What a boundary gives way to 1 N of a load on the axis, in m/N.
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

/// The frame's loads, in N: as many as a picture takes, and 0 for what is no number.
#[must_use]
pub fn pack_loads(responses: &DrawnResponses, loads_n: &[f32]) -> [f32; MOST_LOADS] {
    let mut loads = [0.0; MOST_LOADS];
    for (load, newton) in loads.iter_mut().zip(loads_n).take(responses.loads) {
        *load = if newton.is_finite() { *newton } else { 0.0 };
    }
    loads
}

/// Where every boundary stands on the needle's line, in m: as the frame says, and as the field has it under these loads (N) where the frame
/// says nothing.
#[must_use]
pub fn pack_dents(responses: &DrawnResponses, loads_n: &[f32], dents_m: &[f32]) -> [f32; MOST_LAYERS] {
    let mut dents = [0.0; MOST_LAYERS];
    for (boundary, dent) in dents.iter_mut().enumerate().take(responses.boundaries) {
        let told = dents_m.get(boundary).copied().filter(|dent_m| dent_m.is_finite());
        *dent = told.unwrap_or_else(|| responses.under(boundary, loads_n));
    }
    dents
}
