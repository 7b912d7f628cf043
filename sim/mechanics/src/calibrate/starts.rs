//! Other starts: the same curve told with a boundary elsewhere.

use super::model::{Guess, Model, QUANTITIES};

/// A guess with a boundary moved to a part of the way from the boundary above to where its own gives way. What lies below stays,
/// ruptures keep their places, and the boundary carries the same force there. None where it has no rupture or no room.
pub(super) fn shifted(model: &Model<'_>, guess: &Guess, (boundary, part): (usize, f64)) -> Option<Guess> {
    let columns = QUANTITIES.len();
    guess.places.tip.get(boundary).copied().flatten()?;
    let mut variables = model.variables(guess);
    let (above, own) = (boundary.checked_sub(1)? * columns, boundary * columns);
    let above_m: f64 = variables[..above].iter().step_by(columns).sum();
    let (depth_m, rupture_m) = (above_m + variables[above], variables[own + 4]);
    let moved_m = above_m + part * (rupture_m - above_m);
    if rupture_m <= above_m {
        return None;
    }
    let (carried_n, by_m) = (variables[own + 1] * (rupture_m - depth_m), moved_m - depth_m);
    variables[above] += by_m;
    variables[own] = (variables[own] - by_m).max(0.0);
    if carried_n > 0.0 {
        variables[own + 1] = carried_n / (rupture_m - moved_m);
    }
    Some(Guess { spec: model.spec(guess, &variables), places: guess.places.clone() })
}
