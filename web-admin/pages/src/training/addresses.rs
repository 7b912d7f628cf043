//! Addresses of pages that several other pages link to.

/// Returns the address of an exercise's page.
#[must_use]
pub fn exercise_href(exercise: &str) -> String {
    format!("/exercises/{exercise}")
}
