//! Closed forms of the physics that the tests and the documents quote: rupture positions and forces
//! of a monotonic insertion.

use crate::axial::{AxialSpec, Contactor, Open, PLAIN_EDGE, Path, RuptureCriterion, lay_boundaries};
use crate::skin::Incidence;

/// A rupture predicted in closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedRupture {
    /// The contactor.
    pub contactor: Contactor,
    /// Index of the boundary, from 0 at the surface.
    pub boundary: usize,
    /// Axial displacement of the tip at the rupture, in m.
    pub x_m: f64,
    /// Elastic force on the hand just before, in N. Shared by the members of a cascade.
    pub force_before_n: f64,
    /// Elastic force on the hand just after the whole cascade at this position, in N.
    pub force_after_n: f64,
    /// Elastic energy before, in J.
    pub energy_before_j: f64,
    /// Elastic energy after the whole cascade, in J.
    pub energy_after_j: f64,
}

/// Predicts the ruptures of a slow monotonic perpendicular insertion, in order; those of a cascade
/// have the same position.
///
/// Tip i opens at x = max(previous tip, D_i + P_tip,i/k_i), rim i at max(previous rim, tip i, D_i +
/// L + P_rim,i/k_i); a tent that stiffens at the root of k w + κ w² = P. A tent that relaxes is
/// fully relaxed: this is the limit of infinite slowness. [`predict_held_ruptures`] covers other
/// speeds.
#[must_use]
pub fn predict_ruptures(spec: &AxialSpec) -> Vec<PredictedRupture> {
    predict_held_ruptures(spec, 0.0)
}

/// Predicts the ruptures of an insertion in which the fraction `held` of the branches' force, from
/// 0 to 1, remains at a rupture: 0 is infinitely slow, 1 infinitely fast. The contactor that takes
/// over finds a relaxed tent. The needle's edge is [`PLAIN_EDGE`]; [`AxialSpec::under_edge`]
/// rotates it.
#[must_use]
pub fn predict_held_ruptures(spec: &AxialSpec, held: f64) -> Vec<PredictedRupture> {
    let plain = spec.has_sheets().then(|| spec.under_edge(PLAIN_EDGE));
    let spec = plain.as_ref().unwrap_or(spec);
    let mut boundaries_m = Vec::with_capacity(spec.layers.len() + 1);
    lay_boundaries(&spec.layers, &Incidence::UPRIGHT, &mut boundaries_m);
    let path = Path::new(spec, &boundaries_m, Incidence::UPRIGHT);
    let events = predict_positions(spec, &boundaries_m, held);
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
        predicted.extend(
            cascade
                .iter()
                .map(|event| predict_rupture(&HeldPath { path: &path, held, before, events: &events }, event, open)),
        );
    }
    predicted
}

/// The opening of a boundary by a contactor.
pub(crate) struct Opening {
    pub x_m: f64,
    pub contactor: Contactor,
    boundary: usize,
    /// Dent of the boundary when the contactor took it over, in m: this part of it has relaxed.
    found_m: f64,
}

/// All ruptures with their positions, sorted by position; at one position tips come before rims,
/// each in boundary order.
pub(crate) fn predict_positions(spec: &AxialSpec, boundaries_m: &[f64], held: f64) -> Vec<Opening> {
    let lag_m = spec.tip_to_rim_m;
    let (mut tip_m, mut rim_m) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    let (mut tips, mut rims) = (Vec::new(), Vec::new());
    for (boundary, (layer, depth_m)) in spec.layers.iter().zip(boundaries_m).enumerate() {
        // Beyond the inherited dent the branches act as if the threshold were higher by the force
        // that they would have held.
        let held = match layer.options.gives_way_at {
            RuptureCriterion::Force => held,
            RuptureCriterion::Dent => 0.0,
        };
        let dent_m = |threshold_n: f64, found_m: f64| {
            let relaxed_n = held * layer.options.branch_share() * layer.stiffness_n_per_m * found_m;
            layer.dent_m(threshold_n + relaxed_n, held)
        };
        let found_m = (tip_m - depth_m).max(0.0);
        tip_m = tip_m.max(depth_m + dent_m(layer.tip_rupture_n, found_m));
        tips.push(Opening { x_m: tip_m, contactor: Contactor::Tip, boundary, found_m });
        if lag_m > 0.0 {
            let found_m = (rim_m.max(tip_m) - lag_m - depth_m).max(0.0);
            rim_m = rim_m.max(tip_m).max(depth_m + lag_m + dent_m(layer.rim_rupture_n, found_m));
            rims.push(Opening { x_m: rim_m, contactor: Contactor::Rim, boundary, found_m });
        }
    }
    tips.append(&mut rims);
    tips.sort_by(|a, b| a.x_m.total_cmp(&b.x_m));
    tips
}

/// The tents before and after a cascade, with the remaining fraction of the branches' force on the
/// tents that existed before it.
struct HeldPath<'a> {
    path: &'a Path<'a>,
    held: f64,
    before: Open,
    events: &'a [Opening],
}

/// Force in N and energy in J.
#[derive(Default)]
struct Load {
    force_n: f64,
    energy_j: f64,
}

impl HeldPath<'_> {
    /// Load of both tents.
    fn load(&self, open: Open, x_m: f64) -> Load {
        let Self { path, before, .. } = *self;
        let had_rim = before.rim < before.tip;
        let tip =
            (open.tip == before.tip).then(|| self.branches(Contactor::Tip, open.tip, path.tip(open, x_m).deflection_m));
        let rim = (had_rim && open.rim == before.rim)
            .then(|| self.branches(Contactor::Rim, open.rim, path.rim(open, x_m).deflection_m));
        let [tip, rim] = [tip, rim].map(Option::unwrap_or_default);
        Load {
            force_n: path.tip(open, x_m).force_n + path.rim(open, x_m).force_n + tip.force_n + rim.force_n,
            energy_j: path.energy_j(open, x_m) + tip.energy_j + rim.energy_j,
        }
    }

    /// Load of the branches of a tent that existed before: q = held g k (w − w₀), q²/(2 g k), with
    /// w₀ the inherited dent.
    fn branches(&self, contactor: Contactor, boundary: usize, dent_m: f64) -> Load {
        let Some(layer) = self.path.layers.get(boundary) else { return Load::default() };
        let opening = self.events.iter().find(|event| (event.contactor, event.boundary) == (contactor, boundary));
        let stretched_m = (dent_m - opening.map_or(0.0, |opening| opening.found_m)).max(0.0);
        let force_n = self.held * layer.options.branch_share() * layer.stiffness_n_per_m * stretched_m;
        Load { force_n, energy_j: 0.5 * self.held * force_n * stretched_m }
    }
}

fn predict_rupture(tents: &HeldPath<'_>, event: &Opening, after: Open) -> PredictedRupture {
    let x_m = event.x_m;
    let (before, after) = (tents.load(tents.before, x_m), tents.load(after, x_m));
    PredictedRupture {
        contactor: event.contactor,
        boundary: event.boundary,
        x_m,
        force_before_n: before.force_n,
        force_after_n: after.force_n,
        energy_before_j: before.energy_j,
        energy_after_j: after.energy_j,
    }
}
