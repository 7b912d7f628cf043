//! Drags on tissue that stiffens and relaxes as its law does.
//!
//! The field is linear. Under a drag the tissue has the secant stiffness F/w of the law of the
//! dragged layer, where w is the dent that its boundary would have under a load with the same
//! history. So a drag F displaces the linear field as the drag k w does, k being the stiffness
//! that the field was made with. A boundary under tip or rim needs no such load: it is placed where
//! the law has it, which is its secant stiffness.

use law::axial::{AxialSpec, Layer, MAX_BRANCHES};

/// The dents of all layers of a law under their drags.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DragDents {
    layers: Vec<DragDent>,
}

/// The dent of one layer under its drag, and the forces of its branches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct DragDent {
    dent_m: f64,
    branches_n: [f64; MAX_BRANCHES],
}

impl DragDents {
    /// Untouched layers.
    pub fn new(layers: usize) -> Self {
        Self { layers: vec![DragDent::default(); layers] }
    }

    /// Advances by `dt_s` to these drags, in N, and replaces each by the drag on the linear field
    /// that has the same effect. Never allocates.
    pub fn linearise(&mut self, law: &AxialSpec, dt_s: f64, drags_n: &mut [f64]) {
        for ((dent, layer), drag_n) in self.layers.iter_mut().zip(&law.layers).zip(drags_n) {
            // A linear law would only round.
            if layer.options.relaxes() || layer.options.stiffening_n_per_m2 > 0.0 {
                dent.advance(layer, dt_s, *drag_n);
                *drag_n = layer.stiffness_n_per_m * dent.dent_m;
            }
        }
    }
}

impl DragDent {
    /// Solves k w + κ w |w| + Σ q = F at the end of a step in which w changes evenly: each branch
    /// then has q = q₀ e^(−Δ) + g k (w − w₀) (1 − e^(−Δ))/Δ, with Δ = dt/τ. A load that is not
    /// finite changes nothing.
    fn advance(&mut self, layer: &Layer, dt_s: f64, load_n: f64) {
        if !load_n.is_finite() {
            return;
        }
        let k = layer.stiffness_n_per_m;
        let (mut spring_n_per_m, mut held_n) = (k, 0.0);
        let mut slopes_n_per_m = [0.0; MAX_BRANCHES];
        let branches = layer.options.branches.iter().zip(&mut self.branches_n).zip(&mut slopes_n_per_m);
        for ((branch, force_n), slope_n_per_m) in branches {
            let delta = dt_s.max(0.0) / branch.time_s;
            let kept = if delta > 0.0 { -libm::expm1(-delta) / delta } else { 1.0 };
            *force_n *= libm::exp(-delta);
            *slope_n_per_m = branch.share * k * kept;
            spring_n_per_m += *slope_n_per_m;
            held_n += *force_n - *slope_n_per_m * self.dent_m;
        }
        let before_m = self.dent_m;
        self.dent_m = dent_m(spring_n_per_m, layer.options.stiffening_n_per_m2, load_n - held_n);
        for (force_n, slope_n_per_m) in self.branches_n.iter_mut().zip(slopes_n_per_m) {
            *force_n += slope_n_per_m * (self.dent_m - before_m);
        }
    }
}

/// The root w of k w + κ w |w| = F, in m: accurate for a small κ, where the textbook form cancels.
fn dent_m(spring_n_per_m: f64, stiffening_n_per_m2: f64, load_n: f64) -> f64 {
    let root = libm::sqrt(spring_n_per_m * spring_n_per_m + 4.0 * stiffening_n_per_m2 * load_n.abs());
    2.0 * load_n / (spring_n_per_m + root)
}

#[cfg(test)]
mod tests {
    //! Fails if a drag dents its layer otherwise than the law's own boundary, moved by that dent,
    //! carries the drag: stiffening, relaxing, loaded, held and unloaded.

    use law::Incidence;
    use law::axial::{
        AxialInput, AxialParams, AxialScratch, AxialState, ForceLaw, LayerOptions, MaxwellBranch, RuptureCriterion,
        step,
    };

    use super::*;

    /// Fields steps of 8 ms, ticks of the law of 1 ms.
    const TICKS: u32 = 8;

    fn skin(stiffening_n_per_m2: f64, branches: Vec<MaxwellBranch>) -> AxialSpec {
        let options = LayerOptions { stiffening_n_per_m2, branches, ..LayerOptions::default() };
        let layer = Layer {
            name: "skin".to_owned(),
            thickness_m: 0.1,
            stiffness_n_per_m: 60.0,
            damping_n_s_per_m2: 0.0,
            tip_rupture_n: 1e3,
            rim_rupture_n: 1e3,
            friction_n_per_m: 0.0,
            cutting_n: 0.0,
            options: LayerOptions { gives_way_at: RuptureCriterion::Dent, ..options },
        };
        AxialSpec {
            law: ForceLaw::Version5,
            layers: vec![layer],
            tip_to_rim_m: 0.0,
            presliding_stiffness_n_per_m: 2000.0,
            speed_window_s: 0.0,
            damping_time_s: 0.01,
            rate: None,
            breakaway: None,
        }
    }

    /// Rises to 4 N in 0.4 s, holds for 1.2 s, then falls to half, which tissue that relaxes follows without pulling.
    fn drag_n(step: u32) -> f64 {
        match f64::from(step) / 200.0 {
            rising if rising < 0.25 => 16.0 * rising,
            held if held < 1.0 => 4.0,
            falling => (4.0 - 4.0 * (falling - 1.0)).max(2.0),
        }
    }

    #[test]
    fn drag_dents_a_layer_as_the_law_carries_it() {
        let branches = vec![MaxwellBranch { share: 0.9, time_s: 0.2 }, MaxwellBranch { share: 0.4, time_s: 2.0 }];
        for law in [skin(26_800.0, Vec::new()), skin(0.0, branches.clone()), skin(26_800.0, branches)] {
            let params = AxialParams::new(law.clone()).expect("valid");
            let (mut state, mut scratch) = (AxialState::new(&params), AxialScratch::new(&params));
            let (mut dents, mut before_m) = (DragDents::new(1), 0.0);
            let mut carried_n = |t_s: f64, x_m: f64| {
                step(&params, &mut state, &mut scratch, &AxialInput { t_s, x_m, incidence: Incidence::UPRIGHT }).tip_n
            };
            carried_n(0.0, 0.0);
            let mut apart = 0.0_f64;
            for at in 0..320 {
                let mut drags_n = [drag_n(at)];
                dents.linearise(&law, f64::from(TICKS) * 1e-3, &mut drags_n);
                let to_m = drags_n[0] / law.layers[0].stiffness_n_per_m;
                let found_n = (1..=TICKS).map(|tick| {
                    let x_m = before_m + (to_m - before_m) * f64::from(tick) / f64::from(TICKS);
                    carried_n(f64::from(at * TICKS + tick) * 1e-3, x_m)
                });
                let found_n = found_n.last().expect("ticks");
                assert!((found_n - drag_n(at)).abs() < 1e-9, "{found_n} N of {} N in step {at} of {law:?}", drag_n(at));
                before_m = to_m;
                apart = apart.max((drags_n[0] / drag_n(at).max(1e-9) - 1.0).abs());
            }
            assert!(apart > 0.3, "a linear layer would be dented as far: {apart}");
        }
    }

    #[test]
    fn drag_out_dents_as_far_as_drag_in() {
        let law = skin(26_800.0, vec![MaxwellBranch { share: 0.9, time_s: 0.2 }]);
        let [mut inwards, mut outwards] = [DragDents::new(1), DragDents::new(1)];
        for at in 0..320 {
            let [mut pushed_n, mut pulled_n] = [[drag_n(at)], [-drag_n(at)]];
            inwards.linearise(&law, 8e-3, &mut pushed_n);
            outwards.linearise(&law, 8e-3, &mut pulled_n);
            assert!((pushed_n[0] + pulled_n[0]).abs() < 1e-12, "{pushed_n:?} in, {pulled_n:?} out");
        }
    }

    #[test]
    fn linear_layer_and_bad_loads_keep_their_drag() {
        let (linear, stiffening) = (skin(0.0, Vec::new()), skin(26_800.0, Vec::new()));
        let mut dents = DragDents::new(1);
        let mut drags_n = [0.37];
        dents.linearise(&linear, 8e-3, &mut drags_n);
        assert_eq!(drags_n.map(f64::to_bits), [0.37_f64.to_bits()], "not a bit changes");
        dents.linearise(&stiffening, 8e-3, &mut drags_n);
        for bad_n in [f64::NAN, f64::INFINITY] {
            let mut again_n = [bad_n];
            dents.linearise(&stiffening, 8e-3, &mut again_n);
            assert_eq!(again_n.map(f64::to_bits), drags_n.map(f64::to_bits), "{bad_n} N is no load");
        }
    }
}
