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

/// Source of the boundary conditions of a recording's field, from the oldest version to the newest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Follows {
    /// The force law's forces, in older recordings: a boundary is displaced according to the
    /// field's own stiffness under these forces.
    #[default]
    Forces,
    /// The needle: boundaries under load of tip and rim are placed at the contactors' positions.
    Needle,
    /// The needle, with tissue that stiffens and relaxes as the law does: drags act on the law's
    /// secant stiffness, and boundaries stay inside the body.
    Secant,
}

/// Minimum thickness of a layer between two boundaries, as a fraction, unless a contactor presses
/// it flatter.
const KEPT: f64 = 0.125;

/// Largest displacement of a boundary that no contactor presses, as a fraction of the body's depth
/// along the needle (choice).
const MOST_OF_BODY: f64 = 0.5;

/// Limits of the dents that the needle alone does not set.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Limits {
    /// Largest part of the distance from its resting position to a contactor by which an opened
    /// boundary moves.
    opened: f64,
    /// Largest displacement of a boundary that no contactor presses, in m.
    free_m: f64,
    /// Position of the base along the needle, in m.
    base_m: f64,
}

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
    fn bounds_m(&self, boundary: usize, rest_m: &[f64], limits: &Limits) -> [f64; 2] {
        let Some(&own_m) = rest_m.get(boundary) else { return [f64::NEG_INFINITY, f64::INFINITY] };
        let pressed = self.pressed(rest_m);
        if let Some(held) = pressed.iter().flatten().find(|pressed| pressed.boundary == boundary) {
            return [held.dent_m; 2];
        }
        let front = |ahead_m: f64, is_opened: bool, pressed: Option<Pressed>| {
            if is_opened {
                [-1.0, 1.0].map(|side| side * limits.opened * ahead_m.abs())
            } else {
                closed_front(ahead_m, pressed)
            }
        };
        let tip = front(self.tip_m - own_m, boundary < self.tip_open, pressed[0]);
        // The rim meets only boundaries that the tip has opened.
        if !self.has_rim() || boundary >= self.tip_open || own_m > self.tip_m {
            return tip;
        }
        let rim = front(self.rim_m() - own_m, boundary < self.rim_open, pressed[1]);
        [tip[0].max(rim[0]), tip[1].min(rim[1])]
    }
}

/// Bounds of the dent of a boundary that a contactor `ahead_m` beyond its resting position has not
/// opened, in m. In the law a contactor meets each boundary at its resting position, so a boundary
/// moves no farther than the contactor is from there, and stays on its own side. The pressed
/// boundary above carries it along, or may push it as far as itself.
fn closed_front(ahead_m: f64, pressed: Option<Pressed>) -> [f64; 2] {
    let far_m = ahead_m.abs();
    [ahead_m, pressed.map_or(far_m, |pressed| pressed.dent_m.max(far_m))]
}

/// Adjusts the dents of all boundaries, in m along the needle and positive into the body, to the
/// needle's position: pressed boundaries end at tip and rim, opened ones lie behind them, others in
/// front of them, and no boundary passes another. Without a needle in the tissue only the order is
/// kept. `rest_m` holds the distance along the needle to each resting boundary and to the base, in
/// m, from the surface down. Never allocates; values that are not finite become 0.
///
/// With [`Follows::Secant`], an opened boundary moves by at most seven eighths of its distance to
/// the contactor, one that no contactor presses or pushes by at most half of the body's depth, and
/// none lies below the base unless the tip does.
pub fn settle_dents(follows: Follows, needle: Option<&Intrusion>, rest_m: &[f64], dents_m: &mut [f64]) {
    for dent_m in dents_m.iter_mut().filter(|dent_m| !dent_m.is_finite()) {
        *dent_m = 0.0;
    }
    let needle = needle.filter(|needle| needle.is_finite());
    let limits = limits(follows, rest_m, dents_m.len());
    for dent_m in dents_m.iter_mut() {
        *dent_m = dent_m.min(limits.free_m).max(-limits.free_m);
    }
    hold_boundaries(needle, rest_m, dents_m, &limits);
    for boundary in 1..dents_m.len().min(rest_m.len()) {
        let thickness_m = rest_m[boundary] - rest_m[boundary - 1];
        dents_m[boundary] = dents_m[boundary].max(dents_m[boundary - 1] - (1.0 - KEPT) * thickness_m);
    }
    keep_above_base(limits.base_m, rest_m, dents_m);
    hold_boundaries(needle, rest_m, dents_m, &limits);
}

/// Lifts boundaries from the base up, so that every layer keeps a part of its thickness.
fn keep_above_base(base_m: f64, rest_m: &[f64], dents_m: &mut [f64]) {
    // Earlier versions have no base: rounding alone would change their bits.
    if base_m.is_infinite() {
        return;
    }
    let (mut below_m, mut most_m) = (base_m, 0.0);
    for (dent_m, &own_m) in dents_m.iter_mut().zip(rest_m).rev() {
        most_m += (1.0 - KEPT) * (below_m - own_m);
        *dent_m = dent_m.min(most_m);
        (below_m, most_m) = (own_m, *dent_m);
    }
}

fn limits(follows: Follows, rest_m: &[f64], boundaries: usize) -> Limits {
    match (follows, rest_m.get(boundaries)) {
        (Follows::Secant, Some(&base_m)) => Limits { opened: 1.0 - KEPT, free_m: MOST_OF_BODY * base_m, base_m },
        (Follows::Secant, None) => Limits { opened: 1.0 - KEPT, free_m: f64::INFINITY, base_m: f64::INFINITY },
        (Follows::Forces | Follows::Needle, _) => Limits { opened: 1.0, free_m: f64::INFINITY, base_m: f64::INFINITY },
    }
}

fn hold_boundaries(needle: Option<&Intrusion>, rest_m: &[f64], dents_m: &mut [f64], limits: &Limits) {
    let Some(needle) = needle else { return };
    for (boundary, dent_m) in dents_m.iter_mut().enumerate() {
        let [least_m, most_m] = needle.bounds_m(boundary, rest_m, limits);
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

    /// Skin, fat, a membrane without thickness, muscle, and the base.
    const REST_M: [f64; 5] = [0.0, 0.0008, 0.0092, 0.0092, 0.04];
    const VERSIONS: [Follows; 2] = [Follows::Needle, Follows::Secant];

    fn trocar(tip_mm: f64, tip_open: usize, rim_open: usize) -> Intrusion {
        Intrusion { tip_m: tip_mm * 1e-3, tip_to_rim_m: 2e-3, tip_open, rim_open }
    }

    fn settled(needle: &Intrusion, dents_mm: [f64; 4]) -> [f64; 4] {
        let mut dents_m = dents_mm.map(|mm| mm * 1e-3);
        settle_dents(Follows::Secant, Some(needle), &REST_M, &mut dents_m);
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
            follows in proptest::sample::select(&VERSIONS),
        ) {
            let tip_to_rim_m = if rim { 2e-3 } else { 0.0 };
            // A contactor opens only boundaries that it has reached.
            let reached = REST_M[..4].iter().filter(|rest_m| **rest_m <= tip_mm * 1e-3).count();
            let (tip_open, rim_open) = (opened.0, opened.0.min(opened.1));
            let needle = Intrusion { tip_m: tip_mm * 1e-3, tip_to_rim_m, tip_open, rim_open };
            let mut dents_m = dents_mm.map(|mm| mm * 1e-3);
            settle_dents(follows, Some(&needle), &REST_M, &mut dents_m);
            let stand: Vec<f64> = REST_M.iter().zip(dents_m).map(|(rest_m, dent_m)| rest_m + dent_m).collect();
            prop_assert!(stand.windows(2).all(|pair| pair[1] >= pair[0] - 1e-12), "{stand:?}");
            for (boundary, at_m) in stand.iter().enumerate() {
                let before = boundary >= tip_open || boundary >= reached;
                let right = if before { *at_m >= needle.tip_m - 1e-12 } else { *at_m <= needle.tip_m + 1e-12 };
                prop_assert!(right, "boundary {boundary} of {stand:?} on the wrong side of {needle:?}");
            }
            for pressed in needle.pressed(&REST_M[..4]).into_iter().flatten() {
                prop_assert!((dents_m[pressed.boundary] - pressed.dent_m).abs() < 1e-12);
            }
        }

        #[test]
        fn free_boundaries_keep_off_the_tip_and_inside_the_body(
            tip_mm in -1.0..60.0_f64,
            rim in any::<bool>(),
            opened in (0_usize..=4, 0_usize..=4),
            dents_mm in proptest::array::uniform4(-80.0..80.0_f64),
        ) {
            let (tip_open, rim_open) = (opened.0, opened.0.min(opened.1));
            let tip_to_rim_m = if rim { 2e-3 } else { 0.0 };
            let needle = Intrusion { tip_m: tip_mm * 1e-3, tip_to_rim_m, tip_open, rim_open };
            let mut dents_m = dents_mm.map(|mm| mm * 1e-3);
            settle_dents(Follows::Secant, Some(&needle), &REST_M, &mut dents_m);
            let own_dent_m = needle.pressed(&REST_M[..4]).into_iter().flatten().map(|pressed| pressed.dent_m).fold(0.0, f64::max);
            for (boundary, (rest_m, dent_m)) in REST_M.iter().zip(dents_m).enumerate() {
                let (at_m, way_m) = (rest_m + dent_m, needle.tip_m - rest_m);
                let half_m = 0.5 * REST_M[4];
                prop_assert!(dent_m.abs() <= own_dent_m.max(half_m) + 1e-12, "{dents_m:?}");
                prop_assert!(at_m <= REST_M[4].max(needle.tip_m) + 1e-12, "boundary {boundary} of {dents_m:?} below the base");
                let at_rim = rim && (at_m - needle.rim_m()).abs() < 1e-12;
                let off_m = (needle.tip_m - at_m).abs();
                let is_off = off_m >= KEPT * way_m.abs() - 1e-12;
                prop_assert!(boundary >= tip_open || at_rim || is_off, "opened boundary {boundary} of {dents_m:?} at {needle:?}");
            }
        }

        #[test]
        fn nothing_jumps_while_the_needle_moves_on(
            tip_mm in 0.0..20.0_f64,
            opened in (0_usize..=4, 0_usize..=4),
            dents_mm in proptest::array::uniform4(-3.0..12.0_f64),
            follows in proptest::sample::select(&VERSIONS),
        ) {
            let at = |tip_mm: f64| {
                let mut dents_m = dents_mm.map(|mm| mm * 1e-3);
                settle_dents(follows, Some(&trocar(tip_mm, opened.0, opened.0.min(opened.1))), &REST_M, &mut dents_m);
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
        settle_dents(Follows::Secant, Some(&trocar(f64::NAN, 0, 0)), &REST_M, &mut dents_m);
        assert_eq!(dents_m, [0.0, 0.0, 0.001, 0.001]);
        settle_dents(Follows::Secant, Some(&trocar(3.0, 9, 9)), &REST_M[..2], &mut dents_m);
        assert!(dents_m.iter().all(|dent_m| dent_m.is_finite()));
    }
}
