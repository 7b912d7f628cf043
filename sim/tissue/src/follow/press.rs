//! The loads that bring the field into contact with the needle.

use law::stance::Pressed;

use super::responses::Responses;

/// Sweeps over two contacts that influence each other's boundary.
const SWEEPS: usize = 16;

/// Sets the loads of pressed boundaries, in N, so that the field is dented as far as the needle has
/// pressed them. The needle cannot pull. Never allocates.
pub(super) fn press_loads(on_axis: &Responses, pressed: &[Option<Pressed>; 2], loads_n: &mut [f64]) {
    for _ in 0..SWEEPS {
        for &Pressed { boundary, dent_m } in pressed.iter().flatten() {
            let per_n = on_axis.of_m_per_n(boundary, boundary);
            let off_m = dent_m - on_axis.axial_m(boundary, loads_n);
            if let Some(load_n) = loads_n.get_mut(boundary).filter(|_| per_n > 0.0) {
                *load_n = (*load_n + off_m / per_n).max(0.0);
            }
        }
    }
}
