//! Published dimensions of the lower back, each with its source. The status records whether a
//! figure was read in the source, in its abstract or a table, or recalled from memory; recalled
//! figures, and those estimated from pictures, must be verified before use.

use super::part::Level;

/// Provenance of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Read in the source itself, in its abstract or a table.
    Read,
    /// Recalled without access to the source.
    Recalled,
}

/// One published dimension of a level of the spine, or of the interspace below it.
#[derive(Clone, Copy, Debug)]
pub struct PublishedDimension {
    /// The dimension.
    pub dimension: Dimension,
    /// The vertebra, or the interspace below it.
    pub level: Level,
    /// Mean, in mm, or in degrees for angles.
    pub mean: f64,
    /// Standard deviation, in the same unit.
    pub sd: f64,
    /// The publication.
    pub source: &'static str,
    /// Provenance of the figure.
    pub standing: Standing,
}

/// The dimensions that are drawn for each body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dimension {
    /// Width of a body's endplates.
    EndplateWidth,
    /// Depth of a body's endplates.
    EndplateDepth,
    /// Height of a body at its back.
    BodyHeight,
    /// Distance between the pedicles.
    CanalWidth,
    /// Depth of the bony canal in the midline.
    CanalDepth,
    /// Width of a pedicle.
    PedicleWidth,
    /// Height of a pedicle.
    PedicleHeight,
    /// Distance from the middle of the body to the tip of the spinous process.
    SpinousReach,
    /// Height of the spinous process.
    SpinousHeight,
    /// Distance between the tips of the transverse processes.
    TransverseSpan,
    /// Height of the disc below, in its middle.
    DiscHeight,
    /// Angle of the disc below, standing, in degrees.
    DiscAngle,
    /// Thickness of the ligamentum flavum below.
    FlavumThickness,
}

impl Dimension {
    /// Every dimension.
    pub const ALL: [Self; 13] = [
        Self::EndplateWidth,
        Self::EndplateDepth,
        Self::BodyHeight,
        Self::CanalWidth,
        Self::CanalDepth,
        Self::PedicleWidth,
        Self::PedicleHeight,
        Self::SpinousReach,
        Self::SpinousHeight,
        Self::TransverseSpan,
        Self::DiscHeight,
        Self::DiscAngle,
        Self::FlavumThickness,
    ];

    /// Its name in tables, with its unit.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::EndplateWidth => "endplate_width_mm",
            Self::EndplateDepth => "endplate_depth_mm",
            Self::BodyHeight => "body_height_mm",
            Self::CanalWidth => "canal_width_mm",
            Self::CanalDepth => "canal_depth_mm",
            Self::PedicleWidth => "pedicle_width_mm",
            Self::PedicleHeight => "pedicle_height_mm",
            Self::SpinousReach => "spinous_reach_mm",
            Self::SpinousHeight => "spinous_height_mm",
            Self::TransverseSpan => "transverse_span_mm",
            Self::DiscHeight => "disc_height_mm",
            Self::DiscAngle => "disc_angle_deg",
            Self::FlavumThickness => "flavum_thickness_mm",
        }
    }

    /// Means and standard deviations of L1 to L5, and the levels whose figures were read.
    fn row(self) -> Row {
        match self {
            Self::EndplateWidth => Row::recalled([42.2, 44.0, 46.0, 48.0, 48.3], [3.0; 5], PANJABI),
            Self::EndplateDepth => {
                Row::recalled([34.7, 34.8, 35.0, 34.7, 35.5], [3.0, 3.0, 3.0, 3.0, 3.5], PANJABI).read(4, AUCKLAND)
            }
            Self::BodyHeight => Row::recalled([23.8, 24.3, 23.8, 24.1, 22.9], [1.9; 5], PANJABI),
            Self::CanalWidth => {
                Row::recalled([23.7, 23.8, 24.3, 25.4, 28.2], [2.2, 2.2, 2.4, 2.6, 3.1], PANJABI).read(4, AUCKLAND)
            }
            Self::CanalDepth => {
                Row::recalled([19.0, 18.2, 17.5, 18.6, 15.6], [2.0, 2.0, 2.0, 2.0, 2.1], PANJABI).read(4, AUCKLAND)
            }
            Self::PedicleWidth => {
                Row::recalled([8.6, 8.8, 10.2, 12.8, 16.1], [1.6, 1.6, 1.8, 2.0, 2.3], PANJABI).read(4, AUCKLAND)
            }
            Self::PedicleHeight => {
                Row::recalled([15.4, 15.0, 14.4, 14.5, 12.9], [1.5, 1.5, 1.5, 1.5, 1.9], PANJABI).read(4, AUCKLAND)
            }
            Self::SpinousReach => Row::recalled([67.7, 70.0, 71.9, 69.0, 62.0], [4.5; 5], PANJABI),
            Self::SpinousHeight => Row::recalled([17.5, 17.5, 16.5, 13.5, 12.5], [2.4; 5], SHAW),
            Self::TransverseSpan => Row::recalled([71.2, 76.1, 85.7, 79.4, 92.5], [6.5; 5], PANJABI),
            Self::DiscHeight => Row::recalled([7.6, 9.0, 9.8, 10.8, 9.4], [1.5; 5], LI),
            Self::DiscAngle => Row::recalled([6.0, 8.0, 10.0, 13.0, 14.0], [2.5; 5], LI),
            Self::FlavumThickness => Row::recalled([3.0, 3.19, 3.38, 3.70, 3.65], [0.9, 0.9, 0.94, 1.16, 1.16], ASIAN)
                .read(2, ASIAN)
                .read(3, ASIAN)
                .read(4, ASIAN),
        }
    }
}

const PANJABI: &str = "Panjabi et al. 1992, Spine 17:299";
const AUCKLAND: &str = "CT of lumbar vertebrae, Maori and European New Zealanders, Int J Spine Surg, table 6";
const SHAW: &str = "Aylott et al. 2012, Eur Spine J 21(S2):S212 (growth with age read)";
const LI: &str = "lateral radiographs of standing Chinese subjects, 7 to 12 mm and 46 to 53 degrees in all (sums read)";
const ASIAN: &str = "Asian Spine J 2015, 9:245 (MRI of 200 patients, right side)";

struct Row {
    means: [f64; 5],
    sds: [f64; 5],
    sources: [&'static str; 5],
    standings: [Standing; 5],
}

impl Row {
    fn recalled(means: [f64; 5], sds: [f64; 5], source: &'static str) -> Self {
        Self { means, sds, sources: [source; 5], standings: [Standing::Recalled; 5] }
    }

    fn read(mut self, level: usize, source: &'static str) -> Self {
        self.sources[level] = source;
        self.standings[level] = Standing::Read;
        self
    }
}

/// Returns the published values of a dimension, L1 to L5.
#[must_use]
pub fn list_published(dimension: Dimension) -> [PublishedDimension; 5] {
    let row = dimension.row();
    Level::ALL.map(|level| {
        let at = level as usize;
        PublishedDimension {
            dimension,
            level,
            mean: row.means[at],
            sd: row.sds[at],
            source: row.sources[at],
            standing: row.standings[at],
        }
    })
}
