//! The OpenHaptics driver against a stand-in library with the same ABI: order of calls, units, frames, limits, and every way
//! in which a device can be missing or get lost.
//!
//! It would fail on a force that is set to zero above the limit, turned by a clamp of each axis, inverted, averaged or let
//! through as not a number; on a panic that crosses into the driver; and on motors left on by any way out.

use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

use allocation_counter::measure;
use haptics::device::{Clocked, DeviceFault, Reading};
use haptics::openhaptics::{OpenHaptics, OpenHapticsError, OpenHapticsOptions};
use libhd::{Call, Script, StandIn, Then, lacking};
use nalgebra::Vector3;

/// Frames as fast as the machine makes them.
const FAST: Script = Script {
    init_error: 0,
    calibration: 0x5000,
    calibrates: false,
    takes_force: true,
    period_us: 0,
    step_mm: [1.0, 0.0, 0.0],
    encoder_mm: 0.0,
    repeats: 1,
    motor_heat: 0.0,
    inline: false,
    at_frame: u64::MAX,
    then: Then::Nothing,
};

fn open(library: impl Into<OsString>) -> Result<OpenHaptics, OpenHapticsError> {
    OpenHaptics::open(&OpenHapticsOptions { library: library.into(), device: None })
}

/// Runs a scripted device with a tick that knows the number of the frame; what came of it, and what the library heard.
fn run(
    script: Script,
    mut tick: impl FnMut(usize, &Reading, Option<DeviceFault>) -> Option<Vector3<f64>> + Send,
) -> (Result<(), DeviceFault>, libhd::Heard) {
    let stand_in = StandIn::new(script);
    let mut device = open(stand_in.path()).expect("it opens");
    let mut frame = 0;
    let ended = device.run(
        &mut |reading, fault| {
            frame += 1;
            tick(frame - 1, reading, fault)
        },
        &AtomicBool::new(false),
    );
    drop(device);
    (ended, stand_in.heard())
}

/// Shows one force for a frame, then ends; what reached the motors, in N.
fn shown(force_n: Vector3<f64>) -> Vector3<f64> {
    let (ended, heard) = run(FAST, |frame, _, _| (frame == 0).then_some(force_n));
    assert_eq!(ended, Ok(()));
    assert_eq!(heard.faults, 0);
    Vector3::from(heard.forces_n()[0])
}

#[test]
fn calls_follow_the_reference_and_the_last_force_is_zero() {
    let (ended, heard) = run(FAST, |frame, _, _| (frame < 5).then_some(Vector3::new(1.0, 0.0, 0.0)));
    assert_eq!(ended, Ok(()));
    let expected = [
        Call::Init,
        Call::CheckCalibration,
        Call::EnableForce,
        Call::Schedule,
        Call::Start,
        Call::Stop,
        Call::Unschedule,
        Call::DisableForce,
        Call::DisableDevice,
    ];
    assert_eq!(heard.calls(), expected);
    assert_eq!(heard.faults, 0, "frames are begun once and ended, and forces are set inside");
    assert_eq!(heard.forces_n(), [[1.0, 0.0, 0.0]; 5].iter().chain(&[[0.0; 3]]).copied().collect::<Vec<_>>());
}

#[test]
fn it_says_what_it_is() {
    let stand_in = StandIn::new(FAST);
    let device = open(stand_in.path()).expect("it opens");
    let info = device.info();
    assert_eq!((info.name.as_str(), info.serial.as_deref()), ("Touch", Some("40720700147")));
    // The stiffness is the softer of what it claims, 500 N/m, and what a Touch is rated.
    let limits = (info.max_force_n, info.continuous_force_n, info.max_stiffness_n_per_m);
    assert_eq!(limits, (3.3, 0.88, 400.0));
    for (side_m, expected_m) in info.workspace_m.iter().zip([0.160, 0.120, 0.070]) {
        assert!((side_m - expected_m).abs() < 1e-12, "{side_m} m");
    }
}

#[test]
fn poses_are_in_metres_from_the_centre_with_the_tip_along_z() {
    let mut seen = Vec::new();
    let (ended, _) = run(FAST, |frame, reading, fault| {
        assert_eq!(fault, None);
        seen.push(*reading);
        (frame < 2).then(Vector3::zeros)
    });
    assert_eq!(ended, Ok(()));
    // The stand-in stands at (frame, 20, −30) mm in a workspace whose middle is (0, 20, 0) mm.
    for (frame, reading) in seen.iter().enumerate() {
        let expected_m = Vector3::new(frame as f64 * 1e-3, 0.0, -0.030);
        assert!((reading.position_m - expected_m).norm() < 1e-12, "{:?}", reading.position_m);
        // Its stylus is turned by a quarter about z: its x axis points up, its tip still along −z.
        assert!((reading.orientation * Vector3::z() + Vector3::z()).norm() < 1e-12);
        assert!((reading.orientation * Vector3::x() + Vector3::y()).norm() < 1e-12);
        assert_eq!(reading.buttons, 1);
    }
    assert!(seen.windows(2).all(|pair| pair[0].t_s < pair[1].t_s), "times rise");
}

#[test]
fn large_force_is_clamped_and_a_small_one_passes_unchanged() {
    for force_n in [Vector3::new(30.0, -40.0, 0.0), Vector3::new(0.0, -3.4, 0.0), Vector3::new(1e300, 1e300, -1e300)] {
        let shown_n = shown(force_n);
        assert!((shown_n.norm() - 3.3).abs() < 1e-9, "{shown_n:?}");
        assert!(shown_n.normalize().dot(&(force_n / force_n.amax()).normalize()) > 1.0 - 1e-12, "{shown_n:?}");
    }
    let small_n = Vector3::new(0.3, -0.2, 1e-9);
    assert_eq!(shown(small_n), small_n, "and one below it is shown as it is");
}

#[test]
fn what_is_not_a_number_is_shown_as_nothing() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(shown(Vector3::new(0.5, bad, 0.0)), Vector3::zeros());
    }
}

#[test]
fn a_step_of_force_is_there_in_its_own_frame() {
    let wanted = |frame: usize| Vector3::new(if frame < 3 { 0.2 } else { 3.0 }, 0.0, 0.0);
    let (_, heard) = run(FAST, |frame, _, _| (frame < 6).then(|| wanted(frame)));
    let shown: Vec<f64> = heard.forces_n().iter().map(|force_n| force_n[0]).collect();
    assert_eq!(shown, [0.2, 0.2, 0.2, 3.0, 3.0, 3.0, 0.0], "no average, no frame late");
}

#[test]
fn a_frame_never_allocates() {
    let counted = |frames: usize| {
        let stand_in = StandIn::new(Script { inline: true, ..FAST });
        let mut device = open(stand_in.path()).expect("it opens");
        let mut left = frames;
        let stop = AtomicBool::new(false);
        let mut tick = |_: &Reading, _: Option<DeviceFault>| {
            left -= 1;
            (left > 0).then(|| Vector3::new(9.0, f64::NAN, 0.0))
        };
        measure(|| assert_eq!(device.run(&mut tick, &stop), Ok(()))).count_total
    };
    assert_eq!(counted(10), counted(1000), "whatever starting costs, frames cost nothing");
}

#[test]
fn panic_of_the_tick_propagates_after_the_force_is_zero() {
    let stand_in = StandIn::new(FAST);
    let mut device = open(stand_in.path()).expect("it opens");
    let mut frame = 0;
    let mut tick = |_: &Reading, _: Option<DeviceFault>| {
        frame += 1;
        assert!(frame < 4, "the tick breaks, on purpose");
        Some(Vector3::new(0.0, 2.0, 0.0))
    };
    let ended = catch_unwind(AssertUnwindSafe(|| device.run(&mut tick, &AtomicBool::new(false))));
    let words = ended.expect_err("the panic goes on");
    assert_eq!(words.downcast_ref::<&str>(), Some(&"the tick breaks, on purpose"));
    let heard = stand_in.heard();
    assert_eq!(heard.forces_n()[2..], [[0.0, 2.0, 0.0], [0.0; 3]]);
    assert_eq!(heard.calls().last(), Some(&Call::Unschedule));
}

#[test]
fn a_stop_from_another_thread_ends_in_zero_force() {
    let stand_in = StandIn::new(Script { period_us: 200, ..FAST });
    let mut device = open(stand_in.path()).expect("it opens");
    let stop = AtomicBool::new(false);
    let mut frames = 0;
    let ended = device.run(
        &mut |_, _| {
            frames += 1;
            stop.store(frames == 20, Ordering::Relaxed);
            Some(Vector3::new(0.0, 2.0, 0.0))
        },
        &stop,
    );
    assert_eq!(ended, Ok(()));
    assert_eq!(stand_in.heard().forces_n()[19..], [[0.0, 2.0, 0.0], [0.0; 3]]);
}

#[test]
fn a_device_that_is_lost_mid_way_says_so_and_is_let_go() {
    for code in [0x0300, 0x0302, 0x0303, 0x0304] {
        let script = Script { at_frame: 7, then: Then::Error(code), ..FAST };
        let (ended, heard) = run(script, |_, _, _| Some(Vector3::new(0.0, 1.0, 0.0)));
        assert_eq!(ended, Err(DeviceFault::Gone));
        assert_eq!((heard.frames, heard.calls().last()), (8, Some(&Call::DisableDevice)));
    }
}

#[test]
fn most_severe_error_of_a_frame_decides_the_outcome() {
    // The younger error is asked for first. A lost device makes the frame that follows fail, and a warm motor is no end.
    let ended = |codes| {
        run(Script { at_frame: 7, then: Then::Errors(codes), ..FAST }, |frame, _, fault| {
            assert!(fault.is_none() || fault == Some(DeviceFault::RefusesForce(0x0200)), "{fault:?}");
            (frame < 12).then(Vector3::zeros)
        })
        .0
    };
    assert_eq!(ended([0x0302, 0x0402]), Err(DeviceFault::Gone));
    assert_eq!(ended([0x0402, 0x0302]), Err(DeviceFault::Gone));
    assert_eq!(ended([0x0200, 0x0402]), Ok(()));
    assert_eq!(ended([0x0402, 0x0200]), Ok(()));
    assert_eq!(ended([0x0200, 0x0201]), Ok(()));
}

#[test]
fn a_device_that_was_lost_is_opened_again() {
    let stand_in = StandIn::new(Script { at_frame: 7, then: Then::ErrorOnce(0x0302), ..FAST });
    let mut frames = 0;
    let mut tick = |_: &Reading, _: Option<DeviceFault>| {
        frames += 1;
        (frames < 20).then(|| Vector3::new(0.0, 1.0, 0.0))
    };
    let mut device = open(stand_in.path()).expect("it opens");
    assert_eq!(device.run(&mut tick, &AtomicBool::new(false)), Err(DeviceFault::Gone));
    drop(device);
    let mut device = open(stand_in.path()).expect("it opens again");
    assert_eq!(device.run(&mut tick, &AtomicBool::new(false)), Ok(()));
    drop(device);
    let heard = stand_in.heard();
    assert_eq!((heard.faults, heard.forces_n()[10]), (0, [0.0, 1.0, 0.0]));
}

#[test]
fn a_scheduler_that_falls_silent_is_a_lost_device() {
    let script = Script { at_frame: 7, then: Then::Silence, ..FAST };
    let (ended, heard) = run(script, |_, _, _| Some(Vector3::zeros()));
    assert_eq!((ended, heard.frames), (Err(DeviceFault::Gone), 7));
}

#[test]
fn refused_force_reaches_the_tick_and_the_attempt_continues() {
    let script = Script { at_frame: 3, then: Then::Error(0x0204), ..FAST };
    let mut told = Vec::new();
    let (ended, _) = run(script, |frame, _, fault| {
        told.push(fault);
        (frame < 5).then(Vector3::zeros)
    });
    assert_eq!(ended, Ok(()));
    let refused = Some(DeviceFault::RefusesForce(0x0204));
    assert_eq!(told, [None, None, None, None, refused, refused]);
}

#[test]
fn hottest_motor_is_read_and_an_unknown_heat_is_no_fault() {
    for (motor_heat, expected) in [(0.9, 0.9), (-1.0, 0.0)] {
        let mut read = Vec::new();
        let (ended, _) = run(Script { motor_heat, ..FAST }, |frame, reading, fault| {
            read.push((reading.motor_heat, fault));
            (frame < 3).then(Vector3::zeros)
        });
        assert_eq!(ended, Ok(()));
        assert!(read[1..].iter().all(|seen| *seen == (expected, None)), "{motor_heat}: {read:?}");
    }
}

#[test]
fn nan_reading_repeats_the_last_good_one_with_its_time() {
    let script = Script { at_frame: 4, then: Then::NotANumber, ..FAST };
    let mut seen = Vec::new();
    let (ended, _) = run(script, |frame, reading, _| {
        seen.push(*reading);
        (frame < 8).then(Vector3::zeros)
    });
    assert_eq!(ended, Ok(()));
    assert!(seen[..4].windows(2).all(|pair| pair[0].t_s < pair[1].t_s));
    assert!(seen[4..].iter().all(|reading| *reading == seen[3]), "stale, and recognisable as such");
}

#[test]
fn a_slow_driver_is_slow_and_not_lost() {
    let (ended, heard) = run(Script { period_us: 20_000, ..FAST }, |frame, _, _| (frame < 10).then(Vector3::zeros));
    assert_eq!((ended, heard.frames), (Ok(()), 11));
}

#[test]
fn due_calibration_is_run_and_a_manual_one_is_requested() {
    let due = StandIn::new(Script { calibration: 0x5001, calibrates: true, ..FAST });
    assert!(open(due.path()).is_ok());
    let expected = [
        Call::CheckCalibration,
        Call::Schedule,
        Call::Start,
        Call::UpdateCalibration,
        Call::CheckCalibration,
        Call::Stop,
        Call::Unschedule,
        Call::CheckCalibration,
        Call::EnableForce,
    ];
    assert_eq!(due.heard().calls()[1..10], expected, "in the inkwell a device is calibrated while frames are made");
    for script in [Script { calibration: 0x5002, ..FAST }, Script { calibration: 0x5001, ..FAST }] {
        let error = refused(&StandIn::new(script));
        assert_eq!(error, OpenHapticsError::NotCalibrated { status: script.calibration });
        assert!(error.advice().contains("inkwell"));
    }
}

/// Why a device does not open; it must have been let go.
fn refused(stand_in: &StandIn) -> OpenHapticsError {
    let error = open(stand_in.path()).err().expect("it does not open");
    let calls = stand_in.heard().calls();
    let opened = !matches!(error, OpenHapticsError::DeviceNotFound { .. } | OpenHapticsError::Licence { .. });
    assert_eq!(calls.contains(&Call::DisableDevice), opened, "what was opened is let go: {calls:?}");
    error
}

#[test]
fn what_is_missing_is_named_with_what_to_do() {
    let not_found = refused(&StandIn::new(Script { init_error: 0x0301, ..FAST }));
    assert!(matches!(not_found, OpenHapticsError::DeviceNotFound { code: 0x0301, .. }), "{not_found}");
    let licence = refused(&StandIn::new(Script { init_error: 0x0600, ..FAST }));
    assert!(matches!(licence, OpenHapticsError::Licence { code: 0x0600, .. }), "{licence}");
    let force = refused(&StandIn::new(Script { takes_force: false, ..FAST }));
    assert!(matches!(force, OpenHapticsError::ForceRefused { .. }), "{force}");
    let no_library = open("/nowhere/libHD.so").err().expect("it does not open");
    assert!(matches!(no_library, OpenHapticsError::LibraryNotFound { .. }), "{no_library}");
    let system = if cfg!(windows) { "os error 126" } else { "No such file" };
    assert!(no_library.to_string().contains(system), "in the system's words: {no_library}");
    let (_folder, old) = lacking("hdUpdateCalibration");
    let old = open(old).err().expect("it does not open");
    assert!(matches!(old, OpenHapticsError::WrongVersion { symbol: "hdUpdateCalibration", .. }), "{old}");
    for (error, word) in
        [(not_found, "connect"), (licence, "licence manager"), (force, "power"), (no_library, "install"), (old, "3.4")]
    {
        assert!(error.advice().contains(word), "{error}: {}", error.advice());
        assert_eq!(error.to_string().lines().count(), 1);
    }
}
