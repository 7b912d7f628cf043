//! Positions of the boundaries around a needle, so that the display agrees with the needle's
//! position.
//!
//! The force law and the field are two models of one tissue. The field alone is dented by the law's
//! force divided by its own stiffness, which agrees with the law's tip only if the two stiffnesses
//! agree. The displayed dents are therefore constrained by the law's state: the boundaries that tip
//! and rim have opened, and their positions. Within these bounds the field determines the dents.

/// Position of a needle along its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Intrusion {
    /// Distance of the tip from the intersection of its line with the resting skin, in m; negative
    /// above it.
    pub tip_m: f64,
    /// Distance from the tip back to the cannula's rim, in m; 0 for a needle without one.
    pub tip_to_rim_m: f64,
    /// Number of boundaries that the tip has opened, from the surface down.
    pub tip_open: usize,
    /// Number of boundaries that the rim has opened, from the surface down.
    pub rim_open: usize,
}

/// A boundary pressed by tip or rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed {
    /// Index of the boundary, from 0 at the surface.
    pub boundary: usize,
    /// Dent along the needle, in m.
    pub dent_m: f64,
}

/// Minimum thickness of a layer between two boundaries, as a fraction, unless a contactor presses
/// it flatter.
const KEPT: f64 = 0.125;

impl Intrusion {
    /// The boundaries pressed by the tip and the rim: the first that each has not opened, if it has
    /// reached it. `rest_m` holds the distance along the needle to each resting boundary, in m,
    /// from the surface down.
    #[must_use]
    pub fn pressed(&self, rest_m: &[f64]) -> [Option<Pressed>; 2] {
        let by = |boundary: usize, at_m: f64| {
            let dent_m = at_m - rest_m.get(boundary)?;
            (dent_m > 0.0).then_some(Pressed { boundary, dent_m })
        };
        let rim = self.has_rim() && self.rim_open < self.tip_open;
        let rim = if rim { by(self.rim_open, self.rim_m()) } else { None };
        [by(self.tip_open, self.tip_m), rim]
    }

    fn has_rim(&self) -> bool {
        self.tip_to_rim_m > 0.0
    }

    fn rim_m(&self) -> f64 {
        self.tip_m - self.tip_to_rim_m
    }

    fn is_finite(&self) -> bool {
        self.tip_m.is_finite() && self.tip_to_rim_m.is_finite()
    }

    /// Bounds of the dent of a boundary, in m. They increase with the boundary's resting position,
    /// so that clamping keeps the order.
    fn bounds_m(&self, boundary: usize, rest_m: &[f64]) -> [f64; 2] {
        let Some(&own_m) = rest_m.get(boundary) else { return [f64::NEG_INFINITY, f64::INFINITY] };
        let pressed = self.pressed(rest_m);
        if let Some(held) = pressed.iter().flatten().find(|pressed| pressed.boundary == boundary) {
            return [held.dent_m; 2];
        }
        let tip = boundary_front(self.tip_m - own_m, boundary < self.tip_open, pressed[0]);
        // The rim meets only boundaries that the tip has opened.
        if !self.has_rim() || boundary >= self.tip_open || own_m > self.tip_m {
            return tip;
        }
        let rim = boundary_front(self.rim_m() - own_m, boundary < self.rim_open, pressed[1]);
        [tip[0].max(rim[0]), tip[1].min(rim[1])]
    }
}

/// Bounds of the dent of a boundary for a contactor that is `ahead_m` beyond its resting position,
/// in m. In the law a contactor meets each boundary at its resting position, so a boundary moves no
/// farther than the contactor is from there, and stays on its own side.
fn boundary_front(ahead_m: f64, opened: bool, pressed: Option<Pressed>) -> [f64; 2] {
    match (opened, ahead_m > 0.0) {
        // Carried along by the pressed boundary, no farther than it.
        (false, true) => [ahead_m, pressed.map_or(ahead_m, |pressed| pressed.dent_m.max(ahead_m))],
        // Not pressed yet: the pressed boundary above may push it as far as itself.
        (false, false) => [ahead_m, pressed.map_or(-ahead_m, |pressed| pressed.dent_m.max(-ahead_m))],
        (true, _) => [-ahead_m.abs(), ahead_m.abs()],
    }
}

/// Adjusts the dents of all boundaries, in m along the needle and positive into the body, to the
/// needle's position: pressed boundaries end at tip and rim, opened ones lie behind them, others in
/// front of them, and no boundary passes another. Without a needle in the tissue only the order is
/// kept. `rest_m` is as in [`Intrusion::pressed`]. Never allocates; values that are not finite
/// become 0.
pub fn settle_dents(needle: Option<&Intrusion>, rest_m: &[f64], dents_m: &mut [f64]) {
    for dent_m in dents_m.iter_mut().filter(|dent_m| !dent_m.is_finite()) {
        *dent_m = 0.0;
    }
    let needle = needle.filter(|needle| needle.is_finite());
    hold_boundaries(needle, rest_m, dents_m);
    for boundary in 1..dents_m.len().min(rest_m.len()) {
        let thickness_m = rest_m[boundary] - rest_m[boundary - 1];
        dents_m[boundary] = dents_m[boundary].max(dents_m[boundary - 1] - (1.0 - KEPT) * thickness_m);
    }
    hold_boundaries(needle, rest_m, dents_m);
}

fn hold_boundaries(needle: Option<&Intrusion>, rest_m: &[f64], dents_m: &mut [f64]) {
    let Some(needle) = needle else { return };
    for (boundary, dent_m) in dents_m.iter_mut().enumerate() {
        let [least_m, most_m] = needle.bounds_m(boundary, rest_m);
        *dent_m = dent_m.min(most_m).max(least_m);
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what stands where the needle is stands exactly there")]
mod tests {
    //! A boundary off the tip that presses it, one that has passed another, or one that jumps at
    //! contact would be a display error.

    use proptest::prelude::*;

    use super::*;

    /// Skin, fat, a membrane without thickness, muscle.
    const REST_M: [f64; 4] = [0.0, 0.0008, 0.0092, 0.0092];

    fn trocar(tip_mm: f64, tip_open: usize, rim_open: usize) -> Intrusion {
        Intrusion { tip_m: tip_mm * 1e-3, tip_to_rim_m: 2e-3, tip_open, rim_open }
    }

    fn settled(needle: &Intrusion, dents_mm: [f64; 4]) -> [f64; 4] {
        let mut dents_m = dents_mm.map(|mm| mm * 1e-3);
        settle_dents(Some(needle), &REST_M, &mut dents_m);
        dents_m.map(|m| (m * 1e6).round() / 1e3)
    }

    #[test]
    fn what_is_pressed_ends_at_tip_and_rim() {
        assert_eq!(settled(&trocar(5.0, 0, 0), [11.1, 9.0, 3.0, 3.0])[0], 5.0, "the skin under the tip");
        let through = settled(&trocar(4.0, 1, 0), [9.0, 9.0, 3.0, 3.0]);
        assert_eq!(through[..2], [2.0, 3.2], "the skin under the rim, the fat under the tip");
        let inside = settled(&trocar(8.0, 2, 2), [5.0, 4.0, 3.0, 3.0]);
        assert!(inside[2] <= 1.2 + 1e-9, "the membrane keeps clear of a tip that has not met it: {inside:?}");
    }

    #[test]
    fn deeper_boundary_yields_no_farther_than_the_pressed_one() {
        let pressed = settled(&trocar(5.0, 0, 0), [11.1, 9.0, 8.0, 7.0]);
        assert_eq!(pressed, [5.0; 4]);
    }

    proptest! {
        #[test]
        fn nothing_passes_anything(
            tip_mm in -1.0..30.0_f64,
            rim in any::<bool>(),
            opened in (0_usize..=4, 0_usize..=4),
            dents_mm in proptest::array::uniform4(-20.0..40.0_f64),
        ) {
            let tip_to_rim_m = if rim { 2e-3 } else { 0.0 };
            // A contactor opens only boundaries that it has reached.
            let reached = REST_M.iter().filter(|rest_m| **rest_m <= tip_mm * 1e-3).count();
            let (tip_open, rim_open) = (opened.0, opened.0.min(opened.1));
            let needle = Intrusion { tip_m: tip_mm * 1e-3, tip_to_rim_m, tip_open, rim_open };
            let mut dents_m = dents_mm.map(|mm| mm * 1e-3);
            settle_dents(Some(&needle), &REST_M, &mut dents_m);
            let stand: Vec<f64> = REST_M.iter().zip(dents_m).map(|(rest_m, dent_m)| rest_m + dent_m).collect();
            prop_assert!(stand.windows(2).all(|pair| pair[1] >= pair[0] - 1e-12), "{stand:?}");
            for (boundary, at_m) in stand.iter().enumerate() {
                let before = boundary >= tip_open || boundary >= reached;
                let right = if before { *at_m >= needle.tip_m - 1e-12 } else { *at_m <= needle.tip_m + 1e-12 };
                prop_assert!(right, "boundary {boundary} of {stand:?} on the wrong side of {needle:?}");
            }
            for pressed in needle.pressed(&REST_M).into_iter().flatten() {
                prop_assert!((dents_m[pressed.boundary] - pressed.dent_m).abs() < 1e-12);
            }
        }

        #[test]
        fn nothing_jumps_while_the_needle_moves_on(
            tip_mm in 0.0..20.0_f64,
            opened in (0_usize..=4, 0_usize..=4),
            dents_mm in proptest::array::uniform4(-3.0..12.0_f64),
        ) {
            let at = |tip_mm: f64| {
                let mut dents_m = dents_mm.map(|mm| mm * 1e-3);
                settle_dents(Some(&trocar(tip_mm, opened.0, opened.0.min(opened.1))), &REST_M, &mut dents_m);
                dents_m
            };
            for (here, there) in at(tip_mm).iter().zip(at(tip_mm + 0.01)) {
                prop_assert!((here - there).abs() < 2.1e-5, "{here} m, then {there} m");
            }
        }
    }

    #[test]
    fn numbers_that_are_none_are_contained() {
        let mut dents_m = [f64::NAN, f64::INFINITY, 0.001, -0.001];
        settle_dents(Some(&trocar(f64::NAN, 0, 0)), &REST_M, &mut dents_m);
        assert_eq!(dents_m, [0.0, 0.0, 0.001, 0.001]);
        settle_dents(Some(&trocar(3.0, 9, 9)), &REST_M[..2], &mut dents_m);
        assert!(dents_m.iter().all(|dent_m| dent_m.is_finite()));
    }
}
