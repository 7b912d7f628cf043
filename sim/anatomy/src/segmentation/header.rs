//! The header of a NIfTI file: the encoding of the image and the positions of its voxels.
//!
//! Fields, offsets and the three methods of orientation are those of the standard (nifti1.h, R. Cox
//! and others, 2003; nifti2.h, 2011). Orientation is taken from the sform if present, otherwise
//! from the qform, otherwise voxels are aligned with the axes.

use nalgebra::{Matrix3, Vector3};

use super::error::SegmentationError;

/// Maximum number of voxels along one axis.
const MOST_ALONG: i64 = 4096;
/// Maximum number of voxels: 512 × 512 × 512, which are 256 MiB of labels.
pub(super) const MOST_VOXELS: usize = 1 << 27;
/// Number of bytes after a header that indicate extensions.
const EXTENSION_FLAG: usize = 4;
/// Maximum number of bytes between header and image.
const MOST_OFFSET: f64 = 1e6;
/// Allowed edges of a voxel, in m.
const EDGE_M: std::ops::RangeInclusive<f64> = 2e-5..=0.03;
/// Minimum volume of a voxel, as a fraction of the product of its edges: a flatter header describes
/// a plane.
const LEAST_SKEW: f64 = 0.1;

/// Source of an image's orientation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orientation {
    /// The header's affine map.
    Sform,
    /// The header's quaternion.
    Qform,
    /// Neither: indices are assumed to run right, anterior and superior.
    Pixdim,
}

impl Orientation {
    /// A description for the user.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Sform => "sform",
            Self::Qform => "qform",
            Self::Pixdim => "none: indices taken to run right, anterior, superior",
        }
    }
}

/// Transform from voxel indices to the world: right, anterior, superior, in m. Integer indices are
/// centres of voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// A step of each index, as columns, in m.
    pub steps_m: Matrix3<f64>,
    /// The centre of voxel (0, 0, 0), in m.
    pub origin_m: Vector3<f64>,
}

/// Storage type of a voxel's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Stored {
    Unsigned(usize),
    Signed(usize),
    Float(usize),
}

impl Stored {
    pub fn bytes(self) -> usize {
        match self {
            Self::Unsigned(bytes) | Self::Signed(bytes) | Self::Float(bytes) => bytes,
        }
    }
}

/// The decoded header.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    pub size: [usize; 3],
    pub stored: Stored,
    pub is_little: bool,
    /// Number of bytes between the header and the image.
    pub gap: usize,
    pub slope: f64,
    pub intercept: f64,
    pub placement: Placement,
    pub orientation: Orientation,
    /// Whether the header names no unit of length.
    pub unit_is_assumed: bool,
}

/// Length of a header, in bytes, from its first four bytes.
pub(super) fn header_length(first: [u8; 4]) -> Result<usize, SegmentationError> {
    match [u32::from_le_bytes(first), u32::from_be_bytes(first)] {
        [348, _] | [_, 348] => Ok(348),
        [540, _] | [_, 540] => Ok(540),
        [little, _] => Err(SegmentationError::NotNifti(format!("its first number is {little}, not 348 or 540"))),
    }
}

/// Reads a header of 348 or 540 bytes.
pub(super) fn read_header(bytes: &[u8]) -> Result<Header, SegmentationError> {
    let is_second = bytes.len() == 540;
    let first = [bytes[0], bytes[1], bytes[2], bytes[3]];
    let fields = Fields { bytes, is_little: u32::from_le_bytes(first) as usize == bytes.len(), is_second };
    fields.check_magic()?;
    let steps = fields.steps();
    let (orientation, placement) = fields.placement(steps)?;
    let (unit_m, unit_is_assumed) = fields.unit()?;
    let placement = Placement { steps_m: placement.steps_m * unit_m, origin_m: placement.origin_m * unit_m };
    check_placement(&placement)?;
    let (slope, intercept) = fields.scaling();
    Ok(Header {
        size: fields.size()?,
        stored: fields.stored()?,
        is_little: fields.is_little,
        gap: fields.gap()?,
        slope,
        intercept,
        placement,
        orientation,
        unit_is_assumed,
    })
}

fn check_placement(placement: &Placement) -> Result<(), SegmentationError> {
    let edges = [0, 1, 2].map(|axis| placement.steps_m.column(axis).norm());
    // Written so that NaN fails.
    let is_near = placement.origin_m.iter().all(|c| c.abs() <= 10.0);
    let is_solid = placement.steps_m.determinant().abs() >= LEAST_SKEW * edges.iter().product::<f64>();
    if edges.iter().all(|edge| EDGE_M.contains(edge)) && is_near && is_solid {
        return Ok(());
    }
    Err(SegmentationError::Header {
        field: "voxels",
        value: format!("{:.4} mm × {:.4} mm × {:.4} mm", edges[0] * 1e3, edges[1] * 1e3, edges[2] * 1e3),
        allowed: "allowed: edges of 0.02 mm to 30 mm that span a volume, within 10 m of the origin",
    })
}

/// The bytes of a header and their decoding. Offsets differ between the two versions.
struct Fields<'b> {
    bytes: &'b [u8],
    is_little: bool,
    is_second: bool,
}

impl Fields<'_> {
    /// An unsigned number of `count` bytes at an offset.
    fn unsigned(&self, at: usize, count: usize) -> u64 {
        decode_unsigned(&self.bytes[at..at + count], self.is_little)
    }

    fn short(&self, at: usize) -> i64 {
        i64::from(self.unsigned(at, 2) as u16 as i16)
    }

    /// A number that is `f32` in version 1 and `f64` in version 2, at its offset in each.
    fn real(&self, first: usize, second: usize) -> f64 {
        match self.is_second {
            true => f64::from_bits(self.unsigned(second, 8)),
            false => f64::from(f32::from_bits(self.unsigned(first, 4) as u32)),
        }
    }

    /// As [`Self::real`], for an element of an array.
    fn real_of(&self, first: usize, second: usize, at: usize) -> f64 {
        self.real(first + 4 * at, second + 8 * at)
    }

    fn check_magic(&self) -> Result<(), SegmentationError> {
        let (magic, wanted): (&[u8], &[u8]) = match self.is_second {
            true => (&self.bytes[4..8], b"n+2\0"),
            false => (&self.bytes[344..348], b"n+1\0"),
        };
        if magic == wanted {
            return Ok(());
        }
        Err(SegmentationError::NotNifti(format!("its magic number is {:?}", String::from_utf8_lossy(magic))))
    }

    /// The edges of a voxel, preceded by the sign with which the qform mirrors the third axis.
    fn steps(&self) -> [f64; 4] {
        [0, 1, 2, 3].map(|at| self.real_of(76, 104, at))
    }

    fn size(&self) -> Result<[usize; 3], SegmentationError> {
        let dim = |at: usize| match self.is_second {
            true => self.unsigned(16 + 8 * at, 8) as i64,
            false => self.short(40 + 2 * at),
        };
        let all: Vec<i64> = (0..8).map(dim).collect();
        let more = (4..8).any(|at| all[0] >= at as i64 && all[at] > 1);
        let size = [all[1], all[2], all[3]];
        let voxels = size.iter().try_fold(1_i64, |product, &along| product.checked_mul(along));
        let is_sized = size.iter().all(|along| (1..=MOST_ALONG).contains(along))
            && voxels.is_some_and(|voxels| voxels <= MOST_VOXELS as i64);
        if (3..=7).contains(&all[0]) && !more && is_sized {
            return Ok(size.map(|along| along as usize));
        }
        Err(SegmentationError::Header {
            field: "dim",
            value: format!("{all:?}"),
            allowed: "allowed: one image of three dimensions, each 1 to 4096 voxels, at most 134217728 in all",
        })
    }

    fn stored(&self) -> Result<Stored, SegmentationError> {
        let code = self.short(if self.is_second { 12 } else { 70 });
        Ok(match code {
            2 => Stored::Unsigned(1),
            512 => Stored::Unsigned(2),
            768 => Stored::Unsigned(4),
            1280 => Stored::Unsigned(8),
            256 => Stored::Signed(1),
            4 => Stored::Signed(2),
            8 => Stored::Signed(4),
            1024 => Stored::Signed(8),
            16 => Stored::Float(4),
            64 => Stored::Float(8),
            _ => {
                return Err(SegmentationError::Header {
                    field: "datatype",
                    value: code.to_string(),
                    allowed: "allowed: whole numbers of 8 to 64 bits, or real ones of 32 or 64 (2, 4, 8, 16, 64, 256, 512, 768, 1024, 1280)",
                });
            }
        })
    }

    fn gap(&self) -> Result<usize, SegmentationError> {
        let offset = match self.is_second {
            true => self.unsigned(168, 8) as i64 as f64,
            false => f64::from(f32::from_bits(self.unsigned(108, 4) as u32)),
        };
        let length = self.bytes.len() as f64;
        // Some programs omit the offset and mean directly after the header and its four bytes of
        // extension.
        if offset == 0.0 {
            return Ok(EXTENSION_FLAG);
        }
        if offset >= length && offset <= length + MOST_OFFSET {
            return Ok((offset - length) as usize);
        }
        Err(SegmentationError::Header {
            field: "vox_offset",
            value: offset.to_string(),
            allowed: "allowed: 0, or at most 1000000 bytes after the header",
        })
    }

    /// A slope of 0 or NaN means that values are unscaled.
    fn scaling(&self) -> (f64, f64) {
        let (slope, intercept) = (self.real(112, 176), self.real(116, 184));
        if slope == 0.0 || !slope.is_finite() || !intercept.is_finite() { (1.0, 0.0) } else { (slope, intercept) }
    }

    /// The unit of length in m, and whether it is assumed: mm, if the header has none.
    fn unit(&self) -> Result<(f64, bool), SegmentationError> {
        let code = if self.is_second { self.unsigned(500, 4) } else { self.unsigned(123, 1) } & 7;
        match code {
            0 => Ok((1e-3, true)),
            1 => Ok((1.0, false)),
            2 => Ok((1e-3, false)),
            3 => Ok((1e-6, false)),
            _ => Err(SegmentationError::Header {
                field: "xyzt_units",
                value: code.to_string(),
                allowed: "allowed: 0 (taken as mm), 1 (m), 2 (mm) or 3 (µm)",
            }),
        }
    }

    /// Orientation and position of the image, in the header's unit.
    fn placement(&self, steps: [f64; 4]) -> Result<(Orientation, Placement), SegmentationError> {
        let code = |first, second| if self.is_second { self.unsigned(second, 4) as i64 } else { self.short(first) };
        if code(254, 348) > 0 {
            let row = |row: usize, column: usize| self.real_of(280 + 16 * row, 400 + 32 * row, column);
            let steps_m = Matrix3::from_fn(row);
            return Ok((Orientation::Sform, Placement { steps_m, origin_m: Vector3::from_fn(|at, _| row(at, 3)) }));
        }
        let edges = Matrix3::from_diagonal(&Vector3::new(steps[1], steps[2], steps[3]).abs());
        if code(252, 344) > 0 {
            let quaternion = [0, 1, 2].map(|at| self.real_of(256, 352, at));
            let mirror = if steps[0] < 0.0 { -1.0 } else { 1.0 };
            let steps_m = rotation(quaternion)? * edges * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, mirror));
            let origin_m = Vector3::from_fn(|at, _| self.real_of(268, 376, at));
            return Ok((Orientation::Qform, Placement { steps_m, origin_m }));
        }
        Ok((Orientation::Pixdim, Placement { steps_m: edges, origin_m: Vector3::zeros() }))
    }
}

/// The rotation of a quaternion whose real part follows from the others.
fn rotation([b, c, d]: [f64; 3]) -> Result<Matrix3<f64>, SegmentationError> {
    let rest = 1.0 - (b * b + c * c + d * d);
    // Quaternions of half a turn are stored in 32 bits and their norm may slightly exceed 1.
    let is_unit = rest >= -1e-5;
    if !is_unit {
        return Err(SegmentationError::Header {
            field: "quatern",
            value: format!("{b}, {c}, {d}"),
            allowed: "allowed: three parts of a quaternion of length 1",
        });
    }
    let a = libm::sqrt(rest.max(0.0));
    let length = libm::sqrt(a * a + b * b + c * c + d * d);
    let [a, b, c, d] = [a, b, c, d].map(|part| part / length);
    Ok(Matrix3::new(
        a * a + b * b - c * c - d * d,
        2.0 * (b * c - a * d),
        2.0 * (b * d + a * c),
        2.0 * (b * c + a * d),
        a * a + c * c - b * b - d * d,
        2.0 * (c * d - a * b),
        2.0 * (b * d - a * c),
        2.0 * (c * d + a * b),
        a * a + d * d - c * c - b * b,
    ))
}

/// Decodes an unsigned number of at most eight bytes.
pub(super) fn decode_unsigned(bytes: &[u8], is_little: bool) -> u64 {
    let join = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
    if is_little { bytes.iter().rev().fold(0, join) } else { bytes.iter().fold(0, join) }
}
