//! Forces that jump, are constant, or are invalid. The model is stateless, so no force may affect
//! later results.

use tissue::FieldModel;
use tissue::axisymmetric::{Axisymmetric, AxisymmetricError, fit};

use crate::slabs::{ask_contactor, make_elastic_layer};
use crate::{Measured, largest};

fn lower_back() -> Result<Axisymmetric, AxisymmetricError> {
    let layers = vec![
        make_elastic_layer(0.0008, 132e3, 0.45),
        make_elastic_layer(0.0084, 33.1e3, 0.45),
        make_elastic_layer(0.039, 198e3, 0.45),
    ];
    Ok(fit(&ask_contactor(layers, 0.0), 1e-2)?.model)
}

/// Returns axial and radial displacement in m at points throughout the tissue.
fn answer(model: &Axisymmetric) -> Vec<f64> {
    let places = (0..12).flat_map(|r| (0..8).map(move |z| [0.0021 * f64::from(r), 0.0031 * f64::from(z)]));
    places.flat_map(|[r_m, depth_m]| model.displacement_m(r_m, depth_m)).collect()
}

fn largest_change(one: &[f64], other: &[f64]) -> f64 {
    largest(one.iter().zip(other).map(|(a, b)| (a - b).abs()))
}

/// In to 50 mm at 1 m/s and out again, at 331 N/m; then 1 N as before.
pub(super) fn stab_memory() -> Measured {
    let mut model = lower_back()?;
    let before = answer(&model);
    for tick in (0..50).chain((0..50).rev()) {
        model.solve(0.331 * f64::from(tick));
    }
    model.solve(1.0);
    Ok(largest_change(&before, &answer(&model)))
}

/// Relative to the largest displacement.
pub(super) fn teleport_linearity() -> Measured {
    let mut model = lower_back()?;
    let scaled: Vec<f64> = answer(&model).iter().map(|u| 100.0 * u).collect();
    model.solve(100.0);
    Ok(largest_change(&scaled, &answer(&model)) / largest(scaled.iter().map(|u| u.abs())))
}

/// The last valid result is kept.
pub(super) fn bad_force_answers() -> Measured {
    let mut model = lower_back()?;
    model.solve(0.7);
    let before = answer(&model);
    let changed = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(|force_n| {
        model.solve(force_n);
        usize::from(answer(&model) != before)
    });
    Ok(changed.iter().sum::<usize>() as f64)
}

/// 72 000 fields at 120 Hz, bit-exact.
pub(super) fn hold_changes() -> Measured {
    let mut model = lower_back()?;
    model.solve(0.7);
    let before = answer(&model);
    let mut changes = 0;
    for field in 0..72_000 {
        model.solve(0.7);
        // Every point depends on the whole solution: check the full field occasionally and one
        // point always.
        let same = model.displacement_m(0.0, 0.0)[0].to_bits() == before[0].to_bits();
        let all_same = field % 1000 != 0 || answer(&model) == before;
        changes += usize::from(!(same && all_same));
    }
    Ok(changes as f64)
}
