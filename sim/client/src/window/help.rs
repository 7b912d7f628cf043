//! How the needle is moved and looked at: before an attempt and during it.

use eframe::egui::{self, RichText, Ui};

/// Keys and gestures that move the needle of a virtual hand, and what each does.
const MOVES: [(&str, &str); 4] = [
    ("wheel, drag, ↓ ↑", "needle in and out: a notch is 0.75 mm, shift makes keys slower"),
    ("W A S D, shift + drag", "needle aside"),
    ("I J K L", "lean the needle"),
    ("space", "confirm the position"),
];
/// What every device leaves to the keyboard.
const LOOKS: [(&str, &str); 4] = [
    ("1 2 3, right drag, 0", "view, turn it, back"),
    ("G", "planned line"),
    ("F11", "full screen"),
    ("ctrl +, ctrl −", "larger and smaller text"),
];
/// The same in a line, on the picture.
pub const IN_A_LINE: &str =
    "wheel or ↓ ↑: in, out · W A S D: aside · I J K L: lean · space: confirm · F11: full screen";

/// Before an attempt.
pub fn how_to_move(ui: &mut Ui, by_hand: bool) {
    ui.label(RichText::new("How to move").strong());
    if !by_hand {
        ui.label("The device's handle is the needle, its button confirms the position. Home it where the needle is to begin.");
    }
    keys(ui, by_hand);
}

/// The keys, as a table.
pub fn keys(ui: &mut Ui, by_hand: bool) {
    let moves = MOVES.iter().filter(|_| by_hand);
    ui.spacing_mut().interact_size.y = 0.0;
    egui::Grid::new("keys").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        for (key, what) in moves.chain(&LOOKS) {
            ui.label(RichText::new(*key).strong().small());
            ui.add(egui::Label::new(RichText::new(*what).small()).wrap());
            ui.end_row();
        }
    });
}
