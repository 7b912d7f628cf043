//! Forms: the values of their fields, why one was refused, and how fields are deserialized.

use serde::{Deserialize, Deserializer};

/// An option of a selection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SelectOption {
    /// Value sent by the form.
    pub value: String,
    /// Label shown to the reader.
    pub label: String,
    /// Whether it is selected.
    pub chosen: bool,
}

/// A form on a page: the values of its fields and, after a refused submission, the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilledForm<T, W = String> {
    /// Values of the fields: defaults, or the user's input.
    pub typed: T,
    /// Why the submission was refused.
    pub refused: Option<W>,
}

impl<T, W> FilledForm<T, W> {
    /// Creates a form that has not been submitted.
    #[must_use]
    pub const fn new(typed: T) -> Self {
        Self { typed, refused: None }
    }

    /// Creates a form whose submission was refused.
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

/// Deserializes a text without surrounding whitespace.
///
/// # Errors
///
/// If the field is not a string.
pub fn read_trimmed_text<'de, D: Deserializer<'de>>(field: D) -> Result<String, D::Error> {
    Ok(String::deserialize(field)?.trim().to_owned())
}

/// Deserializes a checkbox. Browsers send its value if it is ticked, and omit the field otherwise.
///
/// # Errors
///
/// If the field is not a string.
pub fn read_ticked_box<'de, D: Deserializer<'de>>(field: D) -> Result<bool, D::Error> {
    let value = String::deserialize(field)?;
    Ok(["yes", "true"].contains(&value.as_str()))
}
