//! NIfTI files as the tests make them, byte by byte.

use std::io::Write;

use anatomy::segmentation::{LabelMap, Orientation, SegmentationError};
use flate2::Compression;
use flate2::write::GzEncoder;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// What a file says, and in which form.
pub struct Written {
    pub size: [usize; 3],
    /// A step of each index in the world, in mm.
    pub steps_mm: Matrix3<f64>,
    pub origin_mm: Vector3<f64>,
    pub labels: Vec<u16>,
}

/// Which of the two headers, whose byte order, and what says how the image lies.
#[derive(Clone, Copy)]
pub struct Form {
    pub is_second: bool,
    pub is_little: bool,
    pub by: Orientation,
}

pub const PLAIN: Form = Form { is_second: false, is_little: true, by: Orientation::Sform };

impl Written {
    pub fn bytes(&self, form: Form) -> Vec<u8> {
        let mut header = Header { bytes: vec![0; if form.is_second { 540 } else { 348 }], form };
        header.integer(0, 0, 4, header.bytes.len() as i64);
        let dims = [3, self.size[0], self.size[1], self.size[2], 1, 1, 1, 1];
        for (at, dim) in dims.into_iter().enumerate() {
            header.integer(40 + 2 * at, 16 + 8 * at, if form.is_second { 8 } else { 2 }, dim as i64);
        }
        header.integer(70, 12, 2, 512);
        header.integer(123, 500, if form.is_second { 4 } else { 1 }, 2);
        match form.is_second {
            true => header.integer(0, 168, 8, 544),
            false => header.real(108, 0, 352.0),
        }
        self.orient(&mut header);
        let magic: &[u8] = if form.is_second { b"n+2\0\r\n\x1a\n" } else { b"n+1\0" };
        let at = if form.is_second { 4 } else { 344 };
        header.bytes[at..at + magic.len()].copy_from_slice(magic);
        let mut bytes = header.bytes;
        bytes.extend([0; 4]);
        for label in &self.labels {
            bytes.extend(if form.is_little { label.to_le_bytes() } else { label.to_be_bytes() });
        }
        bytes
    }

    fn orient(&self, header: &mut Header) {
        let edges = [0, 1, 2].map(|axis| self.steps_mm.column(axis).norm());
        let mirror = self.steps_mm.determinant().signum();
        for (at, value) in [mirror, edges[0], edges[1], edges[2]].into_iter().enumerate() {
            header.real(76 + 4 * at, 104 + 8 * at, value);
        }
        let width = if header.form.is_second { 4 } else { 2 };
        header.integer(254, 348, width, i64::from(header.form.by == Orientation::Sform));
        header.integer(252, 344, width, i64::from(header.form.by != Orientation::Pixdim));
        for row in 0..3 {
            let all = [self.steps_mm[(row, 0)], self.steps_mm[(row, 1)], self.steps_mm[(row, 2)], self.origin_mm[row]];
            for (column, value) in all.into_iter().enumerate() {
                header.real(280 + 16 * row + 4 * column, 400 + 32 * row + 8 * column, value);
            }
        }
        let mut turn = self.steps_mm;
        (0..3).for_each(|axis| turn.column_mut(axis).scale_mut(1.0 / edges[axis]));
        turn.column_mut(2).scale_mut(mirror);
        let quaternion = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
        let sign = if quaternion.w < 0.0 { -1.0 } else { 1.0 };
        for (at, value) in [quaternion.i, quaternion.j, quaternion.k].into_iter().enumerate() {
            header.real(256 + 4 * at, 352 + 8 * at, value * sign);
            header.real(268 + 4 * at, 376 + 8 * at, self.origin_mm[at]);
        }
    }
}

struct Header {
    bytes: Vec<u8>,
    form: Form,
}

impl Header {
    fn integer(&mut self, first: usize, second: usize, width: usize, value: i64) {
        let at = if self.form.is_second { second } else { first };
        let mut bytes = value.to_le_bytes()[..width].to_vec();
        if !self.form.is_little {
            bytes.reverse();
        }
        self.bytes[at..at + width].copy_from_slice(&bytes);
    }

    fn real(&mut self, first: usize, second: usize, value: f64) {
        match self.form.is_second {
            true => self.integer(first, second, 8, value.to_bits() as i64),
            false => self.integer(first, second, 4, i64::from((value as f32).to_bits())),
        }
    }
}

pub fn pack(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub fn read(bytes: &[u8]) -> Result<LabelMap, SegmentationError> {
    LabelMap::read(bytes)
}

/// A step of each index: voxels of these edges, in mm, turned about an oblique axis.
pub fn oblique_steps(edges_mm: [f64; 3], angle_rad: f64) -> Matrix3<f64> {
    let axis = nalgebra::Unit::new_normalize(Vector3::new(0.3, -0.7, 0.6));
    Rotation3::from_axis_angle(&axis, angle_rad).into_inner() * Matrix3::from_diagonal(&Vector3::from(edges_mm))
}
