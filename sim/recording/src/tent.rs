//! State of the tissue's field, topic `/tissue/tent`.

/// State of the tissue at a time. All values along the needle at the exercise's angle; boundaries
/// and layers from the surface down, positive into the body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tent {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Displacement of each boundary, in m.
    pub tent_m: Vec<f32>,
    /// Load that the field carries at each boundary, in N.
    pub contactor_n: Vec<f32>,
    /// Drag of the shaft along each layer, in N; negative on withdrawal.
    pub drag_n: Vec<f32>,
    /// Source of the field's boundary conditions.
    pub follows: Follows,
}

/// Source of the boundary conditions of a recording's field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Follows {
    /// The force law's forces, in older recordings: a boundary is displaced according to the
    /// field's own stiffness under these forces.
    #[default]
    Forces,
    /// The needle: boundaries under load of tip and rim are placed at the contactors' positions.
    Needle,
}
