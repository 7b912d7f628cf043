//! After an attempt: the score, the three costliest mistakes, the curves, and the next steps.

use std::collections::VecDeque;
use std::sync::Arc;

use assessment::words::{deduction_with_cost, failure_phrase};
use assessment::{AssessError, Assessment, Deduction, DepthMiss, FailureCause, HardFailure, UnmetRequirement};
use documents::Exercise;
use eframe::egui::{self, RichText, ScrollArea, Ui};
use haptics::servo::{Ended, Priority, Quantiles, Report};
use phrase::Phrase;
use recording::Recording;

use super::expert::ExpertCurves;
use super::plots::{self, Curves};
use super::rescue::{Rescue, RescueWish};
use super::survey::Survey;
use super::{colours, help};
use crate::exit::Failure;
use crate::live::desk::{self, AskedSurvey, Call, DeskAnswer};
use crate::live::{Finished, Kept, LiveTrial};
use crate::outbox::Outbox;
use crate::station::Pairing;

/// Number of mistakes shown.
const COSTLIEST: usize = 3;

/// The state of a debrief.
pub struct Debrief {
    /// The judged attempt, or the attempt in memory if it could not be saved.
    kept: Result<JudgedAttempt, Rescue>,
    servo: Option<Report>,
    pairing: Option<Pairing>,
    delivery: Option<Call<Phrase>>,
    /// Why the outbox failed.
    refused: Option<String>,
    /// Surveys still to be shown after this attempt.
    asked: VecDeque<Arc<AskedSurvey>>,
    survey: Option<Survey>,
}

/// An attempt that is on disk and judged.
struct JudgedAttempt {
    kept: Kept,
    recording: Arc<Recording>,
    judged: Result<Assessment, AssessError>,
    curves: Curves,
    expert: ExpertCurves,
    layers: Vec<attempt::LayerSpan>,
    exercise: Exercise,
}

/// The next step.
pub enum AfterDebrief {
    /// Stay on this screen.
    Stay,
    /// Watch the attempt.
    Replay(Arc<Recording>),
    /// Try again.
    Retry,
    /// Choose another exercise.
    Choose,
}

impl Debrief {
    /// Judges a finished attempt, sends it to the school and offers the first survey.
    ///
    /// # Errors
    /// If the recording cannot be read back.
    pub fn new(
        trial: &LiveTrial,
        finished: Finished,
        pairing: Option<Pairing>,
        asked: Vec<Arc<AskedSurvey>>,
    ) -> Result<Self, Failure> {
        let servo = finished.report;
        let kept = match finished.kept {
            Ok(kept) => Ok(JudgedAttempt::new(trial, kept)?),
            Err(unsaved) => Err(Rescue::new(unsaved)),
        };
        let asked = VecDeque::from(asked);
        let mut debrief = Self { kept, servo, pairing, delivery: None, refused: None, asked, survey: None };
        debrief.deliver();
        Ok(debrief)
    }

    /// Sends the recording to the school, if this station has joined one and the recording has a
    /// pseudonym.
    fn deliver(&mut self) {
        let (Ok(judged), Some(pairing)) = (&self.kept, &self.pairing) else { return };
        if judged.recording.session.trainee.is_empty() {
            return;
        }
        let sent = Outbox::open(None).and_then(|outbox| desk::deliver(&outbox, &judged.kept.path, pairing.clone()));
        match sent {
            Ok(call) => {
                self.delivery = Some(call);
                self.ask_next();
            }
            Err(failure) => self.refused = Some(failure.to_string()),
        }
    }

    /// Offers the next survey, if there is one.
    fn ask_next(&mut self) {
        let (Ok(judged), Some(pairing)) = (&self.kept, &self.pairing) else { return };
        let session = judged.recording.session.session_id;
        let next = self.asked.pop_front();
        self.survey = next.and_then(|asked| match Outbox::open(None) {
            Ok(outbox) => Some(Survey::new(asked, session, pairing.clone(), outbox)),
            Err(failure) => {
                self.refused = Some(failure.to_string());
                None
            }
        });
    }

    /// Shows the state of the delivery on one line.
    fn delivery_ui(&self, ui: &mut Ui) {
        if let Some(why) = &self.refused {
            ui.colored_label(colours::BAD, format!("× {why}"));
        }
        match self.delivery.as_ref().map(desk::read) {
            Some(DeskAnswer::Waiting) => {
                ui.label(tr!("sending the recording …"));
                ui.ctx().request_repaint_after_secs(0.2);
            }
            Some(DeskAnswer::Came(told)) => {
                ui.colored_label(colours::GOOD, format!("● {}", words::phrase(&told)));
            }
            Some(DeskAnswer::Refused(why)) => {
                ui.colored_label(colours::WARN, format!("▲ {}", words::phrase(&why)));
            }
            None => {}
        }
    }

    /// Returns the assessment, if the attempt could be judged.
    pub fn assessment(&self) -> Option<&Assessment> {
        self.kept.as_ref().ok()?.judged.as_ref().ok()
    }

    /// Returns whether the attempt is on disk. If not, warns the user that leaving loses it.
    pub fn may_close(&mut self) -> bool {
        if let Err(rescue) = &mut self.kept {
            rescue.leave();
        }
        self.kept.is_ok()
    }

    /// Shows one frame.
    pub fn ui(&mut self, ui: &mut Ui, trial: &LiveTrial) -> Result<AfterDebrief, Failure> {
        if let Err(rescue) = &mut self.kept {
            let wish = scrolling_page(ui, |ui| rescue.ui(ui));
            return self.rescue(wish, trial);
        }
        Ok(self.judged_ui(ui))
    }

    fn judged_ui(&mut self, ui: &mut Ui) -> AfterDebrief {
        let Ok(judged) = &self.kept else { return AfterDebrief::Stay };
        let next = egui::Panel::bottom("next").show(ui, |ui| show_next_buttons(ui, judged)).inner;
        if self.survey.as_mut().is_some_and(|survey| survey.ui(ui)) {
            self.ask_next();
        }
        let Ok(judged) = &mut self.kept else { return next };
        judged.expert.update(ui.ctx());
        let Ok(judged) = &self.kept else { return next };
        scrolling_page(ui, |ui| {
            judged.ui(ui);
            self.delivery_ui(ui);
            let Some(servo) = &self.servo else { return };
            if is_too_slow(servo) {
                ui.colored_label(
                    colours::WARN,
                    format!(
                        "▲ {}",
                        tr!("This computer is too slow for the device: the force was interrupted. Run stylet doctor \
                             for details.")
                    ),
                );
            }
            if help::shows_figures(ui) {
                ui.label(RichText::new(say_servo_report(servo)).weak().small());
            }
        });
        next
    }

    /// Carries out the user's decision about an attempt that is not on disk.
    fn rescue(&mut self, wish: RescueWish, trial: &LiveTrial) -> Result<AfterDebrief, Failure> {
        let Err(rescue) = &mut self.kept else { return Ok(AfterDebrief::Stay) };
        match wish {
            RescueWish::Wait => {}
            RescueWish::ThrowAway => {
                rescue.unsaved.discard();
                return Ok(AfterDebrief::Choose);
            }
            RescueWish::Save(path) => {
                if let Some(kept) = rescue.unsaved.save(&path) {
                    self.kept = Ok(JudgedAttempt::new(trial, kept)?);
                    self.deliver();
                }
            }
        }
        Ok(AfterDebrief::Stay)
    }
}

/// A scrolling page with margins.
fn scrolling_page<T>(ui: &mut Ui, show: impl FnOnce(&mut Ui) -> T) -> T {
    let frame = egui::Frame::central_panel(ui.style()).inner_margin(egui::Margin::same(24));
    let shown = egui::CentralPanel::default().frame(frame).show(ui, |ui| ScrollArea::vertical().show(ui, show));
    shown.inner.inner
}

fn show_next_buttons(ui: &mut Ui, judged: &JudgedAttempt) -> AfterDebrief {
    ui.add_space(6.0);
    // Keys typed into an answer must not start another attempt.
    let typing = ui.ctx().text_edit_focused();
    let wanted = |ui: &mut Ui, words: &str, key: egui::Key| {
        ui.button(words).clicked() || (!typing && ui.input(|input| input.key_pressed(key)))
    };
    let next = ui.horizontal(|ui| {
        if wanted(ui, tr!("Try again (R)"), egui::Key::R) {
            return AfterDebrief::Retry;
        }
        if wanted(ui, tr!("Watch replay (W)"), egui::Key::W) {
            return AfterDebrief::Replay(Arc::clone(&judged.recording));
        }
        if wanted(ui, tr!("Another exercise (Esc)"), egui::Key::Escape) {
            return AfterDebrief::Choose;
        }
        AfterDebrief::Stay
    });
    ui.add_space(6.0);
    next.inner
}

impl JudgedAttempt {
    fn new(trial: &LiveTrial, kept: Kept) -> Result<Self, Failure> {
        let recording = crate::sources::read_recording(&kept.path)?;
        let judged = assessment::assess(&recording, &trial.bundle);
        Ok(Self {
            curves: Curves::new(sentence!("this attempt"), &recording),
            expert: ExpertCurves::start(trial),
            layers: attempt::span_layers(&recording, &trial.bundle),
            recording: Arc::new(recording),
            judged,
            kept,
            exercise: trial.bundle.exercise.clone(),
        })
    }

    fn ui(&self, ui: &mut Ui) {
        match &self.judged {
            Ok(assessment) => show_verdict(ui, assessment, &self.exercise, self.curves.entered()),
            Err(why @ AssessError::Void(_)) => {
                ui.label(RichText::new(format!("▲ {}", words::phrase(&why.phrase()))).size(20.0).color(colours::WARN));
                ui.label(tr!("This does not reflect your performance: the recording is kept but does not count."));
            }
            Err(why) => {
                let told = tr!("not scored: {why}", why = words::phrase(&why.phrase()));
                ui.colored_label(colours::WARN, format!("▲ {told}"));
            }
        }
        ui.add_space(8.0);
        let height = (ui.clip_rect().bottom() - ui.cursor().top() - 110.0).clamp(180.0, 640.0);
        if self.curves.entered() {
            let both: Vec<&Curves> = std::iter::once(&self.curves).chain(self.expert.curves()).collect();
            ui.columns(2, |columns| {
                plots::plot_over_depth(&mut columns[0], &both, &self.layers, height);
                plots::plot_over_time(&mut columns[1], &[&self.curves], None, height);
            });
        }
        if help::shows_figures(ui) {
            let place = tr!("recorded in {place}", place = self.kept.path.display());
            ui.label(RichText::new(place).weak());
        }
    }
}

fn show_verdict(ui: &mut Ui, assessment: &Assessment, exercise: &Exercise, entered: bool) {
    let (sign, word, colour) =
        if assessment.passed { ("●", tr!("passed"), colours::GOOD) } else { ("×", tr!("not passed"), colours::BAD) };
    ui.horizontal(|ui| {
        ui.label(RichText::new(words::fixed(assessment.score, 0)).size(44.0).strong());
        ui.vertical(|ui| {
            ui.label(RichText::new(format!("{sign} {word}")).size(20.0).color(colour));
            ui.label(tr!("of 100; pass mark {mark}", mark = words::fixed(exercise.pass_mark, 0)));
        });
    });
    for failure in &assessment.hard_fails {
        let words = words::phrase(&failure_phrase(failure));
        let distance = say_distance(failure, assessment, exercise).map(|distance| format!(" ({distance})"));
        ui.colored_label(colours::BAD, format!("× {words}{}", distance.unwrap_or_default()));
    }
    ui.add_space(6.0);
    // If a requirement is not met, every line has lost all its points; the costs without it are
    // more informative.
    let Assessment { metrics, hard_fails, .. } = assessment;
    let ungated = assessment::judge_without_requirements(metrics, hard_fails, exercise);
    let deductions = ungated.as_ref().map_or(&assessment.deductions, |ungated| &ungated.deductions);
    let costliest = costliest_deductions(deductions);
    if !entered {
        ui.label(tr!("The needle never entered the body."));
    } else if costliest.is_empty() {
        ui.label(tr!("No points were lost."));
    } else {
        let heading = match &ungated {
            None => tr!("What cost most").to_owned(),
            Some(ungated) => tr!(
                "Otherwise the score would have been {score} points; largest deductions",
                score = words::fixed(ungated.score, 0)
            ),
        };
        ui.label(RichText::new(heading).strong());
        for deduction in costliest {
            ui.label(format!("−  {}", words::phrase(&deduction_with_cost(deduction))));
        }
    }
}

/// Describes the distance of the position from the target and the allowed distance; `None` for
/// other failures.
fn say_distance(failure: &HardFailure, assessment: &Assessment, exercise: &Exercise) -> Option<String> {
    let FailureCause::Required { unmet: UnmetRequirement::Within } = failure.cause else { return None };
    let DepthMiss { error_mm, allowed_mm } = DepthMiss::find(&assessment.metrics, exercise)?;
    let (distance, allowed) = (words::fixed(error_mm.abs(), 2), words::fixed(allowed_mm, 2));
    Some(if error_mm > 0.0 {
        tr!("{distance} mm too deep, {allowed} mm allowed", distance = distance, allowed = allowed)
    } else {
        tr!("{distance} mm too shallow, {allowed} mm allowed", distance = distance, allowed = allowed)
    })
}

/// Whether so many ticks stalled that the safety chain must have cut the force repeatedly.
fn is_too_slow(report: &Report) -> bool {
    report.priority != Priority::Device && report.counts.stalls * 1000 > report.counts.ticks
}

/// Describes the servo's timing, for the station's maintainer.
fn say_servo_report(report: &Report) -> String {
    let priority = match report.priority {
        Priority::RealTime => tr!("real-time priority"),
        Priority::Device => tr!("the device's own thread"),
        Priority::Ordinary => tr!("normal priority: real-time priority was denied"),
    };
    let ended = say_ended(&report.ended);
    let counts = tr!(
        "servo: {ended}, {ticks} ticks, {stalls} stalls, {dropped} records dropped, {priority}",
        ended = ended,
        ticks = report.counts.ticks,
        stalls = report.counts.stalls,
        dropped = report.counts.dropped,
        priority = priority
    );
    let late = tr!("lateness: {quantiles}", quantiles = say_quantiles(&report.lateness.quantiles()));
    let took = tr!("compute: {quantiles}", quantiles = say_quantiles(&report.compute.quantiles()));
    [counts, late, took].join("\n")
}

/// Describes why a servo ended.
pub fn say_ended(ended: &Ended) -> String {
    match ended {
        Ended::Stopped => tr!("stopped").to_owned(),
        Ended::Panicked => tr!("stopped by a program error; the force was set to zero").to_owned(),
        Ended::DeviceLost(why) => tr!("connection to the device lost: {why}", why = why),
    }
}

fn say_quantiles(quantiles: &Quantiles) -> String {
    words::decimal(&quantiles.to_string())
}

/// Returns the costliest deductions, in descending order, without those below half a point.
fn costliest_deductions(deductions: &[Deduction]) -> Vec<&Deduction> {
    let mut cost: Vec<&Deduction> = deductions.iter().filter(|deduction| deduction.points >= 0.5).collect();
    cost.sort_by(|a, b| b.points.total_cmp(&a.points));
    cost.truncate(COSTLIEST);
    cost
}
