//! Forms: what stands in their fields, why one was refused, and how a field is read.

use serde::{Deserialize, Deserializer};

/// A form on a page: what stands in its fields, and, where it was sent and refused, why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilledForm<T, W = String> {
    /// What stands in its fields: what a page begins with, or what was typed.
    pub typed: T,
    /// Why it was refused.
    pub refused: Option<W>,
}

impl<T, W> FilledForm<T, W> {
    /// A form that nobody has sent yet.
    #[must_use]
    pub const fn new(typed: T) -> Self {
        Self { typed, refused: None }
    }

    /// A form that was sent and refused.
    #[must_use]
    pub const fn refused(typed: T, why: W) -> Self {
        Self { typed, refused: Some(why) }
    }
}

impl<T: Default, W> Default for FilledForm<T, W> {
    fn default() -> Self {
        Self::new(T::default())
    }
}

/// Reads a text without the spaces around it.
///
/// # Errors
/// When the field is no text.
pub fn read_trimmed_text<'de, D: Deserializer<'de>>(field: D) -> Result<String, D::Error> {
    Ok(String::deserialize(field)?.trim().to_owned())
}

/// Reads a box, which a browser sends with its value where it is ticked, and else leaves out.
///
/// # Errors
/// When the field is no text.
pub fn read_ticked_box<'de, D: Deserializer<'de>>(field: D) -> Result<bool, D::Error> {
    let value = String::deserialize(field)?;
    Ok(["yes", "true"].contains(&value.as_str()))
}
