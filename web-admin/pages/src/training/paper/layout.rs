//! Sets the blocks of a paper on sheets of A4. Lengths are in points, from the upper left corner.

use krilla::image::Image;

use super::fonts::{Fonts, Shaped};
use super::lines::break_lines;
use super::{Block, Style, table};

/// Width of A4.
pub(super) const SHEET_WIDTH: f32 = 595.28;
/// Height of A4.
pub(super) const SHEET_HEIGHT: f32 = 841.89;
/// Left and right margin.
pub(super) const MARGIN: f32 = 56.0;
/// Width of the text.
pub(super) const WIDTH: f32 = SHEET_WIDTH - 2.0 * MARGIN;
/// Top of the text.
pub(super) const TOP: f32 = 62.0;
/// Bottom of the text.
const BOTTOM: f32 = SHEET_HEIGHT - 62.0;
/// Baseline of the footer.
const FOOT: f32 = SHEET_HEIGHT - 34.0;
/// Side of a QR code, with its margin: 34 mm.
const CODE_SIDE: f32 = 96.4;
/// Largest size of a logo: 50 mm by 20 mm.
const LOGO: [f32; 2] = [142.0, 56.7];
/// Upper end of the logo.
const LOGO_TOP: f32 = 58.0;
/// Space for a signature by hand.
const SIGNING_SPACE: f32 = 46.0;
/// Width of the line to sign on.
const SIGNING_WIDTH: f32 = 215.0;

/// A colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ink {
    /// Text.
    Dark,
    /// Explanations.
    Muted,
    /// Headings.
    Accent,
    /// Rules of tables.
    Line,
}

/// Size, line height and colour of a text, and the space around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TextLook {
    pub size: f32,
    pub leading: f32,
    pub ink: Ink,
    pub fixed: bool,
    pub before: f32,
    pub after: f32,
}

/// Something drawn on a sheet. `leaf` is its place in the structure; without one, it is decoration.
#[derive(Clone, Debug)]
pub(super) enum SheetMark {
    /// A line of text, from its baseline.
    Text { x: f32, y: f32, look: TextLook, shaped: Shaped, leaf: Option<usize> },
    /// A horizontal bar, from its upper left corner.
    Bar { x: f32, y: f32, width: f32, height: f32, ink: Ink },
    /// A picture, from its upper left corner.
    Picture { x: f32, y: f32, size: [f32; 2], image: Image },
    /// A QR code, from its upper left corner.
    Code { x: f32, y: f32, side: f32, content: String, leaf: usize },
}

/// A part of the structure.
#[derive(Clone, Debug)]
pub(super) enum TaggedPart {
    /// Marks with this number.
    Leaf(usize),
    /// Parts that belong together.
    Group(PartRole, Vec<TaggedPart>),
}

/// Role of a part.
#[derive(Clone, Debug)]
pub(super) enum PartRole {
    Heading(u16, String),
    Paragraph,
    Table,
    TableHead,
    TableBody,
    Row,
    ColumnHeading,
    RowHeading,
    Cell,
    Figure { alt: String, sheet: usize, corner: [f32; 2], side: f32 },
}

/// A paper on sheets.
#[derive(Debug, Default)]
pub(super) struct Layout {
    /// Marks of each sheet.
    pub sheets: Vec<Vec<SheetMark>>,
    /// The structure, in reading order.
    pub parts: Vec<TaggedPart>,
    /// Number of leaves in the structure.
    pub leaves: usize,
    /// Headings with sheet and height.
    pub headings: Vec<(String, usize, f32)>,
    /// Whether characters are missing in the fonts.
    pub replaced: bool,
    /// Upper end of the next block.
    pub y: f32,
    /// Size of the logo.
    logo: Option<[f32; 2]>,
}

/// Sets blocks on sheets.
pub(super) fn lay_out(blocks: &[Block], logo: Option<&Image>, fonts: &Fonts) -> Layout {
    let mut layout = Layout { sheets: vec![Vec::new()], y: TOP, ..Layout::default() };
    layout.put(SheetMark::Bar { x: MARGIN, y: 40.0, width: WIDTH, height: 5.6, ink: Ink::Accent });
    if let Some(image) = logo {
        layout.put_logo(image);
    }
    for block in blocks.iter().filter(|block| !block.is_blank()) {
        match block {
            Block::Heading(level, text) => layout.set_heading(*level, text, fonts),
            Block::Text(style, text) => layout.set_paragraph(text, style.look(), fonts),
            Block::Table(table) => table::set_table(&mut layout, table, fonts),
            Block::Code { content, alt, text } => layout.set_code(content, alt, text, fonts),
            Block::Signature { name, function } => layout.set_signature([name, function], fonts),
        }
    }
    layout
}

/// Writes title and page number at the foot of papers with several sheets.
pub(super) fn number_sheets(layout: &mut Layout, title: &str, fonts: &Fonts) {
    let all = layout.sheets.len();
    if all == 1 {
        return;
    }
    let look = Style::Small.look();
    for (at, sheet) in layout.sheets.iter_mut().enumerate() {
        let number = fonts.shape(&tr!("Page {n} of {all}", n = at + 1, all = all), false);
        let right = MARGIN + WIDTH - number.width() * look.size;
        sheet.push(SheetMark::Text { x: right, y: FOOT, look, shaped: number, leaf: None });
        let room = (WIDTH - 90.0) / look.size;
        let title = break_lines(fonts, title, false, room).into_iter().next().unwrap_or_default();
        sheet.push(SheetMark::Text { x: MARGIN, y: FOOT, look, shaped: title, leaf: None });
    }
}

impl Layout {
    /// Begins a new sheet unless there is room for `height`. Returns whether it did.
    pub(super) fn make_room(&mut self, height: f32) -> bool {
        let full = self.y + height > BOTTOM && self.y > TOP;
        if full {
            self.sheets.push(Vec::new());
            self.y = TOP;
        }
        full
    }

    /// Adds a mark to the current sheet.
    pub(super) fn put(&mut self, mark: SheetMark) {
        if let Some(sheet) = self.sheets.last_mut() {
            sheet.push(mark);
        }
    }

    /// Returns the number of a new leaf.
    pub(super) fn next_leaf(&mut self) -> usize {
        self.leaves += 1;
        self.leaves - 1
    }

    /// Draws a line of text whose upper end is `y`.
    pub(super) fn put_line(&mut self, [x, y]: [f32; 2], look: TextLook, shaped: Shaped, leaf: Option<usize>) {
        self.replaced |= shaped.replaced;
        // The baseline of these fonts is 0.8 em below the upper end of letters.
        let baseline = y + (look.leading - look.size) / 2.0 + 0.8 * look.size;
        self.put(SheetMark::Text { x, y: baseline, look, shaped, leaf });
    }

    fn put_logo(&mut self, image: &Image) {
        let (wide, high) = image.size();
        let scale = (LOGO[0] / wide.max(1) as f32).min(LOGO[1] / high.max(1) as f32);
        let size = [wide as f32 * scale, high as f32 * scale];
        self.put(SheetMark::Picture { x: MARGIN + WIDTH - size[0], y: LOGO_TOP, size, image: image.clone() });
        self.logo = Some(size);
    }

    /// Returns the width of text at the current height, next to the logo or below it.
    fn width(&self) -> f32 {
        match self.logo {
            Some([wide, high]) if self.sheets.len() == 1 && self.y < LOGO_TOP + high => WIDTH - wide - 12.0,
            _ => WIDTH,
        }
    }

    fn set_heading(&mut self, level: u16, text: &str, fonts: &Fonts) {
        let look = if level == 1 { TITLE } else { SECTION };
        // A heading does not stand alone at the end of a sheet.
        self.make_room(look.before + look.leading + look.after + 60.0);
        self.headings.push((text.to_owned(), self.sheets.len() - 1, self.y));
        self.set_text(PartRole::Heading(level, text.to_owned()), text, look, fonts);
    }

    fn set_paragraph(&mut self, text: &str, look: TextLook, fonts: &Fonts) {
        self.set_text(PartRole::Paragraph, text, look, fonts);
    }

    fn set_text(&mut self, role: PartRole, text: &str, look: TextLook, fonts: &Fonts) {
        self.y += look.before;
        let leaf = self.next_leaf();
        for line in break_lines(fonts, text, look.fixed, self.width() / look.size) {
            self.make_room(look.leading);
            self.put_line([MARGIN, self.y], look, line, Some(leaf));
            self.y += look.leading;
        }
        self.y += look.after;
        self.parts.push(TaggedPart::Group(role, vec![TaggedPart::Leaf(leaf)]));
    }

    fn set_code(&mut self, content: &str, alt: &str, text: &str, fonts: &Fonts) {
        self.make_room(CODE_SIDE);
        let [figure, paragraph] = [self.next_leaf(), self.next_leaf()];
        let (y, corner) = (self.y, [MARGIN, self.y]);
        let code = SheetMark::Code { x: MARGIN, y, side: CODE_SIDE, content: content.to_owned(), leaf: figure };
        self.put(code);
        let look = Style::Small.look();
        let left = MARGIN + CODE_SIDE + 12.0;
        let lines = break_lines(fonts, text, false, (WIDTH - CODE_SIDE - 12.0) / look.size);
        let high = lines.len() as f32 * look.leading;
        let mut at = y + ((CODE_SIDE - high) / 2.0).max(0.0);
        for line in lines {
            self.put_line([left, at], look, line, Some(paragraph));
            at += look.leading;
        }
        self.y += CODE_SIDE.max(high) + 8.0;
        let role = PartRole::Figure { alt: alt.to_owned(), sheet: self.sheets.len() - 1, corner, side: CODE_SIDE };
        self.parts.push(TaggedPart::Group(role, vec![TaggedPart::Leaf(figure)]));
        self.parts.push(TaggedPart::Group(PartRole::Paragraph, vec![TaggedPart::Leaf(paragraph)]));
    }

    fn set_signature(&mut self, lines: [&str; 2], fonts: &Fonts) {
        let look = Style::Body.look();
        self.make_room(SIGNING_SPACE + 3.0 * look.leading);
        self.y += SIGNING_SPACE;
        self.put(SheetMark::Bar { x: MARGIN, y: self.y, width: SIGNING_WIDTH, height: 0.6, ink: Ink::Dark });
        self.y += 4.0;
        for (text, ink) in lines.into_iter().zip([Ink::Dark, Ink::Muted]).filter(|(text, _)| !text.is_empty()) {
            self.set_text(PartRole::Paragraph, text, TextLook { ink, before: 0.0, after: 0.0, ..look }, fonts);
        }
        self.y += 14.0;
    }
}

/// Look of headings of level 1.
const TITLE: TextLook =
    TextLook { size: 15.0, leading: 20.0, ink: Ink::Accent, fixed: false, before: 18.0, after: 4.0 };
/// Look of headings of level 2.
const SECTION: TextLook =
    TextLook { size: 12.5, leading: 17.0, ink: Ink::Accent, fixed: false, before: 16.0, after: 3.0 };

impl Style {
    /// Returns how a paragraph of this style looks.
    pub(super) fn look(self) -> TextLook {
        let plain = TextLook { size: 10.5, leading: 15.0, ink: Ink::Dark, fixed: false, before: 0.0, after: 5.0 };
        match self {
            Self::School => TextLook { size: 13.0, leading: 18.0, after: 0.0, ..plain },
            Self::Name => TextLook { size: 25.0, leading: 31.0, after: 4.0, ..plain },
            Self::Lead => TextLook { size: 13.0, leading: 18.0, after: 12.0, ..plain },
            Self::Body => plain,
            Self::Strong => TextLook { size: 11.5, leading: 16.0, ..plain },
            Self::Small => TextLook { size: 9.0, leading: 12.5, ink: Ink::Muted, after: 4.0, ..plain },
            Self::Digits => TextLook { size: 8.5, leading: 12.5, fixed: true, after: 6.0, ..plain },
        }
    }
}
