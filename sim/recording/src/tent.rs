//! How the field of the tissue stands, topic `/tissue/tent`.

/// How the tissue stands at a moment. All along the needle, where one at the exercise's angle meets them, boundaries and layers from the surface
/// down, positive into the body.
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
    /// What the field follows.
    pub follows: Follows,
}

/// What the field of a recording follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Follows {
    /// The force law's forces, in recordings of before: a boundary stands where the field's own stiffness puts it under them.
    #[default]
    Forces,
    /// The needle: what tip and rim press on stands where they are.
    Needle,
}
