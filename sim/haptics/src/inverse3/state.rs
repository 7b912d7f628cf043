//! Messages of the service: JSON text, parsed in place. Only numbers are kept, and nothing is
//! allocated.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::de::{IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::axes;
use crate::device::{Reading, buttons};

/// Maximum number of devices of a kind that are considered; a station has one or two.
const FEW: usize = 4;

/// A frame of the service. The first one has `config`; later ones contain only changes.
#[derive(Deserialize)]
pub struct StateFrame<'a> {
    #[serde(borrow, default)]
    inverse3: Few<Arm<'a>>,
    #[serde(default)]
    verse_grip: Few<VerseGrip>,
    #[serde(default)]
    wireless_verse_grip: Few<VerseGrip>,
    /// Grips with custom buttons, which the service lists separately from version 3.5 on.
    #[serde(default)]
    custom_verse_grip: Few<VerseGrip>,
}

/// An Inverse3.
#[derive(Deserialize)]
pub struct Arm<'a> {
    /// Its identifier, for example `04C3`.
    #[serde(borrow)]
    pub device_id: Cow<'a, str>,
    config: Option<IgnoredAny>,
    state: Option<ArmState>,
    status: Option<Status>,
}

#[derive(Deserialize)]
struct ArmState {
    cursor_position: Option<Xyz>,
    /// The force that the arm applies, in N, service axes.
    current_cursor_force: Option<Xyz>,
}

/// Readiness of an arm. A missing field counts as ready.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub struct Status {
    calibrated: Option<bool>,
    ready: Option<bool>,
    power_supply: Option<bool>,
}

/// A VerseGrip, wired or wireless.
#[derive(Deserialize)]
struct VerseGrip {
    state: Option<GripState>,
}

#[derive(Deserialize)]
struct GripState {
    orientation: Option<Xyzw>,
    button: Option<bool>,
    buttons: Option<Abc>,
}

#[derive(Clone, Copy, Deserialize)]
struct Xyz {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Clone, Copy, Deserialize)]
struct Xyzw {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(default)]
struct Abc {
    a: bool,
    b: bool,
}

impl<'a> StateFrame<'a> {
    /// Parses a message of the service; `None` if it is not a frame.
    pub fn read(text: &'a str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }

    /// All arms.
    pub fn arms(&self) -> impl Iterator<Item = &Arm<'a>> {
        self.inverse3.0.iter().flatten()
    }

    /// The arm with an identifier.
    pub fn arm(&self, id: &str) -> Option<&Arm<'a>> {
        self.arms().find(|arm| arm.device_id == id)
    }

    /// Whether an arm comes with its configuration, as in a full snapshot.
    pub fn is_full(&self) -> bool {
        self.arms().any(|arm| arm.config.is_some())
    }

    /// The reading of the arm `id` at `t_s`. Grip values missing in the frame are kept from
    /// `before`; `None` if the frame has no position of the arm.
    pub fn reading(&self, id: &str, t_s: f64, before: &Reading) -> Option<Reading> {
        let position = self.arm(id)?.state.as_ref()?.cursor_position?;
        Some(Reading {
            t_s,
            position_m: axes::position_m(Vector3::new(position.x, position.y, position.z)),
            orientation: self.grips().find_map(GripState::orientation).unwrap_or(before.orientation),
            buttons: self.grips().find_map(GripState::pressed).unwrap_or(before.buttons),
            motor_heat: 0.0,
        })
    }

    /// The force that the arm `id` applies according to the service, in N, device frame; `None` if
    /// the frame does not report it.
    pub fn reported_n(&self, id: &str) -> Option<Vector3<f64>> {
        let Xyz { x, y, z } = self.arm(id)?.state.as_ref()?.current_cursor_force?;
        Some(axes::our_force_n(Vector3::new(x, y, z)))
    }

    /// Whether a grip reports its orientation.
    pub fn has_grip(&self) -> bool {
        self.grips().any(|grip| grip.orientation().is_some())
    }

    fn grips(&self) -> impl Iterator<Item = &GripState> {
        let grips = self.wireless_verse_grip.0.iter().chain(&self.verse_grip.0).chain(&self.custom_verse_grip.0);
        grips.flatten().filter_map(|grip| grip.state.as_ref())
    }
}

impl Arm<'_> {
    /// Why the arm rejects forces, one bit each of [`super::code`]; 0 if it accepts them; `None` if
    /// this frame has no status.
    pub fn refusal(&self) -> Option<u32> {
        let status = self.status?;
        let is_false = |said: Option<bool>| said == Some(false);
        let bit = |code: u32, said: Option<bool>| if is_false(said) { code } else { 0 };
        Some(
            bit(super::code::NOT_CALIBRATED, status.calibrated)
                | bit(super::code::NOT_READY, status.ready)
                | bit(super::code::NO_POWER, status.power_supply),
        )
    }
}

impl GripState {
    fn orientation(&self) -> Option<UnitQuaternion<f64>> {
        let Xyzw { x, y, z, w } = self.orientation?;
        UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.5)
            .filter(|unit| unit.coords.iter().all(|part| part.is_finite()))
            .map(axes::orientation)
    }

    /// The button of a wired grip, or `a` of a wireless one, confirms; `b` is the clutch.
    fn pressed(&self) -> Option<u32> {
        let pressed = |bit: u32, held: bool| if held { bit } else { 0 };
        let with_cable = self.button.map(|held| pressed(buttons::CONFIRM, held));
        with_cable
            .or_else(|| self.buttons.map(|Abc { a, b }| pressed(buttons::CONFIRM, a) | pressed(buttons::CLUTCH, b)))
    }
}

/// The first few items of a list, without heap allocation.
struct Few<T>([Option<T>; FEW]);

impl<T> Default for Few<T> {
    fn default() -> Self {
        Self([const { None }; FEW])
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Few<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(FewVisitor(PhantomData))
    }
}

struct FewVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for FewVisitor<T> {
    type Value = Few<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a list of devices")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Few<T>, A::Error> {
        let mut few = Few::default();
        for place in &mut few.0 {
            *place = items.next_element()?;
        }
        while items.next_element::<IgnoredAny>()?.is_some() {}
        Ok(few)
    }
}
