//! `stylet calibrate`: fits a scene to a measured force–depth curve.

mod data;
mod report;
mod sheet;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::builder::RangedU64ValueParser;
use documents::{DocumentError, Patient, Scene};
use law::axial::AxialSpec;
use report::{CalibrationReport, SampleCount};
use tissue::calibrate::{self, CalibrateError, Fit, Fresh, Start};

use self::data::MeasuredCurve;

use crate::exit::{Failure, Outcome};
use crate::new_file::NewFile;
use crate::progress::Progress;
use crate::{output, sources};

/// Weight of the patient that a curve is assumed to be from, in kg (Stylet's physics, section 2;
/// literature).
const REFERENCE_KG: f64 = 71.1;
/// Exponent of the growth of the layers with the weight (literature).
const WEIGHT_EXPONENT: f64 = 1.5;

/// Fit a scene's layers to a measured force–depth curve
///
/// DATA.csv has the columns depth_m (displacement of the tip from the skin) and force_n (positive
/// pushes the needle out), from a slow perpendicular insertion and, if measured, the withdrawal,
/// which alone reveals friction. Lines that start with # are comments. Each drop of the force is a
/// ruptured boundary. Thickness, stiffness, thresholds, friction and cutting of every layer are
/// fitted within bounds; the result is always sound. Prints the residual, the error of each peak,
/// the 95 % interval of each parameter that the curve determines, and the parameters that it does
/// not determine, and warns if the residual exceeds the curve's own noise.
///
/// With a third column t_s (time in s, which must increase) and a --start of law 3 the curve may
/// hold, withdraw and enter the same track again, and options are fitted as well: those that the
/// start names in a layer (stiffening_n_per_m2, relaxation, static_friction_n_per_m, damping above
/// 0), and the needle's presliding stiffness and breakaway_mm. A hold reveals relaxation, a stop of
/// the needle damping, a withdrawal friction, a second insertion friction without cutting.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    stylet calibrate specimen.csv --out specimen.toml\n  \
    stylet calibrate epidural.csv --start curricula/scenes/epidural-71kg.toml --weight-kg 90 --out epidural-90kg.toml\n  \
    stylet calibrate held.csv --start curricula/scenes/liver-18g.toml --out mine.toml")]
pub struct CalibrateArgs {
    /// The measured curve: a header with depth_m (m), force_n (N) and, for options of law 3, t_s
    /// (s); other columns are ignored
    #[arg(value_name = "DATA.csv")]
    data: PathBuf,
    /// The scene to write; its file name becomes the scene's id
    #[arg(long, value_name = "SCENE.toml")]
    out: PathBuf,
    /// A starting scene: its layers, names, needle and all values that the curve does not determine
    /// are kept
    #[arg(long, value_name = "SCENE.toml", conflicts_with_all = ["layers", "tip_to_rim_mm"])]
    start: Option<PathBuf>,
    /// Number of layers, the largest drops first [default: as many as the drops justify]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=32))]
    layers: Option<usize>,
    /// Distance from a trocar's tip to its rim, in mm, 0 to 50; 0 is a needle. Its drops are
    /// assumed to alternate between tip and rim
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = tip_to_rim, allow_negative_numbers = true)]
    tip_to_rim_mm: f64,
    /// Write the scene for a patient of this weight, in kg, 30 to 200: depths × (weight/71.1)^1.5
    /// at the same forces
    #[arg(long, value_name = "KG", value_parser = weight, allow_negative_numbers = true)]
    weight_kg: Option<f64>,
    /// Replace the scene if it exists
    #[arg(long)]
    force: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &CalibrateArgs) -> Outcome {
    let mut file = NewFile::create(&args.out, args.force)?;
    let start = args.start.as_deref().map(|path| read_start(path, args.weight_kg.is_some())).transpose()?;
    let curve = data::read(&args.data, is_optioned(start.as_ref())?)?;
    check_weight(args, &curve)?;
    let fitted = fit(args, &curve, start.as_ref())?;
    let (samples, left_out) = (curve.len(), curve.left_out());
    let scale = scale_of(args);
    let target = stretched(&fitted.spec, scale);
    let base = start.unwrap_or_else(|| Base::fresh(&args.out, &args.data, &target));
    let written = write(args, &base, &target, &curve.stretched(scale))?;
    file.file()
        .write_all(written.text.as_bytes())
        .map_err(|error| Failure::work(format_args!("{}: {error}", args.out.display())))?;
    file.keep()?;
    let report = CalibrationReport::new(args, SampleCount { samples, left_out }, &fitted, &written);
    report.warn();
    if args.json { output::print_json(&report) } else { output::print_buffered(|out| report.write(out)) }
}

/// Ratio of the depths of the written scene to those of the curve.
fn scale_of(args: &CalibrateArgs) -> f64 {
    args.weight_kg.map_or(1.0, |kg| libm::pow(kg / REFERENCE_KG, WEIGHT_EXPONENT))
}

/// Whether options are fitted: to a timed curve, from a scene that may have them.
fn is_optioned(start: Option<&Base>) -> Result<bool, DocumentError> {
    let start = start.map(Base::scene).transpose()?;
    Ok(start.is_some_and(|scene| calibrate::needs_times(&scene.axial_spec(&Patient::nominal(&scene)))))
}

/// Rejects `--weight-kg` for a timed curve, whose depths are not scaled.
fn check_weight(args: &CalibrateArgs, curve: &MeasuredCurve) -> Result<(), Failure> {
    match (curve, args.weight_kg) {
        (MeasuredCurve::Timed(_), Some(kg)) => {
            let why = format!("--weight-kg {kg}: depths of a curve with times cannot be scaled; omit this option");
            Err(Failure::refused(&args.data, why))
        }
        _ => Ok(()),
    }
}

/// The text into which the fitted numbers are inserted.
struct Base {
    path: PathBuf,
    text: String,
}

/// A written scene.
struct WrittenScene {
    text: String,
    scene: Scene,
    /// Root mean square residual of the written scene on the curve, in N.
    rms_n: f64,
    /// Ratio of its depths to those of the curve.
    depth_scale: f64,
}

impl Base {
    fn fresh(out: &Path, data: &Path, spec: &AxialSpec) -> Self {
        Self { path: out.to_owned(), text: sheet::blank(data, spec) }
    }

    fn scene(&self) -> Result<Scene, DocumentError> {
        documents::load::read_layered_scene_text(&self.path, &self.text)
    }
}

fn read_start(path: &Path, is_scaled: bool) -> Result<Base, Failure> {
    let base = Base { path: path.to_owned(), text: sources::read_text(path)? };
    let scene = base.scene()?;
    if is_scaled && !scene.structures.is_empty() {
        let why = "structure: a scene with structures cannot be made for another weight, because their positions would not \
             be scaled";
        return Err(Failure::refused(path, why));
    }
    Ok(base)
}

fn fit(args: &CalibrateArgs, curve: &MeasuredCurve, start: Option<&Base>) -> Result<Fit, Failure> {
    let progress = Progress::busy("fitting");
    let mut watch = |done: u32| progress.set(u64::from(done));
    let fresh = Fresh { layers: args.layers, tip_to_rim_m: args.tip_to_rim_mm / 1e3 };
    let spec = start.map(|base| read_law(args, base, curve)).transpose()?;
    let from = spec.as_ref().map_or(Start::Fresh(fresh), Start::Scene);
    let fitted = match (curve, from) {
        (MeasuredCurve::Timed(curve), Start::Scene(spec)) => calibrate::fit_timed(curve, spec, &mut watch),
        (MeasuredCurve::Timed(_), Start::Fresh(_)) => {
            return Err(Failure::work("a curve with times needs a starting scene (--start)"));
        }
        (MeasuredCurve::Slow(curve), from) => calibrate::fit(curve, from, &mut watch),
    };
    fitted.map_err(|error| match error {
        CalibrateError::TooFewDrops { .. } => Failure::refused(&args.data, format_args!("{error} (--layers, --start)")),
        _ => Failure::refused(&args.data, error),
    })
}

/// The law of a starting scene. A threshold that follows from a fracture energy has no value that a
/// fit could change.
fn read_law(args: &CalibrateArgs, base: &Base, curve: &MeasuredCurve) -> Result<AxialSpec, Failure> {
    let scene = base.scene()?;
    let is_fractured = |layer: &documents::SceneLayer| layer.options.fracture_energy_j_per_m2.is_some();
    if let (MeasuredCurve::Timed(_), Some(at)) = (curve, scene.layers.iter().position(is_fractured)) {
        let energy = scene.layers[at].options.fracture_energy_j_per_m2.unwrap_or_default();
        let why = format!(
            "{}: layer[{at}].fracture_energy_j_per_m2 = {energy} J/m²; allowed in a starting scene: tip_rupture_n",
            base.path.display()
        );
        return Err(Failure::refused(&args.data, why));
    }
    Ok(scene.axial_spec(&Patient::nominal(&scene)))
}

/// The law with every depth multiplied and every force kept: k w and c l stay constant if w and l
/// grow and k and c shrink. So a sound law stays sound; its energies grow with the depths.
fn stretched(spec: &AxialSpec, factor: f64) -> AxialSpec {
    let mut spec = spec.clone();
    for layer in &mut spec.layers {
        layer.thickness_m *= factor;
        layer.stiffness_n_per_m /= factor;
        layer.friction_n_per_m /= factor;
    }
    spec
}

/// Inserts the numbers into the text and parses it again, so that the report describes the file,
/// including rounding.
fn write(
    args: &CalibrateArgs,
    base: &Base,
    target: &AxialSpec,
    curve: &MeasuredCurve,
) -> Result<WrittenScene, Failure> {
    let id = sheet::id_of(&args.out);
    let old = base.scene()?;
    let put = |source: &str| -> Result<(String, Scene, f64), Failure> {
        let text = documents::rewrite::rewrite_document(&base.text, &old, target, &id, source)?;
        let scene = documents::load::read_scene_text(&args.out, &text)?;
        let spec = scene.axial_spec(&Patient::nominal(&scene));
        let rms_n = curve.residual_rms_n(&spec).map_err(|why| Failure::refused(&args.out, why))?;
        Ok((text, scene, rms_n))
    };
    let (_, _, rms_n) = put("")?;
    let (text, scene, rms_n) = put(&sheet::source(args, rms_n, curve))?;
    let findings = scene.soundness(0.0).map_err(|why| Failure::refused(&args.out, why))?;
    match findings.first() {
        None => Ok(WrittenScene { text, scene, rms_n, depth_scale: scale_of(args) }),
        Some(finding) => {
            let patient = &finding.patient;
            Err(Failure::work(format_args!(
                "{}: not written: with the start's thickness_spread_mm the {patient} patient is unsound: {}",
                args.out.display(),
                finding.unsound
            )))
        }
    }
}

fn tip_to_rim(text: &str) -> Result<f64, String> {
    within(text, 0.0, 50.0, "mm")
}

fn weight(text: &str) -> Result<f64, String> {
    within(text, 30.0, 200.0, "kg")
}

fn within(text: &str, least: f64, most: f64, unit: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("{text} {unit}; allowed: a number from {least} {unit} to {most} {unit}")),
    }
}
