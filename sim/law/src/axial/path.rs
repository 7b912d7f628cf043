//! The layers along a needle's path: positions of the boundaries and their response when tented.
//! Shared by the step and the closed form.

use super::options::PLAIN_EDGE;
use super::params::{AxialSpec, Layer};
use crate::skin::Incidence;

/// Number of boundaries that each contactor has opened; they open in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Open {
    pub tip: usize,
    pub rim: usize,
}

/// Force and energy of the spring of one tented boundary, without its branches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TentedBoundary {
    pub deflection_m: f64,
    pub force_n: f64,
    pub energy_j: f64,
}

/// The layers along a path. `boundaries_m[i]` is D_i; one more entry than layers, the last being
/// the far side.
pub(crate) struct Path<'a> {
    pub layers: &'a [Layer],
    pub boundaries_m: &'a [f64],
    pub tip_to_rim_m: f64,
    pub incidence: Incidence,
    /// Direction of the needle's edge in the plane of the skin, of unit length.
    pub edge: [f64; 2],
}

/// Fills `boundaries_m` with the distance along the needle to each boundary and to the far side.
pub(crate) fn lay_boundaries(layers: &[Layer], incidence: &Incidence, boundaries_m: &mut Vec<f64>) {
    incidence.lay_layers(layers.iter().map(|layer| layer.thickness_m), boundaries_m);
}

impl<'a> Path<'a> {
    /// The path of a specification over boundaries computed for the same incidence.
    pub fn new(spec: &'a AxialSpec, boundaries_m: &'a [f64], incidence: Incidence) -> Self {
        Self { layers: &spec.layers, boundaries_m, tip_to_rim_m: spec.tip_to_rim_m, incidence, edge: PLAIN_EDGE }
    }

    /// The same path under another direction of the needle's edge.
    pub fn under_edge(self, edge: [f64; 2]) -> Self {
        Self { edge, ..self }
    }

    /// Stiffness k of a layer's boundary under this needle, in N/m.
    pub fn stiffness_n_per_m(&self, layer: &Layer) -> f64 {
        let k = layer.stiffness_n_per_m;
        layer.options.sheet.map_or(k, |sheet| k * sheet.stiffness_share(self.edge))
    }

    /// A threshold of a layer under this needle, in N.
    pub fn threshold_n(&self, layer: &Layer, across_n: f64) -> f64 {
        layer.options.sheet.map_or(across_n, |sheet| across_n * sheet.threshold_share(self.edge))
    }

    fn tent(&self, boundary: usize, reach_m: f64) -> TentedBoundary {
        let (Some(layer), Some(depth)) = (self.layers.get(boundary), self.boundaries_m.get(boundary)) else {
            return TentedBoundary::default();
        };
        let w = (reach_m - depth).max(0.0);
        let (k, kappa) = (self.stiffness_n_per_m(layer), layer.options.stiffening_n_per_m2);
        // Without κ both add zero, which changes no bit.
        let force_n = k * w + kappa * w * w;
        let energy_j = 0.5 * k * w * w + kappa * w * w * w / 3.0;
        TentedBoundary { deflection_m: w, force_n, energy_j }
    }

    /// The boundary tented by the tip: the first that it has not opened.
    pub fn tip(&self, open: Open, x_m: f64) -> TentedBoundary {
        self.tent(open.tip, x_m)
    }

    /// The boundary tented by the rim: the first that it has not opened, if the tip has. A single
    /// contactor has no rim.
    pub fn rim(&self, open: Open, x_m: f64) -> TentedBoundary {
        if self.tip_to_rim_m > 0.0 && open.rim < open.tip {
            self.tent(open.rim, x_m - self.tip_to_rim_m)
        } else {
            TentedBoundary::default()
        }
    }

    /// Energy stored by the springs, U = ½ k w² + ⅓ κ w³ of tip and rim, in J.
    pub fn energy_j(&self, open: Open, x_m: f64) -> f64 {
        self.tip(open, x_m).energy_j + self.rim(open, x_m).energy_j
    }

    /// Material depth s of the tip, in m: an intact boundary is carried along instead of being
    /// passed.
    pub fn depth_m(&self, open: Open, x_m: f64) -> f64 {
        let stop = if open.tip < self.layers.len() { self.boundaries_m.get(open.tip) } else { None };
        stop.map_or(x_m, |boundary| x_m.min(*boundary)).max(0.0)
    }

    /// Each layer with the length l_j = clip(s − D_j, 0, d_j) of needle inside it, in m, for a
    /// material depth s.
    pub fn inserted(&self, depth_m: f64) -> impl Iterator<Item = (&'a Layer, f64)> + use<'a> {
        let incidence = self.incidence;
        self.layers.iter().zip(self.boundaries_m.windows(2)).map(move |(layer, ends_m)| {
            let length_m =
                if incidence.is_flat() { layer.thickness_m * incidence.path_factor } else { ends_m[1] - ends_m[0] };
            (layer, (depth_m - ends_m[0]).max(0.0).min(length_m))
        })
    }

    /// The layer j with D_j < s ≤ D_{j+1}; `None` above the skin and below the last layer.
    pub fn layer_at(&self, depth_m: f64) -> Option<usize> {
        self.boundaries_m.windows(2).position(|pair| matches!(pair, [near, far] if *near < depth_m && depth_m <= *far))
    }
}
