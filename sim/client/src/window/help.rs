//! Help on moving and viewing the needle, before and during an attempt.

use eframe::egui::{self, RichText, Ui};

/// Keys and gestures that move the needle of a virtual hand, and their effects.
const MOVES: [(&str, &str); 4] = [
    (sentence!("wheel, drag, ↓ ↑"), sentence!("needle in and out: 0.75 mm per wheel notch, shift slows the keys")),
    (sentence!("W A S D, shift + drag"), sentence!("move the needle sideways")),
    (sentence!("I J K L"), sentence!("tilt the needle")),
    (sentence!("space"), sentence!("confirm the position")),
];
/// Keys that work with every device.
const LOOKS: [(&str, &str); 5] = [
    (sentence!("1 2 3 4, right drag, 0"), sentence!("view, rotate, reset")),
    (sentence!("G"), sentence!("planned line")),
    (sentence!("F11"), sentence!("full screen")),
    (sentence!("ctrl +, ctrl −"), sentence!("larger and smaller text")),
    (sentence!("F3"), sentence!("timing of computer and device")),
];
/// The same on one line, for the picture.
pub const IN_A_LINE: &str =
    sentence!("wheel or ↓ ↑: in, out · W A S D: sideways · I J K L: tilt · space: confirm · F11: full screen");

/// Whether figures for the station's maintainer are shown: F3 shows and hides them on every page of
/// the window.
pub fn shows_figures(ui: &Ui) -> bool {
    let id = egui::Id::unique(module_path!());
    let pressed = ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::F3));
    ui.ctx().data_mut(|data| {
        let shown = data.get_temp_mut_or_default::<bool>(id);
        *shown ^= pressed;
        *shown
    })
}

/// Shows the help before an attempt.
pub fn how_to_move(ui: &mut Ui, by_hand: bool) {
    ui.label(RichText::new(tr!("How to move")).strong());
    if !by_hand {
        let handle = tr!(
            "The device's handle is the needle; its button confirms the position. Start with the handle where the \
             needle should begin."
        );
        ui.label(handle);
    }
    keys(ui, by_hand);
}

/// Shows the keys as a table.
pub fn keys(ui: &mut Ui, by_hand: bool) {
    let moves = MOVES.iter().filter(|_| by_hand);
    ui.spacing_mut().interact_size.y = 0.0;
    egui::Grid::new("keys").num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        for (key, what) in moves.chain(&LOOKS) {
            ui.label(RichText::new(words::say(key)).strong().small());
            ui.add(egui::Label::new(RichText::new(words::say(what)).small()).wrap());
            ui.end_row();
        }
    });
}
