//! Writes sheets as PDF with their structure.

use std::num::NonZeroU16;

use krilla::color::rgb;
use krilla::configure::{Accessibility, Archival, ConfigurationBuilder};
use krilla::destination::XyzDestination;
use krilla::embed::{AssociationKind, EmbeddedFile, MimeType};
use krilla::geom::{Path, PathBuilder, Point, Rect, Size, Transform};
use krilla::image::Image;
use krilla::metadata::{DateTime, Metadata};
use krilla::outline::{Outline, OutlineNode};
use krilla::page::PageSettings;
use krilla::paint::Fill;
use krilla::surface::Surface;
use krilla::tagging::{
    Artifact, ArtifactType, BBox, ContentTag, Identifier, Node, SpanTag, TableHeaderScope, Tag, TagGroup, TagKind,
    TagTree,
};
use krilla::{Document, SerializeSettings};
use time::OffsetDateTime;

use super::fonts::{Fonts, Shaped};
use super::layout::{Ink, Layout, PartRole, SHEET_HEIGHT, SHEET_WIDTH, SheetMark, TaggedPart, TextLook};
use super::{AttachedFile, Logo, Paper, PaperError};
use crate::training::qr;

/// Identifiers of the marks of each leaf.
type Leaves = Vec<Vec<Identifier>>;

/// Writes a paper.
///
/// # Errors
/// If the file would not conform to PDF/A-3a and PDF/UA-1.
pub(super) fn write_pdf(paper: &Paper, layout: &Layout, fonts: &Fonts) -> Result<Vec<u8>, PaperError> {
    let configuration = ConfigurationBuilder::new()
        .with_archival_validator(Archival::A3_A)
        .with_accessibility_validator(Accessibility::UA1)
        .finish()
        .map_err(|error| PaperError(format!("{error:?}")))?;
    let mut document = Document::new_with(SerializeSettings { configuration, ..SerializeSettings::default() });
    let mut leaves: Leaves = vec![Vec::new(); layout.leaves];
    let settings = PageSettings::from_wh(SHEET_WIDTH, SHEET_HEIGHT).unwrap_or_default();
    for sheet in &layout.sheets {
        let mut page = document.start_page_with(settings.clone());
        let mut surface = page.surface();
        for mark in sheet {
            draw_mark(&mut surface, mark, fonts, &mut leaves);
        }
    }
    document.set_outline(outline_of(layout));
    document.set_tag_tree(tree_of(layout, leaves, paper.language));
    document.set_metadata(metadata_of(paper));
    if let Some(file) = paper.attachment.as_ref().and_then(|file| embedded(file, paper.made_at)) {
        document.embed_file(file);
    }
    document.finish().map_err(|error| PaperError(format!("{error:?}")))
}

/// Reads a logo; a file that is neither PNG nor JPEG is left out.
pub(super) fn read_logo(logo: &Logo) -> Option<Image> {
    let file = logo.bytes.clone().into();
    match logo.media_type.as_str() {
        "image/png" => Image::from_png(file, false).ok(),
        "image/jpeg" => Image::from_jpeg(file, false).ok(),
        _ => None,
    }
}

fn metadata_of(paper: &Paper) -> Metadata {
    Metadata::new()
        .title(paper.title.clone())
        .language(paper.language.to_owned())
        .creator("Stylet".to_owned())
        .creation_date(date_of(paper.made_at))
}

fn date_of(at: OffsetDateTime) -> DateTime {
    let at = at.to_utc();
    DateTime::new(at.year().clamp(0, 9999) as u16)
        .month(at.month().into())
        .day(at.day())
        .hour(at.hour())
        .minute(at.minute())
        .second(at.second())
        .utc_offset_hour(0)
}

fn embedded(file: &AttachedFile, made_at: OffsetDateTime) -> Option<EmbeddedFile> {
    Some(EmbeddedFile {
        path: file.name.to_owned(),
        mime_type: Some(MimeType::new(file.media_type)?),
        description: Some(file.description.clone()),
        association_kind: AssociationKind::Data,
        data: file.bytes.clone().into(),
        modification_date: Some(date_of(made_at)),
        compress: Some(false),
        location: None,
    })
}

fn outline_of(layout: &Layout) -> Outline {
    let mut outline = Outline::new();
    for (text, sheet, y) in &layout.headings {
        outline.push_child(OutlineNode::new(text.clone(), XyzDestination::new(*sheet, Point::from_xy(0.0, *y))));
    }
    outline
}

fn draw_mark(surface: &mut Surface<'_>, mark: &SheetMark, fonts: &Fonts, leaves: &mut Leaves) {
    match mark {
        SheetMark::Text { x, y, look, shaped, leaf } => {
            let tag = match leaf {
                Some(_) => ContentTag::Span(SpanTag::empty()),
                None => ContentTag::Artifact(Artifact::with_kind(ArtifactType::Footer)),
            };
            let id = surface.start_tagged(tag);
            draw_text(surface, [*x, *y], *look, shaped, fonts);
            surface.end_tagged();
            keep(leaves, *leaf, id);
        }
        SheetMark::Bar { x, y, width, height, ink } => {
            surface.start_tagged(ContentTag::Artifact(Artifact::with_kind(ArtifactType::Other)));
            fill(surface, *ink);
            if let Some(path) = rectangles([[*x, *y, *width, *height]]) {
                surface.draw_path(&path);
            }
            surface.end_tagged();
        }
        SheetMark::Picture { x, y, size: [width, height], image } => {
            surface.start_tagged(ContentTag::Artifact(Artifact::with_kind(ArtifactType::Other)));
            if let Some(size) = Size::from_wh(*width, *height) {
                surface.push_transform(&Transform::from_translate(*x, *y));
                surface.draw_image(image.clone(), size);
                surface.pop();
            }
            surface.end_tagged();
        }
        SheetMark::Code { x, y, side, content, leaf } => {
            let id = surface.start_tagged(ContentTag::Other);
            fill(surface, Ink::Dark);
            if let Some(path) = qr_path(content, [*x, *y], *side) {
                surface.draw_path(&path);
            }
            surface.end_tagged();
            keep(leaves, Some(*leaf), id);
        }
    }
}

/// Appends an identifier to its leaf.
fn keep(leaves: &mut Leaves, leaf: Option<usize>, id: Identifier) {
    if let Some(ids) = leaf.and_then(|leaf| leaves.get_mut(leaf)) {
        ids.push(id);
    }
}

fn draw_text(surface: &mut Surface<'_>, [x, y]: [f32; 2], look: TextLook, shaped: &Shaped, fonts: &Fonts) {
    fill(surface, look.ink);
    let mut at = x;
    for run in &shaped.runs {
        let font = fonts.written(run.face);
        surface.draw_glyphs(Point::from_xy(at, y), &run.glyphs, font, &run.text, look.size, false);
        at += run.width() * look.size;
    }
}

fn fill(surface: &mut Surface<'_>, ink: Ink) {
    let [red, green, blue] = match ink {
        Ink::Dark => [0x17, 0x26, 0x2e],
        Ink::Muted => [0x51, 0x63, 0x6c],
        Ink::Accent => [0x0b, 0x64, 0x78],
        Ink::Line => [0xc4, 0xd0, 0xd5],
    };
    surface.set_fill(Some(Fill { paint: rgb::Color::new(red, green, blue).into(), ..Fill::default() }));
}

/// Returns rectangles, each by left, top, width and height, as one path.
fn rectangles(all: impl IntoIterator<Item = [f32; 4]>) -> Option<Path> {
    let mut path = PathBuilder::new();
    for [x, y, width, height] in all {
        path.push_rect(Rect::from_xywh(x, y, width, height)?);
    }
    path.finish()
}

fn qr_path(content: &str, [x, y]: [f32; 2], side: f32) -> Option<Path> {
    let (modules, across) = qr::dark_modules(content)?;
    let unit = side / across as f32;
    rectangles(modules.into_iter().map(|[column, row]| [x + column as f32 * unit, y + row as f32 * unit, unit, unit]))
}

fn tree_of(layout: &Layout, mut leaves: Leaves, language: &str) -> TagTree {
    let mut tree = TagTree::new().with_lang(Some(language.to_owned()));
    for part in &layout.parts {
        for node in nodes_of(part, &mut leaves) {
            tree.push(node);
        }
    }
    tree
}

fn nodes_of(part: &TaggedPart, leaves: &mut Leaves) -> Vec<Node> {
    match part {
        TaggedPart::Leaf(leaf) => std::mem::take(&mut leaves[*leaf]).into_iter().map(Node::Leaf).collect(),
        TaggedPart::Group(role, parts) => {
            let children = parts.iter().flat_map(|part| nodes_of(part, leaves)).collect();
            vec![Node::Group(TagGroup::with_children(tag_of(role), children))]
        }
    }
}

fn tag_of(role: &PartRole) -> TagKind {
    match role {
        PartRole::Heading(level, title) => {
            Tag::Hn(NonZeroU16::new(*level).unwrap_or(NonZeroU16::MIN), Some(title.clone())).into()
        }
        PartRole::Paragraph => Tag::P.into(),
        PartRole::Table => Tag::Table.into(),
        PartRole::TableHead => Tag::THead.into(),
        PartRole::TableBody => Tag::TBody.into(),
        PartRole::Row => Tag::TR.into(),
        PartRole::ColumnHeading => Tag::TH(TableHeaderScope::Column).into(),
        PartRole::RowHeading => Tag::TH(TableHeaderScope::Row).into(),
        PartRole::Cell => Tag::TD.into(),
        PartRole::Figure { alt, sheet, corner: [x, y], side } => {
            let area = Rect::from_xywh(*x, *y, *side, *side).map(|rect| BBox::new(*sheet, rect));
            Tag::Figure(Some(alt.clone())).with_bbox(area).into()
        }
    }
}
