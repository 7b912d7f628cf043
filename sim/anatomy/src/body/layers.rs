//! The tissues along a straight needle.

use nalgebra::{Point3, Vector3};

use super::form::Place;
use super::part::{AnatomyPart, BodySide, Level};
use super::{Body, COLUMN, SACRUM};

/// Tissue at a point of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tissue {
    /// Skin.
    Skin,
    /// Fat and loose tissue.
    Fat,
    /// A part with a shape of its own.
    Part(AnatomyPart),
}

impl Tissue {
    /// Its name.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Skin => "skin".to_owned(),
            Self::Fat => "fat".to_owned(),
            Self::Part(part) => part.name(),
        }
    }
}

/// A stretch of one tissue along a needle's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerOnPath {
    /// The tissue.
    pub tissue: Tissue,
    /// Start along the path, in m.
    pub from_m: f64,
    /// End along the path, in m.
    pub to_m: f64,
}

impl LayerOnPath {
    /// Whether it is bone.
    #[must_use]
    pub fn is_bone(&self) -> bool {
        matches!(self.tissue, Tissue::Part(part) if part.kind() == Some(law::structures::StructureKind::Bone))
    }
}

/// Thickness of skin on the back, in mm. Estimated, within 1.5 to 3 mm.
const SKIN: f64 = 2.2;
/// Step of the search for tissues, in mm; thinner ones may be missed.
const STEP: f64 = 0.4;

impl Body {
    /// Lists the tissues along a straight path, from a point in a direction, over a length in m.
    /// The path before the skin is omitted; each end is accurate to a µm.
    #[must_use]
    pub fn list_layers(&self, from_m: &Point3<f64>, direction: &Vector3<f64>, length_m: f64) -> Vec<LayerOnPath> {
        let (start, along) = (self.inner(from_m), direction.normalize());
        let tissue_at = |t: f64| self.tissue(&(start + along * t));
        let mut layers: Vec<LayerOnPath> = Vec::new();
        let mut now = tissue_at(0.0);
        let mut since = 0.0;
        let steps = libm::ceil(length_m * 1e3 / STEP) as u32;
        for step in 1..=steps {
            let t = (f64::from(step) * STEP).min(length_m * 1e3);
            let next = tissue_at(t);
            if next != now || step == steps {
                let mut end = t;
                if next != now {
                    end = boundary(&tissue_at, [t - STEP, t], now);
                }
                layers.extend(now.map(|tissue| LayerOnPath { tissue, from_m: since * 1e-3, to_m: end * 1e-3 }));
                (now, since) = (next, end);
            }
        }
        layers
    }

    /// The tissue at a point; `None` outside the body.
    fn tissue(&self, p: &Place) -> Option<Tissue> {
        let skin = self.skin.distance(p);
        if skin > 0.0 {
            return None;
        }
        if skin > -SKIN {
            return Some(Tissue::Skin);
        }
        let part = self.bone_at(p).or_else(|| self.in_canal(p)).or_else(|| self.soft_part_at(p));
        Some(part.map_or(Tissue::Fat, Tissue::Part))
    }

    fn bone_at(&self, p: &Place) -> Option<AnatomyPart> {
        let column = (0..COLUMN).find(|at| self.bone_distance(*at, p) < 0.0).map(|at| match at {
            0 => AnatomyPart::LastThoracic,
            SACRUM => AnatomyPart::Sacrum,
            at => AnatomyPart::Vertebra(Level::ALL[at - 1]),
        });
        let parts = [AnatomyPart::Ilium, AnatomyPart::EleventhRib, AnatomyPart::TwelfthRib];
        let beside = || {
            let mut all = parts.into_iter().flat_map(|part: fn(BodySide) -> AnatomyPart| BodySide::BOTH.map(part));
            all.find(|part| self.part_distance(*part, p) < 0.0)
        };
        column.or_else(beside)
    }

    fn in_canal(&self, p: &Place) -> Option<AnatomyPart> {
        if self.sac.distance(p) < 0.0 {
            return Some(AnatomyPart::DuralSac);
        }
        (self.canal.distance(p) < 0.0).then_some(AnatomyPart::EpiduralSpace)
    }

    fn soft_part_at(&self, p: &Place) -> Option<AnatomyPart> {
        let at_levels = [AnatomyPart::Flavum, AnatomyPart::Interspinous, AnatomyPart::Disc];
        let levels = at_levels.into_iter().flat_map(|part: fn(Level) -> AnatomyPart| Level::ALL.map(part));
        let at_sides = [AnatomyPart::ErectorSpinae, AnatomyPart::Quadratus, AnatomyPart::Kidney];
        let sides = at_sides.into_iter().flat_map(|part: fn(BodySide) -> AnatomyPart| BodySide::BOTH.map(part));
        let vessels = [AnatomyPart::Aorta, AnatomyPart::VenaCava, AnatomyPart::LumbarVessels];
        let mut all = [AnatomyPart::Supraspinous].into_iter().chain(levels).chain(sides).chain(vessels);
        all.find(|part| self.part_distance(*part, p) < 0.0)
    }
}

/// The end of a tissue between two positions on a path, by bisection.
fn boundary(tissue_at: &dyn Fn(f64) -> Option<Tissue>, within: [f64; 2], now: Option<Tissue>) -> f64 {
    let [mut inside, mut outside] = within;
    for _ in 0..12 {
        let middle = 0.5 * (inside + outside);
        *(if tissue_at(middle) == now { &mut inside } else { &mut outside }) = middle;
    }
    0.5 * (inside + outside)
}
