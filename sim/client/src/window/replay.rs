//! The replay of a recording: picture, plots, timeline, and a second recording as a ghost.

use std::sync::Arc;

use attempt::fluoroscopy::ImagedBody;
use documents::ExerciseBundle;
use eframe::egui::{self, Key, RichText, Slider, Ui};
use recording::{Fluoroscopy, Recording};

use super::canvas::Canvas;
use super::plots::{self, Curves, JumpMoment};
use super::trial;
use super::x_ray::XRayPanel;
use crate::live::x_ray::Radiographer;
use crate::picture::{Alignment, Look, Telling};

/// Playback speeds, relative to the attempt's own.
const SPEEDS: [f64; 6] = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0];
/// Step of the arrow keys, in s; with shift a tenth.
const STEP_S: f64 = 0.5;

/// A recording, and the data derived from it once.
pub struct ReplayView {
    telling: Telling,
    curves: Curves,
    moments: Vec<JumpMoment>,
}

impl ReplayView {
    /// Prepares a recording under a name.
    #[must_use]
    pub fn new(name: &'static str, recording: Arc<Recording>, bundle: &ExerciseBundle) -> Self {
        Self {
            curves: Curves::new(name, &recording),
            moments: plots::recorded_moments(&recording, bundle),
            telling: Telling::new(recording, bundle),
        }
    }
}

/// The X-ray pictures of a recording.
struct ReplayedXRays {
    radiographer: Radiographer,
    panel: XRayPanel,
    /// A second pass over the recording, for the needle at the time of a pulse.
    telling: Telling,
    /// Number of the last pulse that was exposed.
    exposed: Option<usize>,
}

impl ReplayedXRays {
    /// The pictures; `None` if the recording has no pulse. Another thread makes the body.
    fn new(bundle: &ExerciseBundle, recording: &Arc<Recording>) -> Option<Self> {
        recording.fluoroscopy.pulses.first()?;
        let own = bundle.clone();
        let radiographer = Radiographer::start(move || ImagedBody::new(&own), recording.session.seed).ok()?;
        let telling = Telling::new(Arc::clone(recording), bundle);
        Some(Self { radiographer, panel: XRayPanel::default(), telling, exposed: None })
    }

    /// Shows the last picture before a time in s.
    fn ui(&mut self, ui: &mut Ui, look: &Look, now_s: f64) {
        let Fluoroscopy { pulses, .. } = &self.telling.recording().fluoroscopy;
        let last = pulses.partition_point(|pulse| pulse.t_s <= now_s).checked_sub(1);
        if let Some(at) = last.filter(|at| self.exposed != Some(*at)) {
            let pulse = pulses[at];
            let controls = self.telling.recording().fluoroscopy.controls_at(pulse.t_s).copied();
            let frame = self.telling.at(pulse.t_s).frame(look, 1.0);
            if let Some(controls) = controls {
                self.radiographer.expose(pulse, controls, frame);
            }
            self.exposed = last;
        }
        let monitor = self.radiographer.monitor().clone();
        self.panel.replay_ui(ui, &monitor, now_s);
    }
}

/// The replay screen.
pub struct Replay {
    shown: ReplayView,
    x_rays: Option<ReplayedXRays>,
    ghost: Option<(ReplayView, Alignment)>,
    layers: Vec<attempt::LayerSpan>,
    target_depth_m: f64,
    look: Look,
    now_s: f64,
    speed: f64,
    playing: bool,
}

impl Replay {
    /// Shows a recording of an exercise.
    #[must_use]
    pub fn new(bundle: &ExerciseBundle, recording: &Arc<Recording>) -> Self {
        let ExerciseBundle { exercise, scene, .. } = bundle;
        Self {
            layers: attempt::span_layers(recording, bundle),
            x_rays: ReplayedXRays::new(bundle, recording),
            shown: ReplayView::new(sentence!("this attempt"), Arc::clone(recording), bundle),
            ghost: None,
            target_depth_m: exercise.target_depth_mm * 1e-3,
            look: Look::at(scene, true),
            now_s: 0.0,
            speed: 1.0,
            playing: true,
        }
    }

    /// Adds a second recording as a ghost, aligned by the events that both have.
    #[must_use]
    pub fn beside(mut self, bundle: &ExerciseBundle, other: &Arc<Recording>) -> Self {
        let alignment = Alignment::new(&self.shown.telling.recording().events, &other.events);
        self.ghost = Some((ReplayView::new(sentence!("the other attempt"), Arc::clone(other), bundle), alignment));
        self
    }

    /// Shows one frame; returns true if the user closes the replay.
    pub fn ui(&mut self, ui: &mut Ui, canvas: &mut Canvas) -> bool {
        self.advance(ui);
        let close = self.timeline(ui);
        self.plots(ui);
        if let Some(x_rays) = &mut self.x_rays {
            x_rays.ui(ui, &self.look, self.now_s);
        }
        let mut frame = self.shown.telling.at(self.now_s).frame(&self.look, self.target_depth_m);
        if let Some((ghost, alignment)) = &mut self.ghost {
            frame.ghost = Some(ghost.telling.at(alignment.other_s(self.now_s)).needle());
        }
        let picture = egui::CentralPanel::no_frame().show(ui, |ui| canvas.show(ui, &frame)).inner;
        trial::change_look(ui, &picture, &mut self.look);
        close
    }

    fn advance(&mut self, ui: &Ui) {
        let (dt_s, step_s) = ui.input(|input| {
            let shift = if input.modifiers.shift { 0.1 } else { 1.0 };
            let pressed = |key| f64::from(u8::from(input.key_pressed(key)));
            (f64::from(input.stable_dt.min(0.1)), shift * STEP_S * (pressed(Key::ArrowRight) - pressed(Key::ArrowLeft)))
        });
        if ui.input(|input| input.key_pressed(Key::Space)) {
            self.playing = !self.playing;
        }
        let passed_s = if self.playing { dt_s * self.speed } else { 0.0 };
        self.now_s = (self.now_s + passed_s + step_s).clamp(0.0, self.shown.curves.duration_s);
        if self.playing {
            ui.ctx().request_repaint();
        }
    }

    /// Shows the buttons, the slider and the moments to jump to; returns true if the user closes
    /// the replay.
    pub(super) fn timeline(&mut self, ui: &mut Ui) -> bool {
        let panel = egui::Panel::bottom("timeline").resizable(false);
        panel
            .show(ui, |ui| {
                ui.add_space(4.0);
                let close = ui.horizontal_wrapped(|ui| {
                    if ui.button(if self.playing { tr!("Pause (space)") } else { tr!("Play (space)") }).clicked() {
                        self.playing = !self.playing;
                    }
                    for speed in SPEEDS {
                        ui.selectable_value(&mut self.speed, speed, words::decimal(&format!("{speed}×")));
                    }
                    egui::ComboBox::from_id_salt("moments").selected_text(tr!("jump to")).show_ui(ui, |ui| {
                        for JumpMoment { t_s, what } in &self.shown.moments {
                            let told = format!("{} s  {}", words::fixed(*t_s, 2), words::phrase(what));
                            if ui.selectable_label(false, told).clicked() {
                                self.now_s = *t_s;
                            }
                        }
                    });
                    ui.label(RichText::new(tr!("1 2 3 4: views, ← →: step")).weak());
                    ui.button(tr!("Close (Esc)")).clicked()
                });
                ui.spacing_mut().slider_width = (ui.available_width() - 90.0).max(80.0);
                let slider = Slider::new(&mut self.now_s, 0.0..=self.shown.curves.duration_s).suffix(" s");
                let slider = slider.custom_formatter(|value, _| words::fixed(value, 2));
                ui.add(slider.custom_parser(|typed| typed.trim().replace(',', ".").parse().ok()));
                ui.add_space(4.0);
                close.inner || ui.input(|input| input.key_pressed(Key::Escape))
            })
            .inner
    }

    pub(super) fn plots(&mut self, ui: &mut Ui) {
        let panel = egui::Panel::right("plots").default_size(380.0);
        panel.show(ui, |ui| {
            let all: Vec<&Curves> = match &self.ghost {
                Some((ghost, _)) => vec![&self.shown.curves, &ghost.curves],
                None => vec![&self.shown.curves],
            };
            let height = 0.5 * ui.available_height() - 24.0;
            if let Some(t_s) = plots::plot_over_time(ui, &all, Some(self.now_s), height) {
                self.now_s = t_s.clamp(0.0, self.shown.curves.duration_s);
            }
            plots::plot_over_depth(ui, &all, &self.layers, height);
        });
    }
}
