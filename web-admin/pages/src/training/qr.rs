//! QR codes.

use std::fmt::Write;

use qrcodegen::{QrCode, QrCodeEcc};

/// Width of the quiet zone in modules, as the standard requires.
const MARGIN: i32 = 4;

/// Returns column and row of each dark module of a QR code, and its width in modules with the quiet
/// zone; `None` if the text is too long.
pub(super) fn dark_modules(text: &str) -> Option<(Vec<[i32; 2]>, i32)> {
    let code = QrCode::encode_text(text, QrCodeEcc::Medium).ok()?;
    let size = code.size();
    let all = (0..size).flat_map(|y| (0..size).map(move |x| [x, y]));
    let dark = all.filter(|[x, y]| code.get_module(*x, *y)).map(|[x, y]| [x + MARGIN, y + MARGIN]);
    Some((dark.collect(), size + 2 * MARGIN))
}

/// Draws a QR code as SVG, always dark on light, also in dark mode; `None` if the text is too long.
#[must_use]
pub fn draw_qr_code(text: &str) -> Option<String> {
    let (modules, side) = dark_modules(text)?;
    let mut path = String::new();
    for [x, y] in modules {
        // Writing to a `String` cannot fail.
        let _ = write!(path, "M{x} {y}h1v1h-1z");
    }
    Some(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {side} {side}\" shape-rendering=\"crispEdges\">\
         <path fill=\"#fff\" d=\"M0 0h{side}v{side}H0z\"/><path fill=\"#000\" d=\"{path}\"/></svg>"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_dark_modules_on_a_light_ground_with_a_margin() {
        let picture = draw_qr_code("otpauth://totp/x").expect("a picture");
        // Version 2 has 25 modules per side; its first row begins with the seven modules of a
        // finder pattern.
        assert!(picture.contains("viewBox=\"0 0 33 33\"") && picture.contains("M0 0h33v33H0z"), "{picture}");
        let row = (4..=10).map(|x| format!("M{x} 4h1v1h-1z")).collect::<String>();
        assert!(picture.contains(&row) && !picture.contains("M11 4h"), "{picture}");
        assert_eq!(draw_qr_code(&"x".repeat(4000)), None);
    }
}
