//! A certificate as a page that a person can keep and print: one file, with the signed statement inside it.

use askama::Template;
use model::certificate::Statement;
use time::OffsetDateTime;

use super::format;

/// Digits of the key that stand together.
const GROUP: usize = 8;

/// The page, in the language of whoever it is for.
#[derive(Debug, Template)]
#[template(path = "certificate.html")]
pub struct CertificatePage {
    /// What is signed.
    pub statement: Statement,
    /// The mastery rule, in the page's language.
    pub rule: String,
    /// By which attempts the school certifies, in the page's language.
    pub needed: &'static str,
    /// Each exercise, and since when it is mastered.
    pub mastered: Vec<(String, OffsetDateTime)>,
    /// When it was issued.
    pub issued_at: OffsetDateTime,
    /// The name under which the file is saved.
    pub file: String,
    /// The public key, hexadecimal.
    pub key: String,
    /// The certificate, as it may stand in a page.
    pub json: String,
}

impl CertificatePage {
    /// The key as a person compares it.
    fn key_in_groups(&self) -> String {
        let digits: Vec<char> = self.key.chars().collect();
        digits.chunks(GROUP).map(String::from_iter).collect::<Vec<_>>().join(" ")
    }
}

#[cfg(test)]
mod tests {
    //! A person must see what is certified; a name must stay a name, in the page and in the statement inside it.

    use ed25519_dalek::SigningKey;
    use model::certificate::{check_certificate, sign_statement};

    use super::*;
    use crate::{forgotten, samples};

    fn sample() -> Statement {
        let file = include_str!("../../../tests/data/certificate/statement.json");
        serde_json::from_str(file).expect("a statement")
    }

    #[test]
    fn what_is_certified_can_be_read_and_checked_whatever_the_names_hold() {
        let hostile = "</script><script>alert(1)</script> <!-- & \"Ana\"";
        let statement = Statement { trainee: hostile.to_owned(), ..sample() };
        let certificate = sign_statement(&SigningKey::from_bytes(&[7; 32]), &statement).expect("signed");
        let page = CertificatePage {
            statement: statement.clone(),
            rule: "mastered with 3 passes in a row".to_owned(),
            needed: "attempts that were supervised",
            mastered: vec![("Feel the <layers>".to_owned(), samples::NOW)],
            issued_at: samples::NOW,
            file: "certificate-lower-back-basics.html".to_owned(),
            key: certificate.public_key.clone(),
            json: certificate.in_page().expect("JSON"),
        };
        forgotten::check_page("certificate", &page);
        let html = page.render().expect("the page renders");
        assert_eq!(html.matches("<script").count(), 1, "a name begins no script");
        assert!(html.contains("Feel the &#60;layers&#62;") && html.contains("&#60;/script&#62;"), "{html}");
        assert!(html.contains(&certificate.public_key[..GROUP]) && !html.contains("<link"), "{html}");
        let checked = check_certificate(html.as_bytes(), &certificate.public_key).expect("genuine");
        assert_eq!(checked, statement);
    }
}
