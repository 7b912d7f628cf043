//! The embedded fonts: which of them draws a character, and how wide a text is.

use std::cell::RefCell;
use std::collections::BTreeMap;

use harfrust::{FontRef, ShapeOptions, ShaperData, UnicodeBuffer};
use krilla::text::{Font, GlyphId, KrillaGlyph};

use super::PaperError;

/// Drawn in place of a character that no font has.
pub(super) const REPLACEMENT: char = '\u{25a1}';
/// The font for text; it is tried first.
const TEXT: usize = 0;
/// The font of fixed width.
const FIXED: usize = 1;
/// The font of emoji.
const EMOJI: usize = 2;
/// Fonts in the order in which a character is looked up: Latin, Greek and Cyrillic; more of these,
/// of fixed width; emoji.
const FILES: [&[u8]; 3] =
    [epaint_default_fonts::UBUNTU_LIGHT, epaint_default_fonts::HACK_REGULAR, epaint_default_fonts::NOTO_EMOJI_REGULAR];

/// The fonts of a paper.
pub(super) struct Fonts {
    faces: Vec<Face>,
    /// Shaped texts: words and letters recur, and shaping is the slow part of a paper.
    shaped: RefCell<BTreeMap<(bool, String), Shaped>>,
}

/// A font, for measuring and for writing.
struct Face {
    font: FontRef<'static>,
    shaper: ShaperData,
    written: Font,
}

/// A text as glyphs.
#[derive(Clone, Debug, Default)]
pub(super) struct Shaped {
    /// Parts with one font each, from left to right.
    pub runs: Vec<FontRun>,
    /// Whether no font has some of its characters.
    pub replaced: bool,
}

/// Part of a text in one font.
#[derive(Clone, Debug)]
pub(super) struct FontRun {
    /// Index of the font.
    pub face: usize,
    /// The text that the glyphs show.
    pub text: String,
    /// Its glyphs; lengths in em.
    pub glyphs: Vec<KrillaGlyph>,
}

impl FontRun {
    /// Width in em.
    pub(super) fn width(&self) -> f32 {
        self.glyphs.iter().map(|glyph| glyph.x_advance).sum()
    }
}

impl Shaped {
    /// Width in em.
    pub(super) fn width(&self) -> f32 {
        self.runs.iter().map(FontRun::width).sum()
    }
}

impl Fonts {
    /// Reads the fonts.
    ///
    /// # Errors
    /// If one cannot be read.
    pub(super) fn load() -> Result<Self, PaperError> {
        let faces: Option<Vec<Face>> = FILES.into_iter().map(Face::load).collect();
        let faces = faces.ok_or_else(|| PaperError("fonts".to_owned()))?;
        Ok(Self { faces, shaped: RefCell::default() })
    }

    /// Returns the font by its index, for writing.
    pub(super) fn written(&self, face: usize) -> Font {
        self.faces[face].written.clone()
    }

    /// Shapes one line of text.
    pub(super) fn shape(&self, text: &str, fixed: bool) -> Shaped {
        let key = (fixed, text.to_owned());
        if let Some(known) = self.shaped.borrow().get(&key) {
            return known.clone();
        }
        let shaped = self.shape_anew(text, fixed);
        self.shaped.borrow_mut().insert(key, shaped.clone());
        shaped
    }

    fn shape_anew(&self, text: &str, fixed: bool) -> Shaped {
        let first = if fixed { FIXED } else { TEXT };
        let visible: String = text.chars().filter(|c| !is_ignorable(*c)).map(as_drawn).collect();
        let run = self.faces[first].shape(first, &visible);
        if run.glyphs.iter().all(is_known) {
            return Shaped { runs: vec![run], replaced: false };
        }
        let parts = self.split_by_font(&visible, first);
        let replaced = parts.iter().any(|(face, _)| face.is_none());
        let shape = |(face, part): (Option<usize>, String)| match face {
            Some(face) => self.faces[face].shape(face, &part),
            None => self.faces[FIXED].replace(FIXED, part),
        };
        Shaped { runs: parts.into_iter().map(shape).collect(), replaced }
    }

    /// Returns the parts of a text with the font of each; `None` if no font has its characters.
    fn split_by_font(&self, text: &str, first: usize) -> Vec<(Option<usize>, String)> {
        let mut parts: Vec<(Option<usize>, String)> = Vec::new();
        for c in text.chars() {
            let face = self.find_face(c, first);
            match parts.last_mut() {
                Some((last, part)) if *last == face => part.push(c),
                _ => parts.push((face, c.to_string())),
            }
        }
        parts
    }

    /// Returns the first font that has the character.
    fn find_face(&self, c: char, first: usize) -> Option<usize> {
        let order = [first, TEXT, FIXED, EMOJI];
        let has = |face: &usize| self.faces[*face].shape(*face, c.encode_utf8(&mut [0; 4])).glyphs.iter().all(is_known);
        order.into_iter().filter(|_| !is_undefined(c)).find(has)
    }
}

impl Face {
    fn load(file: &'static [u8]) -> Option<Self> {
        let font = FontRef::new(file).ok()?;
        let shaper = ShaperData::new(&font);
        Some(Self { font, shaper, written: Font::new(file.into(), 0)? })
    }

    /// Draws [`REPLACEMENT`] for each character; the text that can be copied stays, where it is defined.
    fn replace(&self, face: usize, text: String) -> FontRun {
        let boxed = self.shape(face, REPLACEMENT.encode_utf8(&mut [0; 4])).glyphs;
        let text: String = text.chars().map(|c| if is_undefined(c) { REPLACEMENT } else { c }).collect();
        let glyph = |(start, c): (usize, char)| {
            boxed.iter().map(move |glyph| KrillaGlyph { text_range: start..start + c.len_utf8(), ..*glyph })
        };
        let glyphs = text.char_indices().flat_map(glyph).collect();
        FontRun { face, text, glyphs }
    }

    fn shape(&self, face: usize, text: &str) -> FontRun {
        let mut buffer = UnicodeBuffer::new();
        buffer.push_str(text);
        buffer.guess_segment_properties();
        let shaped = self.shaper.shaper(&self.font).build().shape(buffer, ShapeOptions::new());
        let em = self.written.units_per_em();
        let infos = shaped.glyph_infos();
        let mut starts: Vec<usize> = infos.iter().map(|info| info.cluster as usize).collect();
        starts.sort_unstable();
        let end_of = |start: usize| starts.iter().copied().find(|next| *next > start).unwrap_or(text.len());
        let glyphs = infos.iter().zip(shaped.glyph_positions()).map(|(info, position)| {
            let start = info.cluster as usize;
            KrillaGlyph::new(
                GlyphId::new(info.glyph_id),
                position.x_advance as f32 / em,
                position.x_offset as f32 / em,
                position.y_offset as f32 / em,
                0.0,
                start..end_of(start),
                None,
            )
        });
        FontRun { face, text: text.to_owned(), glyphs: glyphs.collect() }
    }
}

/// Returns whether a character has no meaning that is defined outside a font: for private use, and those
/// that never become characters. PDF/A-3a forbids them.
fn is_undefined(c: char) -> bool {
    matches!(c, '\u{e000}'..='\u{f8ff}' | '\u{fdd0}'..='\u{fdef}' | '\u{f0000}'..) || u32::from(c) & 0xfffe == 0xfffe
}

/// Returns whether the font has the glyph's character.
fn is_known(glyph: &KrillaGlyph) -> bool {
    glyph.glyph_id.to_u32() != 0
}

/// Returns whether a character has no picture of its own: joiners, variation selectors, and controls
/// that change the direction of the following text.
fn is_ignorable(c: char) -> bool {
    matches!(
        c,
        '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{180b}'..='\u{180f}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{fe00}'..='\u{fe0f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e0fff}'
    )
}

/// Control characters and line ends are drawn as spaces.
fn as_drawn(c: char) -> char {
    if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') { ' ' } else { c }
}
