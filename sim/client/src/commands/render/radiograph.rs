//! Radiographs of an attempt, on the processor.

use std::path::Path;
use std::str::FromStr;

use anatomy::{Body, BodyEntry, BodyQuality, BodySide, Contrast};
use documents::{ExerciseBundle, Needle};
use guidance::{BodyShadow, CArm, Exposure, ImagedNeedle, KermaLevel, PIXELS, Pulse, Radiograph};
use image::{GrayImage, Luma};
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use render::frame::Frame;

use crate::exit::Failure;

/// Options of a radiograph.
#[derive(clap::Args)]
pub struct RadiographArgs {
    /// Take a radiograph: the C-arm's orbital angle, positive to the patient's right, and its tilt, positive to the head, in degrees
    #[arg(
        long,
        value_name = "ORBITAL,TILT",
        allow_hyphen_values = true,
        conflicts_with_all = ["size", "view", "free"]
    )]
    x_ray: Option<ArmAngles>,
    /// Volume of contrast medium in the collecting system of the kidney on the target's side, in ml
    #[arg(
        long,
        value_name = "ML",
        requires = "x_ray",
        default_value_t = 0.0,
        value_parser = volume_ml,
        allow_negative_numbers = true
    )]
    contrast_ml: f64,
    /// Edge of the collimated field at the detector, in mm
    #[arg(long, value_name = "MM", requires = "x_ray", default_value_t = 300.0)]
    field_mm: f64,
    /// Air kerma at the detector, for which the exposure control sets the tube load: a higher one has less noise
    #[arg(long, value_name = "LEVEL", requires = "x_ray", default_value = "low")]
    dose: Dose,
}

/// Level of the exposure control.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Dose {
    /// 30 nGy
    Low,
    /// 45 nGy
    Normal,
    /// 65 nGy
    Boost,
}

/// Angles of a C-arm, in degrees.
#[derive(Clone, Copy)]
struct ArmAngles([f64; 2]);

impl FromStr for ArmAngles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let degrees = |part: &str| part.trim().parse().ok().filter(|degrees: &f64| degrees.is_finite());
        let angles = text.split_once(',').and_then(|(orbital, tilt)| Some([degrees(orbital)?, degrees(tilt)?]));
        angles.map(Self).ok_or_else(|| "allowed: two numbers in degrees, for example 30,0".to_owned())
    }
}

fn volume_ml(text: &str) -> Result<f64, String> {
    let volume = text.parse().ok().filter(|volume: &f64| (0.0..=100.0).contains(volume));
    volume.ok_or_else(|| "allowed: 0 to 100 ml".to_owned())
}

impl RadiographArgs {
    /// Whether radiographs are asked for.
    pub fn are_given(&self) -> bool {
        self.x_ray.is_some()
    }
}

/// A C-arm that is placed around an exercise's target.
pub struct Fluoroscope {
    entry: BodyEntry,
    needle: Needle,
    shadow: BodyShadow,
    level: KermaLevel,
    seed: u64,
    pulses: u32,
}

impl Fluoroscope {
    /// Places the C-arm; `file` is named in errors.
    ///
    /// # Errors
    /// If the scene has no body, or the C-arm cannot be placed so.
    pub fn new(file: &Path, bundle: &ExerciseBundle, args: &RadiographArgs, seed: u64) -> Result<Self, Failure> {
        let Some(scene_body) = &bundle.scene.body else {
            return Err(Failure::refused(file, "a scene without a body; allowed with --x-ray: a scene with [anatomy]"));
        };
        let (body, entry) = scene_body.enter().map_err(|why| Failure::refused(file, why))?;
        let target_m = to_body(&entry, &bundle.exercise.target_m());
        let ArmAngles([orbital_deg, tilt_deg]) = args.x_ray.unwrap_or(ArmAngles([0.0; 2]));
        let arm = CArm {
            orbital_rad: orbital_deg.to_radians(),
            tilt_rad: tilt_deg.to_radians(),
            field_m: args.field_mm * 1e-3,
            ..CArm::over(target_m)
        };
        arm.check().map_err(Failure::input)?;
        let shadow =
            cast_shadow(&body, &arm, &target_m, args.contrast_ml).map_err(|why| Failure::refused(file, why))?;
        let level = match args.dose {
            Dose::Low => KermaLevel::Low,
            Dose::Normal => KermaLevel::Normal,
            Dose::Boost => KermaLevel::Boost,
        };
        Ok(Self { entry, needle: bundle.scene.needle.clone(), shadow, level, seed, pulses: 0 })
    }

    /// Exposes the detector with the needle of a frame. The noise follows from the attempt's seed and the number of the pulse.
    pub fn expose(&mut self, frame: &Frame) -> (GrayImage, Exposure) {
        let pulse = Pulse { seed: self.seed, index: self.pulses, level: self.level };
        self.pulses += 1;
        let radiograph = Radiograph::expose(&self.shadow, Some(&self.imaged_needle(frame)), pulse);
        let edge = PIXELS as u32;
        let grey = |column, row| Luma([radiograph.greys[(row * edge + column) as usize]]);
        let picture = GrayImage::from_fn(edge, edge, grey);
        (picture, radiograph.exposure)
    }

    fn imaged_needle(&self, frame: &Frame) -> ImagedNeedle {
        let [x, y, z, w] = frame.orientation.map(f64::from);
        let axis = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)) * Vector3::z();
        let Needle { length_mm, diameter_mm, inner_diameter_mm, .. } = self.needle;
        ImagedNeedle {
            tip_m: to_body(&self.entry, &Point3::from(frame.tip_m.map(f64::from))),
            direction: self.entry.to_body(&axis),
            length_m: length_mm * 1e-3,
            outer_m: diameter_mm * 1e-3,
            bore_m: inner_diameter_mm * 1e-3,
            has_stylet: self.needle.hub == "stylet" && !frame.hub.open,
        }
    }
}

fn cast_shadow(
    body: &Body,
    arm: &CArm,
    target_m: &Point3<f64>,
    volume_ml: f64,
) -> Result<BodyShadow, guidance::OutOfReach> {
    let side = if target_m.x < 0.0 { BodySide::Left } else { BodySide::Right };
    let contrast = (volume_ml > 0.0).then_some(Contrast { side, volume_ml });
    BodyShadow::cast(arm, &body.list_volumes(BodyQuality::Medium, contrast))
}

/// Converts a point from the scene's frame to the body's.
fn to_body(entry: &BodyEntry, own_m: &Point3<f64>) -> Point3<f64> {
    entry.origin_m + entry.to_body(&own_m.coords)
}
