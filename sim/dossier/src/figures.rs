//! The published figures.

use phrase::sentence;

use crate::sources::{
    DURA_EDGE, DURA_STRENGTH, EPIDURAL_PROFILE, FEEDBACK_OVERSHOOT, FLAVUM_SPEED, FRACTURE_SHARES, LIVER_HOLD,
    LIVER_KIDNEY, LIVER_TOUGHNESS, MeasurementSource, RENAL_ACCESS, RESPONSE_TIMES, TUOHY_PORCINE, VERESS,
};

/// A measured quantity and its definition for a scene. The needle is inserted perpendicularly at 5
/// mm/s unless stated otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeasuredQuantity {
    /// Largest axial force between the opening of the boundary above and that of this layer's
    /// boundary, in N.
    OpeningForce {
        /// The layer below the boundary.
        layer: &'static str,
    },
    /// Displacement of the tip when this layer's boundary opens, in m.
    OpeningDepth {
        /// The layer.
        layer: &'static str,
    },
    /// Largest axial force until the layer's boundary opens, in N.
    PeakUntil {
        /// The layer.
        layer: &'static str,
    },
    /// Decrease of the axial force within 5 mm after this layer's boundary opened, in N.
    LossBehind {
        /// The layer.
        layer: &'static str,
    },
    /// Slope of the least-squares line through force against displacement from the skin to the last
    /// boundary, in N/m.
    OverallSlope,
    /// Opening force at the faster speed divided by that at the slower speed.
    SpeedRatio {
        /// The layer.
        layer: &'static str,
        /// The slower speed, in m/s.
        slow_m_per_s: f64,
        /// The faster speed, in m/s.
        fast_m_per_s: f64,
    },
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

/// The published values, in the quantity's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PublishedRange {
    /// Between two values, both included: a published range, or the smallest and largest
    /// measurement.
    Between {
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// Above a value.
    Above(f64),
    /// Above a value by at least the amount that the study's test could detect; the amount was not
    /// published.
    ToldApart(f64),
    /// A single value, without a spread.
    Single(f64),
    /// No value: only a direction or a test result.
    Unstated,
}

/// A published figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedFigure {
    /// Its id in machine-readable tables.
    pub id: &'static str,
    /// Its title, as a sentence.
    pub title: &'static str,
    /// Specimen and method, as a sentence.
    pub conditions: &'static str,
    /// The measured quantity.
    pub quantity: MeasuredQuantity,
    /// The published values.
    pub range: PublishedRange,
    /// The publication.
    pub source: MeasurementSource,
    /// Ids of the scenes that were fitted to it: their agreement is no evidence.
    pub fitted: &'static [&'static str],
}

/// The weight of one gram, in N.
const GRAM_N: f64 = 9.806_65e-3;
const EPIDURAL: &[&str] = &["epidural-71kg"];

const fn profile(id: &'static str, title: &'static str, quantity: MeasuredQuantity, value: f64) -> PublishedFigure {
    PublishedFigure {
        id,
        title,
        conditions: sentence!("human, 71 kg, Tuohy needle; without a spread"),
        quantity,
        range: PublishedRange::Single(value),
        source: EPIDURAL_PROFILE,
        fitted: EPIDURAL,
    }
}

const fn share(id: &'static str, title: &'static str, quantity: MeasuredQuantity, value: f64) -> PublishedFigure {
    PublishedFigure {
        id,
        title,
        conditions: sentence!("tissue outside a body; without a spread"),
        quantity,
        range: PublishedRange::Single(value),
        source: FRACTURE_SHARES,
        fitted: &[],
    }
}

/// Every figure, in display order.
pub const FIGURES: &[PublishedFigure] = &[
    PublishedFigure {
        id: "skin_opening_force",
        title: sentence!("Force at which the skin opens"),
        conditions: sentence!("fresh human cadavers, needle of percutaneous renal access; range of means"),
        quantity: MeasuredQuantity::OpeningForce { layer: "skin" },
        range: PublishedRange::Between { low: 2.75, high: 2.80 },
        source: RENAL_ACCESS,
        fitted: &[],
    },
    PublishedFigure {
        id: "overall_slope",
        title: sentence!("Slope of force against displacement over the whole way"),
        conditions: sentence!("fresh human cadavers, needle of percutaneous renal access; range of means"),
        quantity: MeasuredQuantity::OverallSlope,
        range: PublishedRange::Between { low: 35.0, high: 59.0 },
        source: RENAL_ACCESS,
        fitted: &[],
    },
    PublishedFigure {
        id: "veress_peak",
        title: sentence!("Peak force until the fascia has opened"),
        conditions: sentence!("22 women, Veress needle into the abdomen; least to greatest"),
        quantity: MeasuredQuantity::PeakUntil { layer: "fascia" },
        range: PublishedRange::Between { low: 409.0 * GRAM_N, high: 1493.0 * GRAM_N },
        source: VERESS,
        fitted: &[],
    },
    PublishedFigure {
        id: "flavum_plunger",
        title: sentence!("Force at the ligamentum flavum, on the plunger"),
        conditions: sentence!("porcine cadaver, Tuohy needle, 17 insertions"),
        quantity: MeasuredQuantity::OfNoScene {
            unit: "N",
            why: sentence!("it is the force on the plunger of the syringe, not on the needle"),
        },
        range: PublishedRange::Between { low: 11.1, high: 11.8 },
        source: TUOHY_PORCINE,
        fitted: &[],
    },
    PublishedFigure {
        id: "flavum_speed",
        title: sentence!("Force at the ligamentum flavum at 2 mm/s over that at 0.4 mm/s"),
        conditions: sentence!("porcine spines, Tuohy needles"),
        quantity: MeasuredQuantity::SpeedRatio { layer: "ligamentum flavum", slow_m_per_s: 0.4e-3, fast_m_per_s: 2e-3 },
        range: PublishedRange::ToldApart(1.0),
        source: FLAVUM_SPEED,
        fitted: &[],
    },
    profile(
        "epidural_skin_force",
        sentence!("Force at which the skin opens"),
        MeasuredQuantity::OpeningForce { layer: "skin" },
        6.04,
    ),
    profile(
        "epidural_skin_depth",
        sentence!("Depth at which the skin opens"),
        MeasuredQuantity::OpeningDepth { layer: "skin" },
        13.92e-3,
    ),
    profile(
        "epidural_supraspinous_force",
        sentence!("Force at the supraspinous ligament"),
        MeasuredQuantity::OpeningForce { layer: "supraspinous ligament" },
        4.35,
    ),
    profile(
        "epidural_interspinous_force",
        sentence!("Force at the interspinous ligament"),
        MeasuredQuantity::OpeningForce { layer: "interspinous ligament" },
        7.46,
    ),
    profile(
        "epidural_flavum_force",
        sentence!("Force at the ligamentum flavum"),
        MeasuredQuantity::OpeningForce { layer: "ligamentum flavum" },
        12.13,
    ),
    profile(
        "epidural_loss_depth",
        sentence!("Depth at which resistance is lost"),
        MeasuredQuantity::OpeningDepth { layer: "epidural space" },
        48.38e-3,
    ),
    profile(
        "epidural_loss",
        sentence!("Loss of resistance"),
        MeasuredQuantity::LossBehind { layer: "epidural space" },
        10.0,
    ),
    share(
        "tearing_share",
        sentence!("Share of tearing in the force; here, in the work"),
        MeasuredQuantity::TearingShare,
        0.61,
    ),
    share(
        "spreading_share",
        sentence!("Share of spreading in the force; here, in the work"),
        MeasuredQuantity::SpreadingShare,
        0.18,
    ),
    share(
        "friction_share",
        sentence!("Share of friction in the force; here, in the work"),
        MeasuredQuantity::FrictionShare,
        0.21,
    ),
    PublishedFigure {
        id: "liver_held_fall",
        title: sentence!("Fall of a held force in 8 s"),
        conditions: sentence!("liver, 18G needle, 3.5 mm in at 3 mm/s and held"),
        quantity: MeasuredQuantity::HeldFall { layer: "liver", speed_m_per_s: 3e-3, depth_m: 3.5e-3 },
        range: PublishedRange::Single(0.48),
        source: LIVER_HOLD,
        fitted: &["liver-18g"],
    },
    PublishedFigure {
        id: "liver_toughness",
        title: sentence!("Fracture toughness of liver"),
        conditions: sentence!("3 bovine livers, needles of 4 diameters; mean and its deviation"),
        quantity: MeasuredQuantity::OfNoScene { unit: "J/m²", why: sentence!("no scene names a toughness") },
        range: PublishedRange::Between { low: 158.0, high: 170.0 },
        source: LIVER_TOUGHNESS,
        fitted: &[],
    },
    PublishedFigure {
        id: "liver_kidney_speed_angle",
        title: sentence!("Force in liver and kidney rises with speed and angle"),
        conditions: sentence!("porcine, 15 to 45°, 0.5 to 2.5 mm/s; p < 0.05, without forces in the abstract"),
        quantity: MeasuredQuantity::OfNoScene { unit: "", why: sentence!("its abstract has no forces") },
        range: PublishedRange::Unstated,
        source: LIVER_KIDNEY,
        fitted: &[],
    },
    PublishedFigure {
        id: "overshoot_by_feedback",
        title: sentence!("Less overshoot by force feedback, as a share"),
        conditions: sentence!("14 people at a simulator, without or with a still picture"),
        quantity: MeasuredQuantity::OfNoScene {
            unit: "",
            why: sentence!("a virtual hand always feels: there is none without feedback"),
        },
        range: PublishedRange::Above(0.52),
        source: FEEDBACK_OVERSHOOT,
        fitted: &[],
    },
    PublishedFigure {
        id: "response_time",
        title: sentence!("Response to a signal that is felt, heard and seen"),
        conditions: sentence!("20 people with a telephone; mean and deviation"),
        quantity: MeasuredQuantity::OfNoScene {
            unit: "s",
            why: sentence!(
                "it includes the telephone's own delay; virtual hands react in 0.20 to 0.25 s to what they feel"
            ),
        },
        range: PublishedRange::Between { low: 0.277, high: 0.363 },
        source: RESPONSE_TIMES,
        fitted: &[],
    },
    PublishedFigure {
        id: "dura_edge",
        title: sentence!("Force at the dura with the bevel across its fibres over that along them"),
        conditions: sentence!("cadaver dura, 40 samples, 17G Tuohy needle; p < 0.05, without forces in the abstract"),
        quantity: MeasuredQuantity::EdgeRatio { layer: "dura" },
        range: PublishedRange::ToldApart(1.0),
        source: DURA_EDGE,
        fitted: &[],
    },
    PublishedFigure {
        id: "dura_strength",
        title: sentence!("Force that tears lumbar dura lengthwise over that crosswise"),
        conditions: sentence!("3 human cadavers; least to greatest"),
        quantity: MeasuredQuantity::OfNoScene {
            unit: "",
            why: sentence!("strips were pulled until they tore: no needle went through"),
        },
        range: PublishedRange::Between { low: 3.5, high: 6.7 },
        source: DURA_STRENGTH,
        fitted: &[],
    },
];

impl MeasuredQuantity {
    /// Returns the SI unit of the values; empty for a dimensionless number.
    #[must_use]
    pub const fn unit(&self) -> &'static str {
        match self {
            Self::OpeningForce { .. } | Self::PeakUntil { .. } | Self::LossBehind { .. } => "N",
            Self::OpeningDepth { .. } => "m",
            Self::OverallSlope => "N/m",
            Self::SpeedRatio { .. }
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
        matches!(self, Self::TearingShare | Self::SpreadingShare | Self::FrictionShare | Self::HeldFall { .. })
    }
}
