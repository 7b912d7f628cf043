//! The published figures.

use documents::NeedleFamily;
use phrase::sentence;

use crate::quantity::MeasuredQuantity;
use crate::sources::{
    DURA_CLICKS, DURA_EDGE, DURA_STRENGTH, EPIDURAL_DEPTH, EPIDURAL_PROFILE, FEEDBACK_OVERSHOOT, FIVE_TROCARS,
    FLAVUM_SPEED, FLAVUM_THICKNESS, FRACTURE_SHARES, LABOUR_PRESSURE, LIVER_HOLD, LIVER_KIDNEY, LIVER_TOUGHNESS,
    LUBRICANTS, MeasurementSource, PRONE_CALYX, RENAL_ACCESS, RESPONSE_TIMES, SKIN_THICKNESS, SWINE_TROCARS,
    TROCAR_ENTRY, TUOHY_PORCINE, VERESS,
};

/// The published values, in the quantity's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PublishedRange {
    /// Between two values, both included: the smallest and the largest measurement, or a range that the
    /// publication states.
    Between {
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// Means of groups, without a spread of single values: a quarter below the least to a quarter
    /// above the greatest is accepted (choice).
    Means {
        /// The least mean.
        low: f64,
        /// The greatest mean.
        high: f64,
    },
    /// Mean and standard deviation: two deviations to either side are accepted.
    Spread {
        /// The mean.
        mean: f64,
        /// The standard deviation.
        deviation: f64,
    },
    /// Above a value.
    Above(f64),
    /// Above a value by at least the amount that the study's test could detect; the amount was not
    /// published.
    Distinguishable(f64),
    /// A single value, without a spread.
    Single(f64),
    /// No value: only a direction or a test result.
    Unstated,
}

/// Share of a mean that is accepted to either side of [`PublishedRange::Means`] (choice).
const MEANS_TOLERANCE: f64 = 0.25;
/// Smallest relative increase that a test can detect (choice): two standard errors of 40 specimens
/// whose forces have a relative standard deviation of one sixth.
const DETECTABLE: f64 = 0.05;

impl PublishedRange {
    /// Returns the lower and the upper end of the values that are accepted as inside; `None` if
    /// nothing can be inside.
    #[must_use]
    pub fn accepted(&self) -> Option<[f64; 2]> {
        match *self {
            Self::Between { low, high } => Some([low, high]),
            Self::Means { low, high } => Some([low * (1.0 - MEANS_TOLERANCE), high * (1.0 + MEANS_TOLERANCE)]),
            Self::Spread { mean, deviation } => Some([mean - 2.0 * deviation, mean + 2.0 * deviation]),
            Self::Above(low) => Some([low, f64::INFINITY]),
            Self::Distinguishable(low) => Some([low * (1.0 + DETECTABLE), f64::INFINITY]),
            Self::Single(_) | Self::Unstated => None,
        }
    }
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
    /// The family of needles that it was measured with and may judge; `None` if it does not depend on
    /// a needle.
    pub family: Option<NeedleFamily>,
    /// The measured quantity.
    pub quantity: MeasuredQuantity,
    /// The published values.
    pub range: PublishedRange,
    /// The publication.
    pub source: MeasurementSource,
    /// Ids of the scenes that were fitted to it: their agreement is no evidence.
    pub fitted: &'static [&'static str],
    /// Ids of scenes that may be outside, each with the reason as a sentence.
    pub excepted: &'static [(&'static str, &'static str)],
}

/// Pressure of one millimetre of mercury, in Pa.
const MMHG_PA: f64 = 133.3;
const EPIDURAL: &[&str] = &["epidural-71kg"];
const RENAL: Option<NeedleFamily> = Some(NeedleFamily::RenalAccess);
const TUOHY: Option<NeedleFamily> = Some(NeedleFamily::Tuohy);
const SPINAL: Option<NeedleFamily> = Some(NeedleFamily::Spinal);
const TROCAR: Option<NeedleFamily> = Some(NeedleFamily::Trocar);
const ORGAN: Option<NeedleFamily> = Some(NeedleFamily::Organ);

const fn figure(
    id: &'static str,
    family: Option<NeedleFamily>,
    quantity: MeasuredQuantity,
    range: PublishedRange,
    source: MeasurementSource,
) -> PublishedFigure {
    PublishedFigure { id, title: "", conditions: "", family, quantity, range, source, fitted: &[], excepted: &[] }
}

impl PublishedFigure {
    const fn titled(self, title: &'static str, conditions: &'static str) -> Self {
        Self { title, conditions, ..self }
    }
}

const fn profile(id: &'static str, title: &'static str, quantity: MeasuredQuantity, value: f64) -> PublishedFigure {
    PublishedFigure {
        fitted: EPIDURAL,
        ..figure(id, TUOHY, quantity, PublishedRange::Single(value), EPIDURAL_PROFILE).titled(
            title,
            sentence!("model of a patient of 71.1 kg in a public simulator; needle and number of people unknown"),
        )
    }
}

const fn share(id: &'static str, title: &'static str, quantity: MeasuredQuantity, value: f64) -> PublishedFigure {
    figure(id, None, quantity, PublishedRange::Single(value), FRACTURE_SHARES)
        .titled(title, sentence!("tissue outside a body; without a spread"))
}

const fn of_no_scene(unit: &'static str, why: &'static str) -> MeasuredQuantity {
    MeasuredQuantity::OfNoScene { unit, why }
}

/// Every figure, in display order.
pub const FIGURES: &[PublishedFigure] = &[
    figure("skin_peak", RENAL, MeasuredQuantity::PeakUntilThrough { layer: "skin" }, PublishedRange::Means { low: 2.75, high: 2.80 }, RENAL_ACCESS).titled(
        sentence!("Greatest force until the needle is through the skin"),
        sentence!("fresh human cadavers, needle of percutaneous renal access; means of two groups"),
    ),
    figure("way_slope", RENAL, MeasuredQuantity::WaySlope, PublishedRange::Between { low: 35.0, high: 59.0 }, RENAL_ACCESS).titled(
        sentence!("Slope of force over displacement on the whole way"),
        sentence!("fresh human cadavers, needle of percutaneous renal access; way to the calyx, or 90 mm"),
    ),
    figure("skin_speed", RENAL, MeasuredQuantity::SpeedRatio { layer: "skin", slow_m_per_s: 1e-3, fast_m_per_s: 20e-3 }, PublishedRange::Between { low: 0.9, high: 1.1 }, LUBRICANTS).titled(
        sentence!("Force at the skin at 20 mm/s over that at 1 mm/s"),
        sentence!("unembalmed human skin and muscle, 883 tests: relatively insensitive to speed; a tenth is our bound"),
    ),
    figure("dry_ratio", RENAL, MeasuredQuantity::DryRatio, PublishedRange::Between { low: 1.5, high: 3.0 }, LUBRICANTS).titled(
        sentence!("Force along a dry shaft over that along a lubricated one"),
        sentence!("unembalmed human skin and muscle, hypodermic needles, many lubricants"),
    ),
    figure("calyx_way", RENAL, MeasuredQuantity::LayerDepth { layer: "calyx" }, PublishedRange::Between { low: 65e-3, high: 129e-3 }, PRONE_CALYX).titled(
        sentence!("Way from the skin to the lower calyx"),
        sentence!("20 patients lying prone, mean 98.4 mm; least to greatest"),
    ),
    figure("skin_thickness", RENAL, MeasuredQuantity::Thickness { layer: "skin" }, PublishedRange::Between { low: 1.5e-3, high: 2.6e-3 }, SKIN_THICKNESS).titled(
        sentence!("Thickness of the skin"),
        sentence!("342 people, ultrasound: 1.55 mm at the thigh to 2.54 mm at the shoulder, 1.91 mm at the waist"),
    ),
    figure("veress_peak", Some(NeedleFamily::Veress), MeasuredQuantity::PeakUntilThrough { layer: "fascia" }, PublishedRange::Spread { mean: 9.88, deviation: 2.92 }, VERESS).titled(
        sentence!("Peak force until the needle is through the fascia"),
        sentence!("22 women, Veress needle into the abdomen"),
    ),
    figure("trocar_entry", TROCAR, MeasuredQuantity::PeakAround { layer: "fascia" }, PublishedRange::Between { low: 8.9, high: 62.3 }, TROCAR_ENTRY).titled(
        sentence!("Force of a trocar's entry"),
        sentence!("25 patients after the incision of the skin, median 28.9 N; least to greatest"),
    ),
    figure("trocar_five", TROCAR, MeasuredQuantity::PeakAround { layer: "fascia" }, PublishedRange::Between { low: 16.8, high: 61.9 }, FIVE_TROCARS).titled(
        sentence!("Peak force of a primary trocar's entry"),
        sentence!("5 patients, six-axis sensor; least to greatest"),
    ),
    figure("trocar_conical", TROCAR, MeasuredQuantity::TipRatio { layer: "fascia", tip: "conical" }, PublishedRange::Means { low: 2.27, high: 2.27 }, SWINE_TROCARS).titled(
        sentence!("Force of a blunt conical 12 mm trocar over that of a pyramidal one"),
        sentence!("12 pigs, 72 entries, two trocars each; ratio of means"),
    ),
    figure("trocar_dilating", TROCAR, MeasuredQuantity::TipRatio { layer: "fascia", tip: "cutting-dilating" }, PublishedRange::Means { low: 1.17, high: 1.17 }, SWINE_TROCARS).titled(
        sentence!("Force of a cutting-dilating 12 mm trocar over that of a pyramidal one"),
        sentence!("12 pigs, 72 entries, two trocars each; ratio of means"),
    ),
    PublishedFigure {
        excepted: &[("epidural-71kg", sentence!("the profile has no times, so that its flavum does not relax"))],
        ..figure("flavum_speed", TUOHY, MeasuredQuantity::SpeedRatio { layer: "ligamentum flavum", slow_m_per_s: 0.4e-3, fast_m_per_s: 2e-3 }, PublishedRange::Distinguishable(1.0), FLAVUM_SPEED).titled(
        sentence!("Force at the ligamentum flavum at 2 mm/s over that at 0.4 mm/s"),
        sentence!("porcine spines, Tuohy needles"),
    )
    },
    figure("epidural_way", None, MeasuredQuantity::LayerDepth { layer: "epidural space" }, PublishedRange::Spread { mean: 48.2e-3, deviation: 11.6e-3 }, EPIDURAL_DEPTH).titled(
        sentence!("Way from the skin to the epidural space"),
        sentence!("magnetic resonance at L3/4; mean and deviation"),
    ),
    PublishedFigure {
        excepted: &[("epidural-71kg", sentence!("the profile's own: the way over which its force is high"))],
        ..figure("flavum_thickness", None, MeasuredQuantity::Thickness { layer: "ligamentum flavum" }, PublishedRange::Between { low: 2.5e-3, high: 4.5e-3 }, FLAVUM_THICKNESS).titled(
        sentence!("Thickness of the ligamentum flavum"),
        sentence!("lumbar levels, means 3.2 to 3.7 mm; the ends are ours, for other studies have deviations of 0.9 to 1.2 mm"),
    )
    },
    profile("epidural_skin_force", sentence!("Force at which the skin opens"), MeasuredQuantity::OpeningForce { layer: "skin" }, 6.04),
    profile("epidural_skin_depth", sentence!("Depth at which the skin opens"), MeasuredQuantity::OpeningDepth { layer: "skin" }, 13.92e-3),
    profile("epidural_supraspinous_force", sentence!("Force at the supraspinous ligament"), MeasuredQuantity::PeakAround { layer: "supraspinous ligament" }, 4.35),
    profile("epidural_interspinous_force", sentence!("Force in the interspinous ligament"), MeasuredQuantity::HeldForce { layer: "interspinous ligament" }, 7.47),
    profile("epidural_flavum_force", sentence!("Force at the ligamentum flavum"), MeasuredQuantity::PeakAround { layer: "ligamentum flavum" }, 12.13),
    profile("epidural_loss_depth", sentence!("Depth at which resistance is lost"), MeasuredQuantity::OpeningDepth { layer: "epidural space" }, 48.38e-3),
    profile("epidural_loss", sentence!("Loss of resistance"), MeasuredQuantity::LossBehind { layer: "epidural space" }, 10.0),
    figure("flavum_plunger", TUOHY, of_no_scene("N", sentence!("it is the force on the plunger of the syringe, not on the needle")), PublishedRange::Between { low: 11.1, high: 11.8 }, TUOHY_PORCINE).titled(
        sentence!("Force at the ligamentum flavum, on the plunger"),
        sentence!("porcine cadaver, Tuohy needle, 17 insertions"),
    ),
    figure("labour_pressure", TUOHY, of_no_scene("Pa", sentence!("it is the pressure in the syringe, which no scene simulates")), PublishedRange::Between { low: 376.0 * MMHG_PA, high: 461.0 * MMHG_PA }, LABOUR_PRESSURE).titled(
        sentence!("Pressure in the syringe at the ligamentum flavum"),
        sentence!("women in labour, 16G Tuohy needle, four groups of body mass index; means"),
    ),
    figure("dura_drop", SPINAL, MeasuredQuantity::LossBehind { layer: "dura" }, PublishedRange::Between { low: 0.0, high: 2.1 }, DURA_CLICKS).titled(
        sentence!("Fall of the force at the dura"),
        sentence!("porcine dura, seven fine spinal needles; the greatest drop, estimated from a scale of clicks"),
    ),
    figure("dura_edge", TUOHY, MeasuredQuantity::EdgeRatio { layer: "dura" }, PublishedRange::Distinguishable(1.0), DURA_EDGE).titled(
        sentence!("Force at the dura with the bevel across its fibres over that along them"),
        sentence!("cadaver dura, 40 samples, 17G Tuohy needle; p < 0.05, without forces in the abstract"),
    ),
    figure("dura_strength", None, of_no_scene("", sentence!("strips were pulled until they tore: no needle went through")), PublishedRange::Between { low: 3.5, high: 6.7 }, DURA_STRENGTH).titled(
        sentence!("Force that tears lumbar dura lengthwise over that crosswise"),
        sentence!("3 human cadavers; least to greatest"),
    ),
    share("tearing_share", sentence!("Share of tearing in the force; here, in the work"), MeasuredQuantity::TearingShare, 0.61),
    share("spreading_share", sentence!("Share of spreading in the force; here, in the work"), MeasuredQuantity::SpreadingShare, 0.18),
    share("friction_share", sentence!("Share of friction in the force; here, in the work"), MeasuredQuantity::FrictionShare, 0.21),
    PublishedFigure {
        fitted: &["liver-18g"],
        ..figure("liver_held_fall", ORGAN, MeasuredQuantity::HeldFall { layer: "liver", speed_m_per_s: 3e-3, depth_m: 3.5e-3 }, PublishedRange::Single(0.48), LIVER_HOLD).titled(
            sentence!("Fall of a held force in 8 s"),
            sentence!("liver, 18G needle, 3.5 mm in at 3 mm/s and held"),
        )
    },
    figure("liver_toughness", ORGAN, of_no_scene("J/m²", sentence!("no scene names a toughness")), PublishedRange::Between { low: 158.0, high: 170.0 }, LIVER_TOUGHNESS).titled(
        sentence!("Fracture toughness of liver"),
        sentence!("3 bovine livers, needles of 4 diameters; mean and its deviation"),
    ),
    figure("liver_kidney_speed_angle", ORGAN, of_no_scene("", sentence!("its abstract has no forces")), PublishedRange::Unstated, LIVER_KIDNEY).titled(
        sentence!("Force in liver and kidney rises with speed and angle"),
        sentence!("porcine, 15 to 45°, 0.5 to 2.5 mm/s; p < 0.05, without forces in the abstract"),
    ),
    figure("overshoot_by_feedback", None, of_no_scene("", sentence!("virtual hands always have force feedback")), PublishedRange::Above(0.52), FEEDBACK_OVERSHOOT).titled(
        sentence!("Less overshoot by force feedback, as a share"),
        sentence!("14 people at a simulator, without or with a still picture"),
    ),
    figure("response_time", None, of_no_scene("s", sentence!("it includes the telephone's own delay; virtual hands react to a force within 0.15 to 0.25 s")), PublishedRange::Between { low: 0.277, high: 0.363 }, RESPONSE_TIMES).titled(
        sentence!("Response to a signal that is felt, heard and seen"),
        sentence!("20 people with a telephone; mean and deviation"),
    ),
];
