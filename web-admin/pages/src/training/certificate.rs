//! Certificates to keep and print, as single-file pages and as PDF, with the signed statement inside.

use askama::Template;
use askama_web::WebTemplate;
use model::training::certificate::Statement;
use model::training::certificate_note::CertificateNote;
use model::training::signatory::Signatory;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::training::paper::{AttachedFile, Block, Logo, Paper, PaperColumn, PaperTable, Style};
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
    /// The school's logo.
    pub logo: Option<Logo>,
    /// Who signs it on paper.
    pub signatory: Option<Signatory>,
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

    /// Returns the registrar's number as a sentence.
    fn number_words(&self) -> Option<String> {
        self.statement.registrar_id.as_deref().map(number_words)
    }

    fn lead(&self) -> String {
        tr!("has mastered every exercise of the course “{course}”.", course = self.statement.course)
    }

    fn rule_words(&self) -> String {
        let rule = tr!("An exercise is {rule}.", rule = self.rule);
        format!("{rule} {}", tr!("Attempts counted: {needed}.", needed = self.needed))
    }

    fn issued_words(&self) -> String {
        tr!("Issued on {date}.", date = format::format_date(self.issued_at))
    }

    fn title(&self) -> String {
        tr!("Certificate of {trainee}: {course}", trainee = self.statement.trainee, course = self.statement.course)
    }

    /// Returns the certificate as a paper: the same sentences as the page, with the signed certificate
    /// attached.
    #[must_use]
    pub fn paper(&self) -> Paper {
        let statement = &self.statement;
        let mut blocks = vec![
            Block::text(Style::School, &statement.school),
            Block::Heading(1, tr!("Certificate").to_owned()),
            Block::text(Style::Name, &statement.trainee),
        ];
        blocks.extend(self.number_words().map(|number| Block::text(Style::Body, number)));
        blocks.extend([
            Block::text(Style::Lead, self.lead()),
            Block::Table(self.exercises()),
            Block::text(Style::Body, self.rule_words()),
            Block::text(Style::Strong, scope_words()),
            Block::text(Style::Body, self.issued_words()),
        ]);
        blocks.extend(self.signatory.as_ref().map(sign_block));
        blocks.extend(self.check_blocks());
        Paper {
            title: self.title(),
            language: words::current().code(),
            made_at: self.issued_at,
            logo: self.logo.clone(),
            blocks,
            attachment: Some(AttachedFile {
                name: "certificate.json",
                media_type: "application/json",
                description: tr!("The signed certificate").to_owned(),
                bytes: self.json.clone().into_bytes(),
            }),
        }
    }

    fn exercises(&self) -> PaperTable {
        PaperTable {
            columns: vec![
                PaperColumn { title: tr!("Exercise").to_owned(), percent: 72 },
                PaperColumn { title: tr!("Mastered on").to_owned(), percent: 28 },
            ],
            rows: self.mastered.iter().map(|(title, on)| vec![title.clone(), format::format_date(*on)]).collect(),
        }
    }

    /// Returns how to check the file and a print of it.
    fn check_blocks(&self) -> Vec<Block> {
        let small = |text| Block::text(Style::Small, text);
        let mut blocks = vec![
            Block::Heading(2, tr!("How to check this certificate").to_owned()),
            small(tr!(
                "A statement signed by the school’s service is attached to this file. The text of the paper is not signed; the program Stylet shows the signed statement, and rejects it if it was changed."
            )),
            small(tr!("The key is the one published by the school. This certificate is signed with:")),
            Block::text(Style::Digits, self.key_in_groups()),
        ];
        if !self.check_code().is_empty() {
            blocks.push(Block::Code {
                content: self.check_href.clone(),
                alt: tr!("QR code with an address of the school’s service that checks this certificate").to_owned(),
                text: tr!("If you have only a print, scan this code: the school’s service shows whether it is genuine. Check that the address belongs to the school.").to_owned(),
            });
        }
        blocks.push(small(tr!(
            "The handbook of Stylet explains under “Certificates” how to check the file offline, without this service."
        )));
        blocks
    }

    /// Returns the QR code that checks a printed certificate; empty if the names are too long for a
    /// code.
    fn check_code(&self) -> String {
        qr::draw_qr_code(&self.check_href).unwrap_or_default()
    }
}

/// States what a paper does not prove.
pub(super) fn scope_words() -> &'static str {
    tr!("Simulated performance only; no statement about competence with patients.")
}

/// Returns a registrar's number with its name.
pub(super) fn number_words(number: &str) -> String {
    format!("{} {number}", tr!("Registrar’s number"))
}

/// Returns the line to sign on.
pub(super) fn sign_block(signatory: &Signatory) -> Block {
    Block::Signature { name: signatory.name.clone(), function: signatory.function.clone() }
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
            logo: Some(Logo { media_type: "image/png".to_owned(), bytes: vec![0] }),
            signatory: Some(Signatory { name: "Prof. <Ada>".to_owned(), function: "Dean".to_owned() }),
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
        let pdf = page.paper().to_pdf().expect("a paper");
        for file in [html.as_bytes(), &pdf] {
            assert_eq!(check_certificate(file, &certificate.public_key).expect("genuine"), statement);
        }
        page.paper().assert_says_the_same(&html, &["The file of this page", "A statement signed by"]);
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
