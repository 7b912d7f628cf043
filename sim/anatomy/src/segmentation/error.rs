//! Why a label map cannot be used.

/// What is wrong with a label map, or with what is asked of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SegmentationError {
    /// The bytes end too soon, cannot be unpacked, or cannot be read.
    #[error("unreadable: {0}")]
    Unreadable(String),
    /// No NIfTI-1 or NIfTI-2 file of one part.
    #[error("no NIfTI file: {0}; allowed: NIfTI-1 or NIfTI-2, header and image in one file (.nii or .nii.gz)")]
    NotNifti(String),
    /// A number of the header that is not allowed.
    #[error("{field} = {value}; {allowed}")]
    Header {
        /// The header's field, as the NIfTI standard calls it.
        field: &'static str,
        /// What stands in it.
        value: String,
        /// What is allowed, in words.
        allowed: &'static str,
    },
    /// A voxel that holds no label.
    #[error(
        "voxel {index:?} holds {value}; allowed: whole numbers from 0 to 65535, for it is a map of labels; around the body NaN or one negative number"
    )]
    NoLabel {
        /// Indices of the voxel, from 0.
        index: [usize; 3],
        /// What it holds, scaled as the header says.
        value: f64,
    },
    /// No voxel has the label.
    #[error("no voxel has it")]
    Empty,
    /// A structure of fewer than half of the voxels that were taken together.
    #[error("nothing is left of it at the resolution that the largest number of triangles allows")]
    Lost,
    /// No skin near the entry.
    #[error("the entry is {away_mm:.1} mm from the body's surface; allowed: at most {most_mm:.0} mm")]
    EntryAway {
        /// How far, in mm.
        away_mm: f64,
        /// How far it may be, in mm.
        most_mm: f64,
    },
    /// A direction out of the body that does not lead out of it.
    #[error("up points {angle_deg:.0}° away from the skin's own direction out of the body; allowed: less than 60°")]
    UpInwards {
        /// The angle, in degrees.
        angle_deg: f64,
    },
    /// No layer below the entry.
    #[error("no voxel below the entry has a label of kind skin or layer")]
    NoLayers,
}
