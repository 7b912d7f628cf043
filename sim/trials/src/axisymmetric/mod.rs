//! The axisymmetric model in the hard cases that concern it, and compared with closed forms.
//!
//! The trials detect a wrong stiffness term, locking elements, an estimate that is too small at a
//! singular corner, a film that degrades the conditioning, and results that depend on earlier ones.

mod closed_forms;
mod layers;
mod loads;

use closed_forms::{
    boussinesq_error, column_error, half_space_error, half_space_rate, mutual_error, patch_error, punch_error,
};
use layers::{
    contrast_estimate, duplicate_change, film_error, film_patch, incompressible_error, incompressible_locking,
    inverted_accepted, sheets_change, skin_error, soft_within_error, stiff_within_error, thin_error,
};
use loads::{bad_force_answers, hold_changes, stab_memory, teleport_linearity};

use super::case;

super::trials! { "axisymmetric":
    soft_within_error, case::RATIOS, "true error of a fit to 0.1 %, a soft layer between stiff ones", <= 1e-3 "";
    stiff_within_error, case::RATIOS, "true error of a fit to 0.1 %, a stiff layer between soft ones", <= 1e-3 "";
    contrast_estimate, case::RATIOS, "factor between the true error and the estimate", <= 3.0 "";
    skin_error, case::THIN_SKIN, "true error of a fit to 0.1 %", <= 1e-3 "";
    incompressible_error, case::INCOMPRESSIBLE, "true error of a fit to 0.1 %", <= 1e-3 "";
    incompressible_locking, case::INCOMPRESSIBLE, "growth of the error of one mesh from ν = 0.45", <= 10.0 "";
    film_error, case::SLIVERS, "change of the answer by a sliver of 1 µm of the same tissue", <= 1e-3 "";
    film_patch, case::SLIVERS, "error of a linear field through elements thousands of times as wide as high", <= 1e-9 "";
    inverted_accepted, case::SLIVERS, "meshes with an inverted or an empty element that were not refused", <= 0.0 "";
    stab_memory, case::STAB, "change of a later answer by the forces of a stab", <= 0.0 "m";
    teleport_linearity, case::TELEPORT, "distance from 100 times the answer to 1 N, after a jump to 100 N", <= 1e-14 "";
    bad_force_answers, case::BAD_SAMPLES, "answers that a bad force changed", <= 0.0 "";
    hold_changes, case::HOLD, "answers that differ from the first", <= 0.0 "";
    sheets_change, case::COINCIDENT, "change of the answer by sheets without thickness", <= 0.0 "";
    duplicate_change, case::COINCIDENT, "change of the answer when a layer is two of the same", <= 2e-3 "";
    thin_error, case::THIN, "true error of a fit to 0.1 %, a layer of 0.2 mm under a footprint of 1 mm", <= 1e-3 "";
    half_space_error, case::HALF_SPACE, "distance of the shortfall at R = 50 a from 1.7 %", <= 5e-4 "";
    half_space_rate, case::HALF_SPACE, "distance from 2 of what doubling R divides the shortfall by", <= 0.05 "";
    boussinesq_error, case::BOUSSINESQ, "error at 10 mm in a block of 5 m", <= 2e-3 "";
    punch_error, case::PUNCH, "error of the stiffness on a block of 5 m", <= 1e-3 "";
    column_error, case::COLUMN, "largest error at the boundaries", <= 1e-10 "";
    patch_error, case::PATCH, "largest error of a linear field in elements of any size and order", <= 1e-11 "";
    mutual_error, case::MUTUAL, "difference of two loads' work on each other", <= 1e-5 "";
}
