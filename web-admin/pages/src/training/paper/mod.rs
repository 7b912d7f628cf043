//! Papers: certificates and transcripts as PDF.
//!
//! A page declares its paper as plain blocks; this module sets and writes them. The file is PDF/A-3a
//! (ISO 19005-3) and PDF/UA-1 (ISO 14289-1): tagged, with embedded fonts, language and title. The
//! same paper gives the same bytes.

mod draw;
mod fonts;
mod layout;
mod lines;
mod table;

use std::fmt;

use data_encoding::BASE64;
use time::OffsetDateTime;

/// A paper to keep and print, in one language.
#[derive(Clone, Debug, PartialEq)]
pub struct Paper {
    /// Title in the metadata, and at the foot of papers with several pages.
    pub title: String,
    /// Language as in BCP 47.
    pub language: &'static str,
    /// Time of creation.
    pub made_at: OffsetDateTime,
    /// Logo of the school.
    pub logo: Option<Logo>,
    /// Content, in reading order. The first heading has level 1.
    pub blocks: Vec<Block>,
    /// A file in the paper.
    pub attachment: Option<AttachedFile>,
}

/// Logo of a school.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Logo {
    /// Media type: PNG or JPEG.
    pub media_type: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

impl Logo {
    /// Returns the logo as a data URL.
    pub(crate) fn data_url(&self) -> String {
        format!("data:{};base64,{}", self.media_type, BASE64.encode(&self.bytes))
    }
}

/// A file in a paper, stored without compression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttachedFile {
    /// File name.
    pub name: &'static str,
    /// Media type.
    pub media_type: &'static str,
    /// Description for readers.
    pub description: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// A part of a paper.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    /// A heading of level 1 or 2.
    Heading(u16, String),
    /// A paragraph.
    Text(Style, String),
    /// A table; the first column heads its rows.
    Table(PaperTable),
    /// A QR code, with a paragraph next to it.
    Code {
        /// Content of the code.
        content: String,
        /// Description for those who cannot see it.
        alt: String,
        /// The paragraph.
        text: String,
    },
    /// A line to sign on, and below it the signatory's name and function.
    Signature {
        /// Name.
        name: String,
        /// Function; may be empty.
        function: String,
    },
}

/// A table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PaperTable {
    /// Columns.
    pub columns: Vec<PaperColumn>,
    /// Cells of each row, one per column.
    pub rows: Vec<Vec<String>>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PaperColumn {
    /// Its heading.
    pub title: String,
    /// Its share of the width; the sum over all columns is 100.
    pub percent: u8,
}

/// Style of a paragraph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Name of the school.
    School,
    /// Name of the person.
    Name,
    /// The main sentence.
    Lead,
    /// Text.
    Body,
    /// An important sentence.
    Strong,
    /// Explanations.
    Small,
    /// Digits to compare, in a font of fixed width.
    Digits,
}

/// Why a paper could not be written. A program error: no content of a paper causes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PaperError(String);

impl fmt::Display for PaperError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the paper cannot be written: {}", self.0)
    }
}

impl std::error::Error for PaperError {}

impl Paper {
    /// Writes the paper as PDF.
    ///
    /// # Errors
    /// If the fonts cannot be read, or the library rejects the file as not conforming.
    pub fn to_pdf(&self) -> Result<Vec<u8>, PaperError> {
        let fonts = fonts::Fonts::load()?;
        let logo = self.logo.as_ref().and_then(draw::read_logo);
        let mut layout = layout::lay_out(&self.blocks, logo.as_ref(), &fonts);
        if layout.replaced {
            let note = Block::text(Style::Small, replacement_note());
            layout = layout::lay_out(&[self.blocks.as_slice(), &[note]].concat(), logo.as_ref(), &fonts);
        }
        layout::number_sheets(&mut layout, &self.title, &fonts);
        draw::write_pdf(self, &layout, &fonts)
    }

    /// Returns all texts of the paper, in reading order.
    #[cfg(test)]
    pub(crate) fn texts(&self) -> Vec<&str> {
        self.blocks.iter().flat_map(Block::texts).collect()
    }

    /// Checks that the paper and the page have the same texts, without those of one of them alone.
    #[cfg(test)]
    pub(crate) fn assert_says_the_same(&self, html: &str, alone: &[&str]) {
        let page = scraper::Html::parse_document(html);
        let main = scraper::Selector::parse("main").expect("a selector");
        let main = page.select(&main).next().expect("the content");
        let shown: Vec<&str> = main.text().map(str::trim).filter(|text| !text.is_empty()).collect();
        let (shown_text, paper_text) = (shown.join(" "), self.texts().join(" "));
        let shared = |text: &&&str| !text.is_empty() && !alone.iter().any(|one| text.starts_with(one));
        for text in self.texts().iter().filter(shared) {
            assert!(shown_text.contains(*text), "{text:?} is on paper alone: {shown_text}");
        }
        for text in shown.iter().filter(shared) {
            assert!(paper_text.contains(*text), "{text:?} is on the page alone: {paper_text}");
        }
    }
}

/// States what the replacement glyph means.
fn replacement_note() -> String {
    tr!(
        "{sign} stands for a character that the fonts of this file lack. The text that can be copied from it is complete.",
        sign = fonts::REPLACEMENT
    )
}

impl Block {
    /// Returns a paragraph.
    #[must_use]
    pub fn text(style: Style, text: impl Into<String>) -> Self {
        Self::Text(style, text.into())
    }

    /// Returns whether there is nothing to set. A heading without a title does not conform to PDF/UA.
    fn is_blank(&self) -> bool {
        matches!(self, Self::Heading(_, text) | Self::Text(_, text) if text.trim().is_empty())
    }
}

#[cfg(test)]
impl Block {
    fn texts(&self) -> Vec<&str> {
        match self {
            Self::Heading(_, text) | Self::Text(_, text) | Self::Code { text, .. } => vec![text],
            Self::Table(table) => {
                let titles = table.columns.iter().map(|column| column.title.as_str());
                titles.chain(table.rows.iter().flatten().map(String::as_str)).collect()
            }
            Self::Signature { name, function } => vec![name, function],
        }
    }
}

#[cfg(test)]
mod tests;
