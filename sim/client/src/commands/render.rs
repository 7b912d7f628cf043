//! `stylet render`: renders an image of a recording or an exercise, or the frames of a film,
//! without a window.

mod radiograph;

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use documents::{ExerciseBundle, Patient};
use render::frame::{Frame, Stage, View};
use render::{Headless, PictureError, Quality};

use self::radiograph::{RadiographArgs, XRayCamera};
use crate::exit::{Failure, Outcome};
use crate::new_file::create_folder;
use crate::picture::{self, Look, Moment, Telling};
use crate::progress::Progress;
use crate::{output, sources};

/// Maximum width and height of an image, in pixels.
const MOST_PIXELS: u32 = 8192;

/// Render a recording or an exercise without a window
///
/// An exercise is rendered with the needle at its start. The same recording and time give the same
/// bytes on the same graphics adapter.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet render attempt.mcap --at 4.2 --view tip --out pop.png\n  \
    stylet render attempt.mcap --frames film --fps 30\n  \
    stylet render attempt.mcap --at 20 --x-ray 30,0 --contrast-ml 8 --out oblique.png")]
pub struct RenderArgs {
    /// A recording or an exercise
    #[arg(value_name = "REC.mcap|EXERCISE.toml")]
    what: PathBuf,
    /// Time of the image, in s since the start
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = seconds, allow_negative_numbers = true)]
    at: f64,
    /// Size of the image, in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720")]
    size: PictureSize,
    /// whole, patient, tip or section
    #[arg(long, value_name = "VIEW", default_value = "whole", value_parser = view)]
    view: View,
    /// Hide the planned line, entry and target
    #[arg(long)]
    free: bool,
    /// The image to write
    #[arg(long, value_name = "P.png", required_unless_present = "frames", conflicts_with = "frames")]
    out: Option<PathBuf>,
    /// Folder for the frames of a film: 00000.png, 00001.png, …
    #[arg(long, value_name = "DIR", conflicts_with = "at")]
    frames: Option<PathBuf>,
    /// Frames per second of a film
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=240))]
    fps: u32,
    #[command(flatten)]
    radiograph: RadiographArgs,
}

/// Width and height, in pixels.
#[derive(Clone, Copy)]
struct PictureSize([u32; 2]);

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |side: &str| side.parse().ok().filter(|side| (1..=MOST_PIXELS).contains(side));
        let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
        sides.map(Self).ok_or_else(|| format!("allowed: two numbers from 1 to {MOST_PIXELS}, for example 1280x720"))
    }
}

fn view(text: &str) -> Result<View, String> {
    match text {
        "whole" => Ok(View::Whole),
        "patient" => Ok(View::Patient),
        "tip" => Ok(View::Tip),
        "section" => Ok(View::Section),
        _ => Err("allowed: whole, patient, tip or section".to_owned()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| seconds.is_finite() && *seconds >= 0.0);
    seconds.ok_or_else(|| "allowed: a time of 0 s or more".to_owned())
}

/// The content to render.
struct Film {
    bundle: ExerciseBundle,
    /// Seed of the attempt; 0 for an exercise.
    seed: u64,
    /// What a graphics adapter draws; `None` for radiographs, which need no tissue model.
    stage: Option<Stage>,
    look: Look,
    source: MomentSource,
}

/// Source of the moments.
enum MomentSource {
    /// A recording and its duration, in s.
    Recording(Box<Telling>, f64),
    /// An exercise, with the needle at its start.
    Exercise(Box<Moment>),
}

impl Film {
    fn frame(&mut self, t_s: f64) -> Frame {
        let moment = match &mut self.source {
            MomentSource::Recording(telling, _) => telling.at(t_s),
            MomentSource::Exercise(moment) => moment,
        };
        moment.frame(&self.look, self.bundle.exercise.target_depth_mm * 1e-3)
    }

    fn duration_s(&self) -> f64 {
        match self.source {
            MomentSource::Recording(_, duration_s) => duration_s,
            MomentSource::Exercise(_) => 0.0,
        }
    }
}

/// Runs the command.
pub fn run(args: &RenderArgs) -> Outcome {
    let mut film = if args.what.extension().is_some_and(|extension| extension == "toml") {
        of_exercise(args)?
    } else {
        of_recording(args)?
    };
    if args.at > film.duration_s() && args.at > 0.0 {
        let allowed = format!("--at {} s: the attempt lasts {:.3} s", args.at, film.duration_s());
        return Err(Failure::refused(&args.what, allowed));
    }
    let mut painter = Painter::new(args, &film)?;
    match (&args.out, &args.frames) {
        (Some(out), _) => still(&mut painter, &film.frame(args.at), out),
        (None, Some(folder)) => frames(&mut painter, &mut film, args, folder),
        (None, None) => Ok(()),
    }
}

/// What makes an image of a frame.
enum Painter {
    /// A graphics adapter, and the size in pixels.
    Adapter(Box<Headless>, [u32; 2]),
    /// X-rays, on the processor.
    XRays(Box<XRayCamera>),
}

impl Painter {
    fn new(args: &RenderArgs, film: &Film) -> Result<Self, Failure> {
        let Some(stage) = &film.stage else {
            let camera = XRayCamera::new(&args.what, &film.bundle, &args.radiograph, film.seed)?;
            return Ok(Self::XRays(Box::new(camera)));
        };
        let mut headless = Headless::new(Quality::Full).map_err(Failure::work)?;
        headless.set_stage(stage).map_err(|error| Failure::refused(&args.what, error))?;
        Ok(Self::Adapter(Box::new(headless), args.size.0))
    }

    /// Renders a frame and writes the image. Returns its size and how it was made.
    fn paint(&mut self, frame: &Frame, out: &Path) -> Result<String, Failure> {
        let (saved, description) = match self {
            Self::Adapter(headless, size) => {
                let picture = headless.next(frame, *size).map_err(|error| failure(&error))?;
                let description = format!("{} × {} pixels on {}", size[0], size[1], headless.adapter());
                (picture.save_with_format(out, image::ImageFormat::Png), description)
            }
            Self::XRays(camera) => {
                let (picture, exposure) = camera.expose(frame);
                let description = format!(
                    "{} × {} pixels; {:.3} mAs, {:.1} µGy at the reference point, {:.2} µGy·m²",
                    picture.width(),
                    picture.height(),
                    exposure.load_mas,
                    exposure.kerma_ugy,
                    exposure.kerma_area_ugy_m2
                );
                (picture.save_with_format(out, image::ImageFormat::Png), description)
            }
        };
        saved.map_err(|error| cannot_write(out, &error))?;
        Ok(description)
    }
}

fn of_exercise(args: &RenderArgs) -> Result<Film, Failure> {
    let path = args.what.as_path();
    let bundle = ExerciseBundle::read(path)?;
    let stage = if args.radiograph.are_given() {
        None
    } else {
        let specimen = sources::prepare_specimen(path, &bundle, &Patient::nominal(&bundle.scene))?;
        Some(picture::build_stage(path, &bundle, &specimen)?)
    };
    let source = MomentSource::Exercise(Box::new(Moment::before(&bundle, &[])));
    let look = Look { view: args.view, ..Look::at(&bundle.scene, !args.free) };
    Ok(Film { bundle, seed: 0, stage, look, source })
}

fn of_recording(args: &RenderArgs) -> Result<Film, Failure> {
    let path = args.what.as_path();
    let recording = sources::read_recording(path)?;
    let bundle = sources::own_exercise(path, &recording)?;
    let drawn = !args.radiograph.are_given();
    let stage = drawn.then(|| picture::stage_of_recording(path, &bundle, &recording)).transpose()?;
    let duration_s = recording.samples.last().map_or(0.0, |sample| sample.t_s);
    let look = Look { view: args.view, ..Look::at(&bundle.scene, !args.free) };
    let seed = recording.session.seed;
    let source = MomentSource::Recording(Box::new(Telling::new(Arc::new(recording), &bundle)), duration_s);
    Ok(Film { bundle, seed, stage, look, source })
}

fn still(painter: &mut Painter, frame: &Frame, out: &Path) -> Outcome {
    let description = painter.paint(frame, out)?;
    output::print_line(format_args!("{}: {description}", out.display()))
}

fn frames(painter: &mut Painter, film: &mut Film, args: &RenderArgs, folder: &Path) -> Outcome {
    create_folder(folder)?;
    let count = (film.duration_s() * f64::from(args.fps)).floor() as u64 + 1;
    let progress = Progress::new(count, "drawing");
    let mut description = String::new();
    for at in 0..count {
        let frame = film.frame(at as f64 / f64::from(args.fps));
        description = painter.paint(&frame, &folder.join(format!("{at:05}.png")))?;
        progress.set(at + 1);
    }
    drop(progress);
    output::print_line(format_args!(
        "{}: {count} frames at {} per second; each {description}",
        folder.display(),
        args.fps
    ))
}

/// An unsupported size is a usage error; all other errors are the adapter's.
fn failure(error: &PictureError) -> Failure {
    match error {
        PictureError::Size { .. } => Failure::input(error),
        _ => Failure::work(error),
    }
}

fn cannot_write(out: &Path, error: &image::ImageError) -> Failure {
    Failure::work(format_args!("{}: {error}", out.display()))
}
