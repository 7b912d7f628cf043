//! The person who signs a school's certificates and transcripts on paper.

/// Maximum length of a name and of a function, in characters.
pub const LONGEST: usize = 120;

/// Name and function of the person who signs on paper.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signatory {
    /// Name.
    pub name: String,
    /// Function at the school; may be empty.
    pub function: String,
}

impl Signatory {
    /// Returns the signatory from the input of a form; `None` if there is no name.
    ///
    /// # Errors
    /// If there is a function without a name, or one of them is longer than [`LONGEST`].
    pub fn from_form(name: &str, function: &str) -> Result<Option<Self>, String> {
        let (name, function) = (name.trim(), function.trim());
        if name.is_empty() && !function.is_empty() {
            return Err(tr!("the signatory: a function needs a name").to_owned());
        }
        for text in [name, function] {
            let length = text.chars().count();
            if length > LONGEST {
                return Err(tr!(
                    "the signatory: {n} characters; at most {most} are allowed",
                    n = length,
                    most = LONGEST
                ));
            }
        }
        Ok((!name.is_empty()).then(|| Self { name: name.to_owned(), function: function.to_owned() }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signatory_has_a_name_and_bounded_texts() {
        let one = |name: &str, function: &str| Signatory::from_form(name, function);
        let dean = Signatory { name: "Ada".to_owned(), function: "Dean".to_owned() };
        assert_eq!(one(" Ada ", "Dean"), Ok(Some(dean)));
        assert_eq!(one("", " "), Ok(None));
        assert!(one("", "Dean").is_err() && one(&"x".repeat(LONGEST + 1), "").is_err());
        assert!(one(&"ä".repeat(LONGEST), &"ü".repeat(LONGEST)).is_ok());
        assert!(one("Ada", &"x".repeat(LONGEST + 1)).is_err());
    }
}
