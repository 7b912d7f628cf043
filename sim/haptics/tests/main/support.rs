//! Shipped scenes, real devices' limits, and an engine whose time is told.

use std::path::Path;
use std::sync::Arc;

use documents::{Document, Patient};
use haptics::device::{DeviceFault, DeviceInfo, Reading};
use haptics::mapping::Mapping;
use haptics::servo::{Engine, LatestReader, Record, Records, Setup, TickMoment};
use law::puncture::{PunctureParams, PunctureSpec};
use nalgebra::{UnitQuaternion, Vector3};

pub const RATE_HZ: f64 = 1000.0;
pub const PERIOD_S: f64 = 1.0 / RATE_HZ;

/// A shipped scene by its name, without the field that the servo does not run.
pub fn shipped(name: &str) -> PunctureSpec {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/scenes").join(name).with_extension("toml");
    let Document::Scene(scene) = documents::load::read_document(&path).expect("a shipped scene is valid") else {
        panic!("{name} is a scene")
    };
    scene.puncture_spec(&Patient::nominal(&scene))
}

/// The names of all shipped scenes.
pub fn shipped_names() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/scenes");
    let files = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let stem = |path: std::path::PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let mut names: Vec<String> =
        files.filter(|path| path.extension().is_some_and(|ext| ext == "toml")).filter_map(stem).collect();
    names.sort();
    names
}

/// What a real device can do.
pub fn device(name: &str, max_force_n: f64, continuous_force_n: f64, max_stiffness_n_per_m: f64) -> DeviceInfo {
    DeviceInfo {
        name: name.to_owned(),
        serial: None,
        max_force_n,
        continuous_force_n,
        max_stiffness_n_per_m,
        workspace_m: [0.16, 0.12, 0.07],
        measures_orientation: true,
        is_virtual: false,
    }
}

/// The weakest one.
pub fn touch() -> DeviceInfo {
    device("Touch", 3.3, 0.88, 400.0)
}

/// A handle that points down, at a place in the patient's frame.
pub fn reading(t_s: f64, position_m: Vector3<f64>) -> Reading {
    let orientation = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI);
    Reading { t_s, position_m, orientation, buttons: 0, motor_heat: 0.0 }
}

/// An engine at 1 kHz, ticked by hand.
pub struct Rig {
    pub engine: Engine,
    pub records: Records,
    pub latest: LatestReader,
    pub now_s: f64,
}

impl Rig {
    /// With the device's frame the patient's. `target_x_m` is what the exercise asks for, in m.
    pub fn new(spec: PunctureSpec, info: &DeviceInfo, target_x_m: f64) -> Self {
        let params = Arc::new(PunctureParams::new(spec).expect("a valid scene"));
        Self::of(Setup::new(params, Mapping::in_patient_frame(), info, target_x_m, RATE_HZ))
    }

    pub fn of(setup: Setup) -> Self {
        let (engine, records, latest) = Engine::new(setup).expect("a valid rate");
        Self { engine, records, latest, now_s: 10.0 }
    }

    /// A tick in time. The force, in N, device frame; `None` when it is over.
    pub fn tick(&mut self, reading: Result<Reading, DeviceFault>) -> Option<Vector3<f64>> {
        self.late_tick(reading, 0.0)
    }

    /// A tick that comes late, in s.
    pub fn late_tick(&mut self, reading: Result<Reading, DeviceFault>, late_s: f64) -> Option<Vector3<f64>> {
        self.now_s += late_s;
        let moment = TickMoment { now_s: self.now_s, late_s };
        let force_n = self.engine.tick(reading, &moment, &|| moment.now_s);
        self.engine.took(1e-6);
        self.now_s += PERIOD_S;
        force_n
    }

    /// Every record so far that was not taken yet.
    pub fn taken(&mut self) -> Vec<Record> {
        std::iter::from_fn(|| self.records.pop()).collect()
    }
}
