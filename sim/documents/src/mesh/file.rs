//! Parses triangles from STL and OBJ files.

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::Path;

use law::structures::Surface;
use phrase::{Phrase, phrase};
use tobj::LoadOptions;

use super::Raw;
use super::text_stl::{join_solids, text_of};

/// Parses the triangles of a file; the extension of its name determines the format.
///
/// # Errors
/// If the format is unknown or the bytes are not valid in it.
pub(super) fn parse(name: &str, bytes: &[u8]) -> Result<Raw, Phrase> {
    let extension = Path::new(name).extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("stl") => stl(bytes).map_err(|why| phrase!("unreadable as STL ({why})", why = why)),
        Some("obj") => obj(bytes).map_err(|why| phrase!("unreadable as OBJ ({why})", why = why)),
        _ => {
            let ending = extension.display().to_string();
            Err(phrase!("a file that ends in \".{ending}\"", ending = ending))
        }
    }
}

/// Encodes a surface in m as a binary STL file in mm, without normals: readers compute them from
/// the vertices.
#[must_use]
pub fn write_stl((vertices_m, triangles): &Surface) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        let corners = triangle.iter().flat_map(|&v| vertices_m[v as usize].iter().copied());
        bytes.extend(corners.flat_map(|m| ((m * 1e3) as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn stl(bytes: &[u8]) -> Result<Raw, Phrase> {
    let text = text_of(bytes).map(|text| join_solids(&text)).transpose()?;
    let bytes = text.as_deref().map_or(bytes, str::as_bytes);
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(Phrase::data)?;
    Ok(Raw {
        corners: mesh.vertices.iter().map(|v| v.0).collect(),
        triangles: mesh.faces.iter().map(|f| f.vertices).collect(),
    })
}

/// Byte order marks of UTF-16.
const UTF_16: [[u8; 2]; 2] = [[0xff, 0xfe], [0xfe, 0xff]];

/// Parses all objects and groups of a file into one mesh; splits polygons into triangle fans.
fn obj(bytes: &[u8]) -> Result<Raw, Phrase> {
    if bytes.contains(&0) || UTF_16.iter().any(|mark| bytes.starts_with(mark)) {
        return Err(phrase!("not text"));
    }
    // Names and comments may use any code page; the parsed part is ASCII.
    let text = String::from_utf8_lossy(bytes);
    let shape = shape_of(text.strip_prefix('\u{feff}').unwrap_or(&text))?;
    let mut reader = Cursor::new(shape.as_bytes());
    let options = LoadOptions { triangulate: true, ..LoadOptions::default() };
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| Err(tobj::LoadError::MaterialParseError));
    let (models, _) = loaded.map_err(|error| match error {
        // Reported after the last line, for all faces together, so there is no line number.
        tobj::LoadError::FaceVertexOutOfBounds => phrase!("a face refers to a vertex that does not exist in the file"),
        error => {
            let line = shape[..reader.position() as usize].lines().count();
            phrase!("line {line}: {why}", line = line, why = Phrase::data(error))
        }
    })?;
    let mut raw = Raw { corners: Vec::new(), triangles: Vec::new() };
    for model in models {
        let first = raw.corners.len();
        let index = |at: u32| first + at as usize;
        raw.corners.extend(model.mesh.positions.as_chunks::<3>().0);
        raw.triangles.extend(model.mesh.indices.as_chunks::<3>().0.iter().map(|t| t.map(index)));
    }
    Ok(raw)
}

/// Returns an OBJ text's vertices and faces, positions only, on their original lines.
///
/// The other records do not affect the shape, and an error in them (a missing material, a texture
/// coordinate out of range) must not refuse a mesh.
fn shape_of(text: &str) -> Result<String, Phrase> {
    let mut shape = String::with_capacity(text.len());
    let (mut line, mut lines) = (String::new(), text.lines().enumerate().peekable());
    while let Some((at, part)) = lines.next() {
        line.push_str(part);
        // A line that ends in a backslash continues on the next, except comments, which may end in
        // a path.
        let goes_on = line.trim_end().ends_with('\\') && !line.trim_start().starts_with('#');
        if goes_on && lines.peek().is_some() {
            line.truncate(line.trim_end().len() - 1);
            line.push(' ');
            shape.push('\n');
            continue;
        }
        let whole = std::mem::take(&mut line);
        let mut words = whole.split_whitespace();
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("v") => {
                shape.push('v');
                words.take(3).for_each(|word| push(&mut shape, word));
            }
            Some("f") => {
                let corners = words.clone().count();
                if corners < 3 {
                    return Err(phrase!("line {line}: a face of {corners} corners", line = at + 1, corners = corners));
                }
                shape.push('f');
                words.for_each(|word| push(&mut shape, word.split('/').next().unwrap_or_default()));
            }
            _ => {}
        }
        shape.push('\n');
    }
    Ok(shape)
}

fn push(line: &mut String, word: &str) {
    // Writing to a string cannot fail.
    let _ = write!(line, " {word}");
}
