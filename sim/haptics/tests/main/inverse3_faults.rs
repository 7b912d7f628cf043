//! The Inverse3 driver against everything that can go wrong with the service: it is missing, silent, slow, talkative, old, or
//! speaks nonsense; it closes, breaks, or refuses force; the servo itself stops.
//!
//! It would fail on a force that stays applied, a loop that spins on a closed socket, an old state taken for a new one, and a
//! failure without a name.

use std::io::Write;
use std::net::TcpListener;
use std::time::Duration;

use haptics::device::{Device, DeviceFault};
use haptics::inverse3::{Inverse3, Inverse3Error, Inverse3Options, code};
use inverse_service::{Script, Service, State, Then, first, state};
use nalgebra::Vector3;

use crate::inverse3::{opened, options, reading, told, until};

const PUSH_N: Vector3<f64> = Vector3::new(3.0, 0.0, 0.0);

/// Writes a force until the device is lost; why.
#[track_caller]
fn lost(device: &mut Inverse3) -> DeviceFault {
    let mut fault = None;
    until(|| {
        fault = device.write(&PUSH_N).err();
        fault.is_some_and(|fault| !matches!(fault, DeviceFault::RefusesForce(_)))
    });
    assert_eq!(device.read().err(), fault, "reading says the same");
    fault.expect("a fault")
}

#[test]
fn a_servo_that_stops_writing_leaves_no_force() {
    let (service, mut device) = opened(Script::default());
    let (_, shown_n) = told(&service, &mut device, PUSH_N);
    assert_eq!(shown_n, PUSH_N);
    until(|| service.forces_n().last().is_some_and(|(_, force_n)| Vector3::from(*force_n) == Vector3::zeros()));
    // And it is back as soon as the servo is.
    assert_eq!(told(&service, &mut device, PUSH_N).1, PUSH_N);
}

#[test]
fn closed_or_broken_socket_loses_the_device_and_ends_the_thread() {
    for then in [Then::Close, Then::Break] {
        let (_service, mut device) = opened(Script { at_message: 20, then, ..Script::default() });
        assert_eq!(lost(&mut device), DeviceFault::Gone);
        until(|| !device.health().running);
        let states = device.health().states;
        assert!((1..=20).contains(&states), "it heard {states} states, and spins no more");
    }
}

#[test]
fn a_service_that_falls_silent_is_told_zero_and_then_given_up() {
    let (service, mut device) = opened(Script { at_message: 20, then: Then::Silence, ..Script::default() });
    let seen = reading(&mut device, |reading| reading.position_m.x > 1e-3);
    assert_eq!(lost(&mut device), DeviceFault::Gone);
    assert_eq!(service.forces_n().last().map(|(_, force_n)| *force_n), Some([0.0; 3]), "nobody pushes blind");
    assert!(service.heard().len() < 60, "and nobody shouts at the deaf: {} messages", service.heard().len());
    assert!(seen.position_m.x <= 20e-4);
}

#[test]
fn a_service_that_was_lost_is_opened_again() {
    let (service, mut device) = opened(Script { at_message: 20, then: Then::BreakOnce, ..Script::default() });
    assert_eq!(lost(&mut device), DeviceFault::Gone);
    drop(device);
    let mut again = Inverse3::open(&options(&service)).expect("it opens again");
    reading(&mut again, |reading| reading.position_m.x > 30e-4);
    assert!(again.write(&PUSH_N).is_ok());
}

#[test]
fn a_slow_service_is_asked_no_faster_than_it_answers() {
    let (service, mut device) = opened(Script { delay: Duration::from_millis(40), ..Script::default() });
    let before = device.read().expect("a reading");
    let after = reading(&mut device, |reading| reading.position_m.x >= 10e-4 - 1e-12);
    assert!(device.write(&PUSH_N).is_ok(), "slow is not lost");
    assert!(after.t_s - before.t_s > 0.3, "readings carry the time at which they came");
    // Positions count the messages that were answered: few more may be on their way.
    let answered = (after.position_m.x / 1e-4).round() as usize;
    assert!(service.heard().len() <= answered + 3, "{} messages for {answered} answers", service.heard().len());
}

#[test]
fn a_talkative_service_is_heard_to_its_end() {
    let (service, mut device) = opened(Script { answers: 5, ..Script::default() });
    let seen = reading(&mut device, |reading| reading.position_m.x > 50e-4);
    let told = service.heard().len();
    assert!(seen.position_m.x <= (5 * told) as f64 * 1e-4 + 1e-12);
    // One state for each message would leave four of five unheard, and the handle further behind with each.
    until(|| device.health().states >= 5 * 40);
    assert!(service.heard().len() < 5 * 40, "{} messages", service.heard().len());
}

#[test]
fn a_frame_without_the_arm_is_no_reading() {
    let other = state(&State { device_id: "FFFF", ..State::default() }, 500);
    let (_service, mut device) = opened(Script { at_message: 20, then: Then::Say(other), ..Script::default() });
    let last = reading(&mut device, |reading| reading.position_m.x >= 19e-4);
    // Frames keep coming for a second, and none of them is of this arm.
    assert_eq!(lost(&mut device), DeviceFault::Gone);
    assert!(last.position_m.x < 21e-4);
}

#[test]
fn nonsense_is_counted_and_only_nonsense_is_a_fault() {
    let nonsense = [
        "{\"inverse3\":[{\"device_id\":\"04C3\",\"state\":{\"cursor_position\":{\"x\":1e999,\"y\":0,\"z\":0}}}]}",
        "{\"inverse3\":[{\"device_id\":\"04C3\",\"state\":{\"cursor_position\":{\"x\":\"NaN\",\"y\":0,\"z\":0}}}]}",
        "{\"inverse3\":",
        "<html></html>",
        "",
    ];
    let script = |text: &str| Script { at_message: 20, then: Then::Say(text.to_owned()), ..Script::default() };
    let devices = nonsense.map(|text| opened(script(text)));
    for (text, (_service, mut device)) in nonsense.into_iter().zip(devices) {
        assert_eq!(lost(&mut device), DeviceFault::Reported(code::NOT_UNDERSTOOD), "{text}");
        let health = device.health();
        assert!(health.garbage > 0 && (1..=20).contains(&health.states), "{text}: {health:?}");
    }
}

#[test]
fn an_arm_that_loses_power_refuses_force_and_is_still_read() {
    let dark = state(&State { power_supply: false, ..State::default() }, 21);
    let (_service, mut device) = opened(Script { at_message: 20, then: Then::Say(dark), ..Script::default() });
    until(|| device.write(&PUSH_N).is_err());
    let refusal = code::NO_POWER | code::NOT_READY;
    assert_eq!(device.write(&PUSH_N), Err(DeviceFault::RefusesForce(refusal)));
    assert!(device.read().is_ok());
}

/// Why a device does not open.
#[track_caller]
fn refused(script: Script, change: impl FnOnce(&mut Inverse3Options)) -> Inverse3Error {
    let service = Service::start(script);
    let mut options = options(&service);
    change(&mut options);
    let error = Inverse3::open(&options).err().expect("it does not open");
    assert!(!error.advice().is_empty() && error.to_string().lines().count() == 1);
    error
}

#[test]
fn what_is_missing_is_named() {
    let nobody = refused(Script::default(), |options| "ws://127.0.0.1:9".clone_into(&mut options.url));
    assert!(matches!(nobody, Inverse3Error::Unreachable { .. }), "{nobody}");
    let address = refused(Script::default(), |options| "http://localhost".clone_into(&mut options.url));
    assert!(matches!(address, Inverse3Error::Unreachable { .. }), "{address}");
    let silent = refused(Script { first: None, ..Script::default() }, |_| ());
    assert!(matches!(silent, Inverse3Error::Silent { seconds: 2, .. }), "{silent}");
    let nonsense = refused(Script { first: Some("<html>".to_owned()), ..Script::default() }, |_| ());
    assert!(matches!(nonsense, Inverse3Error::NotUnderstood { .. }), "{nonsense}");
    let other = refused(Script::default(), |options| options.device_id = Some("FFFF".to_owned()));
    assert_eq!(other, Inverse3Error::NoDevice { wanted: "FFFF".to_owned(), found: "04C3".to_owned() });
    let nothing = r#"{"session_id":7,"inverse3":[]}"#.to_owned();
    let script = Script { first: Some(nothing.clone()), at_message: 0, then: Then::Say(nothing), ..Script::default() };
    let none = refused(script, |_| ());
    assert!(matches!(none, Inverse3Error::NoDevice { .. }), "{none}");
}

#[test]
fn an_arm_that_is_not_ready_is_not_opened() {
    for (state, expected) in [
        (State { calibrated: false, ..State::default() }, "not calibrated"),
        (State { power_supply: false, ..State::default() }, "without power supply"),
    ] {
        let error = refused(Script { first: Some(first(&state)), ..Script::default() }, |_| ());
        assert_eq!(error, Inverse3Error::NotReady { device_id: "04C3".to_owned(), why: expected });
    }
}

#[test]
fn another_program_on_the_port_is_not_the_service() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let url = format!("ws://{}", listener.local_addr().expect("an address"));
    let other = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a client");
        stream.write_all(b"SSH-2.0-OpenSSH_9.2\r\n").expect("it is told");
    });
    let error = Inverse3::open(&Inverse3Options { url, ..Inverse3Options::default() }).err().expect("it does not open");
    assert!(matches!(error, Inverse3Error::NotTheService { .. }), "{error}");
    other.join().expect("it ends");
}
