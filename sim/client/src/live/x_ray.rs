//! X-rays during an attempt: the controls of the C-arm, and the pictures of its pulses. A thread of its own exposes them, because
//! a picture takes longer than a pulse.

use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread;

use attempt::fluoroscopy::{Fluoroscope, ImagedBody, start_controls};
use documents::FluoroscopySettings;
use guidance::{BodyShadow, Radiograph};
use phrase::Phrase;
use recording::{CArmControls, FluoroscopyPulse};
use render::frame::Frame;

use super::lock;
use crate::exit::Failure;
use crate::picture;

/// Number of saved pictures that stay on the screen.
const MOST_SAVED: usize = 3;

/// The picture of a pulse.
#[derive(Clone, Debug)]
pub struct XRayPicture {
    /// Grey levels by rows from the upper left.
    pub greys: Vec<u8>,
    /// The pulse.
    pub pulse: FluoroscopyPulse,
    /// The position of the C-arm.
    pub controls: CArmControls,
}

/// What the monitor of a C-arm shows.
#[derive(Clone, Debug, Default)]
pub struct Monitor {
    /// The last picture.
    pub latest: Option<Arc<XRayPicture>>,
    /// The pictures of the last single shots.
    pub saved: Vec<Arc<XRayPicture>>,
    /// The last pulse, with the dose so far, and the number of pulses by the pedal.
    pub last_pulse: Option<FluoroscopyPulse>,
    /// Number of pulses by the pedal so far.
    pub pedal_pulses: u32,
}

/// What the thread is asked to do.
enum Request {
    /// Fill the collecting system with a volume of contrast medium, in ml.
    Fill(f64),
    /// Expose a pulse.
    Expose(Box<ExposureRequest>),
}

/// A pulse to be exposed with the needle of a frame.
struct ExposureRequest {
    pulse: FluoroscopyPulse,
    controls: CArmControls,
    frame: Frame,
}

/// A thread that exposes pulses. If it is slower than they come, it skips all but the last of the pedal's; no single shot is skipped.
pub struct Radiographer {
    monitor: Arc<Mutex<Monitor>>,
    requests: Mutex<Sender<Request>>,
}

impl Radiographer {
    /// Starts the thread, which makes the body and ends with the returned value. Without a body the monitor stays empty. The noise
    /// follows from the attempt's seed.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn start(
        make_body: impl FnOnce() -> Result<ImagedBody, Phrase> + Send + 'static,
        seed: u64,
    ) -> Result<Self, Failure> {
        let monitor = Arc::new(Mutex::new(Monitor::default()));
        let (requests, waiting) = mpsc::channel();
        let theirs = Arc::clone(&monitor);
        thread::Builder::new()
            .name("radiographs".to_owned())
            .spawn(move || {
                if let Ok(body) = make_body() {
                    RadiographThread { body, seed, shadow: None, monitor: theirs }.expose_all(&waiting);
                }
            })
            .map_err(|error| Failure::work(format_args!("the thread of radiographs cannot be started: {error}")))?;
        Ok(Self { monitor, requests: Mutex::new(requests) })
    }

    /// Returns what the monitor shows, locked.
    pub fn monitor(&self) -> MutexGuard<'_, Monitor> {
        lock(&self.monitor)
    }

    /// Requests the picture of a pulse.
    pub fn expose(&self, pulse: FluoroscopyPulse, controls: CArmControls, frame: Frame) {
        let mut monitor = self.monitor();
        monitor.last_pulse = Some(pulse);
        monitor.pedal_pulses += u32::from(!pulse.shot);
        drop(monitor);
        self.request(Request::Expose(Box::new(ExposureRequest { pulse, controls, frame })));
    }

    fn request(&self, request: Request) {
        // Fails only if the thread has panicked; the monitor then keeps its last picture.
        let _ = lock(&self.requests).send(request);
    }
}

/// The thread's data.
struct RadiographThread {
    body: ImagedBody,
    seed: u64,
    /// The last position, and the body's shadow there.
    shadow: Option<(CArmControls, BodyShadow)>,
    monitor: Arc<Mutex<Monitor>>,
}

impl RadiographThread {
    fn expose_all(mut self, waiting: &Receiver<Request>) {
        while let Ok(first) = waiting.recv() {
            let mut exposures: Vec<ExposureRequest> = Vec::new();
            for request in [first].into_iter().chain(waiting.try_iter()) {
                match request {
                    // Made before the next pulse needs it.
                    Request::Fill(volume_ml) => drop(self.body.volumes(volume_ml)),
                    Request::Expose(exposing) => exposures.push(*exposing),
                }
            }
            let last = exposures.len().saturating_sub(1);
            for (_, exposing) in exposures.into_iter().enumerate().filter(|(at, new)| new.pulse.shot || *at == last) {
                let Some(picture) = self.expose(exposing).map(Arc::new) else { continue };
                let mut monitor = lock(&self.monitor);
                if picture.pulse.shot {
                    monitor.saved.insert(0, Arc::clone(&picture));
                    monitor.saved.truncate(MOST_SAVED);
                }
                monitor.latest = Some(picture);
            }
        }
    }

    /// Exposes a pulse; `None` if the C-arm would meet the body.
    fn expose(&mut self, ExposureRequest { pulse, controls, frame }: ExposureRequest) -> Option<XRayPicture> {
        if self.shadow.as_ref().is_none_or(|(there, _)| !there.is_same_view(&controls)) {
            self.shadow = self.body.shadow(&controls).ok().map(|shadow| (controls, shadow));
        }
        let (_, shadow) = self.shadow.as_ref()?;
        let needle = picture::image_needle(&self.body, &frame);
        let radiograph = Radiograph::expose(shadow, Some(&needle), self.body.pulse(&controls, &pulse, self.seed));
        Some(XRayPicture { greys: radiograph.greys, pulse, controls })
    }
}

/// The C-arm of an attempt in progress.
pub struct LiveArm {
    fluoroscope: Fluoroscope,
    /// Pulses per second while the pedal is pressed.
    pub pulses_per_s: f64,
    controls: Mutex<CArmControls>,
    /// The pictures.
    pub radiographer: Radiographer,
}

impl LiveArm {
    /// Places the C-arm at the start.
    ///
    /// # Errors
    /// If the thread of its pictures cannot be started.
    pub fn start(fluoroscope: Fluoroscope, settings: &FluoroscopySettings, seed: u64) -> Result<Self, Failure> {
        let body = fluoroscope.body().clone();
        let radiographer = Radiographer::start(move || Ok(body), seed)?;
        let controls = Mutex::new(start_controls(settings));
        Ok(Self { fluoroscope, pulses_per_s: settings.pulses_per_s, controls, radiographer })
    }

    /// Returns the C-arm before its first pulse.
    pub fn fluoroscope(&self) -> Fluoroscope {
        self.fluoroscope.clone()
    }

    /// Returns the controls, as the user has set them last.
    pub fn controls(&self) -> CArmControls {
        *lock(&self.controls)
    }

    /// Sets the controls.
    pub fn set(&self, controls: CArmControls) {
        let before = std::mem::replace(&mut *lock(&self.controls), controls);
        if controls.contrast_ml > before.contrast_ml {
            self.radiographer.request(Request::Fill(controls.contrast_ml));
        }
    }
}
