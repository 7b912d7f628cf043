//! Fluoroscopy of an attempt: a C-arm around the target of an exercise, its pulses and their dose.
//!
//! Everything follows from the recorded controls, the needle and the seed, to the bit. A recording holds no picture.

use std::sync::{Arc, Mutex, PoisonError};

use anatomy::{Body, BodyEntry, BodyQuality, BodySide, BodyVolume, Contrast};
use documents::{ExerciseBundle, FluoroscopySettings, Needle};
use guidance::{BodyShadow, CArm, Exposure, ImagedNeedle, KermaLevel, Pulse, mean_transmission};
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use phrase::{Phrase, phrase};
use recording::{CArmControls, Fluoroscopy, FluoroscopyPulse, Recording};

/// Pulses whose tube load a single shot has.
const SHOT_PULSES: f64 = 10.0;
/// Name of the layer whose calyx the collecting system must have.
const CALYX: &str = "calyx";

/// The body of an exercise, as X-rays show it.
#[derive(Clone, Debug)]
pub struct ImagedBody {
    body: Body,
    entry: BodyEntry,
    needle: Needle,
    /// The target in the body's frame, in m: the isocentre.
    target_m: Point3<f64>,
    volumes: Arc<VolumeCache>,
}

/// The volumes of a body, made once for all copies of it.
#[derive(Debug)]
struct VolumeCache {
    /// Without contrast medium.
    empty: Arc<Vec<BodyVolume>>,
    /// With the last amount of contrast medium, in ml.
    filled: Mutex<(f64, Arc<Vec<BodyVolume>>)>,
}

impl ImagedBody {
    /// Builds the body of an exercise. Where its target lies in a calyx, the collecting system of that kidney has one there.
    ///
    /// # Errors
    /// If the scene has no body.
    pub fn new(bundle: &ExerciseBundle) -> Result<Self, Phrase> {
        let scene_body = bundle.scene.body.as_ref();
        let scene_body =
            scene_body.ok_or_else(|| phrase!("a scene without a body; allowed: a scene with [anatomy]"))?;
        let (mut body, entry) = scene_body.enter()?;
        let target_m = to_body(&entry, &bundle.exercise.target_m());
        if is_in_calyx(bundle) {
            body.connect_calyx(side_of(&target_m), &target_m, &-entry.to_body(&bundle.exercise.axis()));
        }
        let empty = Arc::new(body.list_volumes(BodyQuality::Medium, None));
        let volumes = Arc::new(VolumeCache { filled: Mutex::new((0.0, Arc::clone(&empty))), empty });
        Ok(Self { body, entry, needle: bundle.scene.needle.clone(), target_m, volumes })
    }

    /// The C-arm in a position.
    #[must_use]
    pub fn arm(&self, controls: &CArmControls) -> CArm {
        let CArmControls { orbital_rad, tilt_rad, field_m, .. } = *controls;
        CArm { orbital_rad, tilt_rad, field_m, ..CArm::over(self.target_m) }
    }

    /// The volumes with a volume of contrast medium in ml in the kidney on the target's side.
    #[must_use]
    pub fn volumes(&self, contrast_ml: f64) -> Arc<Vec<BodyVolume>> {
        if contrast_ml <= 0.0 {
            return Arc::clone(&self.volumes.empty);
        }
        // Locked while they are made: another thread would make the same.
        let mut filled = self.volumes.filled.lock().unwrap_or_else(PoisonError::into_inner);
        if filled.0.to_bits() != contrast_ml.to_bits() {
            let mut volumes = (*self.volumes.empty).clone();
            let contrast = Contrast { side: side_of(&self.target_m), volume_ml: contrast_ml };
            self.body.add_contrast(&mut volumes, BodyQuality::Medium, contrast);
            *filled = (contrast_ml, Arc::new(volumes));
        }
        Arc::clone(&filled.1)
    }

    /// The shadow of the body.
    ///
    /// # Errors
    /// If the C-arm would meet the body.
    pub fn shadow(&self, controls: &CArmControls) -> Result<BodyShadow, guidance::OutOfReach> {
        BodyShadow::cast(&self.arm(controls), &self.volumes(controls.contrast_ml))
    }

    /// The needle with its tip at a position in m and an orientation x, y, z, w of the scene's frame, with its stylet or without.
    #[must_use]
    pub fn image_needle(&self, tip_m: [f64; 3], orientation: [f64; 4], is_open: bool) -> ImagedNeedle {
        let axis = UnitQuaternion::new_normalize(Quaternion::from(orientation)) * Vector3::z();
        let Needle { length_mm, diameter_mm, inner_diameter_mm, .. } = self.needle;
        ImagedNeedle {
            tip_m: to_body(&self.entry, &Point3::from(tip_m)),
            direction: self.entry.to_body(&axis),
            length_m: length_mm * 1e-3,
            outer_m: diameter_mm * 1e-3,
            bore_m: inner_diameter_mm * 1e-3,
            has_stylet: self.needle.hub == "stylet" && !is_open,
        }
    }

    /// The pulse to expose of a recorded one.
    #[must_use]
    pub fn pulse(&self, controls: &CArmControls, recorded: &FluoroscopyPulse, seed: u64) -> Pulse {
        let exposure = Exposure::with_load(&self.arm(controls), recorded.load_mas);
        Pulse { seed, index: recorded.index, exposure }
    }
}

/// Whether the target of an exercise lies in a layer that is a calyx.
fn is_in_calyx(bundle: &ExerciseBundle) -> bool {
    let depth_mm = bundle.exercise.incidence().depth_m(bundle.exercise.target_depth_mm * 1e-3) * 1e3;
    let mut top_mm = 0.0;
    bundle.scene.layers.iter().any(|layer| {
        let (from_mm, to_mm) = (top_mm, top_mm + layer.thickness_mm);
        top_mm = to_mm;
        layer.name == CALYX && (from_mm..to_mm).contains(&depth_mm)
    })
}

fn side_of(target_m: &Point3<f64>) -> BodySide {
    if target_m.x < 0.0 { BodySide::Left } else { BodySide::Right }
}

/// Converts a point from the scene's frame to the body's.
fn to_body(entry: &BodyEntry, own_m: &Point3<f64>) -> Point3<f64> {
    entry.origin_m + entry.to_body(&own_m.coords)
}

/// The controls at the start of an exercise.
#[must_use]
pub fn start_controls(settings: &FluoroscopySettings) -> CArmControls {
    CArmControls {
        orbital_rad: settings.orbital_deg.to_radians(),
        tilt_rad: settings.tilt_deg.to_radians(),
        field_m: settings.field_mm * 1e-3,
        ..CArmControls::default()
    }
}

/// A C-arm in use: turns controls into pulses with their dose.
#[derive(Clone, Debug)]
pub struct Fluoroscope {
    body: ImagedBody,
    pulses_per_s: f64,
    /// The mean transmission in the position of the last pulse; `None` if the arm would meet the body there.
    measured: Option<(CArmControls, Option<f64>)>,
    /// When the pedal was pressed, and the number of pulses since then.
    pressed: Option<(f64, u32)>,
    shots: u32,
    pulses: u32,
    kerma_ugy: f64,
    kerma_area_ugy_m2: f64,
}

impl Fluoroscope {
    /// The C-arm of an exercise; `None` if it has none.
    ///
    /// # Errors
    /// If the scene has no body.
    pub fn new(bundle: &ExerciseBundle) -> Result<Option<Self>, Phrase> {
        let Some(settings) = &bundle.exercise.fluoroscopy else { return Ok(None) };
        Ok(Some(Self {
            body: ImagedBody::new(bundle)?,
            pulses_per_s: settings.pulses_per_s,
            measured: None,
            pressed: None,
            shots: 0,
            pulses: 0,
            kerma_ugy: 0.0,
            kerma_area_ugy_m2: 0.0,
        }))
    }

    /// Returns the body.
    #[must_use]
    pub fn body(&self) -> &ImagedBody {
        &self.body
    }

    /// Advances to a tick, whose time is that of the controls. Returns the pulse in it: at most one, a single shot first.
    pub fn step(&mut self, controls: &CArmControls) -> Option<FluoroscopyPulse> {
        self.pressed = if controls.pedal { self.pressed.or(Some((controls.t_s, 0))) } else { None };
        if controls.shots > self.shots {
            self.shots += 1;
            return self.emit(controls, true);
        }
        let (since_s, count) = self.pressed?;
        if controls.t_s < since_s + f64::from(count) / self.pulses_per_s {
            return None;
        }
        self.pressed = Some((since_s, count + 1));
        self.emit(controls, false)
    }

    fn emit(&mut self, controls: &CArmControls, shot: bool) -> Option<FluoroscopyPulse> {
        let mean_transmission = self.measure(controls)?;
        let arm = self.body.arm(controls);
        let once = Exposure::control(&arm, KermaLevel::Low, mean_transmission);
        let exposure = Exposure::with_load(&arm, once.load_mas * if shot { SHOT_PULSES } else { 1.0 });
        self.kerma_ugy += exposure.kerma_ugy;
        self.kerma_area_ugy_m2 += exposure.kerma_area_ugy_m2;
        let index = self.pulses;
        self.pulses += 1;
        Some(FluoroscopyPulse {
            t_s: controls.t_s,
            index,
            shot,
            load_mas: exposure.load_mas,
            mean_transmission,
            kerma_mgy: self.kerma_ugy * 1e-3,
            // µGy m² are 1e-6 Gy and 1e4 cm².
            kerma_area_gycm2: self.kerma_area_ugy_m2 * 1e-2,
        })
    }

    /// Measures the transmission, once in each position.
    fn measure(&mut self, controls: &CArmControls) -> Option<f64> {
        if let Some((there, mean)) = self.measured
            && there.is_same_view(controls)
        {
            return mean;
        }
        let volumes = self.body.volumes(controls.contrast_ml);
        let mean = mean_transmission(&self.body.arm(controls), &volumes).ok();
        self.measured = Some((*controls, mean));
        mean
    }
}

/// Counts the pulses that differ from those of the recorded controls: in time, kind, tube load or dose. `fluoroscope` is that of the
/// exercise, before its first pulse; without one there must be no pulse.
#[must_use]
pub fn count_pulse_differences(recording: &Recording, fluoroscope: Option<Fluoroscope>) -> u64 {
    let Fluoroscopy { controls, pulses } = &recording.fluoroscopy;
    let Some(mut fluoroscope) = fluoroscope else { return (controls.len() + pulses.len()) as u64 };
    let used = recording.samples.iter().filter_map(|sample| {
        let controls = recording.fluoroscopy.controls_at(sample.t_s)?;
        fluoroscope.step(&CArmControls { t_s: sample.t_s, ..*controls })
    });
    let again: Vec<FluoroscopyPulse> = used.collect();
    let same = again.iter().zip(pulses).take_while(|(again, recorded)| again == recorded).count();
    (again.len().max(pulses.len()) - same) as u64
}
