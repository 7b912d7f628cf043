//! The scripted device: a Touch whose handle moves as far a frame as the script says, a little turned, with its first button held.

use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use crate::{Call, ENVIRONMENT, Heard, NOTED, Script, Then};

/// Greatest force, in N.
pub const MAX_FORCE_N: f64 = 3.3;

/// Everything the library remembers.
pub struct State {
    pub script: Script,
    pub heard: Heard,
    /// The most recent last: `hdGetError` takes them from this end.
    pub errors: Vec<u32>,
    pub open: bool,
    pub in_frame: bool,
    pub force_on: bool,
}

static STATE: LazyLock<Mutex<State>> = LazyLock::new(|| {
    let word = std::env::var(ENVIRONMENT).unwrap_or_default();
    Mutex::new(State {
        script: Script::named(&word),
        heard: Heard { calls: [None; 32], forces_n: [[0.0; 3]; NOTED], frames: 0, faults: 0 },
        errors: Vec::new(),
        open: false,
        in_frame: false,
        force_on: false,
    })
});

/// The state, for as long as one call takes.
pub fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

impl State {
    pub fn note(&mut self, call: Call) {
        if let Some(free) = self.heard.calls.iter_mut().find(|noted| noted.is_none()) {
            *free = Some(call);
        }
    }

    /// An error that is the caller's fault.
    pub fn fault(&mut self, code: u32) {
        self.heard.faults += 1;
        self.errors.push(code);
    }

    pub fn begin_frame(&mut self) {
        if self.in_frame || !self.open {
            self.fault(0x0400);
        }
        self.in_frame = true;
    }

    pub fn end_frame(&mut self) {
        if !self.in_frame {
            self.fault(0x0401);
        }
        self.in_frame = false;
        match self.script.then {
            Then::Error(code) if self.has_happened() => self.errors.push(code),
            Then::Errors(codes) if self.has_happened() => self.errors.extend(codes),
            Then::ErrorOnce(code) if self.heard.frames as u64 == self.script.at_frame => self.errors.push(code),
            _ => {}
        }
        self.heard.frames += 1;
    }

    pub fn set_force(&mut self, force_n: [f64; 3]) {
        let norm_n = force_n.iter().map(|part| part * part).sum::<f64>().sqrt();
        // A norm that is not a number is not below the limit either.
        let fits = norm_n <= MAX_FORCE_N * (1.0 + 1e-12);
        if !self.in_frame || !fits {
            self.fault(0x0201);
        }
        if let Some(noted) = self.heard.forces_n.get_mut(self.heard.frames) {
            *noted = force_n;
        }
    }

    /// Position in mm and axes of the stylus, column after column.
    pub fn transform(&self) -> [f64; 16] {
        if self.script.then == Then::NotANumber && self.has_happened() {
            return [f64::NAN; 16];
        }
        let Script { step_mm, encoder_mm, repeats, .. } = self.script;
        let seen = (self.heard.frames - self.heard.frames % repeats) as f64;
        let read = |mm: f64| if encoder_mm > 0.0 { (mm / encoder_mm).floor() * encoder_mm } else { mm };
        let [x_mm, y_mm, z_mm] = step_mm.map(|step_mm| read(step_mm * seen));
        // A quarter turn about z: the stylus's x axis points up.
        [0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x_mm, 20.0 + y_mm, -30.0 + z_mm, 1.0]
    }

    pub fn has_happened(&self) -> bool {
        self.heard.frames as u64 >= self.script.at_frame
    }

    pub fn is_silent(&self) -> bool {
        self.script.then == Then::Silence && self.has_happened()
    }
}
