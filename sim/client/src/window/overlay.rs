//! The instruments next to and on the picture of an attempt. Every colour has a second cue: a word,
//! a sign or a place.

use attempt::needle_axis;
use documents::{Channel, Feedback, name_structure};
use eframe::egui::{
    self, Align, Align2, Color32, FontId, Layout, Painter, Pos2, ProgressBar, Rect, Response, RichText, ScrollArea, Ui,
};
use egui_plot::{Line, Plot, PlotPoints, VLine};
use haptics::safety;
use haptics::scaling::{FELT_POP_N, ScaledBoundary, Scaling};
use haptics::servo::{Priority, Snapshot, flags as servo_flags};
use law::Skin;
use recording::{EventKind, Sample};
use render::Quality;
use render::camera::Camera;
use words::fixed;

use super::choose::own_words;
use super::plots::say_mark;
use super::sound::Sound;
use super::{colours, help};
use crate::live::{AttemptView, Live, LiveTrial, Phase, SpokenEvent, given};

/// Width of the instruments, in points.
const SIDE: f32 = 300.0;
/// Time for which a message is shown, in s.
const STAYS_S: f64 = 6.0;
/// Maximum number of messages on the screen.
const MOST_SAID: usize = 4;

/// The input of the instruments.
pub struct Instruments<'a> {
    /// The attempt so far.
    pub shown: &'a AttemptView,
    /// The servo's latest tick.
    pub latest: Option<&'a Snapshot>,
    /// The attempt in progress.
    pub live: &'a Live,
    /// The picture's level of quality.
    pub quality: Quality,
    /// Reasons why other devices were not used.
    pub passed_over: &'a [String],
    /// Whether mouse and keyboard move the needle.
    pub by_hand: bool,
}

impl Instruments<'_> {
    /// Returns the feedback given to the trainee.
    fn feedback(&self) -> Feedback {
        self.live.trial.bundle.exercise.feedback
    }
}

/// Shows the instruments at the side; returns true if the user ends the attempt.
pub fn show_side_panel(ui: &mut Ui, instruments: &Instruments<'_>, sound: &mut Sound) -> bool {
    let panel = egui::Panel::right("instruments").exact_size(SIDE).resizable(false);
    panel
        .show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| instruments_ui(ui, instruments, sound)).inner
        })
        .inner
}

fn instruments_ui(ui: &mut Ui, instruments: &Instruments<'_>, sound: &mut Sound) -> bool {
    let feedback = instruments.feedback();
    ui.add_space(8.0);
    show_elapsed_time(ui, instruments.shown);
    if feedback.gives(Channel::Readings) {
        ui.separator();
        show_readings(ui, instruments);
        plot_force_trace(ui, instruments.shown);
    }
    ui.separator();
    show_device_state(ui, instruments);
    ui.separator();
    if feedback.gives(Channel::Sound) {
        ui.checkbox(&mut sound.on, tr!("Sound of pops (M)"));
        if ui.input(|input| input.key_pressed(egui::Key::M)) {
            sound.on = !sound.on;
        }
    }
    let end = ui.button(tr!("End the attempt (Esc)")).clicked();
    ui.add_space(6.0);
    egui::CollapsingHeader::new(tr!("Keys"))
        .id_salt("keys")
        .default_open(false)
        .show(ui, |ui| help::keys(ui, instruments.by_hand));
    end || ui.input(|input| input.key_pressed(egui::Key::Escape))
}

fn show_elapsed_time(ui: &mut Ui, shown: &AttemptView) {
    let left_s = shown.left_s();
    let colour = if left_s < 15.0 { colours::WARN } else { ui.visuals().strong_text_color() };
    let (minutes, seconds) = ((left_s / 60.0).floor(), left_s % 60.0);
    let time = words::decimal(&format!("{minutes:.0}:{seconds:04.1}"));
    let left = if left_s < 15.0 { tr!("{time} left – hurry", time = time) } else { tr!("{time} left", time = time) };
    ui.label(RichText::new(left).size(20.0).color(colour));
    let doing = match shown.phase {
        Phase::Approach => tr!("Move to the entry point and insert the needle."),
        Phase::Inside => tr!("At the target, confirm (space), then withdraw."),
        Phase::Confirmed => tr!("Confirmed. Withdraw the needle."),
        Phase::Withdrawn => tr!("Done."),
        Phase::TimeUp => tr!("Time is up."),
    };
    ui.label(doing);
}

fn show_readings(ui: &mut Ui, Instruments { shown, latest, live, .. }: &Instruments<'_>) {
    let sample = &shown.moment.sample;
    let exercise = &live.trial.bundle.exercise;
    show_big_value(
        ui,
        tr!("Advance"),
        &format!("{} mm", fixed(sample.x_m * 1e3, 1)),
        &tr!("target {depth}", depth = fixed(exercise.target_depth_mm, 1)),
    );
    // Pushing against tissue that only deforms increases the advance, but not the depth.
    let depth = format!("{} mm", fixed(f64::from(sample.depth_m) * 1e3, 1));
    show_big_value(ui, tr!("Depth"), &depth, &words::phrase(&shown.place()));
    let force_n = latest.map_or(shown.hand_n, |latest| latest.output.hand_n);
    show_big_value(ui, tr!("Force"), &format!("{} N", fixed(force_n, 2)), tr!("along the needle"));
    if let (Some(latest), false) = (latest, live.info.is_virtual) {
        let beside = tr!("of {force} N intended", force = fixed(latest.owed_n.norm(), 2));
        show_big_value(ui, tr!("Hand"), &format!("{} N", fixed(given::given_n(&latest.record), 2)), &beside);
    }
    draw_force_gauge(ui, force_n.abs(), live.scaling.peak_n);
    let lean = angle_deg(&exercise.skin_shape, sample);
    let planned = tr!("planned {angle}°", angle = fixed(exercise.angle_deg, 0));
    show_big_value(ui, tr!("Angle"), &format!("{}°", fixed(lean, 0)), &planned);
}

/// Draws a force in N as a bar, relative to the largest expected force.
fn draw_force_gauge(ui: &mut Ui, force_n: f64, peak_n: f64) {
    /// Width of the number at its end, in points.
    const END: f32 = 48.0;
    let most_n = 1.2 * peak_n.max(1.0);
    let share = (force_n / most_n).clamp(0.0, 1.0) as f32;
    let fill = if force_n > peak_n { colours::WARN } else { colours::FORCE };
    ui.horizontal(|ui| {
        let width = ui.available_width() - END;
        ui.add(ProgressBar::new(share).fill(fill).corner_radius(2).desired_height(12.0).desired_width(width));
        ui.label(RichText::new(format!("{} N", fixed(most_n, 1))).weak().small());
    });
}

fn show_big_value(ui: &mut Ui, name: &str, value: &str, beside: &str) {
    ui.horizontal(|ui| {
        ui.allocate_ui_with_layout([60.0, 26.0].into(), Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(60.0);
            ui.label(name);
        });
        ui.label(RichText::new(value).size(22.0).strong());
        ui.add(egui::Label::new(RichText::new(beside).weak()).truncate());
    });
}

/// Returns the angle of the needle to the skin's normal at its tip, in degrees.
fn angle_deg(skin: &Skin, sample: &Sample) -> f64 {
    let inwards = -skin.outward(&sample.position_m.into());
    libm::acos(needle_axis(sample).dot(&inwards).clamp(-1.0, 1.0)).to_degrees()
}

fn plot_force_trace(ui: &mut Ui, shown: &AttemptView) {
    let now_s = shown.moment.sample.t_s;
    let points: PlotPoints<'_> = shown.trace.iter().map(|point| [point.t_s - now_s, point.force_n]).collect();
    let pops = shown.said.iter().filter(|said| is_pop(said) && now_s - said.t_s < 10.0);
    let plot = Plot::new("force").height(130.0).include_x(-10.0).include_x(0.0).include_y(0.0).include_y(2.0);
    let plot = plot.allow_drag(false).allow_zoom(false).allow_scroll(false).allow_boxed_zoom(false).show_x(false);
    let plot = plot.x_axis_formatter(say_mark).y_axis_formatter(say_mark);
    plot.x_axis_label("s").y_axis_label(tr!("force, N")).show(ui, |plot| {
        plot.line(Line::new(tr!("force"), points).color(colours::FORCE).width(2.0));
        for pop in pops {
            plot.vline(VLine::new(tr!("pop"), pop.t_s - now_s).color(colours::WARN));
        }
    });
}

fn is_pop(said: &SpokenEvent) -> bool {
    said.kind.contactor().is_some()
}

/// Shows the scaling of the forces, and the boundaries that the device cannot show unchanged.
fn show_scaling(ui: &mut Ui, scaling: &Scaling) -> Response {
    let shown = ui.label(words::phrase(&scaling.phrase()));
    let names = |boundaries: Vec<&ScaledBoundary>| {
        let names = boundaries.into_iter().map(|boundary| words::phrase(&name_structure(&boundary.name)));
        names.collect::<Vec<_>>().join(", ")
    };
    let (softened, unfelt) = (names(scaling.softened().collect()), names(scaling.unfelt().collect()));
    if !softened.is_empty() {
        ui.label(RichText::new(tr!("softer than in the scene: {layers}", layers = softened)).weak().small());
    }
    if !unfelt.is_empty() {
        let least = fixed(FELT_POP_N, 1);
        let words = tr!("pops below {least} N, barely perceptible: {layers}", least = least, layers = unfelt);
        ui.label(RichText::new(words).color(colours::WARN).small());
    }
    shown
}

/// Shows the state of the device.
fn show_device_state(ui: &mut Ui, instruments: &Instruments<'_>) {
    let Instruments { latest, live, passed_over, .. } = instruments;
    let name = ui.label(RichText::new(words::known(&live.trial.session.device)).strong());
    if !passed_over.is_empty() {
        name.on_hover_text(passed_over.join("\n"));
    }
    let feedback = live.trial.bundle.exercise.feedback;
    match (feedback.gives(Channel::Force), live.info.is_virtual) {
        (false, _) => ui.label(tr!("no force in this exercise")),
        (true, true) => ui.label(tr!("it has no force feedback")),
        (true, false) => show_scaling(ui, &live.scaling),
    };
    if !live.info.measures_orientation {
        ui.label(tr!("it does not report its orientation: the needle points as planned"));
    }
    if let Some(latest) = latest {
        let troubles = safety_troubles(latest.record.flags);
        if troubles.is_empty() {
            ui.colored_label(colours::GOOD, format!("● {}", tr!("OK")));
        } else {
            ui.colored_label(colours::WARN, format!("▲ {}", troubles.join(", ")));
        }
        if latest.dropped > 0 {
            ui.colored_label(
                colours::BAD,
                format!(
                    "× {}",
                    trn!("{n} tick could not be recorded", "{n} ticks could not be recorded", latest.dropped)
                ),
            );
        }
    }
    if help::shows_figures(ui) {
        show_figures(ui, instruments);
    }
}

/// Shows the servo's timing and the picture's quality.
fn show_figures(ui: &mut Ui, Instruments { latest, live, quality, .. }: &Instruments<'_>) {
    if let Some(latest) = latest {
        let servo = tr!(
            "servo: lateness {late} µs (p99), compute {took} µs (p99.9), {stalls} stalls",
            late = fixed(latest.lateness.p99_us, 0),
            took = fixed(latest.compute.p999_us, 0),
            stalls = latest.stalls
        );
        ui.label(RichText::new(servo).weak().small());
    }
    if live.servo().priority() == Some(Priority::Ordinary) {
        ui.label(RichText::new(tr!("no real-time priority: see stylet doctor")).weak().small());
    }
    let (name, made) = (words::say(quality.name()), words::phrase(&quality.phrase()));
    ui.label(RichText::new(tr!("picture: {quality} ({made})", quality = name, made = made)).weak().small());
}

/// Describes the effects of the safety chain on the last tick.
pub fn safety_troubles(flags: u32) -> Vec<&'static str> {
    let all = [
        (safety::flags::HELD, tr!("invalid reading, last one used")),
        (safety::flags::GATED, tr!("force ramping up")),
        (safety::flags::CLAMPED, tr!("force at the device's limit")),
        (safety::flags::THERMAL, tr!("motors kept cool")),
        (safety::flags::WATCHDOG, tr!("force cut by the watchdog")),
        (safety::flags::NOT_FINITE, tr!("no valid number from the force law")),
        (servo_flags::CLUTCHED, tr!("clutch held")),
        (servo_flags::REFUSED, tr!("device rejects the force")),
        (servo_flags::DISAGREES, tr!("device reports a different force")),
    ];
    all.into_iter().filter(|(flag, _)| flags & flag != 0).map(|(_, words)| words).collect()
}

/// Whether an event is shown during the attempt.
fn is_told(kind: EventKind, feedback: Feedback) -> bool {
    match kind {
        EventKind::TipRupture | EventKind::RimRupture | EventKind::StructureHit => feedback.gives(Channel::Captions),
        EventKind::Coaching => feedback.gives(Channel::Coaching),
        EventKind::Contact
        | EventKind::HubContact
        | EventKind::SkinExit
        | EventKind::Confirm
        | EventKind::Fault
        | EventKind::Interrupted => true,
    }
}

/// Shows the recent messages at the bottom.
pub fn show_messages(ui: &mut Ui, shown: &AttemptView, feedback: Feedback) {
    let now_s = shown.moment.sample.t_s;
    let panel = egui::Panel::bottom("messages").exact_size(92.0).resizable(false);
    panel.show(ui, |ui| {
        if let Some(why) = &shown.refused {
            ui.colored_label(
                colours::BAD,
                format!("× {}", tr!("the disk cannot be written ({why}): the attempt continues in memory", why = why)),
            );
        }
        let fresh = shown.said.iter().rev().take_while(|said| now_s - said.t_s < STAYS_S);
        for (said, times) in count_repeats(fresh.filter(|said| is_told(said.kind, feedback))) {
            let (sign, colour) = event_sign(said.kind);
            let repeats = if times > 1 { format!("  ×{times}") } else { String::new() };
            let line = format!("{sign}  {}{repeats}", words::phrase(&said.text));
            ui.label(RichText::new(line).color(colour).size(15.0));
        }
    });
}

/// Returns the latest distinct messages, at most [`MOST_SAID`], each with its number of
/// repetitions.
fn count_repeats<'a>(said: impl Iterator<Item = &'a SpokenEvent>) -> Vec<(&'a SpokenEvent, usize)> {
    let mut counted: Vec<(&SpokenEvent, usize)> = Vec::new();
    for message in said {
        let is_same =
            |(known, _): &&mut (&SpokenEvent, usize)| (known.kind, &known.text) == (message.kind, &message.text);
        if let Some((_, times)) = counted.iter_mut().find(is_same) {
            *times += 1;
        } else if counted.len() < MOST_SAID {
            counted.push((message, 1));
        }
    }
    counted
}

/// Returns an event's sign, the second cue in addition to the colour, and its colour.
fn event_sign(kind: EventKind) -> (&'static str, Color32) {
    match kind {
        EventKind::Coaching | EventKind::HubContact => ("→", colours::WARN),
        EventKind::StructureHit | EventKind::Fault | EventKind::Interrupted => ("×", colours::BAD),
        EventKind::TipRupture | EventKind::RimRupture => ("○", colours::FORCE),
        EventKind::Confirm => ("●", colours::GOOD),
        EventKind::Contact | EventKind::SkinExit => ("·", Color32::LIGHT_GRAY),
    }
}

/// Draws the exercise's title and the feedback given to the trainee on the picture.
pub fn draw_heading(ui: &Ui, rect: Rect, Instruments { live, latest, by_hand, .. }: &Instruments<'_>) {
    /// Gap between two plates, in points.
    const GAP: egui::Vec2 = egui::vec2(0.0, 10.0);
    let exercise = &live.trial.bundle.exercise;
    let painter = ui.painter_at(rect);
    let title = draw_text_plate(
        &painter,
        rect.left_top() + egui::vec2(14.0, 10.0),
        Align2::LEFT_TOP,
        own_words(&exercise.title),
        18.0,
    );
    let views = if exercise.feedback.gives(Channel::Inside) {
        tr!("view: 1 block, 2 tip, 3 section, 4 patient")
    } else {
        words::say(exercise.feedback.in_words())
    };
    let views = draw_text_plate(&painter, title.left_bottom() + GAP, Align2::LEFT_TOP, views, 12.5);
    if *by_hand {
        draw_text_plate(&painter, views.left_bottom() + GAP, Align2::LEFT_TOP, words::say(help::IN_A_LINE), 12.5);
    }
    let felt = exercise.feedback.gives(Channel::Force) && !live.info.is_virtual;
    if let Some(why) = latest.filter(|_| felt).and_then(|latest| given::withheld(&latest.record, latest.let_through)) {
        let place = rect.center_top() + egui::vec2(0.0, 64.0);
        draw_text_plate(&painter, place, Align2::CENTER_TOP, &format!("▲ {}", words::phrase(&why)), 30.0);
    }
}

/// Draws the names of the layers into their bands in the section, next to the needle.
pub fn draw_layer_names(ui: &Ui, rect: Rect, camera: &Camera, trial: &LiveTrial) {
    /// Distance from the planned entry, in points; a needle leans to the right in its section.
    const BESIDE: f32 = 150.0;
    let painter = ui.painter_at(rect);
    let size = [rect.width(), rect.height()].map(|side| side as u32);
    let entry_m = trial.bundle.exercise.entry_m();
    let outward = trial.bundle.exercise.skin_shape.outward(&entry_m);
    let mut top_m = 0.0;
    for layer in &trial.specimen.spec().axial.layers {
        let middle_m = top_m + 0.5 * layer.thickness_m;
        top_m += layer.thickness_m;
        let place_m = entry_m - outward * middle_m;
        let place_m = [place_m.x, place_m.y, place_m.z].map(|c| c as f32);
        let [x, y] = camera.pixel(place_m.into(), size);
        draw_text_plate(
            &painter,
            rect.left_top() + egui::vec2(x - BESIDE, y),
            Align2::LEFT_CENTER,
            &words::phrase(&name_structure(&layer.name)),
            13.0,
        );
    }
}

/// Distance of text from the picture's edges, in points; longer text is wrapped.
const PLATE_MARGIN: f32 = 20.0;

/// Draws text of a size in points on a dark plate, which makes it readable on any picture.
fn draw_text_plate(painter: &Painter, at: Pos2, align: Align2, text: &str, size: f32) -> Rect {
    let width = painter.clip_rect().width() - 2.0 * PLATE_MARGIN;
    let text = painter.layout(text.to_owned(), FontId::proportional(size), Color32::WHITE, width);
    let rect = align.anchor_size(at, text.size());
    painter.rect_filled(rect.expand2([6.0, 3.0].into()), 4.0, Color32::from_black_alpha(150));
    painter.galley(rect.min, text, Color32::WHITE);
    rect
}

#[cfg(test)]
mod tests {
    //! Fails if a pop is named in an exercise with force alone, in which the hand has to find it.

    use EventKind::{Coaching, Confirm, Contact, Fault, RimRupture, SkinExit, StructureHit, TipRupture};
    use phrase::Phrase;
    use render::frame::Stage;

    use super::*;
    use crate::picture;

    #[test]
    fn a_message_that_repeats_takes_one_line() {
        let said = |t_s: f64, text: &'static str| SpokenEvent { t_s, kind: Coaching, text: Phrase::sentence(text) };
        let all = [said(1.0, "slower"), said(2.0, "straighter"), said(3.0, "slower"), said(4.0, "slower")];
        let counted = count_repeats(all.iter().rev());
        let told: Vec<(f64, usize)> = counted.iter().map(|(said, times)| (said.t_s, *times)).collect();
        assert_eq!(told, [(4.0, 3), (2.0, 1)]);
    }

    #[test]
    fn what_is_withheld_is_neither_said_nor_ringed() {
        let stage = Stage { target_m: Some([0.0; 3]), ..Stage::default() };
        for feedback in Feedback::ALL {
            let ringed = picture::hide_what_is_withheld(&stage, feedback).target_m.is_some();
            assert_eq!(ringed, feedback.gives(Channel::Target), "{feedback:?}");
            for kind in [TipRupture, RimRupture, StructureHit] {
                assert_eq!(is_told(kind, feedback), feedback.gives(Channel::Captions), "{kind:?} by {feedback:?}");
            }
            assert_eq!(is_told(Coaching, feedback), feedback.gives(Channel::Coaching), "{feedback:?}");
            assert!([Contact, SkinExit, Confirm, Fault].iter().all(|kind| is_told(*kind, feedback)));
        }
        assert!(
            !is_told(TipRupture, Feedback::Force)
                && picture::hide_what_is_withheld(&stage, Feedback::Force).target_m.is_none()
        );
    }
}
