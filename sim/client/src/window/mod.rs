//! The window: choice of an exercise, briefing, attempt, debrief, replay.

mod briefing;
mod canvas;
mod choose;
mod colours;
mod consent;
mod debrief;
mod desk;
mod expert;
mod help;
mod language;
mod overlay;
mod pictures;
mod plots;
mod preparing;
mod replay;
mod rescue;
mod settings;
mod sound;
mod steer;
mod survey;
mod thumbnails;
mod trial;
mod wall;
mod x_ray;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use documents::ExerciseBundle;
use eframe::egui::{self, Ui};
use eframe::egui_wgpu::WgpuSetup;
use eframe::wgpu::Adapter;
use eframe::{App, CreationContext, NativeOptions};
use recording::{Recording, Session};
use render::frame::Stage;

use self::briefing::{Briefing, Decision};
use self::canvas::Canvas;
use self::debrief::Debrief;
use self::desk::Desk;
pub use self::language::WindowLanguage;
use self::pictures::BriefingPictures;
use self::preparing::{Preparation, PreparedAttempt};
use self::replay::Replay;
use self::settings::SettingsPage;
use self::steer::{Steering, SteeringWish};
use self::thumbnails::Thumbnails;
use self::trial::TrialScreen;
use self::wall::WallPage;
use crate::devices::DeviceArgs;
use crate::exit::{Failure, Outcome};
use crate::live::history::History;
use crate::live::open::{self, Steered};
use crate::live::wall::WallTest;
use crate::live::x_ray::LiveArm;
use crate::live::{self, Live};
use crate::maker::Maker;
use crate::settings::Settings;
use crate::shelf::{Offer, Shelf};
use crate::station::{Pairing, StationKey};
use crate::{output, picture, sources};

/// Servo rate, in Hz.
const TICK_HZ: f64 = 1000.0;

/// The set-up of a station.
pub struct Station {
    /// The catalogue of exercises.
    pub shelf: Shelf,
    /// Earlier attempts at this station.
    pub history: History,
    /// The school that this station has joined.
    pub pairing: Option<Pairing>,
    /// The key that signs the attempts of signed-in trainees.
    pub key: Option<Arc<StationKey>>,
    /// The choice of a device.
    pub device: open::DeviceChoice,
    /// Where haptic devices are.
    pub devices: DeviceArgs,
    /// Folder for recordings.
    pub folder: PathBuf,
    /// Pseudonym for practice without a sign-in, or empty.
    pub trainee: String,
    /// Seed of the patient and of a virtual operator's hand.
    pub seed: u64,
    /// Whether to show the planned line, entry and target.
    pub guided: bool,
    /// Language of the window.
    pub language: WindowLanguage,
    /// The user's settings.
    pub settings: Settings,
}

/// Interval at which a progress bar is redrawn.
const BEAT: Duration = Duration::from_millis(33);

/// The current screen.
enum Screen {
    Choose,
    /// A device at a virtual wall.
    Wall(Box<WallPage>),
    Briefing {
        at: usize,
        error: Option<String>,
    },
    /// An attempt is being prepared.
    Preparing {
        at: usize,
        preparation: Preparation,
    },
    Trial {
        at: usize,
        trial: Box<TrialScreen>,
    },
    Debrief {
        at: usize,
        debrief: Box<Debrief>,
        trial: Arc<live::LiveTrial>,
    },
    /// A replay, and the screen to return to.
    Replay {
        replay: Box<Replay>,
        back: Option<Box<Screen>>,
    },
}

/// The program with its window.
struct Window {
    station: Option<Station>,
    language: WindowLanguage,
    desk: Desk,
    /// Pictures of the list.
    thumbnails: Thumbnails,
    /// Pictures of the briefing that was opened last.
    pictures: BriefingPictures,
    screen: Screen,
    canvas: Canvas,
    /// The constant part of the pictures of the last attempt, with nothing hidden.
    stage: Stage,
    /// The error to show.
    error: Option<String>,
    settings: SettingsPage,
}

/// Opens a window to practise in.
///
/// # Errors
/// If there is no display or no graphics adapter.
pub fn play(station: Station) -> Outcome {
    let screen = match (station.shelf.exercises.as_slice(), station.shelf.broken.as_slice()) {
        ([_], []) if !station.shelf.is_reading() => Screen::Briefing { at: 0, error: None },
        _ => Screen::Choose,
    };
    open_window("Stylet", move |canvas| {
        Ok(Window {
            language: station.language,
            station: Some(station),
            desk: Desk::default(),
            thumbnails: Thumbnails::default(),
            pictures: BriefingPictures::default(),
            screen,
            canvas,
            stage: Stage::default(),
            error: None,
            settings: SettingsPage::default(),
        })
    })
}

/// Opens a window on a recording, optionally with a second one as a ghost.
///
/// # Errors
/// If a recording is rejected, or there is no display or no graphics adapter.
pub fn watch(path: &Path, recording: Recording, other: Option<Recording>, language: WindowLanguage) -> Outcome {
    let bundle = sources::own_exercise(path, &recording)?;
    let stage = picture::stage_of_recording(path, &bundle, &recording)?;
    let (recording, other) = (Arc::new(recording), other.map(Arc::new));
    let title = words::within(language.spoken(), || tr!("Stylet: replay"));
    open_window(title, move |mut canvas| {
        canvas.set_stage(&stage)?;
        let replay = replay(&bundle, &recording, other.as_ref());
        Ok(Window {
            station: None,
            language,
            desk: Desk::default(),
            thumbnails: Thumbnails::default(),
            pictures: BriefingPictures::default(),
            screen: Screen::Replay { replay, back: None },
            canvas,
            stage,
            error: None,
            settings: SettingsPage::default(),
        })
    })
}

fn replay(bundle: &ExerciseBundle, recording: &Arc<Recording>, other: Option<&Arc<Recording>>) -> Box<Replay> {
    let replay = Replay::new(bundle, recording);
    Box::new(match other {
        Some(other) => replay.beside(bundle, other),
        None => replay,
    })
}

fn open_window(
    title: &str,
    make: impl FnOnce(Canvas) -> Result<Window, Box<dyn std::error::Error + Send + Sync>>,
) -> Outcome {
    let viewport =
        egui::ViewportBuilder::default().with_inner_size([1280.0, 720.0]).with_min_inner_size([900.0, 500.0]);
    let viewport = viewport.with_title(title);
    let mut options = NativeOptions { viewport, ..NativeOptions::default() };
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        let descriptor = Arc::clone(&setup.device_descriptor);
        setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
            let shows = |adapter: &&Adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface));
            let adapters = adapters.iter().filter(shows).cloned().collect();
            render::usable_adapter(adapters, &*descriptor).map_err(|error| error.to_string())
        }));
    }
    let create = |context: &CreationContext<'_>| {
        let state = context
            .wgpu_render_state
            .as_ref()
            .ok_or("no graphics adapter; run stylet doctor to see what is missing")?;
        colours::apply_colours(&context.egui_ctx);
        context.egui_ctx.send_viewport_cmd(egui::ViewportCommand::Maximized(true));
        Ok(Box::new(make(Canvas::new(state))?) as Box<dyn App>)
    };
    eframe::run_native(title, options, Box::new(create))
        .map_err(|error| Failure::work(format_args!("no window: {error}; run stylet doctor to see what is missing")))
}

#[cfg(test)]
mod tests;

impl App for Window {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        words::within(self.language.spoken(), || {
            let screen = std::mem::replace(&mut self.screen, Screen::Choose);
            self.screen = self.show(ui, screen);
            self.keep_open(ui);
            full_screen(ui);
            if let Some(error) = &self.error {
                egui::Window::new(tr!("Something went wrong")).show(ui.ctx(), |ui| ui.label(error));
            }
        });
    }
}

/// Toggles full screen with F11.
fn full_screen(ui: &Ui) {
    if ui.input(|input| input.key_pressed(egui::Key::F11)) {
        let full = ui.input(|input| input.viewport().fullscreen).unwrap_or(false);
        ui.ctx().send_viewport_cmd(egui::ViewportCommand::Fullscreen(!full));
    }
}

impl Window {
    /// Keeps the window open while an attempt is not on disk.
    fn keep_open(&mut self, ui: &Ui) {
        if let Screen::Debrief { debrief, .. } = &mut self.screen
            && ui.input(|input| input.viewport().close_requested())
            && !debrief.may_close()
        {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::CancelClose);
        }
    }

    /// Shows a screen; returns the next one.
    fn show(&mut self, ui: &mut Ui, screen: Screen) -> Screen {
        match screen {
            Screen::Choose => self.choose(ui),
            Screen::Wall(mut page) => match page.ui(ui) {
                false => Screen::Wall(page),
                true => Screen::Choose,
            },
            Screen::Briefing { at, error } => self.brief(ui, at, error),
            Screen::Preparing { at, preparation } => self.prepare(ui, at, preparation),
            Screen::Trial { at, mut trial } => match trial.ui(ui, &mut self.canvas) {
                trial::AfterTrial::Stay => Screen::Trial { at, trial },
                trial::AfterTrial::Over => self.debrief(at, *trial),
            },
            Screen::Debrief { at, debrief, trial } => self.after(ui, at, debrief, trial),
            Screen::Replay { mut replay, back } => match (replay.ui(ui, &mut self.canvas), back) {
                (false, back) => Screen::Replay { replay, back },
                (true, Some(back)) => *back,
                (true, None) => {
                    ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
                    Screen::Replay { replay, back: None }
                }
            },
        }
    }

    fn choose(&mut self, ui: &mut Ui) -> Screen {
        let Some(station) = &mut self.station else { return Screen::Choose };
        if let Some(pairing) = &station.pairing {
            self.desk.ui(ui, pairing, &mut self.language);
        }
        if let (Some(pairing), true) = (&station.pairing, self.desk.asks_consent()) {
            self.desk.show_consent(ui, pairing);
            return Screen::Choose;
        }
        let who = self.desk.signed_in();
        let listing = who.as_ref().map_or(choose::Listing::Here, |who| match who.guest {
            true => choose::Listing::Study(&who.exercises),
            false => choose::Listing::School(&who.exercises),
        });
        for broken in station.shelf.take_arrived() {
            output::print_warning(format_args!("skipped: {}", broken.why));
        }
        let choice = choose::ExerciseChoice { shelf: &station.shelf, history: &station.history, listing };
        let controls = choose::ListControls {
            language: &mut self.language,
            settings: &mut self.settings.open,
            thumbnails: &mut self.thumbnails,
        };
        let chosen = choose::choose_exercise(ui, &choice, controls);
        self.settings.ui(ui, &mut station.settings, &mut station.device);
        match chosen {
            Some(at) => Screen::Briefing { at, error: None },
            None if std::mem::take(&mut self.settings.tests_wall) => self.feel_wall(),
            None => Screen::Choose,
        }
    }

    /// Opens the chosen device at a virtual wall.
    fn feel_wall(&mut self) -> Screen {
        let Some(station) = &self.station else { return Screen::Choose };
        let desk = open::Desk { args: &station.devices, settings: &station.settings };
        match WallTest::start(&station.device, &desk, TICK_HZ) {
            Ok(test) => {
                self.settings.untested = None;
                Screen::Wall(Box::new(WallPage::new(test, station.settings.pointer_speed)))
            }
            Err(failure) => {
                self.settings.untested = Some(failure.to_string());
                Screen::Choose
            }
        }
    }

    fn brief(&mut self, ui: &mut Ui, at: usize, error: Option<String>) -> Screen {
        let Some(station) = &mut self.station else { return Screen::Choose };
        let Some(Offer { bundle, .. }) = station.shelf.exercises.get(at) else { return Screen::Choose };
        if let Some(pairing) = &station.pairing {
            self.desk.ui(ui, pairing, &mut self.language);
        }
        if let (Some(pairing), true) = (&station.pairing, self.desk.asks_consent()) {
            self.desk.show_consent(ui, pairing);
            return Screen::Briefing { at, error };
        }
        let briefing = Briefing {
            exercise: &bundle.exercise,
            pictures: self.pictures.of(bundle),
            device: &words::phrase(&station.device.phrase()),
            by_hand: matches!(station.device, open::DeviceChoice::Auto | open::DeviceChoice::Mouse),
            guided: &mut station.guided,
            ready: !self.desk.is_asking(),
            error: error.as_deref(),
            language: &mut self.language,
        };
        match briefing::show_briefing(ui, briefing) {
            Decision::Stay => Screen::Briefing { at, error },
            Decision::Back => Screen::Choose,
            Decision::Begin => {
                let seed = station.seed;
                station.seed = seed.wrapping_add(1);
                let preparation = Preparation::start(ExerciseBundle::clone(bundle), seed);
                Screen::Preparing { at, preparation }
            }
        }
    }

    fn prepare(&mut self, ui: &mut Ui, at: usize, preparation: Preparation) -> Screen {
        briefing::show_preparing(ui, preparation.share());
        if !preparation.is_over() {
            ui.ctx().request_repaint_after(BEAT);
            return Screen::Preparing { at, preparation };
        }
        match preparation.finish().and_then(|prepared| self.begin(prepared)) {
            Ok(trial) => Screen::Trial { at, trial },
            Err(failure) => Screen::Briefing { at, error: Some(failure.to_string()) },
        }
    }

    /// Begins a prepared attempt: picture, device, servo and recorder.
    fn begin(&mut self, prepared: PreparedAttempt) -> Result<Box<TrialScreen>, Failure> {
        let station = self.station.as_mut().ok_or_else(|| Failure::input(tr!("no exercise is selected")))?;
        let PreparedAttempt { bundle, seed, specimen, stage, fluoroscope } = prepared;
        let file = Path::new(&bundle.exercise.id);
        let given = picture::hide_what_is_withheld(&stage, bundle.exercise.feedback);
        self.canvas.set_stage(&given).map_err(|error| Failure::refused(file, error))?;
        self.stage = stage;
        let mut opened = open::open(
            &station.device,
            &open::Desk { args: &station.devices, settings: &station.settings },
            &bundle,
            seed,
            TICK_HZ,
        )?;
        if let Steered::Window(aim) = &mut opened.steered {
            aim.write(Steering::new(&bundle).follow(&SteeringWish::default()));
        }
        // Once an arm was used it is required: a loose cable must not replace it by the mouse.
        if let Some(again) = opened.again().filter(|_| station.device == open::DeviceChoice::Auto) {
            station.device = again;
        }
        let info = opened.driven.info();
        let name = match &opened.steered {
            Steered::Gamepad(feed) => feed.name(),
            Steered::Itself | Steered::Window(_) => &info.name,
        };
        let maker = Maker { device: name, device_max_force_n: info.max_force_n, seed, tick_hz: TICK_HZ };
        let signed_in = self.desk.signed_in();
        let is_program = matches!(station.device, open::DeviceChoice::Operator(_));
        // The station signs attempts of trainees who have signed in with a code, but none of a
        // virtual operator.
        let key = station.key.clone().filter(|_| signed_in.is_some() && !is_program);
        let trainee = signed_in.map_or_else(|| station.trainee.clone(), |who| who.trainee);
        let session = Session { trainee, ..maker.session(&bundle) };
        let path = station.folder.join(format!("{}.mcap", session.session_id));
        let settings = bundle.exercise.fluoroscopy.as_ref();
        let arm = fluoroscope.zip(settings).map(|(arm, settings)| LiveArm::start(arm, settings, seed)).transpose()?;
        let trial = live::LiveTrial { bundle, specimen, session, path, arm, key };
        let live = Live::start(trial, opened.mapping, opened.driven)?;
        Ok(Box::new(TrialScreen::new(live, opened.steered, opened.passed_over, station)))
    }

    fn debrief(&mut self, at: usize, trial: TrialScreen) -> Screen {
        let (trial, finished) = trial.stop();
        let pairing = self.station.as_ref().and_then(|station| station.pairing.clone());
        let asked = self.desk.note_attempt(&trial.bundle.exercise.id);
        match Debrief::new(&trial, finished, pairing, asked) {
            Ok(debrief) => {
                if let (Some(station), Some(assessment)) = (&self.station, debrief.assessment()) {
                    station.history.add(&trial.session, assessment);
                }
                Screen::Debrief { at, debrief: Box::new(debrief), trial }
            }
            Err(failure) => Screen::Briefing { at, error: Some(failure.to_string()) },
        }
    }

    fn after(&mut self, ui: &mut Ui, at: usize, mut debrief: Box<Debrief>, trial: Arc<live::LiveTrial>) -> Screen {
        match debrief.ui(ui, &trial) {
            Ok(debrief::AfterDebrief::Stay) => Screen::Debrief { at, debrief, trial },
            Ok(debrief::AfterDebrief::Retry) => Screen::Briefing { at, error: None },
            Ok(debrief::AfterDebrief::Choose) => Screen::Choose,
            Ok(debrief::AfterDebrief::Replay(recording)) => {
                let replay = replay(&trial.bundle, &recording, None);
                // A replay also shows the parts that were hidden during the attempt.
                if let Err(error) = self.canvas.set_stage(&self.stage) {
                    self.error = Some(error.to_string());
                }
                Screen::Replay { replay, back: Some(Box::new(Screen::Debrief { at, debrief, trial })) }
            }
            Err(failure) => {
                self.error = Some(failure.to_string());
                Screen::Debrief { at, debrief, trial }
            }
        }
    }
}
