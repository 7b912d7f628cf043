//! The picture of a pulse: transmission, scatter, quanta and grey levels.

use anatomy::BodyVolume;

use crate::attenuation::{BINS, STEEL_PER_CM, coefficients_per_cm, transmit};
use crate::c_arm::{CArm, DETECTOR_M, Detector};
use crate::exposure::Exposure;
use crate::needle::ImagedNeedle;
use crate::noise::{Counter, draw_poisson};
use crate::paths::{OutOfReach, project};

/// Pixels along the detector's edge.
pub const PIXELS: usize = 512;
/// Scattered energy over primary energy. A choice for the eye; no metric reads it.
const SCATTER: f64 = 0.5;
/// Standard deviation of scattered light at the detector, in m. A choice for the eye.
const SCATTER_SPREAD_M: f64 = 0.04;
/// Quanta per mm² and µGy of the beam behind a patient (RQA5, IEC 62220-1), recalled.
const QUANTA_PER_MM2_UGY: f64 = 30_174.0;
/// Fraction of the quanta that the detector absorbs.
const ABSORBED: f64 = 0.65;
/// Range of −ln I that the grey levels show. A choice for the eye.
const WINDOW: f64 = 3.0;
/// Blocks along the detector's edge on which scatter is computed: it varies over 68 pixels.
const BLOCKS: usize = 64;

/// The optical depth of a body for each ray of a C-arm. It is the same for every needle.
#[derive(Clone, Debug)]
pub struct BodyShadow {
    arm: CArm,
    detector: Detector,
    depths: Vec<[f64; BINS]>,
}

impl BodyShadow {
    /// Projects the volumes of a body: each adds its coefficients less those of its parent. Air surrounds the body.
    ///
    /// # Errors
    /// If the body extends to the tube or to the detector.
    pub fn cast(arm: &CArm, volumes: &[BodyVolume]) -> Result<Self, OutOfReach> {
        let detector = Detector::new(arm, PIXELS);
        Ok(Self { arm: *arm, detector, depths: sum_depths(&detector, volumes)? })
    }

    /// Transmitted fraction of each ray, with a needle's steel added.
    fn transmissions(&self, needle: Option<&ImagedNeedle>) -> Vec<f64> {
        let source_m = self.detector.source_m();
        let with_steel = |(at, depth): (usize, &[f64; BINS])| {
            let ray = self.detector.ray((at % PIXELS) as f64 + 0.5, (at / PIXELS) as f64 + 0.5);
            let steel_cm = needle.map_or(0.0, |needle| needle.steel_m(&source_m, &ray)) * 1e2;
            if steel_cm == 0.0 {
                return transmit(depth);
            }
            transmit(&std::array::from_fn(|bin| depth[bin] + STEEL_PER_CM[bin] * steel_cm))
        };
        self.depths.iter().enumerate().map(with_steel).collect()
    }
}

/// Returns the mean transmission at the sensors of the exposure control, without the needle.
///
/// # Errors
/// If the body extends to the tube or to the detector.
pub fn mean_transmission(arm: &CArm, volumes: &[BodyVolume]) -> Result<f64, OutOfReach> {
    let depths = sum_depths(&Detector::sensors(arm), volumes)?;
    Ok(depths.iter().map(transmit).sum::<f64>() / depths.len() as f64)
}

/// Sums the optical depths of volumes along each ray.
fn sum_depths(detector: &Detector, volumes: &[BodyVolume]) -> Result<Vec<[f64; BINS]>, OutOfReach> {
    let mut depths = vec![[0.0; BINS]; detector.pixels * detector.pixels];
    for volume in volumes {
        let around = volume.parent.map_or([0.0; BINS], |parent| coefficients_per_cm(volumes[parent].substance));
        let own = coefficients_per_cm(volume.substance);
        let per_m: [f64; BINS] = std::array::from_fn(|bin| (own[bin] - around[bin]) * 1e2);
        let paths = project(detector, &volume.mesh)?;
        for (depth, length_m) in depths.iter_mut().zip(&paths.lengths_m).filter(|(_, length_m)| **length_m != 0.0) {
            depth.iter_mut().zip(per_m).for_each(|(depth, per_m)| *depth += per_m * length_m);
        }
    }
    Ok(depths)
}

/// A pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// The attempt's seed, from which the noise follows.
    pub seed: u64,
    /// Index of the pulse in the attempt.
    pub index: u32,
    /// Its exposure.
    pub exposure: Exposure,
}

/// The picture of a pulse.
#[derive(Clone, Debug, PartialEq)]
pub struct Radiograph {
    /// Transmitted fraction of the energy without scatter and noise, by rows from the upper left.
    pub transmissions: Vec<f64>,
    /// Grey levels: dense tissue is dark, and so is the collimator.
    pub greys: Vec<u8>,
}

impl Radiograph {
    /// Exposes the detector once.
    #[must_use]
    pub fn expose(shadow: &BodyShadow, needle: Option<&ImagedNeedle>, pulse: Pulse) -> Self {
        let transmissions = shadow.transmissions(needle);
        let field = Field::new(&shadow.arm);
        let lit = |at: usize| if field.contains(at) { transmissions[at] } else { 0.0 };
        let veil = blur(&lit);
        let pixel_mm = shadow.detector.pixel_m() * 1e3;
        let open_quanta = QUANTA_PER_MM2_UGY * pixel_mm * pixel_mm * pulse.exposure.open_kerma_ugy * ABSORBED;
        let densities = (0..PIXELS * PIXELS).map(|at| {
            let intensity = (lit(at) + SCATTER * veil.at(at)) / (1.0 + SCATTER);
            let counted = draw_poisson(open_quanta * intensity, &mut Counter::new(pulse.seed, pulse.index, at as u32));
            // A pixel without a quantum is as dark as one with half of one.
            -libm::log(counted.max(0.5) / open_quanta)
        });
        let densities: Vec<f64> = densities.collect();
        let greys = field.grey_levels(&densities);
        Self { transmissions, greys }
    }
}

/// The collimated square.
struct Field {
    first: usize,
    last: usize,
}

impl Field {
    fn new(arm: &CArm) -> Self {
        let half = 0.5 * PIXELS as f64 * (arm.field_m / DETECTOR_M).min(1.0);
        let middle = 0.5 * PIXELS as f64;
        Self { first: (middle - half).round() as usize, last: (middle + half).round() as usize }
    }

    fn contains(&self, at: usize) -> bool {
        [at % PIXELS, at / PIXELS].iter().all(|place| (self.first..self.last).contains(place))
    }

    /// Grey levels around the median of the field.
    fn grey_levels(&self, densities: &[f64]) -> Vec<u8> {
        let mut inside: Vec<f64> =
            densities.iter().enumerate().filter(|(at, _)| self.contains(*at)).map(|(_, density)| *density).collect();
        let middle = inside.len() / 2;
        let (_, median, _) = inside.select_nth_unstable_by(middle, f64::total_cmp);
        let median = *median;
        let grey = |density: f64| ((0.5 - (density - median) / WINDOW).clamp(0.0, 1.0) * 255.0).round() as u8;
        let shown = |(at, density): (usize, &f64)| if self.contains(at) { grey(*density) } else { 0 };
        densities.iter().enumerate().map(shown).collect()
    }
}

/// A blurred picture on coarse blocks.
struct Veil {
    blocks: Vec<f64>,
}

impl Veil {
    /// Bilinear between the middles of blocks.
    fn at(&self, pixel: usize) -> f64 {
        let edge = PIXELS / BLOCKS;
        let place = |pixel: usize| {
            let place = ((pixel as f64 + 0.5) / edge as f64 - 0.5).clamp(0.0, (BLOCKS - 1) as f64);
            let low = (place as usize).min(BLOCKS - 2);
            (low, place - low as f64)
        };
        let ((x, right), (y, down)) = (place(pixel % PIXELS), place(pixel / PIXELS));
        let row = |y: usize| {
            let first = y * BLOCKS + x;
            self.blocks[first] * (1.0 - right) + self.blocks[first + 1] * right
        };
        row(y) * (1.0 - down) + row(y + 1) * down
    }
}

/// Convolves a picture with the Gaussian of the scatter; the picture is 0 outside the detector.
fn blur(pixel: &dyn Fn(usize) -> f64) -> Veil {
    let edge = PIXELS / BLOCKS;
    let mut blocks = vec![0.0; BLOCKS * BLOCKS];
    for at in 0..PIXELS * PIXELS {
        blocks[at / PIXELS / edge * BLOCKS + at % PIXELS / edge] += pixel(at) / (edge * edge) as f64;
    }
    let spread = SCATTER_SPREAD_M / DETECTOR_M * BLOCKS as f64;
    let weights: Vec<f64> =
        (0..BLOCKS).map(|off| libm::exp(-0.5 * (off as f64 / spread) * (off as f64 / spread))).collect();
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    for along in [1, BLOCKS] {
        let across = BLOCKS + 1 - along;
        let before = blocks.clone();
        for line in 0..BLOCKS {
            for to in 0..BLOCKS {
                let share = |from: usize| before[line * across + from * along] * weights[from.abs_diff(to)];
                blocks[line * across + to * along] = (0..BLOCKS).map(share).sum::<f64>() / sum;
            }
        }
    }
    Veil { blocks }
}
