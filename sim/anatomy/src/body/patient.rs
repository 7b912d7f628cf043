//! The patient: the dimensions of one body, drawn from the published distributions.

use law::operator::Draw;
use phrase::{Phrase, phrase};

use super::part::Level;
use super::published::{Dimension, list_published};

/// Position of a patient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Posture {
    /// Face down, a pillow under the belly.
    Prone,
    /// Sitting, the back bent.
    Sitting,
    /// On the side, knees to the chest.
    Side,
}

impl Posture {
    /// Every posture.
    pub const ALL: [Self; 3] = [Self::Prone, Self::Sitting, Self::Side];

    /// The posture with a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|posture| posture.name() == name)
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Prone => "prone",
            Self::Sitting => "sitting",
            Self::Side => "side",
        }
    }

    /// Flexion of each disc relative to standing, in degrees. Flexion by 60° reduces the sum of all
    /// five by 42 to 46° (read: lateral radiographs of standing and flexed Chinese subjects); the
    /// part of it in each posture is estimated.
    fn bend_per_disc_deg(self) -> f64 {
        match self {
            Self::Prone => 2.0,
            Self::Sitting => 8.4,
            Self::Side => 7.0,
        }
    }
}

/// The parameters of a body: everything that a recording needs to reproduce it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyOrder {
    /// Position of the patient.
    pub posture: Posture,
    /// Seed that selects one of the patients of this weight and age.
    pub seed: u64,
    /// Body weight, in kg.
    pub weight_kg: f64,
    /// Age, in years.
    pub age_years: f64,
}

/// Allowed weights of a body, in kg.
pub const WEIGHTS_KG: [f64; 2] = [40.0, 160.0];
/// Allowed ages of a body, in years: growing spines differ.
pub const AGES_YEARS: [f64; 2] = [18.0, 95.0];

impl BodyOrder {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The value out of range, with the allowed range.
    pub fn check(&self) -> Result<(), Phrase> {
        let within = |value: f64, [least, most]: [f64; 2]| value >= least && value <= most;
        if !within(self.weight_kg, WEIGHTS_KG) {
            let [least, most] = WEIGHTS_KG;
            return Err(phrase!(
                "weight_kg = {value} kg; allowed: {least} to {most} kg",
                value = self.weight_kg,
                least = least,
                most = most
            ));
        }
        if !within(self.age_years, AGES_YEARS) {
            let [least, most] = AGES_YEARS;
            return Err(phrase!(
                "age_years = {value}; allowed: {least} to {most} years",
                value = self.age_years,
                least = least,
                most = most
            ));
        }
        Ok(())
    }
}

/// The dimensions of one body, in mm and degrees, L1 to L5.
#[derive(Clone, Debug)]
pub struct BodyValues {
    dimensions: [[f64; 5]; Dimension::ALL.len()],
    /// Stature relative to the mean.
    pub(super) size: f64,
    /// Thickness of the fat over the supraspinous ligament, in mm.
    pub(super) midline_fat: f64,
    /// Fat over the muscles lateral to it, in mm.
    pub(super) lateral_fat: f64,
    /// Half of the waist's width, in mm.
    pub(super) half_waist: f64,
    /// Distance from the front of the belly to the middle of L3, in mm.
    pub(super) belly: f64,
    /// Flexion of each disc relative to standing, in degrees.
    pub(super) bend_deg: f64,
    /// Half of the thickness of the spinous processes, in mm.
    pub(super) spinous_half_width: f64,
    /// Radius of the aorta at L3, in mm.
    pub(super) aorta_radius: f64,
    /// Half of a kidney's length, in mm.
    pub(super) kidney_half_length: f64,
    /// Depth of the epidural space behind the sac, in mm.
    pub(super) epidural_depth: f64,
    /// Cross-section of the muscles relative to the mean.
    pub(super) muscle: f64,
}

/// Fraction of a dimension's variance that is shared with the size of the whole skeleton.
/// Estimated: published correlations between vertebral dimensions are around it.
const SHARED_VARIANCE: f64 = 0.5;

impl BodyValues {
    /// Draws the dimensions.
    #[must_use]
    pub fn draw(order: &BodyOrder) -> Self {
        let mut draw = Draw::new(order.seed);
        let size = draw.normal(1.0);
        let dimensions = Dimension::ALL.map(|dimension| draw_levels(dimension, order, size, &mut draw));
        let weight = order.weight_kg - 70.0;
        let age = order.age_years - 50.0;
        // Distance from skin to flavum increases by 0.18 mm/kg (women) to 0.37 mm/kg (men): So, Kim
        // and Ahn 1997, read; nearly all of it is fat.
        let midline_fat = (7.5 + 0.26 * weight + draw.normal(2.5)).max(3.0);
        Self {
            dimensions,
            size: 1.0 + 0.05 * size,
            midline_fat,
            lateral_fat: (9.0 + 0.32 * weight + draw.normal(2.5)).max(3.5),
            half_waist: 150.0 + 1.05 * weight + draw.normal(6.0),
            belly: 110.0 + 1.3 * weight + draw.normal(7.0),
            bend_deg: (order.posture.bend_per_disc_deg() + draw.normal(1.4)).max(0.0),
            // Increases by 0.05 mm a year: Aylott et al. 2012, read.
            spinous_half_width: (3.4 + 0.025 * age + draw.normal(0.3)).max(2.4),
            // Diameter of 13.8 ± 1.9 mm at L3: Jasper et al. 2014, read.
            aorta_radius: 6.9 + draw.normal(0.95) + 0.02 * age,
            // Length of 109 ± 13 mm: multi-slice CT, Adv Biomed Res, read.
            kidney_half_length: (54.5 + draw.normal(6.5)).max(42.0),
            // Published in the midline: 3 to 6 mm. A needle's way through a bent canal is up to 7 %
            // longer, so larger values are cut off.
            epidural_depth: (5.5 - 0.015 * age + draw.normal(0.9)).clamp(3.0, 5.5),
            muscle: (1.0 - 0.004 * age.max(0.0) + draw.normal(0.12)).clamp(0.65, 1.3),
        }
    }

    /// A dimension at a level.
    #[must_use]
    pub fn get(&self, dimension: Dimension, level: Level) -> f64 {
        self.dimensions[dimension as usize][level as usize]
    }
}

fn draw_levels(dimension: Dimension, order: &BodyOrder, size: f64, draw: &mut Draw) -> [f64; 5] {
    // The levels of a person are correlated: half of the remaining variance is drawn once.
    let person = draw.normal(1.0);
    list_published(dimension).map(|published| {
        let own = 0.5_f64.sqrt() * (person + draw.normal(1.0));
        let off = SHARED_VARIANCE.sqrt() * size + (1.0 - SHARED_VARIANCE).sqrt() * own;
        // Larger deviations would be pathological.
        let off = off.clamp(-2.2, 2.2);
        (published.mean + published.sd * off + drift(dimension, order.age_years - 50.0)).max(0.4 * published.mean)
    })
}

/// Change with age, in the dimension's unit.
fn drift(dimension: Dimension, age: f64) -> f64 {
    match dimension {
        // 0.03 to 0.07 mm a year: Aylott et al. 2012, read.
        Dimension::SpinousHeight => 0.05 * age,
        Dimension::DiscHeight => -0.03 * age.max(0.0),
        Dimension::FlavumThickness => 0.012 * age,
        _ => 0.0,
    }
}
