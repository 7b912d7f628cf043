//! The field's table as the graphics card reads it, and the loads that bring a tent to where the needle is.

use crate::frame::{FieldTable, Puncture, Stage};
use crate::placement::Placement;

/// Samples along the radius, close to each other near the axis: sample i lies at reach (i/(n-1))².
pub const SAMPLES: usize = 256;
/// Loads that a picture takes.
pub const MOST_LOADS: usize = 48;
/// Sweeps over the contacts; two contacts converge in a few.
const SWEEPS: usize = 6;

/// Responses of every boundary to 1 N of every load.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    /// Boundaries.
    pub boundaries: usize,
    /// Loads.
    pub loads: usize,
    /// How far the table reaches, in m.
    pub reach_m: f32,
    /// Boundary by boundary, load by load, [`SAMPLES`] each, in m/N.
    pub samples: Vec<f32>,
}

impl Responses {
    /// Resamples a table. Without one nothing gives way.
    #[must_use]
    pub fn of(table: &FieldTable, boundaries: usize) -> Self {
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

/// The frame's loads, with those of the contacts brought to what puts the tent's top under the needle. The force law and the
/// field are two models of the same tissue; without this a tip would stand off the tent that it makes.
pub fn loads_in_contact(responses: &Responses, contacts: &[(usize, f32)], loads_n: &[f32]) -> [f32; MOST_LOADS] {
    let mut loads = [0.0; MOST_LOADS];
    let count = responses.loads.min(MOST_LOADS);
    for (load, newton) in loads.iter_mut().zip(loads_n).take(count) {
        *load = if newton.is_finite() { *newton } else { 0.0 };
    }
    for _ in 0..SWEEPS {
        for &(boundary, depth_m) in contacts.iter().filter(|(boundary, _)| *boundary < count) {
            let per_n = responses.on_axis(boundary, boundary);
            if per_n > 0.0 {
                loads[boundary] += (depth_m - responses.under(boundary, &loads[..count])) / per_n;
            }
        }
    }
    loads
}

/// Boundaries that the needle presses on, and how far it has pushed them along its axis, in m: the tip on the first that is
/// closed, the rim on those behind it that still carry it.
pub fn contacts(stage: &Stage, place: &Placement, open: Option<&Puncture>, loads_n: &[f32]) -> Vec<(usize, f32)> {
    let Some(open) = open else { return Vec::new() };
    let opened = open.opened as usize;
    let slant = -place.axis.z;
    let pressed = |(boundary, layer): (usize, &crate::frame::Layer)| {
        let carried = loads_n.get(boundary).is_some_and(|newton| *newton > 0.0);
        let rim_m = if boundary < opened { stage.needle.tip_to_rim_m } else { 0.0 };
        let depth_m = place.tip_depth_m() - rim_m - layer.top_m / slant;
        (carried && boundary <= opened && depth_m > 0.0).then_some((boundary, depth_m))
    };
    stage.layers.iter().enumerate().filter_map(pressed).collect()
}
