//! Radiographs of an attempt, on the processor.

use std::path::Path;
use std::str::FromStr;

use attempt::fluoroscopy::ImagedBody;
use documents::ExerciseBundle;
use guidance::{BodyShadow, Exposure, KermaLevel, PIXELS, Pulse, Radiograph, mean_transmission};
use image::{GrayImage, Luma};
use recording::CArmControls;
use render::frame::Frame;

use crate::exit::Failure;
use crate::picture;

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
pub struct XRayCamera {
    body: ImagedBody,
    shadow: BodyShadow,
    exposure: Exposure,
    seed: u64,
    pulses: u32,
}

impl XRayCamera {
    /// Places the C-arm; `file` is named in errors.
    ///
    /// # Errors
    /// If the scene has no body, or the C-arm cannot be placed so.
    pub fn new(file: &Path, bundle: &ExerciseBundle, args: &RadiographArgs, seed: u64) -> Result<Self, Failure> {
        let body = ImagedBody::new(bundle).map_err(|why| Failure::refused(file, why))?;
        let ArmAngles([orbital_deg, tilt_deg]) = args.x_ray.unwrap_or(ArmAngles([0.0; 2]));
        let controls = CArmControls {
            orbital_rad: orbital_deg.to_radians(),
            tilt_rad: tilt_deg.to_radians(),
            field_m: args.field_mm * 1e-3,
            contrast_ml: args.contrast_ml,
            ..CArmControls::default()
        };
        let arm = body.arm(&controls);
        arm.check().map_err(Failure::input)?;
        let mean = mean_transmission(&arm, &body.volumes(args.contrast_ml));
        let mean = mean.map_err(|why| Failure::refused(file, why))?;
        let shadow = body.shadow(&controls).map_err(|why| Failure::refused(file, why))?;
        let level = match args.dose {
            Dose::Low => KermaLevel::Low,
            Dose::Normal => KermaLevel::Normal,
            Dose::Boost => KermaLevel::Boost,
        };
        Ok(Self { body, shadow, exposure: Exposure::control(&arm, level, mean), seed, pulses: 0 })
    }

    /// Exposes the detector with the needle of a frame. The noise follows from the attempt's seed and the number of the pulse.
    pub fn expose(&mut self, frame: &Frame) -> (GrayImage, Exposure) {
        let pulse = Pulse { seed: self.seed, index: self.pulses, exposure: self.exposure };
        self.pulses += 1;
        let radiograph = Radiograph::expose(&self.shadow, Some(&picture::image_needle(&self.body, frame)), pulse);
        let edge = PIXELS as u32;
        let grey = |column, row| Luma([radiograph.greys[(row * edge + column) as usize]]);
        (GrayImage::from_fn(edge, edge, grey), self.exposure)
    }
}
