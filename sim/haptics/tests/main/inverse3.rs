//! The Inverse3 driver against a stand-in service that speaks the same protocol: both spellings of a force, axes, grips, and
//! what a force goes through on its way.
//!
//! It would fail on a force in the wrong dialect, along the wrong axis, averaged, turned or zeroed by a clamp, and on a lock or
//! a text made in the servo's thread.

use std::thread::sleep;
use std::time::Duration;

use allocation_counter::measure;
use haptics::device::{Device, Reading, buttons};
use haptics::inverse3::{Dialect, Inverse3, Inverse3Error, Inverse3Options};
use inverse_service::{CLOSED, Grip, Script, Service, State, first};
use nalgebra::Vector3;

/// Options for a stand-in.
pub fn options(service: &Service) -> Inverse3Options {
    Inverse3Options { url: service.url.clone(), ..Inverse3Options::default() }
}

/// A service that behaves as scripted, and the device that it has.
pub fn opened(script: Script) -> (Service, Inverse3) {
    let service = Service::start(script);
    let device = Inverse3::open(&options(&service)).expect("it opens");
    (service, device)
}

/// Waits until something comes true, for as long as a busy machine may need.
#[track_caller]
pub fn until(mut is_so: impl FnMut() -> bool) {
    for _ in 0..20_000 {
        if is_so() {
            return;
        }
        sleep(Duration::from_millis(1));
    }
    panic!("it never came");
}

/// Holds a force, as a servo does, until the service has been told it, and returns it as the service was told: field, N.
#[track_caller]
pub fn told(service: &Service, device: &mut Inverse3, force_n: Vector3<f64>) -> (String, Vector3<f64>) {
    let mut last = None;
    until(|| {
        let before = service.forces_n().len();
        let before_s = device.read().expect("a reading").t_s;
        device.write(&force_n).expect("it takes the force");
        sleep(Duration::from_millis(5));
        let forces_n = service.forces_n();
        last = forces_n.last().cloned();
        // The first message after the write may hold an older force. Where this thread was held up, the driver may by
        // now take the servo for dead, and be right.
        let took_s = device.read().expect("a reading").t_s - before_s;
        forces_n.len() > before + 2 && took_s < 0.040
    });
    let (field, force_n) = last.expect("a force");
    (field, Vector3::from(force_n))
}

/// The reading once `is_so`.
#[track_caller]
pub fn reading(device: &mut Inverse3, mut is_so: impl FnMut(&Reading) -> bool) -> Reading {
    let mut last = device.read().expect("a reading");
    until(|| {
        last = device.read().expect("a reading");
        is_so(&last)
    });
    last
}

#[test]
fn the_services_version_decides_how_a_force_is_spelled() {
    let versions = [
        (Some("3.5.0"), "vector"),
        (Some("v3.12.1-2-gce34c39e"), "vector"),
        (Some("4.0.0"), "vector"),
        (Some("3.4.9"), "values"),
        (Some("3.0.1"), "values"),
        (Some("no number"), "values+vector"),
        (None, "values+vector"),
    ];
    for (version, expected) in versions {
        let (service, mut device) = opened(Script { version, ..Script::default() });
        let (field, _) = told(&service, &mut device, Vector3::new(1.0, 0.0, 0.0));
        assert_eq!(field, expected, "version {version:?}");
        assert_eq!(device.service_version(), version.filter(|words| *words != "no number"));
    }
}

#[test]
fn a_version_on_the_other_documented_port_is_found() {
    let script = Script { version: None, version_elsewhere: Some("3.1.0"), ..Script::default() };
    let service = Service::start(script);
    let asked = Inverse3Options { version_port: service.version_port, ..options(&service) };
    let mut device = Inverse3::open(&asked).expect("it opens");
    assert_eq!(device.service_version(), Some("3.1.0"));
    assert_eq!(told(&service, &mut device, Vector3::x()).0, "values");
}

#[test]
fn unknown_service_version_is_understood_or_a_mismatch_noticed() {
    let push_n = Vector3::new(1.0, 0.5, 0.0);
    for understands in [["vector"].as_slice(), &["values"]] {
        let (service, mut device) = opened(Script { version: None, understands, ..Script::default() });
        told(&service, &mut device, push_n);
        assert!(!holds_until_it_disagrees(&mut device, push_n, 400), "{understands:?}");
    }
    // Told to speak as to a newer service, it finds an older one.
    let service = Service::start(Script { understands: &["values"], ..Script::default() });
    let mut device =
        Inverse3::open(&Inverse3Options { dialect: Some(Dialect::Vector), ..options(&service) }).expect("it opens");
    assert!(holds_until_it_disagrees(&mut device, push_n, 5000));
}

/// Holds a force for at most so many milliseconds, and says whether the service was found to show another.
fn holds_until_it_disagrees(device: &mut Inverse3, force_n: Vector3<f64>, ms: u32) -> bool {
    (0..ms).any(|_| {
        device.write(&force_n).expect("it takes the force");
        sleep(Duration::from_millis(1));
        device.disagrees()
    })
}

#[test]
fn without_a_grip_it_measures_no_orientation() {
    for (grip, measures) in [(Grip::None, false), (Grip::Wired, true), (Grip::Wireless, true)] {
        let state = State { grip, ..State::default() };
        let (_service, device) = opened(Script { first: Some(first(&state)), state, ..Script::default() });
        assert_eq!(device.info().measures_orientation, measures, "{grip:?}");
        assert_eq!(device.info().name.contains("without VerseGrip"), !measures);
    }
}

#[test]
fn dialect_can_be_chosen_and_an_unsupported_version_is_rejected() {
    let service = Service::start(Script::default());
    let told_so = Inverse3Options { dialect: Some(Dialect::Values), ..options(&service) };
    let mut device = Inverse3::open(&told_so).expect("it opens");
    assert_eq!(told(&service, &mut device, Vector3::zeros()).0, "values");
    let old = Service::start(Script { version: Some("2.9.1"), ..Script::default() });
    let error = Inverse3::open(&options(&old)).err().expect("it does not open");
    assert_eq!(error, Inverse3Error::WrongVersion { found: "2.9.1".to_owned() });
    assert!(error.advice().contains("update"));
}

#[test]
fn positions_and_forces_are_in_our_axes() {
    let (service, mut device) = opened(Script::default());
    // The stand-in moves along x and stands 10 mm above the middle of the workspace: up is our y.
    let seen = reading(&mut device, |reading| reading.position_m.x > 1e-3);
    assert!((seen.position_m.y - 0.010).abs() < 1e-12 && seen.position_m.z.abs() < 1e-12, "{seen:?}");
    // Towards the person is our z, and backward, −y, for the service.
    let (_, force_n) = told(&service, &mut device, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!(force_n, Vector3::new(1.0, -3.0, 2.0));
}

#[test]
fn either_grip_gives_orientation_and_buttons() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Half way to the left about the service's vertical axis: the tip points left instead of forward.
    let left = State { orientation: [0.0, 0.0, half, half], buttons: [true, true], ..State::default() };
    for (grip, held) in [(Grip::Wireless, buttons::CONFIRM | buttons::CLUTCH), (Grip::Wired, buttons::CONFIRM)] {
        let (_service, mut device) = opened(Script { state: State { grip, ..left.clone() }, ..Script::default() });
        let seen = reading(&mut device, |reading| reading.position_m.x > 1e-3);
        assert!((seen.orientation * Vector3::z() + Vector3::x()).norm() < 1e-12, "{grip:?}: {seen:?}");
        assert_eq!(seen.buttons, held, "{grip:?}");
    }
    let forward = State::default();
    let (_service, mut device) = opened(Script { state: forward, ..Script::default() });
    let seen = reading(&mut device, |reading| reading.position_m.x > 1e-3);
    assert!((seen.orientation * Vector3::z() + Vector3::z()).norm() < 1e-12, "away from the person: {seen:?}");
    let without = State { grip: Grip::None, ..State::default() };
    let (_service, mut device) = opened(Script { state: without, ..Script::default() });
    let seen = reading(&mut device, |reading| reading.position_m.x > 1e-3);
    assert_eq!(seen.buttons, 0);
}

#[test]
fn force_above_the_limit_is_clamped_in_its_direction() {
    let service = Service::start(Script::default());
    let limited = Inverse3Options { max_force_n: 4.0, ..options(&service) };
    let mut device = Inverse3::open(&limited).expect("it opens");
    for force_n in [Vector3::new(30.0, -40.0, 0.0), Vector3::new(0.0, -4.1, 0.0), Vector3::new(1e300, 0.0, -1e300)] {
        let (_, told_n) = told(&service, &mut device, force_n);
        assert!((told_n.norm() - 4.0).abs() < 1e-9, "{told_n:?}");
        // Back into our axes: the service's (x, y, z) is our (x, z, −y).
        let ours_n = Vector3::new(told_n.x, told_n.z, -told_n.y);
        assert!(ours_n.normalize().dot(&(force_n / force_n.amax()).normalize()) > 1.0 - 1e-12, "{told_n:?}");
    }
}

#[test]
fn no_limit_is_above_the_devices_own() {
    for (asked_n, limit_n) in [(50.0, 10.0), (-1.0, 0.0), (f64::NAN, 0.0), (6.5, 6.5)] {
        let service = Service::start(Script::default());
        let device = Inverse3::open(&Inverse3Options { max_force_n: asked_n, ..options(&service) }).expect("it opens");
        assert!((device.info().max_force_n - limit_n).abs() < 1e-12, "{asked_n}");
    }
}

#[test]
fn what_is_not_a_number_is_told_as_nothing() {
    let (service, mut device) = opened(Script::default());
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (_, told_n) = told(&service, &mut device, Vector3::new(0.5, bad, 0.0));
        assert_eq!(told_n, Vector3::zeros());
    }
}

#[test]
fn a_step_of_force_is_told_whole() {
    let (service, mut device) = opened(Script::default());
    told(&service, &mut device, Vector3::new(0.25, 0.0, 0.0));
    told(&service, &mut device, Vector3::new(5.0, 0.0, 0.0));
    let told_n = service.forces_n().into_iter().map(|(_, force_n)| force_n[0]);
    let mut seen: Vec<f64> = told_n.filter(|part_n| *part_n != 0.0).collect();
    seen.dedup();
    assert_eq!(seen, [0.25, 5.0], "no average between");
}

#[test]
fn reading_and_writing_never_allocate() {
    let (_service, mut device) = opened(Script::default());
    reading(&mut device, |reading| reading.position_m.x > 1e-3);
    let counted = measure(|| {
        for tick in 0..10_000_u32 {
            let force_n = Vector3::new(f64::from(tick % 20), 0.0, 0.0);
            assert!(device.write(&force_n).is_ok() && device.read().is_ok());
        }
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn closing_tells_zero_force_first() {
    for dropped in [false, true] {
        let (service, mut device) = opened(Script::default());
        told(&service, &mut device, Vector3::new(3.0, 0.0, 0.0));
        if dropped {
            drop(device);
        } else {
            device.close();
            assert!(device.read().is_err() && !device.health().running);
        }
        until(|| service.heard().last().is_some_and(|last| last == CLOSED));
        let last_n = service.forces_n().last().map(|(_, force_n)| *force_n);
        assert_eq!(last_n, Some([0.0, 0.0, 0.0]));
        let heard = service.heard();
        assert!(heard[heard.len() - 2].contains("set_cursor_force"), "zero is the last that it hears");
    }
}

#[test]
fn a_first_frame_without_configuration_is_asked_for_in_full() {
    let arms = first(&State::default()).replace("config", "nothing");
    let full = first(&State::default());
    let script =
        Script { first: Some(arms), at_message: 0, then: inverse_service::Then::Say(full), ..Script::default() };
    let (service, _device) = opened(script);
    assert_eq!(service.heard()[0], r#"{"session":{"force_render_full_state":{}}}"#);
}
