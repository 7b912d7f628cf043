//! The parts of a body, by name.

use law::structures::StructureKind;

/// A lumbar vertebra, or the interspace below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The first lumbar vertebra.
    L1,
    /// The second.
    L2,
    /// The third.
    L3,
    /// The fourth.
    L4,
    /// The fifth.
    L5,
}

impl Level {
    /// From L1 to L5.
    pub const ALL: [Self; 5] = [Self::L1, Self::L2, Self::L3, Self::L4, Self::L5];

    /// The vertebra's name.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["L1", "L2", "L3", "L4", "L5"][self as usize]
    }

    /// The vertebra above the interspace with a name.
    #[must_use]
    pub fn above(interspace: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|level| level.interspace() == interspace)
    }

    /// The name of the interspace below it.
    #[must_use]
    pub fn interspace(self) -> &'static str {
        ["L1/2", "L2/3", "L3/4", "L4/5", "L5/S1"][self as usize]
    }
}

/// A side of the body, from the patient's point of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BodySide {
    /// The patient's left, at negative x.
    Left,
    /// The patient's right.
    Right,
}

impl BodySide {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// −1 on the left, 1 on the right.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }

    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// A part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AnatomyPart {
    /// Skin: the body's outside.
    Skin,
    /// A lumbar vertebra.
    Vertebra(Level),
    /// The twelfth thoracic vertebra.
    LastThoracic,
    /// Sacrum.
    Sacrum,
    /// The wing of an ilium with its crest.
    Ilium(BodySide),
    /// Rib 11.
    EleventhRib(BodySide),
    /// Rib 12.
    TwelfthRib(BodySide),
    /// The disc below a lumbar vertebra.
    Disc(Level),
    /// Supraspinous ligament.
    Supraspinous,
    /// The interspinous ligament below a lumbar vertebra.
    Interspinous(Level),
    /// The ligamentum flavum below a lumbar vertebra.
    Flavum(Level),
    /// The content of the canal outside the sac.
    EpiduralSpace,
    /// Dura with its content.
    DuralSac,
    /// Erector spinae.
    ErectorSpinae(BodySide),
    /// Quadratus lumborum.
    Quadratus(BodySide),
    /// Kidney.
    Kidney(BodySide),
    /// Abdominal aorta with the common iliac arteries.
    Aorta,
    /// Inferior vena cava with the common iliac veins.
    VenaCava,
    /// Lumbar arteries.
    LumbarVessels,
}

impl AnatomyPart {
    /// All parts, in the order in which a body is listed.
    #[must_use]
    pub fn list() -> Vec<Self> {
        let sides = |part: fn(BodySide) -> Self| BodySide::BOTH.map(part);
        let levels = |part: fn(Level) -> Self| Level::ALL.map(part);
        let mut parts = vec![Self::Skin];
        parts.extend(levels(Self::Vertebra));
        parts.extend([Self::LastThoracic, Self::Sacrum]);
        parts.extend([Self::Ilium, Self::EleventhRib, Self::TwelfthRib].map(sides).into_iter().flatten());
        parts.extend(levels(Self::Disc));
        parts.push(Self::Supraspinous);
        parts.extend([Self::Interspinous, Self::Flavum].map(levels).into_iter().flatten());
        parts.extend([Self::EpiduralSpace, Self::DuralSac]);
        parts.extend([Self::ErectorSpinae, Self::Quadratus, Self::Kidney].map(sides).into_iter().flatten());
        parts.extend([Self::Aorta, Self::VenaCava, Self::LumbarVessels]);
        parts
    }

    /// Its name in files and tables.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Skin => "skin".to_owned(),
            Self::Vertebra(level) => format!("vertebra-{}", level.name()),
            Self::LastThoracic => "vertebra-T12".to_owned(),
            Self::Sacrum => "sacrum".to_owned(),
            Self::Ilium(side) => format!("ilium-{}", side.name()),
            Self::EleventhRib(side) => format!("rib-11-{}", side.name()),
            Self::TwelfthRib(side) => format!("rib-12-{}", side.name()),
            Self::Disc(level) => format!("disc-{}", level.interspace().replace('/', "-")),
            Self::Supraspinous => "supraspinous-ligament".to_owned(),
            Self::Interspinous(level) => format!("interspinous-ligament-{}", level.interspace().replace('/', "-")),
            Self::Flavum(level) => format!("ligamentum-flavum-{}", level.interspace().replace('/', "-")),
            Self::EpiduralSpace => "epidural-space".to_owned(),
            Self::DuralSac => "dural-sac".to_owned(),
            Self::ErectorSpinae(side) => format!("erector-spinae-{}", side.name()),
            Self::Quadratus(side) => format!("quadratus-{}", side.name()),
            Self::Kidney(side) => format!("kidney-{}", side.name()),
            Self::Aorta => "aorta".to_owned(),
            Self::VenaCava => "vena-cava".to_owned(),
            Self::LumbarVessels => "lumbar-vessels".to_owned(),
        }
    }

    /// Its role in the force law; `None` for tissue that the needle crosses as a layer.
    #[must_use]
    pub fn kind(self) -> Option<StructureKind> {
        match self {
            Self::Vertebra(_)
            | Self::LastThoracic
            | Self::Sacrum
            | Self::Ilium(_)
            | Self::EleventhRib(_)
            | Self::TwelfthRib(_) => Some(StructureKind::Bone),
            Self::Kidney(_) => Some(StructureKind::Organ),
            Self::Aorta | Self::VenaCava | Self::LumbarVessels => Some(StructureKind::Vessel),
            Self::DuralSac => Some(StructureKind::Nerve),
            _ => None,
        }
    }
}
