//! The needle's loads on the tissue: the forces of a step at boundaries and along layers.

use super::params::{AxialParams, Layer};
use super::path::Path;
use super::state::{AxialScratch, AxialStanding};

/// Writes the loads of a needle in a given state into `loads_n`, in N, positive into the body: for
/// n layers first the contactor at each of the n boundaries, then the drag along each of the n
/// layers. Their sum is the axial force. Never allocates.
///
/// Viscosity is distributed by b_j l_j and friction by c_j l_j, as in the ledger; cutting drags the
/// layer that contains the tip. `scratch` is that of the last step. Loads beyond the length of
/// `loads_n` are dropped.
pub fn write_loads(params: &AxialParams, standing: &AxialStanding, scratch: &AxialScratch, loads_n: &mut [f64]) {
    loads_n.fill(0.0);
    let layers = params.spec().layers.len();
    let AxialStanding { tip_open, rim_open, output } = standing;
    let mut add = |at: usize, force_n: f64| {
        if let Some(load_n) = loads_n.get_mut(at) {
            *load_n += force_n;
        }
    };
    add((*tip_open).min(layers - 1), output.tip_n);
    add((*rim_open).min(layers - 1), output.rim_n);
    let path = Path::new(params.spec(), &scratch.boundaries_m, scratch.incidence);
    let mut drag = |force_n: f64, coefficient: fn(&Layer) -> f64| {
        let weight = |(layer, inserted_m): (&Layer, f64)| coefficient(layer) * inserted_m;
        let total: f64 = path.inserted(output.depth_m).map(weight).sum();
        if total > 0.0 {
            path.inserted(output.depth_m).enumerate().for_each(|(j, l)| add(layers + j, force_n * (weight(l) / total)));
        }
    };
    drag(output.viscous_n, |layer| layer.damping_n_s_per_m2);
    drag(output.friction_n, |layer| layer.friction_n_per_m);
    if let Some(layer) = path.layer_at(output.depth_m) {
        add(layers + layer, output.cutting_n);
    }
}
