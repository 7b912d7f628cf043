//! The measured quantities and their definition for a scene.

/// A measured quantity. The needle is inserted perpendicularly at [`insertion_speed_m_per_s`] unless
/// stated otherwise.
///
/// [`insertion_speed_m_per_s`]: crate::insertion_speed_m_per_s
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeasuredQuantity {
    /// Largest axial force until the needle's last contactor is through the boundary, in N: tip and
    /// rim of a trocar.
    PeakUntilThrough {
        /// The layer below the boundary.
        layer: &'static str,
    },
    /// Largest axial force between the opening of the boundary above and that of this layer's
    /// boundary, in N.
    OpeningForce {
        /// The layer below the boundary.
        layer: &'static str,
    },
    /// Largest axial force between the opening of the boundary above the layer's own and that of the
    /// boundary below it, in N: the layer's resistance, whether its boundary or its cutting sets it.
    PeakAround {
        /// The layer.
        layer: &'static str,
    },
    /// Median of the axial force while the tip's displacement is in the middle half of a layer, in N:
    /// what a layer holds that grips.
    HeldForce {
        /// The layer.
        layer: &'static str,
    },
    /// Displacement of the tip when this layer's boundary opens, in m.
    OpeningDepth {
        /// The layer.
        layer: &'static str,
    },
    /// Displacement of the tip between contact with this layer's boundary and its opening, in m.
    Dent {
        /// The layer.
        layer: &'static str,
    },
    /// Axial force just before the layer's boundary opens, in N.
    ForceAtOpening {
        /// The layer.
        layer: &'static str,
    },
    /// Decrease of the axial force within 5 mm after this layer's boundary opened, in N.
    LossBehind {
        /// The layer.
        layer: &'static str,
    },
    /// The same, relative to the force before it.
    RelativeLossBehind {
        /// The layer.
        layer: &'static str,
    },
    /// Slope of the least-squares line through force against displacement from contact to the calyx
    /// or, where a scene has none, to 90 mm, in N/m.
    WaySlope,
    /// Depth of a layer's upper face in the undeformed tissue, in m.
    LayerDepth {
        /// The layer.
        layer: &'static str,
    },
    /// Thickness of a layer, in m.
    Thickness {
        /// The layer.
        layer: &'static str,
    },
    /// Peak around a layer at the faster speed divided by that at the slower speed.
    SpeedRatio {
        /// The layer.
        layer: &'static str,
        /// The slower speed, in m/s.
        slow_m_per_s: f64,
        /// The faster speed, in m/s.
        fast_m_per_s: f64,
    },
    /// Peak around a layer with another tip divided by that with a diamond tip.
    TipRatio {
        /// The layer.
        layer: &'static str,
        /// The other tip.
        tip: &'static str,
    },
    /// Force at 90 mm along a dry shaft divided by that along a lubricated one.
    DryRatio,
    /// Share of an insertion's work spent on tearing tissue: ruptures and cutting.
    TearingShare,
    /// Share spent on spreading tissue: stored elastic energy and viscosity.
    SpreadingShare,
    /// Share dissipated by friction along the shaft.
    FrictionShare,
    /// Relative decrease of a held force within 8 s.
    HeldFall {
        /// The layer under load.
        layer: &'static str,
        /// Insertion speed, in m/s.
        speed_m_per_s: f64,
        /// Depth of the hold, in m.
        depth_m: f64,
    },
    /// Opening force under a bevel's edge across the layer's fibres divided by that under an edge
    /// along them.
    EdgeRatio {
        /// The layer.
        layer: &'static str,
    },
    /// No scene models this quantity.
    OfNoScene {
        /// The unit of the figure.
        unit: &'static str,
        /// The reason, as a sentence.
        why: &'static str,
    },
}

impl MeasuredQuantity {
    /// Returns the SI unit of the values; empty for a dimensionless number.
    #[must_use]
    pub const fn unit(&self) -> &'static str {
        match self {
            Self::PeakUntilThrough { .. }
            | Self::OpeningForce { .. }
            | Self::PeakAround { .. }
            | Self::HeldForce { .. }
            | Self::ForceAtOpening { .. }
            | Self::LossBehind { .. } => "N",
            Self::OpeningDepth { .. } | Self::Dent { .. } | Self::LayerDepth { .. } | Self::Thickness { .. } => "m",
            Self::WaySlope => "N/m",
            Self::RelativeLossBehind { .. }
            | Self::SpeedRatio { .. }
            | Self::TipRatio { .. }
            | Self::DryRatio
            | Self::TearingShare
            | Self::SpreadingShare
            | Self::FrictionShare
            | Self::HeldFall { .. }
            | Self::EdgeRatio { .. } => "",
            Self::OfNoScene { unit, .. } => unit,
        }
    }

    /// Returns whether the values are fractions from 0 to 1.
    #[must_use]
    pub const fn is_share(&self) -> bool {
        matches!(
            self,
            Self::TearingShare
                | Self::SpreadingShare
                | Self::FrictionShare
                | Self::HeldFall { .. }
                | Self::RelativeLossBehind { .. }
        )
    }

    /// Returns the layer that the quantity belongs to and at which a plot marks it; `None` for one of
    /// the whole way.
    #[must_use]
    pub const fn layer(&self) -> Option<&'static str> {
        match *self {
            Self::PeakUntilThrough { layer }
            | Self::OpeningForce { layer }
            | Self::PeakAround { layer }
            | Self::HeldForce { layer }
            | Self::OpeningDepth { layer }
            | Self::Dent { layer }
            | Self::ForceAtOpening { layer }
            | Self::LossBehind { layer }
            | Self::RelativeLossBehind { layer }
            | Self::LayerDepth { layer }
            | Self::Thickness { layer }
            | Self::SpeedRatio { layer, .. }
            | Self::TipRatio { layer, .. }
            | Self::HeldFall { layer, .. }
            | Self::EdgeRatio { layer } => Some(layer),
            _ => None,
        }
    }
}
