//! The symbols of the HD library.

#![expect(unsafe_code, reason = "the other side of a C ABI")]

use std::ffi::{c_char, c_ulong, c_void};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::device::{MAX_FORCE_N, state};
use crate::{Call, Heard, Script};

type Callback = unsafe extern "system" fn(*mut c_void) -> u32;

const DEVICE: u32 = 7;
const SCHEDULED: c_ulong = 11;
const FORCE_OUTPUT: u32 = 0x4000;

/// What `hdGetError` returns.
#[repr(C)]
pub struct HDErrorInfo {
    error_code: u32,
    internal_error_code: i32,
    device: u32,
}

/// A callback with its data, to be handed to the scheduler's thread.
#[derive(Clone, Copy)]
struct Job {
    callback: Callback,
    data: *mut c_void,
}

// SAFETY: who schedules a callback promises that it may run in the scheduler's thread.
unsafe impl Send for Job {}

impl Job {
    /// Runs frames until the callback is done, or the scheduler is stopped, or the script wants silence.
    fn run(self) {
        let Self { callback, data } = self;
        let period = Duration::from_micros(state().script.period_us);
        // SAFETY: the data belong to the callback, as its owner promised by scheduling it.
        while is_running() && !state().is_silent() && unsafe { callback(data) } == 1 {
            std::thread::sleep(period);
        }
    }
}

#[derive(Default)]
struct Scheduler {
    job: Option<Job>,
    running: bool,
    thread: Option<JoinHandle<()>>,
}

static SCHEDULER: Mutex<Scheduler> = Mutex::new(Scheduler { job: None, running: false, thread: None });

fn scheduler<T>(act: impl FnOnce(&mut Scheduler) -> T) -> T {
    act(&mut SCHEDULER.lock().unwrap_or_else(PoisonError::into_inner))
}

fn is_running() -> bool {
    scheduler(|scheduler| scheduler.running)
}

#[unsafe(no_mangle)]
extern "system" fn hdInitDevice(_name: *const c_char) -> u32 {
    let mut state = state();
    state.note(Call::Init);
    match state.script.init_error {
        0 => {
            state.open = true;
            DEVICE
        }
        code => {
            state.errors.push(code);
            0xFFFF_FFFF
        }
    }
}

#[unsafe(no_mangle)]
extern "system" fn hdDisableDevice(_device: u32) {
    let mut state = state();
    state.note(Call::DisableDevice);
    state.open = false;
}

#[unsafe(no_mangle)]
extern "system" fn hdMakeCurrentDevice(device: u32) {
    if device != DEVICE {
        state().fault(0x0104);
    }
}

#[unsafe(no_mangle)]
extern "system" fn hdBeginFrame(_device: u32) {
    state().begin_frame();
}

#[unsafe(no_mangle)]
extern "system" fn hdEndFrame(_device: u32) {
    state().end_frame();
}

#[unsafe(no_mangle)]
extern "system" fn hdGetError() -> HDErrorInfo {
    let error_code = state().errors.pop().unwrap_or(0);
    HDErrorInfo { error_code, internal_error_code: -1, device: DEVICE }
}

#[unsafe(no_mangle)]
extern "system" fn hdGetErrorString(code: u32) -> *const c_char {
    let words = match code {
        0x0600 => c"Invalid license",
        0x0301 => c"Device already initiated",
        _ => c"Some error",
    };
    words.as_ptr()
}

#[unsafe(no_mangle)]
extern "system" fn hdEnable(capability: u32) {
    let mut state = state();
    if capability == FORCE_OUTPUT {
        state.note(Call::EnableForce);
        state.force_on = state.script.takes_force;
    }
}

#[unsafe(no_mangle)]
extern "system" fn hdDisable(capability: u32) {
    let mut state = state();
    if capability == FORCE_OUTPUT {
        state.note(Call::DisableForce);
        state.force_on = false;
    }
}

#[unsafe(no_mangle)]
extern "system" fn hdIsEnabled(capability: u32) -> u8 {
    u8::from(capability == FORCE_OUTPUT && state().force_on)
}

/// # Safety
/// `values` has room for what `name` holds.
#[unsafe(no_mangle)]
unsafe extern "system" fn hdGetDoublev(name: u32, values: *mut f64) {
    let transform = state().transform();
    let heat = state().script.motor_heat;
    let heats = [0.5 * heat, heat, 0.25 * heat];
    let held: &[f64] = match name {
        0x2605 if heat >= 0.0 => &heats,
        0x2052 => &transform,
        0x2551 => &[-80.0, -40.0, -35.0, 80.0, 80.0, 35.0],
        0x2602 => &[0.5],
        0x2603 => &[MAX_FORCE_N],
        0x2604 => &[0.88],
        _ => return state().fault(0x0100),
    };
    // SAFETY: the caller's promise.
    unsafe { std::ptr::copy_nonoverlapping(held.as_ptr(), values, held.len()) }
}

/// # Safety
/// `value` points to an integer.
#[unsafe(no_mangle)]
unsafe extern "system" fn hdGetIntegerv(name: u32, value: *mut i32) {
    let held = match name {
        0x2000 => 1,
        0x2555 => 4,
        _ => return state().fault(0x0100),
    };
    // SAFETY: the caller's promise.
    unsafe { value.write(held) }
}

#[unsafe(no_mangle)]
extern "system" fn hdGetString(name: u32) -> *const c_char {
    match name {
        0x2501 => c"Touch".as_ptr(),
        0x2504 => c"40720700147".as_ptr(),
        _ => std::ptr::null(),
    }
}

/// # Safety
/// `values` holds three numbers.
#[unsafe(no_mangle)]
unsafe extern "system" fn hdSetDoublev(name: u32, values: *const f64) {
    if name != 0x2700 {
        return state().fault(0x0100);
    }
    // SAFETY: the caller's promise.
    let force_n = unsafe { values.cast::<[f64; 3]>().read() };
    state().set_force(force_n);
}

#[unsafe(no_mangle)]
extern "system" fn hdCheckCalibration() -> u32 {
    let mut state = state();
    state.note(Call::CheckCalibration);
    state.script.calibration
}

#[unsafe(no_mangle)]
extern "system" fn hdUpdateCalibration(_style: u32) {
    let running = is_running();
    let mut state = state();
    state.note(Call::UpdateCalibration);
    // As the reference has it: in the inkwell, once the servo loop runs.
    if state.script.calibrates && running {
        state.script.calibration = 0x5000;
    }
}

#[unsafe(no_mangle)]
extern "system" fn hdSetSchedulerRate(rate_hz: c_ulong) {
    // As drivers of some devices do, a rate that is not theirs is refused.
    if rate_hz != 500 {
        state().errors.push(0x0101);
    }
}

#[unsafe(no_mangle)]
extern "system" fn hdScheduleAsynchronous(callback: Callback, data: *mut c_void, priority: u16) -> c_ulong {
    if priority == 0xFFFF {
        state().note(Call::Schedule);
    }
    scheduler(|scheduler| scheduler.job = Some(Job { callback, data }));
    SCHEDULED
}

#[unsafe(no_mangle)]
extern "system" fn hdStartScheduler() {
    state().note(Call::Start);
    let inline = state().script.inline;
    let job = scheduler(|scheduler| {
        scheduler.running = true;
        scheduler.job
    });
    match job {
        Some(job) if inline => job.run(),
        Some(job) => {
            let thread = std::thread::spawn(move || job.run());
            scheduler(|scheduler| scheduler.thread = Some(thread));
        }
        None => {}
    }
}

#[unsafe(no_mangle)]
extern "system" fn hdStopScheduler() {
    state().note(Call::Stop);
    let thread = scheduler(|scheduler| {
        scheduler.running = false;
        scheduler.thread.take()
    });
    if let Some(thread) = thread {
        thread.join().expect("the callback does not unwind");
    }
}

#[unsafe(no_mangle)]
extern "system" fn hdUnschedule(callback: c_ulong) {
    if callback != SCHEDULED {
        state().fault(0x0104);
    }
    state().note(Call::Unschedule);
    scheduler(|scheduler| scheduler.job = None);
}

/// Sets the script. Both sides are this crate, built once, so that Rust's own ABI is the same on both.
#[unsafe(no_mangle)]
fn stand_in_script(script: Script) {
    state().script = script;
}

/// What was heard so far.
#[unsafe(no_mangle)]
fn stand_in_heard() -> Heard {
    state().heard
}
