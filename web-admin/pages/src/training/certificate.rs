//! Certificates as single-file pages to keep and print, with the signed statement embedded.

use askama::Template;
use askama_web::WebTemplate;
use model::training::certificate::Statement;
use model::training::certificate_note::CertificateNote;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::training::qr;
use crate::{assets, format};

/// Digits of the key per group.
const GROUP: usize = 8;

/// The certificate's page, in the language of the trainee.
#[derive(Debug, Template)]
#[template(path = "training/certificate.html")]
pub struct CertificatePage {
    /// The signed statement.
    pub statement: Statement,
    /// The school's logo as a data URL.
    pub logo: Option<String>,
    /// The mastery rule, in the page's language.
    pub rule: String,
    /// Description of the attempts that count, in the page's language.
    pub needed: &'static str,
    /// Title of each exercise, and when it was mastered.
    pub mastered: Vec<(String, OffsetDateTime)>,
    /// Time of issue.
    pub issued_at: OffsetDateTime,
    /// The public key, hexadecimal.
    pub key: String,
    /// The signed certificate as JSON, escaped for embedding in HTML.
    pub json: String,
    /// Address that checks the certificate's code.
    pub check_href: String,
}

/// The page that shows whether a certificate's code is genuine.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/certificate_check.html")]
pub struct CertificateCheckPage {
    /// Result of the check.
    pub outcome: CheckOutcome,
    /// Address of this service.
    pub address: String,
}

/// Result of checking a certificate's code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CheckOutcome {
    /// No code was given.
    NothingAsked,
    /// This service has not signed the content of the code.
    Refused,
    /// This service has signed the content.
    Genuine(CertificateNote),
}

impl CertificateCheckPage {
    /// Returns the date of issue as displayed.
    fn issued_on(&self) -> String {
        let CheckOutcome::Genuine(note) = &self.outcome else { return String::new() };
        let at = OffsetDateTime::parse(&note.issued_at, &Rfc3339);
        at.map_or_else(|_| note.issued_at.clone(), format::format_date)
    }
}

impl CertificatePage {
    /// Returns the key in groups of digits, for comparison by eye.
    fn key_in_groups(&self) -> String {
        let digits: Vec<char> = self.key.chars().collect();
        digits.chunks(GROUP).map(String::from_iter).collect::<Vec<_>>().join(" ")
    }

    /// Returns the QR code that checks a printed certificate; empty if the names are too long for a
    /// code.
    fn check_code(&self) -> String {
        qr::draw_qr_code(&self.check_href).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    //! The page must show what is certified, and names must never become markup, neither in the
    //! page nor in the embedded statement.

    use ed25519_dalek::SigningKey;
    use model::training::certificate::{check_certificate, sign_statement};

    use super::*;
    use crate::samples;
    use crate::samples::untranslated_text;

    fn sample() -> Statement {
        let file = include_str!("../../../../tests/data/certificate/statement.json");
        serde_json::from_str(file).expect("a statement")
    }

    #[test]
    fn certificate_escapes_names_and_verifies_as_signed() {
        let hostile = "</script><script>alert(1)</script> <!-- & \"Ana\"";
        let statement = Statement { trainee: hostile.to_owned(), ..sample() };
        let certificate = sign_statement(&SigningKey::from_bytes(&[7; 32]), &statement).expect("signed");
        let page = CertificatePage {
            statement: statement.clone(),
            logo: Some("data:image/png;base64,AA==".to_owned()),
            rule: "mastered with 3 passes in a row".to_owned(),
            needed: "attempts that were supervised",
            mastered: vec![("Feel the <layers>".to_owned(), samples::NOW)],
            issued_at: samples::NOW,
            key: certificate.public_key.clone(),
            json: certificate.in_page().expect("JSON"),
            check_href: "https://stylet.example/certificate?of=eyJub3RlIjoxfQ&by=AAAA".to_owned(),
        };
        untranslated_text::check_page("certificate", &page);
        let html = page.render().expect("the page renders");
        assert_eq!(html.matches("<script").count(), 1, "a name begins no script");
        assert!(html.contains("Feel the &#60;layers&#62;") && html.contains("&#60;/script&#62;"), "{html}");
        assert!(html.contains(&certificate.public_key[..GROUP]) && !html.contains("<link"), "{html}");
        let checked = check_certificate(html.as_bytes(), &certificate.public_key).expect("genuine");
        assert_eq!(checked, statement);
    }

    #[test]
    fn a_check_says_genuine_or_not() {
        let note = CertificateNote {
            note: CertificateNote::VERSION,
            school: "Nordklinik".to_owned(),
            trainee: "<b>Ada".to_owned(),
            course: "Lower back".to_owned(),
            issued_at: "2026-11-23T22:00:00Z".to_owned(),
        };
        let page = |outcome| CertificateCheckPage { outcome, address: "https://stylet.example".to_owned() };
        let html = samples::keep_page("certificate-genuine", &page(CheckOutcome::Genuine(note)));
        assert!(html.contains("Genuine") && html.contains("&#60;b&#62;Ada") && html.contains("23 Nov 2026"), "{html}");
        let html = samples::keep_page("certificate-refused", &page(CheckOutcome::Refused));
        assert!(html.contains("Not genuine") && !html.contains("Ada"), "{html}");
        assert!(samples::keep_page("certificate-nothing", &page(CheckOutcome::NothingAsked)).contains("Scan the code"));
    }
}
