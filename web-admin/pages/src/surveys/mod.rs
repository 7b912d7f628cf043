//! Surveys: the list, the management of a survey, instruments, the form and the results.

pub mod figures;
pub mod form;
pub mod instrument;
pub mod manage;
pub mod previewing;
pub mod results;
#[cfg(test)]
pub(crate) mod samples;

use model::surveys::Identity;

/// Describes an identity setting to readers of the results.
#[must_use]
pub fn identity_words(identity: Identity) -> &'static str {
    match identity {
        Identity::Anonymous => tr!("Anonymous: neither names nor attempts are stored"),
        Identity::Pseudonymous => tr!("Pseudonymous: without names; linked to the attempt if the survey follows one"),
        Identity::Named => tr!("Named"),
    }
}
