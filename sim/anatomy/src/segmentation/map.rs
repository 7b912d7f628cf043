//! A label map: one number per voxel, read from a NIfTI file within limits.

use std::io::{BufReader, Read};

use flate2::bufread::MultiGzDecoder;
use nalgebra::{Matrix3, Point3, Vector3};

use super::error::SegmentationError;
use super::header::{Header, MOST_VOXELS, Orientation, Placement, Stored, decode_unsigned, header_length, read_header};

/// The first bytes of a gzip file.
const GZIP: [u8; 2] = [0x1f, 0x8b];
/// Number of voxels allocated before the first is read, so that a header alone cannot allocate more
/// memory.
const FIRST_ROOM: usize = 1 << 20;

/// Maximum distance of a label from a whole number: slopes are stored in 32 bits.
const WHOLE: f64 = 1e-3;

/// The labels of voxels, and their positions. 0 is outside the body.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelMap {
    pub(super) size: [usize; 3],
    /// The first index runs fastest.
    pub(super) labels: Vec<u16>,
    pub(super) placement: Placement,
    orientation: Orientation,
    unit_is_assumed: bool,
}

impl LabelMap {
    /// Reads a NIfTI-1 or NIfTI-2 file, compressed by gzip or not, of at most 134 million voxels.
    ///
    /// Memory grows with the data read and not with the size in the header; data after the last
    /// voxel are not decompressed.
    ///
    /// # Errors
    /// If the file is invalid.
    pub fn read(source: impl Read) -> Result<Self, SegmentationError> {
        let mut source = BufReader::with_capacity(1 << 16, source);
        let mut first = [0; 2];
        fill(&mut source, &mut first)?;
        let whole = first.as_slice().chain(source);
        if first == GZIP { read_plain(MultiGzDecoder::new(BufReader::new(whole))) } else { read_plain(whole) }
    }

    /// Number of voxels along each axis of the image.
    #[must_use]
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Edges of a voxel, in m.
    #[must_use]
    pub fn edges_m(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.placement.steps_m.column(axis).norm())
    }

    /// Volume of a voxel, in m³.
    #[must_use]
    pub fn voxel_m3(&self) -> f64 {
        self.placement.steps_m.determinant().abs()
    }

    /// The source of the image's orientation in the header.
    #[must_use]
    pub fn orientation(&self) -> Orientation {
        self.orientation
    }

    /// Whether the header names no unit of length, so that mm are assumed.
    #[must_use]
    pub fn unit_is_assumed(&self) -> bool {
        self.unit_is_assumed
    }

    /// Converts a position in voxels to the world, in m.
    pub(super) fn to_world_m(&self, index: &Vector3<f64>) -> Point3<f64> {
        Point3::from(self.placement.steps_m * index + self.placement.origin_m)
    }

    /// The label at a point in the world, in m; 0 outside the image. `to_index` is the inverse of
    /// the steps.
    pub(super) fn label_at(&self, to_index: &Matrix3<f64>, place_m: &Point3<f64>) -> u16 {
        let index = to_index * (place_m.coords - self.placement.origin_m);
        let mut at = [0; 3];
        for axis in 0..3 {
            let nearest = libm::floor(index[axis] + 0.5);
            if !(nearest >= 0.0 && nearest < self.size[axis] as f64) {
                return 0;
            }
            at[axis] = nearest as usize;
        }
        self.labels[at[0] + self.size[0] * (at[1] + self.size[1] * at[2])]
    }

    /// The same image with other labels.
    pub(super) fn with_labels(&self, labels: Vec<u16>) -> Self {
        let Self { size, placement, orientation, unit_is_assumed, .. } = *self;
        Self { size, labels, placement, orientation, unit_is_assumed }
    }
}

fn fill(source: &mut impl Read, bytes: &mut [u8]) -> Result<(), SegmentationError> {
    source.read_exact(bytes).map_err(|error| SegmentationError::Unreadable(error.to_string()))
}

fn read_plain(mut source: impl Read) -> Result<LabelMap, SegmentationError> {
    let mut first = [0; 4];
    fill(&mut source, &mut first)?;
    let mut bytes = vec![0; header_length(first)?];
    bytes[..4].copy_from_slice(&first);
    fill(&mut source, &mut bytes[4..])?;
    let header = read_header(&bytes)?;
    fill(&mut source, &mut vec![0; header.gap])?;
    let labels = read_labels(source, &header)?;
    Ok(LabelMap {
        size: header.size,
        labels,
        placement: header.placement,
        orientation: header.orientation,
        unit_is_assumed: header.unit_is_assumed,
    })
}

/// The fill value of an image around the body, if not 0: programs write NaN, or a number that is
/// not a label, such as CT's −1024.
#[derive(Default)]
struct Filling(Option<f64>);

impl Filling {
    /// Whether a value is the fill value: NaN, or the first negative number found. Any other
    /// negative number is an invalid label.
    fn is(&mut self, value: f64) -> bool {
        value.is_nan() || value < 0.0 && value.is_finite() && (*self.0.get_or_insert(value) - value).abs() <= WHOLE
    }
}

/// Reads the labels, one row of voxels at a time.
fn read_labels(mut source: impl Read, header: &Header) -> Result<Vec<u16>, SegmentationError> {
    let [along, across, deep] = header.size;
    let voxels = along * across * deep;
    debug_assert!(voxels <= MOST_VOXELS, "the header was checked");
    let mut labels = Vec::with_capacity(voxels.min(FIRST_ROOM));
    let mut filling = Filling::default();
    let mut row = vec![0; along * header.stored.bytes()];
    for at in 0..across * deep {
        fill(&mut source, &mut row)?;
        for (column, stored) in row.chunks_exact(header.stored.bytes()).enumerate() {
            let label = label_of(stored, header)
                .or_else(|value| if filling.is(value) { Ok(0) } else { Err(value) })
                .map_err(|value| SegmentationError::NoLabel { index: [column, at % across, at / across], value })?;
            labels.push(label);
        }
    }
    Ok(labels)
}

/// The label in a voxel's bytes, or the number that is not a label as the error.
fn label_of(stored: &[u8], header: &Header) -> Result<u16, f64> {
    let bits = decode_unsigned(stored, header.is_little);
    let value = match header.stored {
        Stored::Unsigned(_) => bits as f64,
        Stored::Signed(bytes) => {
            let unused = 64 - 8 * bytes as u32;
            ((bits << unused) as i64 >> unused) as f64
        }
        Stored::Float(4) => f64::from(f32::from_bits(bits as u32)),
        Stored::Float(_) => f64::from_bits(bits),
    };
    let scaled = value * header.slope + header.intercept;
    let label = libm::round(scaled);
    if (0.0..=65535.0).contains(&label) && (scaled - label).abs() <= WHOLE { Ok(label as u16) } else { Err(scaled) }
}
