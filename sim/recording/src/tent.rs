//! State of the tissue's field, topic `/tissue/tent`.

pub use law::stance::Follows;

/// State of the tissue at a time. All values along the needle at the exercise's angle; boundaries
/// and layers from the surface down, positive into the body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tent {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Displacement of each boundary, in m.
    pub tent_m: Vec<f32>,
    /// Load that the tissue bears at each boundary, in N.
    pub contactor_n: Vec<f32>,
    /// Drag of the shaft along each layer, in N; negative on withdrawal.
    pub drag_n: Vec<f32>,
    /// Loads that displace the linear field as far, in N: contactors, then drags. Empty before
    /// [`Follows::Secant`], where they are the loads themselves.
    pub linear_n: Vec<f32>,
    /// Source of the field's boundary conditions.
    pub follows: Follows,
}

impl Tent {
    /// Returns the loads on the linear field, in N: contactors, then drags.
    pub fn field_loads_n(&self) -> impl Iterator<Item = f32> {
        let own: [&[f32]; 2] =
            if self.follows < Follows::Secant { [&self.contactor_n, &self.drag_n] } else { [&self.linear_n, &[]] };
        own.into_iter().flatten().copied()
    }
}
