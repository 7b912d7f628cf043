//! Closed forms of physics that the tests and the documents quote: rupture positions and forces of a monotonic insertion.

use crate::axial::{AxialSpec, Contactor, Layer, Open, Path, lay_boundaries};

/// A rupture predicted in closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedRupture {
    /// Which contactor.
    pub contactor: Contactor,
    /// Which boundary, from 0 at the surface.
    pub boundary: usize,
    /// Axial displacement of the tip at the rupture, in m.
    pub x_m: f64,
    /// Elastic force on the hand just before, in N. The members of a cascade share it.
    pub force_before_n: f64,
    /// Elastic force on the hand just after the whole cascade at this position, in N.
    pub force_after_n: f64,
    /// Elastic energy before, in J.
    pub energy_before_j: f64,
    /// Elastic energy after the whole cascade, in J.
    pub energy_after_j: f64,
}

/// Ruptures of a slow monotonic perpendicular insertion, in order; those of a cascade stand at the same position.
///
/// Tip i opens at x = max(previous tip, D_i + P_tip,i/k_i), rim i at
/// max(previous rim, tip i, D_i + L + P_rim,i/k_i).
#[must_use]
pub fn predict_ruptures(spec: &AxialSpec) -> Vec<PredictedRupture> {
    let mut boundaries_m = Vec::with_capacity(spec.layers.len() + 1);
    lay_boundaries(&spec.layers, 1.0, &mut boundaries_m);
    let path = Path::new(spec, &boundaries_m, 1.0);
    let events = predict_positions(spec, &boundaries_m);
    let mut open = Open { tip: 0, rim: 0 };
    let mut predicted = Vec::with_capacity(events.len());
    for cascade in events.chunk_by(|a, b| a.x_m.total_cmp(&b.x_m).is_eq()) {
        let before = open;
        for event in cascade {
            match event.contactor {
                Contactor::Tip => open.tip += 1,
                Contactor::Rim => open.rim += 1,
            }
        }
        predicted.extend(cascade.iter().map(|event| predict_rupture(&path, event, before, open)));
    }
    predicted
}

/// Where a contactor opens a boundary.
pub(crate) struct Opening {
    pub x_m: f64,
    pub contactor: Contactor,
    boundary: usize,
}

/// Every rupture with its position, sorted by position; at one position tips come before rims, each in boundary order.
pub(crate) fn predict_positions(spec: &AxialSpec, boundaries_m: &[f64]) -> Vec<Opening> {
    let lag_m = spec.tip_to_rim_m;
    let (mut tip_m, mut rim_m) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    let (mut tips, mut rims) = (Vec::new(), Vec::new());
    for (boundary, (layer, depth_m)) in spec.layers.iter().zip(boundaries_m).enumerate() {
        tip_m = tip_m.max(depth_m + deflection_at_rupture_m(layer, layer.tip_rupture_n));
        tips.push(Opening { x_m: tip_m, contactor: Contactor::Tip, boundary });
        if lag_m > 0.0 {
            rim_m = rim_m.max(tip_m).max(depth_m + lag_m + deflection_at_rupture_m(layer, layer.rim_rupture_n));
            rims.push(Opening { x_m: rim_m, contactor: Contactor::Rim, boundary });
        }
    }
    tips.append(&mut rims);
    tips.sort_by(|a, b| a.x_m.total_cmp(&b.x_m));
    tips
}

/// Deflection at which a boundary gives way, in m.
fn deflection_at_rupture_m(layer: &Layer, threshold_n: f64) -> f64 {
    threshold_n / layer.stiffness_n_per_m
}

fn predict_rupture(path: &Path<'_>, event: &Opening, before: Open, after: Open) -> PredictedRupture {
    let x_m = event.x_m;
    let force_n = |open: Open| path.tip(open, x_m).force_n + path.rim(open, x_m).force_n;
    PredictedRupture {
        contactor: event.contactor,
        boundary: event.boundary,
        x_m,
        force_before_n: force_n(before),
        force_after_n: force_n(after),
        energy_before_j: path.energy_j(before, x_m),
        energy_after_j: path.energy_j(after, x_m),
    }
}
