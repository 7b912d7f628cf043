//! Errors of label maps.

/// An error of a label map, or of a request for it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SegmentationError {
    /// The bytes end too soon, cannot be decompressed, or cannot be read.
    #[error("unreadable: {0}")]
    Unreadable(String),
    /// Not a single-file NIfTI-1 or NIfTI-2.
    #[error("not a NIfTI file: {0}; allowed: NIfTI-1 or NIfTI-2, header and image in one file (.nii or .nii.gz)")]
    NotNifti(String),
    /// A number of the header is not allowed.
    #[error("{field} = {value}; {allowed}")]
    Header {
        /// Name of the header field in the NIfTI standard.
        field: &'static str,
        /// Its value.
        value: String,
        /// Description of the allowed values.
        allowed: &'static str,
    },
    /// A voxel's value is not a label.
    #[error(
        "voxel {index:?} = {value}; allowed: whole numbers from 0 to 65535, because this is a label map; around the \
         body NaN or one negative number"
    )]
    NoLabel {
        /// Indices of the voxel, from 0.
        index: [usize; 3],
        /// Its value, scaled as the header requires.
        value: f64,
    },
    /// No voxel has the label.
    #[error("no voxel has this label")]
    Empty,
    /// The structure has fewer than half of the voxels in every merged cell.
    #[error("it disappears at the resolution that the maximum number of triangles permits")]
    Lost,
    /// The entry is too far from the skin.
    #[error("the entry is {away_mm:.1} mm from the body's surface; allowed: at most {most_mm:.0} mm")]
    EntryAway {
        /// Distance, in mm.
        away_mm: f64,
        /// Maximum distance, in mm.
        most_mm: f64,
    },
    /// The direction out of the body points inwards.
    #[error("up points {angle_deg:.0}° away from the skin's outward normal; allowed: less than 60°")]
    UpInwards {
        /// The angle, in degrees.
        angle_deg: f64,
    },
    /// No layer below the entry.
    #[error("no voxel below the entry has a label of kind skin or layer")]
    NoLayers,
}
