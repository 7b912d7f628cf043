//! Opens a device by its name, and maps it to the patient.

use std::fmt::Display;
use std::str::FromStr;

use attempt::HandChoice;
use documents::{Exercise, ExerciseBundle};
use haptics::devices::gamepad::GamepadFeed;
use haptics::devices::hand::{AimWriter, VirtualHand};
use haptics::devices::operator::OperatorDevice;
use haptics::inverse3::Inverse3;
use haptics::mapping::{Home, Mapping, Pointing};
use haptics::openhaptics::OpenHaptics;
use haptics::servo::Driven;
use law::operator::{Operator, Skill, needle_pose};
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use phrase::{Phrase, phrase};

use crate::devices::DeviceArgs;
use crate::exit::Failure;
use crate::settings::Settings;

/// The choice of a device.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviceChoice {
    /// The first haptic device found, otherwise a gamepad, otherwise the mouse.
    Auto,
    /// Mouse and keyboard.
    Mouse,
    /// A gamepad.
    Gamepad,
    /// OpenHaptics.
    OpenHaptics,
    /// Haply Inverse3.
    Inverse3,
    /// A virtual operator.
    Operator(HandChoice),
}

impl FromStr for DeviceChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "mouse" => Ok(Self::Mouse),
            "gamepad" => Ok(Self::Gamepad),
            "openhaptics" => Ok(Self::OpenHaptics),
            "inverse3" => Ok(Self::Inverse3),
            _ => match text.strip_prefix("operator:").map(str::parse) {
                Some(Ok(HandChoice::File(_))) => {
                    Err("stylet play has no operators from files; use stylet simulate".to_owned())
                }
                Some(hand) => hand.map(Self::Operator),
                None => Err("allowed: auto, mouse, gamepad, openhaptics, inverse3 or operator:NAME".to_owned()),
            },
        }
    }
}

impl DeviceChoice {
    /// Describes the device for the user.
    pub fn phrase(&self) -> Phrase {
        match self {
            Self::Auto => phrase!("the connected haptic device, otherwise mouse and keyboard"),
            Self::Mouse => phrase!("mouse and keyboard, without force feedback"),
            Self::Gamepad => phrase!("a gamepad, without force feedback"),
            Self::OpenHaptics => Phrase::data("OpenHaptics"),
            Self::Inverse3 => Phrase::data("Haply Inverse3"),
            Self::Operator(hand) => Phrase::data(hand.device()),
        }
    }
}

/// Source of a device's motion.
pub enum Steered {
    /// A person's hand on the device, or a virtual operator.
    Itself,
    /// The window, by mouse and keyboard.
    Window(AimWriter),
    /// A gamepad, until this is dropped.
    Gamepad(GamepadFeed),
}

/// An open device and its mapping.
pub struct OpenedDevice {
    /// The device.
    pub driven: Driven,
    /// Mapping from the device to the patient.
    pub mapping: Mapping,
    /// Source of the device's motion.
    pub steered: Steered,
    /// Reasons why other devices were not used.
    pub passed_over: Vec<String>,
}

impl OpenedDevice {
    /// Returns the choice that opens this device again; `None` if any will do. After an attempt
    /// with an arm, the next one must not fall back to the mouse because of a loose cable.
    #[must_use]
    pub fn again(&self) -> Option<DeviceChoice> {
        match &self.driven {
            Driven::ByDevice(_) => Some(DeviceChoice::OpenHaptics),
            Driven::ByTimer(device) if !device.info().is_virtual => Some(DeviceChoice::Inverse3),
            Driven::ByTimer(_) => None,
        }
    }
}

/// Options and settings of the devices.
pub struct Desk<'a> {
    /// Where to find haptic devices.
    pub args: &'a DeviceArgs,
    /// The user's settings.
    pub settings: &'a Settings,
}

/// Opens a device for an exercise. `seed` is for a virtual operator.
///
/// # Errors
/// If the device is missing or cannot be opened.
pub fn open(
    choice: &DeviceChoice,
    desk: &Desk<'_>,
    bundle: &ExerciseBundle,
    seed: u64,
    rate_hz: f64,
) -> Result<OpenedDevice, Failure> {
    match choice {
        DeviceChoice::Operator(hand) => Ok(operator(hand, bundle, seed, rate_hz)),
        _ => open_at(choice, desk, &home(&bundle.exercise), rate_hz),
    }
}

/// Opens a device with the needle at `home`. A virtual operator needs an exercise: without one, the
/// mouse replaces it.
///
/// # Errors
/// If the device is missing or cannot be opened.
pub fn open_at(choice: &DeviceChoice, desk: &Desk<'_>, home: &Home, rate_hz: f64) -> Result<OpenedDevice, Failure> {
    match choice {
        DeviceChoice::Auto => Ok(first(desk, home, rate_hz)),
        DeviceChoice::Mouse | DeviceChoice::Operator(_) => Ok(mouse(desk, home, rate_hz)),
        DeviceChoice::Gamepad => gamepad(desk, home, rate_hz).map_err(Failure::work),
        DeviceChoice::OpenHaptics => openhaptics(desk, home).map_err(Failure::work),
        DeviceChoice::Inverse3 => inverse3(desk, home).map_err(Failure::work),
    }
}

/// Opens the first haptic device found, otherwise a gamepad, otherwise the mouse, which is always
/// available.
fn first(desk: &Desk<'_>, home: &Home, rate_hz: f64) -> OpenedDevice {
    let mut passed_over = Vec::new();
    let tries: [&dyn Fn() -> Result<OpenedDevice, String>; 3] =
        [&|| openhaptics(desk, home), &|| inverse3(desk, home), &|| gamepad(desk, home, rate_hz)];
    let found = tries.iter().find_map(|open| open().map_err(|why| passed_over.push(why)).ok());
    OpenedDevice { passed_over, ..found.unwrap_or_else(|| mouse(desk, home, rate_hz)) }
}

fn openhaptics(desk: &Desk<'_>, home: &Home) -> Result<OpenedDevice, String> {
    let device = OpenHaptics::open(&desk.args.openhaptics()).map_err(|why| said("openhaptics", &why))?;
    Ok(with_arm(Driven::ByDevice(Box::new(device)), home, desk.settings))
}

fn inverse3(desk: &Desk<'_>, home: &Home) -> Result<OpenedDevice, String> {
    let device = Inverse3::open(&desk.args.inverse3()).map_err(|why| said("inverse3", &why))?;
    Ok(with_arm(Driven::ByTimer(Box::new(device)), home, desk.settings))
}

fn said(device: &str, why: &dyn Display) -> String {
    format!("{device}: {why}")
}

/// Maps a device in its own workspace. If it measures no orientation, the needle points as planned.
fn with_arm(driven: Driven, home: &Home, settings: &Settings) -> OpenedDevice {
    let pointing = if driven.info().measures_orientation { Pointing::Handle } else { Pointing::Planned };
    let mapping = Mapping::at_home(*home, pointing).placed(settings.placement());
    OpenedDevice { driven, mapping, steered: Steered::Itself, passed_over: Vec::new() }
}

fn mouse(desk: &Desk<'_>, home: &Home, rate_hz: f64) -> OpenedDevice {
    let (hand, aim) = VirtualHand::new(sentence!("mouse"), &VirtualHand::braced(), rate_hz);
    let settings = on_screen(desk.settings);
    OpenedDevice { steered: Steered::Window(aim), ..with_arm(Driven::ByTimer(Box::new(hand)), home, &settings) }
}

fn gamepad(desk: &Desk<'_>, home: &Home, rate_hz: f64) -> Result<OpenedDevice, String> {
    let (hand, aim) = VirtualHand::new(sentence!("gamepad"), &VirtualHand::braced(), rate_hz);
    let settings = on_screen(desk.settings);
    let planned = handle_along(&home.axis);
    let feed = GamepadFeed::start(aim, settings.sticks(), planned).map_err(|why| said("gamepad", &why))?;
    let driven = Driven::ByTimer(Box::new(hand));
    Ok(OpenedDevice { steered: Steered::Gamepad(feed), ..with_arm(driven, home, &settings) })
}

/// Returns the settings for a device that is used by looking at the screen: not turned, on the
/// usual side, with unscaled motion.
fn on_screen(settings: &Settings) -> Settings {
    Settings { other_side: false, device_yaw_deg: 0.0, motion: 1.0, ..*settings }
}

/// Returns the orientation of a handle, device_from_handle, with which the needle points along an
/// axis of unit length in the patient frame.
pub fn handle_along(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    let device_from_patient = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
    device_from_patient * needle_pose(&Point3::origin(), axis).rotation
}

fn home(exercise: &Exercise) -> Home {
    let plan = exercise.plan();
    Home::above(plan.entry_m, Unit::new_normalize(plan.axis), plan.approach_m)
}

fn operator(hand: &HandChoice, bundle: &ExerciseBundle, seed: u64, rate_hz: f64) -> OpenedDevice {
    let plan = bundle.plan();
    let operator = match hand {
        HandChoice::Preset(_, skill) => Operator::skilled(skill, &plan, seed),
        HandChoice::Constant(mm_per_s) => Operator::constant(mm_per_s * 1e-3, &plan),
        // Unreachable: `DeviceChoice` rejects files.
        HandChoice::File(_) => Operator::skilled(&Skill::expert(), &plan, seed),
    };
    let device = OperatorDevice::new(&hand.device(), operator, rate_hz);
    let driven = Driven::ByTimer(Box::new(device));
    OpenedDevice { driven, mapping: Mapping::in_patient_frame(), steered: Steered::Itself, passed_over: Vec::new() }
}
