//! The page on which the user presses the device against a virtual wall: position, force, verdict.

use eframe::egui::{self, Color32, CornerRadius, ProgressBar, Rect, Response, RichText, Sense, Stroke, Ui, pos2, vec2};
use egui_plot::{Corner, Legend, Line, Plot, PlotPoints, Points};
use haptics::safety::flags;
use nalgebra::Vector3;
use phrase::Phrase;
use words::fixed;

use super::choose::{reading_page, show_heading};
use super::plots::say_mark;
use super::steer::Steering;
use super::trial::{Wheel, steering_wish};
use super::{colours, debrief, help, overlay};
use crate::live::open::Steered;
use crate::live::wall::{WallTest, WallVerdict};

/// Height of the picture, in points, and its scale, in points per m.
const HEIGHT: f32 = 300.0;
const POINTS_PER_M: f32 = 9000.0;
/// Greatest distance of a virtual hand's set-point from the start, in m.
const MOST_AWAY_M: f64 = 0.025;
/// Colour of the wall, and of the needle above it.
const WALL: Color32 = Color32::from_rgb(92, 104, 116);
const NEEDLE: Color32 = Color32::from_rgb(200, 208, 214);

/// The page.
pub struct WallPage {
    test: WallTest,
    steering: Steering,
    wheel: Wheel,
    /// Factor of the speed of mouse and keys.
    pointer_speed: f64,
}

impl WallPage {
    /// Shows a test that has begun.
    pub fn new(test: WallTest, pointer_speed: f64) -> Self {
        Self {
            test,
            steering: Steering::straight(-Vector3::z_axis(), MOST_AWAY_M),
            wheel: Wheel::default(),
            pointer_speed,
        }
    }

    /// Shows one frame; returns true if the user closes the page.
    pub fn ui(&mut self, ui: &mut Ui) -> bool {
        ui.ctx().request_repaint();
        self.test.take_ticks();
        let shown = egui::CentralPanel::default().frame(reading_page(ui)).show(ui, |ui| {
            let mut close = ui.input(|input| input.key_pressed(egui::Key::Escape));
            show_heading(ui, tr!("Feel a wall"), |ui| close |= ui.button(tr!("Back (Esc)")).clicked());
            ui.add_space(4.0);
            ui.label(tr!(
                "Press the needle down on the wall, hold it there, and release it. The wall pushes back like a spring."
            ));
            ui.add_space(12.0);
            let picture = ui.columns(2, |columns| {
                self.show_readings(&mut columns[1]);
                self.show_picture(&mut columns[0])
            });
            ui.add_space(10.0);
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.show_verdict(ui));
            (close, picture)
        });
        let (close, picture) = shown.inner;
        if let Steered::Window(aim) = &mut self.test.steered {
            let wish = steering_wish(ui, &picture, &mut self.wheel).at_speed(self.pointer_speed);
            aim.write(self.steering.follow(&wish));
        }
        close
    }

    /// Draws the needle over or in the wall.
    fn show_picture(&self, ui: &mut Ui) -> Response {
        let (place, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
        let painter = ui.painter_at(place);
        let surface = place.top() + 0.45 * HEIGHT;
        let depth = (self.test.measured.depth_m as f32 * POINTS_PER_M).clamp(-0.4 * HEIGHT, 0.5 * HEIGHT);
        let middle = place.center().x;
        painter.rect_filled(place, CornerRadius::same(6), ui.visuals().extreme_bg_color);
        let wall = Rect::from_min_max(pos2(place.left(), surface), place.max);
        painter.rect_filled(wall, CornerRadius::same(6), WALL);
        let tip = pos2(middle, surface + depth);
        if depth > 0.0 {
            // The surface gives way around the tip.
            let half = 60.0 + depth;
            let dent = vec![pos2(middle - half, surface), pos2(middle + half, surface), tip];
            painter.add(egui::Shape::convex_polygon(dent, ui.visuals().extreme_bg_color, Stroke::NONE));
        }
        painter.line_segment([pos2(middle, place.top()), tip], Stroke::new(5.0, NEEDLE));
        painter.circle_filled(tip, 5.0, if depth > 0.0 { colours::FORCE } else { NEEDLE });
        response
    }

    /// Shows the device, the wall, and both forces over depth.
    fn show_readings(&self, ui: &mut Ui) {
        let WallTest { info, wall, measured, .. } = &self.test;
        let [stiffness, most] = [fixed(wall.stiffness_n_per_m, 0), fixed(wall.max_force_n, 1)];
        ui.label(RichText::new(words::phrase(&Phrase::Known(info.name.clone()))).strong());
        ui.label(tr!("wall: {stiffness} N/m, up to {force} N", stiffness = stiffness, force = most));
        let depth = fixed(measured.depth_m.max(0.0) * 1e3, 1);
        ui.label(tr!("depth in the wall: {depth} mm", depth = depth));
        for (text, force_n) in [(tr!("force of the wall"), measured.wall_n), (tr!("force sent"), measured.sent_n)] {
            let share = (force_n / wall.max_force_n.max(f64::MIN_POSITIVE)) as f32;
            let text = format!("{text}: {} N", fixed(force_n, 2));
            ui.add(ProgressBar::new(share.clamp(0.0, 1.0)).text(text).fill(Color32::from_rgb(40, 84, 122)));
        }
        let full_mm = wall.max_force_n / wall.stiffness_n_per_m * 1e3;
        let law: Vec<[f64; 2]> = [0.0, full_mm, 1.8 * full_mm].map(|mm| [mm, wall.force_n(mm * 1e-3)]).to_vec();
        let plot = Plot::new("wall").height((HEIGHT - 130.0).max(100.0)).include_y(1.1 * wall.max_force_n);
        let plot = plot.x_axis_label(tr!("depth in the wall, mm")).y_axis_label(tr!("force, N"));
        let plot = plot.x_axis_formatter(say_mark).y_axis_formatter(say_mark);
        let plot = plot.allow_drag(false).allow_zoom(false).allow_scroll(false).allow_boxed_zoom(false);
        let plot = plot.legend(Legend::default().position(Corner::RightBottom));
        plot.show_x(false).show_y(false).show(ui, |plot| {
            plot.line(Line::new(tr!("force of the wall"), PlotPoints::from(law)).color(colours::WARN).width(1.5));
            plot.points(Points::new(tr!("force sent"), measured.curve.clone()).color(colours::FORCE).radius(2.0));
        });
    }

    fn show_verdict(&self, ui: &mut Ui) {
        let (sign, text, colour) = match (self.test.servo().ended(), self.test.verdict()) {
            (Some(ended), _) => ("×", debrief::say_ended(&ended), colours::BAD),
            (None, WallVerdict::Press) => {
                ("→", tr!("Hold the needle in the wall for half a second").to_owned(), colours::WARN)
            }
            (None, WallVerdict::Good(why)) => ("●", words::phrase(&why), colours::GOOD),
            (None, WallVerdict::Bad(why)) => ("×", words::phrase(&why), colours::BAD),
        };
        ui.label(RichText::new(format!("{sign} {text}")).size(18.0).color(colour));
        if self.test.info.is_virtual {
            ui.label(tr!(
                "Mouse, keyboard and gamepad have no motors: the force acts on a virtual hand. A haptic device must \
                 push your hand by the force that is shown."
            ));
        } else {
            ui.label(tr!("Compare with your hand: if the wall feels softer or weaker than shown, run stylet doctor."));
        }
        if matches!(self.test.steered, Steered::Window(_)) {
            ui.label(RichText::new(words::say(help::IN_A_LINE)).weak());
        }
        // The limit of the wall is part of the test.
        for trouble in overlay::safety_troubles(self.test.measured.flags & !flags::CLAMPED) {
            ui.label(RichText::new(trouble).weak());
        }
    }
}
