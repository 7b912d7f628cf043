//! Addresses of pages that several others lead to.

/// The page of an exercise.
#[must_use]
pub fn exercise_href(exercise: &str) -> String {
    format!("/exercises/{exercise}")
}
