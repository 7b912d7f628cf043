//! A load on the nodes: the traction integrated with the trilinear shape functions, so that its sum
//! and its moment are exact.

use law::axial::{Domain, ParamError};
use libm::{erf, exp};

use super::grid::Grid;
use super::kernel::NodalField;
use super::lattice::Lattice;
use crate::{Load, LoadKind};

/// The share of an axial force on each node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodalLoad {
    /// Place and share. The shares of the whole tissue add up to 1.
    shares: Vec<(usize, f64)>,
}

impl NodalLoad {
    /// Distributes a load over the nodes of a lattice.
    ///
    /// # Errors
    /// If a radius or a depth is out of range.
    pub fn new(lattice: &Lattice, load: &Load) -> Result<Self, ParamError> {
        let grid = &lattice.grid;
        Domain::Positive.check("load_radius_m", load.radius_m, "m")?;
        let across = across(grid, load.radius_m);
        let down = down(grid, load.kind)?;
        let mut shares = Vec::new();
        for node in grid.nodes().filter(|node| grid.moves(*node)) {
            let share = across[node[0]] * across[node[1]] * down[node[2]];
            // Beyond six radii a Gaussian is below rounding.
            if share > 1e-16 {
                shares.push((grid.place(node), share));
            }
        }
        let whole: f64 = lattice.symmetric_parts() * shares.iter().map(|(_, share)| share).sum::<f64>();
        shares.iter_mut().for_each(|(_, share)| *share /= whole);
        Ok(Self { shares })
    }

    /// Adds a force of this magnitude, into the body, to nodal forces.
    pub(super) fn add(&self, force_n: f64, forces: &mut NodalField) {
        for (place, share) in &self.shares {
            forces.axes[2][*place] -= force_n * share;
        }
    }

    /// Does the same in single precision.
    pub(super) fn add_single(&self, force_n: f64, forces: &mut NodalField<f32>) {
        for (place, share) in &self.shares {
            forces.axes[2][*place] -= (force_n * share) as f32;
        }
    }

    /// Displacement of the load into the body, in m: its work per force, in the computed part.
    pub(super) fn work_m(&self, displacement_m: &NodalField) -> f64 {
        -self.shares.iter().map(|(place, share)| share * displacement_m.axes[2][*place]).sum::<f64>()
    }
}

/// ∫ hat(x) exp(−(x/a)²)/(a√π) dx for the hat function of every column.
fn across(grid: &Grid, radius_m: f64) -> Vec<f64> {
    // With t = x/a and s = h/a, ∫ of the hat is [G(t+s) − 2G(t) + G(t−s)] / s, where G'' is the
    // Gaussian.
    let s = grid.spacing_m / radius_m;
    let twice = |t: f64| 0.5 * (t * erf(t) + exp(-t * t) * std::f64::consts::FRAC_2_SQRT_PI / 2.0);
    let column = |i: usize| {
        let t = (i as f64 - grid.centre() as f64) * s;
        let whole = (twice(t + s) - 2.0 * twice(t) + twice(t - s)) / s;
        // Only one half of the hat function on a plane of symmetry is computed.
        if i == 0 && grid.centre() == 0 { 0.5 * whole } else { whole }
    };
    (0..grid.side).map(column).collect()
}

/// The share of every plane of nodes.
fn down(grid: &Grid, kind: LoadKind) -> Result<Vec<f64>, ParamError> {
    let mut shares = vec![0.0; grid.depths_m.len()];
    let (from_m, to_m) = match kind {
        LoadKind::Contactor { depth_m } => (depth_m, depth_m),
        LoadKind::Drag { from_m, to_m } => (from_m, to_m),
    };
    Domain::NotNegative.check("load_depth_m", from_m, "m")?;
    let base_m = grid.depth_m();
    if !(to_m >= from_m && from_m < base_m * (1.0 - 1e-9)) {
        let allowed = "must be above the base of the lattice, and above the lower end of the drag";
        return Err(ParamError { field: "load_depth_m".into(), value: from_m, unit: "m", allowed });
    }
    if to_m - from_m <= 1e-9 {
        let (upper, part) = grid.storey_at(from_m);
        shares[upper] += 1.0 - part;
        shares[upper + 1] += part;
        return Ok(shares);
    }
    for (k, planes_m) in grid.depths_m.windows(2).enumerate() {
        let (top_m, height_m) = (planes_m[0], planes_m[1] - planes_m[0]);
        let part = |depth_m: f64| ((depth_m - top_m) / height_m).clamp(0.0, 1.0);
        let [begin, end] = [from_m, to_m].map(part);
        let lower = 0.5 * (end * end - begin * begin);
        let per_length = height_m / (to_m - from_m);
        shares[k] += per_length * (end - begin - lower);
        shares[k + 1] += per_length * lower;
    }
    Ok(shares)
}
