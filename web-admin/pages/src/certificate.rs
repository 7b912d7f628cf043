//! A certificate as a page that a person can keep and print: one file, with the signed statement inside it.

use askama::Template;
use askama_web::WebTemplate;
use model::certificate::Statement;
use model::certificate_note::CertificateNote;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use super::{assets, format, qr};

/// Digits of the key that stand together.
const GROUP: usize = 8;

/// The page, in the language of whoever it is for.
#[derive(Debug, Template)]
#[template(path = "certificate.html")]
pub struct CertificatePage {
    /// What is signed.
    pub statement: Statement,
    /// The school's logo, as an address that holds it.
    pub logo: Option<String>,
    /// The mastery rule, in the page's language.
    pub rule: String,
    /// By which attempts the school certifies, in the page's language.
    pub needed: &'static str,
    /// Each exercise, and since when it is mastered.
    pub mastered: Vec<(String, OffsetDateTime)>,
    /// When it was issued.
    pub issued_at: OffsetDateTime,
    /// The public key, hexadecimal.
    pub key: String,
    /// The certificate, as it may stand in a page.
    pub json: String,
    /// Where its code is checked.
    pub check_href: String,
}

/// Whether a certificate's code is genuine.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "certificate_check.html")]
pub struct CertificateCheckPage {
    /// What came of it.
    pub outcome: CheckOutcome,
    /// The address of this service.
    pub address: String,
}

/// What came of checking a certificate's code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CheckOutcome {
    /// No code was given.
    NothingAsked,
    /// This service has not signed what the code says.
    Refused,
    /// It has signed this.
    Genuine(CertificateNote),
}

impl CertificateCheckPage {
    /// The day on which a certificate was issued, in words.
    fn issued_on(&self) -> String {
        let CheckOutcome::Genuine(note) = &self.outcome else { return String::new() };
        let at = OffsetDateTime::parse(&note.issued_at, &Rfc3339);
        at.map_or_else(|_| note.issued_at.clone(), format::format_date)
    }
}

impl CertificatePage {
    /// The key as a person compares it.
    fn key_in_groups(&self) -> String {
        let digits: Vec<char> = self.key.chars().collect();
        digits.chunks(GROUP).map(String::from_iter).collect::<Vec<_>>().join(" ")
    }

    /// The code by which a print is checked; empty where the names are too long for one.
    fn check_code(&self) -> String {
        qr::draw_qr_code(&self.check_href).unwrap_or_default()
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
            logo: Some("data:image/png;base64,AA==".to_owned()),
            rule: "mastered with 3 passes in a row".to_owned(),
            needed: "attempts that were supervised",
            mastered: vec![("Feel the <layers>".to_owned(), samples::NOW)],
            issued_at: samples::NOW,
            key: certificate.public_key.clone(),
            json: certificate.in_page().expect("JSON"),
            check_href: "https://stylet.example/certificate?of=eyJub3RlIjoxfQ&by=AAAA".to_owned(),
        };
        forgotten::check_page("certificate", &page);
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
