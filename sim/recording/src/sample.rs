//! A servo tick, and the energy ledger at a time. Inputs are f64, computed channels f32.

/// One servo tick. All values in SI, patient frame; time since the start of the attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Tip position, in m.
    pub position_m: [f64; 3],
    /// Orientation patient_from_needle as a unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// Tip velocity, in m/s.
    pub velocity_m_per_s: [f32; 3],
    /// Axial displacement along the latched axis, in m.
    pub x_m: f64,
    /// Material depth of the tip, in m.
    pub depth_m: f32,
    /// Total force on the hand, in N.
    pub force_n: [f32; 3],
    /// Axial force of the tip's boundary, in N.
    pub tip_n: f32,
    /// Axial force of the rim's boundary, in N.
    pub rim_n: f32,
    /// Viscous part, in N.
    pub viscous_n: f32,
    /// Friction part, in N.
    pub friction_n: f32,
    /// Cutting part, in N.
    pub cutting_n: f32,
    /// Lateral force on the hand, in N.
    pub lateral_n: [f32; 3],
    /// Force sent to the device after the safety chain, in N.
    pub device_n: [f32; 3],
    /// Flags, see the constants in [`flags`].
    pub flags: u32,
    /// Lateness of the tick, in µs.
    pub lateness_us: f32,
    /// Displacement of a flexible needle's tip from `position_m`, in m; 0 for a straight needle.
    pub bend_m: [f32; 3],
}

impl Sample {
    /// Returns the position of the tip, bent or straight, in m, patient frame.
    #[must_use]
    pub fn tip_m(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.position_m[i] + f64::from(self.bend_m[i]))
    }

    /// The layers' share of the axial force on the hand, in N: the sum of its parts. Bone, walls and the hub are only in `force_n`.
    #[must_use]
    pub fn axial_n(&self) -> f64 {
        f64::from(self.tip_n)
            + f64::from(self.rim_n)
            + f64::from(self.viscous_n)
            + f64::from(self.friction_n)
            + f64::from(self.cutting_n)
    }
}

/// Bits of [`Sample::flags`].
pub mod flags {
    /// The tip is in the body.
    pub const INSIDE: u32 = 1;
    /// The input was invalid; the last valid one was held.
    pub const HELD: u32 = 2;
    /// The confirm button is down.
    pub const CONFIRM: u32 = 4;
    /// The force sent to the device was scaled or clamped.
    pub const SCALED: u32 = 8;
    /// The device rendered less than half of the force, although the force is large enough to be
    /// felt.
    pub const UNFELT: u32 = 1 << 16;
}

/// Cumulative energy ledger at a time, topic `/needle/energy`, 10 Hz and at the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energy {
    /// Time since the start, in s.
    pub t_s: f64,
    /// The law's ledger.
    pub ledger: law::ledger::Ledger,
}
