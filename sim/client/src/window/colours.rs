//! The window's look: distinguishable colours that are readable on its dark background (WCAG
//! contrast above 4.5), and its fonts.

use eframe::egui::{Color32, Context, FontDefinitions, FontFamily, Margin, Stroke, Style, TextStyle, Theme};

/// Success.
pub const GOOD: Color32 = Color32::from_rgb(122, 204, 138);
/// A warning.
pub const WARN: Color32 = Color32::from_rgb(240, 190, 96);
/// An error or a failure.
pub const BAD: Color32 = Color32::from_rgb(255, 138, 128);
/// Force.
pub const FORCE: Color32 = Color32::from_rgb(120, 190, 255);
/// Background of panels.
const GROUND: Color32 = Color32::from_rgb(24, 29, 34);
/// Text, and secondary text.
const TEXT: Color32 = Color32::from_rgb(222, 228, 233);
const WEAK: Color32 = Color32::from_rgb(164, 174, 182);

/// Applies the colours and fonts to the window.
pub fn apply_colours(context: &Context) {
    context.set_theme(Theme::Dark);
    context.set_fonts(window_fonts());
    context.style_mut_of(Theme::Dark, adjust_style);
}

/// The proportional fonts lack arrows and dots, which come from the monospaced one.
fn window_fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    if let Some(family) = fonts.families.get_mut(&FontFamily::Proportional) {
        family.insert(1.min(family.len()), "Hack".to_owned());
    }
    fonts
}

fn adjust_style(style: &mut Style) {
    style.visuals.panel_fill = GROUND;
    style.visuals.window_fill = GROUND;
    style.visuals.override_text_color = Some(TEXT);
    style.visuals.weak_text_color = Some(WEAK);
    style.visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(58, 66, 74));
    style.spacing.button_padding = [12.0, 7.0].into();
    style.spacing.item_spacing = [8.0, 6.0].into();
    style.spacing.window_margin = Margin::same(16);
    for (text, size) in
        [(TextStyle::Body, 14.5), (TextStyle::Button, 14.5), (TextStyle::Small, 12.0), (TextStyle::Heading, 26.0)]
    {
        if let Some(font) = style.text_styles.get_mut(&text) {
            font.size = size;
        }
    }
}

#[cfg(test)]
mod tests {
    //! Fails if the fonts lack a sign, which would be drawn as an empty box.

    use eframe::egui::{FontId, RawInput};

    use super::*;

    #[test]
    fn every_sign_has_a_glyph() {
        let context = Context::default();
        apply_colours(&context);
        context.run_ui(RawInput::default(), |_| ()).textures_delta.clear();
        for sign in "●○▲×→←↑↓−·•°²µ…äöüÄÖÜßéñç€–„“”’½±≤≥".chars() {
            let there = context.fonts_mut(|fonts| fonts.has_glyph(&FontId::proportional(14.0), sign));
            assert!(there, "{sign}");
        }
    }
}
