//! Plots of force over time and over depth, of one recording or two.

use std::ops::RangeInclusive;

use attempt::{HandForces, LayerSpan};
use documents::{ExerciseBundle, name_structure};
use eframe::egui::{Color32, Ui};
use egui_plot::{GridMark, Legend, Line, Plot, PlotPoints, Points, Span, VLine};
use law::axial::Contactor;
use phrase::{Phrase, phrase};
use recording::{EventKind, Recording};

use super::colours;

/// Maximum number of points of a line, the least and the greatest force of each stretch: with more
/// the line would break into dashes.
const MOST_POINTS: usize = 500;

/// The curves of an attempt, reduced to few points.
pub struct Curves {
    /// Name in the legend.
    pub name: &'static str,
    /// Force over time: s, N.
    time: Vec<[f64; 2]>,
    /// Force over displacement along the needle: mm, N.
    pub(super) depth: Vec<[f64; 2]>,
    /// Each rupture: time in s, and the force just before it in N.
    pops: Vec<[f64; 2]>,
    /// Duration, in s.
    pub duration_s: f64,
}

impl Curves {
    /// Whether the needle was ever in the body.
    pub fn entered(&self) -> bool {
        !self.depth.is_empty()
    }

    /// Returns the greatest displacement along the needle, in mm; 0 if it never entered.
    pub fn deepest_mm(&self) -> f64 {
        self.depth.iter().map(|point| point[0]).fold(0.0, f64::max)
    }

    /// Computes the curves of a recording.
    pub fn new(name: &'static str, recording: &Recording) -> Self {
        let forces = HandForces::measure(recording);
        let inside = forces.iter().filter(|hand| hand.sample.x_m > 0.0);
        let depth = inside.map(|hand| [hand.sample.x_m * 1e3, hand.force_n]);
        let pops = recording.events.iter().filter(|event| event.kind.contactor().is_some());
        Self {
            name,
            time: forces.thin(MOST_POINTS).iter().map(|hand| [hand.sample.t_s, hand.force_n]).collect(),
            depth: distinct_points(depth),
            pops: pops.map(|event| [event.t_s, forces.before_n(event)]).collect(),
            duration_s: recording.samples.last().map_or(0.0, |sample| sample.t_s),
        }
    }
}

/// Returns the points that can be distinguished from the one before: a long rest takes no points
/// from the rest of the path.
fn distinct_points(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    const LEAST_MM: f64 = 0.1;
    const LEAST_N: f64 = 0.03;
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for [x_mm, force_n] in points {
        let is_there = |[x, n]: &[f64; 2]| (x_mm - x).abs() < LEAST_MM && (force_n - n).abs() < LEAST_N;
        if !kept.last().is_some_and(is_there) {
            kept.push([x_mm, force_n]);
        }
    }
    kept
}

const COLOURS: [Color32; 2] = [colours::FORCE, colours::WARN];

/// Plots force over time, with the playhead if there is one; returns the time at the pointer while
/// its button is down.
pub fn plot_over_time(ui: &mut Ui, all: &[&Curves], playhead_s: Option<f64>, height: f32) -> Option<f64> {
    let plot = Plot::new("force_over_time").height(height).x_axis_label(tr!("time, s"));
    let plot = plot.y_axis_label(tr!("force, N")).x_axis_formatter(say_mark).y_axis_formatter(say_mark);
    let plot = plot.allow_drag(false).allow_zoom(false).allow_scroll(false).allow_boxed_zoom(false).include_y(0.0);
    let shown = plot.legend(Legend::default()).show(ui, |plot| {
        for (curves, colour) in all.iter().zip(COLOURS) {
            plot.line(
                Line::new(words::say(curves.name), PlotPoints::from(curves.time.clone())).color(colour).width(1.5),
            );
            plot.points(Points::new(words::say(curves.name), curves.pops.clone()).color(colour).radius(3.5));
        }
        if let Some(now_s) = playhead_s {
            plot.vline(VLine::new("", now_s).color(Color32::WHITE));
        }
        plot.pointer_coordinate().map(|point| point.x)
    });
    shown.inner.filter(|_| shown.response.is_pointer_button_down_on())
}

/// Names each curve in its colour, if there are several. The legend of a plot would list its layers,
/// too.
fn show_legend(ui: &mut Ui, all: &[&Curves]) {
    ui.horizontal_wrapped(|ui| {
        for (curves, colour) in all.iter().zip(COLOURS).filter(|_| all.len() > 1) {
            ui.colored_label(colour, format!("●  {}", words::say(curves.name)));
            ui.add_space(10.0);
        }
    });
}

/// Plots force over displacement, with the layers as bands; each curve to its own end.
pub fn plot_over_depth(ui: &mut Ui, all: &[&Curves], layers: &[LayerSpan], height: f32) {
    let top = ui.cursor().top();
    show_legend(ui, all);
    let height = height - (ui.cursor().top() - top);
    let plot = Plot::new("force_over_depth")
        .height(height)
        .x_axis_label(tr!("depth along the needle, mm"))
        .y_axis_label(tr!("force, N"))
        .x_axis_formatter(say_mark)
        .y_axis_formatter(say_mark);
    let plot = plot.allow_drag(false).allow_zoom(false).allow_scroll(false).allow_boxed_zoom(false).include_y(0.0);
    let deepest_mm = all.iter().map(|curves| curves.deepest_mm()).fold(1.0, f64::max);
    plot.show(ui, |plot| {
        for (at, layer) in layers.iter().enumerate() {
            let bottom_mm = layer.bottom_mm.min(deepest_mm);
            if bottom_mm > layer.top_mm {
                let fill = Color32::from_white_alpha(if at % 2 == 0 { 14 } else { 5 });
                plot.span(Span::new(words::phrase(&name_structure(&layer.name)), layer.top_mm..=bottom_mm).fill(fill));
            }
        }
        // The attempt itself is drawn last, on top.
        for (curves, colour) in all.iter().zip(COLOURS).rev() {
            plot.line(
                Line::new(words::say(curves.name), PlotPoints::from(curves.depth.clone())).color(colour).width(1.5),
            );
        }
    });
}

/// Formats a mark of an axis, with the decimals that its step requires.
pub fn say_mark(mark: GridMark, _shown: &RangeInclusive<f64>) -> String {
    let decimals = (-libm::log10(mark.step_size).floor()).clamp(0.0, 6.0) as usize;
    words::fixed(mark.value, decimals)
}

/// A moment to jump to.
pub struct JumpMoment {
    /// Time, in s.
    pub t_s: f64,
    /// Description of the event, translatable.
    pub what: Phrase,
}

/// Returns the moments of a recording to jump to.
pub fn recorded_moments(recording: &Recording, bundle: &ExerciseBundle) -> Vec<JumpMoment> {
    let told = recording.events.iter().filter(|event| event.kind != EventKind::Fault);
    told.map(|event| JumpMoment { t_s: event.t_s, what: explain_event(event, bundle) }).collect()
}

/// Describes an event. A coaching message is recorded in its document's main language, and shown in
/// the user's language if the document has it.
fn explain_event(event: &recording::Event, bundle: &ExerciseBundle) -> Phrase {
    let structure = || name_structure(&event.text);
    match event.kind {
        EventKind::TipRupture => Contactor::Tip.into_layer(structure()),
        EventKind::RimRupture => Contactor::Rim.into_layer(structure()),
        EventKind::StructureHit => phrase!("hit {name}", name = structure()),
        EventKind::Contact => phrase!("skin touched"),
        EventKind::HubContact => phrase!("hub at the skin"),
        EventKind::SkinExit => phrase!("needle out"),
        EventKind::Confirm => phrase!("position confirmed"),
        EventKind::Coaching => {
            let rules = &bundle.exercise.coaching;
            let rule = rules.iter().find(|rule| rule.message.own() == event.text);
            rule.map_or_else(|| Phrase::data(&event.text), |rule| Phrase::from(&rule.message))
        }
        EventKind::Fault | EventKind::Interrupted => Phrase::Known(event.text.clone()),
    }
}

#[cfg(test)]
mod tests {
    //! Fails if a curve is reduced to straight lines between few points, which would show a course
    //! of the force that did not occur.

    use eframe::egui::epaint::PathShape;
    use eframe::egui::{Context, RawInput, Rect, Shape, pos2, vec2};

    use super::*;

    /// Returns the right end of each curve as drawn, in points, if the plot shows it.
    fn drawn_ends(all: &[&Curves], layers: &[LayerSpan]) -> Vec<f32> {
        let screen_rect = Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(600.0, 400.0)));
        let context = Context::default();
        let mut shapes = Vec::new();
        for _ in 0..3 {
            let input = RawInput { screen_rect, ..RawInput::default() };
            let mut drawn = context.run_ui(input, |ui| plot_over_depth(ui, all, layers, 300.0));
            drawn.textures_delta.clear();
            shapes = drawn.shapes;
        }
        let end = |colour: Color32| {
            let lines = shapes.iter().filter_map(|drawn| match &drawn.shape {
                Shape::Path(PathShape { points, stroke, .. }) => Some((drawn.clip_rect, points, &stroke.color)),
                _ => None,
            });
            let own = lines.filter(|(.., is)| **is == eframe::egui::epaint::ColorMode::Solid(colour));
            own.map(|(clip, points, _)| {
                let right = points.iter().map(|point| point.x).fold(0.0, f32::max);
                if right <= clip.right() { right } else { f32::NAN }
            })
            .fold(0.0, f32::max)
        };
        COLOURS.iter().take(all.len()).map(|colour| end(*colour)).collect()
    }

    #[test]
    fn an_overshoot_is_drawn_beyond_the_expert_and_the_layers() {
        let to = |name, deepest_mm: u32| Curves {
            name,
            time: Vec::new(),
            depth: (0..=deepest_mm).map(|mm| [f64::from(mm), 1.0 + 0.1 * f64::from(mm)]).collect(),
            pops: Vec::new(),
            duration_s: 1.0,
        };
        let (own, expert) = (to("own", 40), to("expert", 25));
        let layer = LayerSpan { name: "fat".to_owned(), texture: "fat".to_owned(), top_mm: 0.0, bottom_mm: 25.0 };
        let ends = drawn_ends(&[&own, &expert], &[layer]);
        assert!(ends[0] > 1.3 * ends[1] && ends[1] > 100.0, "{ends:?}");
    }

    #[test]
    fn a_long_rest_takes_no_points_from_the_way() {
        let way = |n: u32| [f64::from(n) * 0.02, f64::from(n % 50) * 0.04];
        let rest = std::iter::repeat_n(way(0), 100_000);
        let kept = distinct_points(rest.chain((0..1000).map(way)));
        assert!((490..=1001).contains(&kept.len()), "{} points", kept.len());
        let peak_n = kept.iter().map(|point| point[1]).fold(0.0, f64::max);
        assert!((peak_n - 1.96).abs() < 1e-9, "{peak_n} N");
    }
}
