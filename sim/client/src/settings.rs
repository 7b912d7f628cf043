//! The user's settings at this station, stored between attempts in `settings.toml` in the
//! configuration folder.

use std::fs;
use std::io::ErrorKind;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use haptics::devices::gamepad::StickFeel;
use haptics::mapping::Placement;
use serde::{Deserialize, Serialize};

use crate::exit::Failure;
use crate::folders;

/// Allowed rotation of the device, in degrees.
pub const YAWS_DEG: RangeInclusive<f64> = -180.0..=180.0;
/// Allowed motion of the needle per motion of the handle. At most 1: more would make tissue stiffer
/// than the device can show.
pub const MOTIONS: RangeInclusive<f64> = 0.5..=1.0;
/// Allowed speed of mouse, keys and sticks, relative to the default.
pub const SPEEDS: RangeInclusive<f64> = 0.25..=4.0;
/// Allowed fraction of a stick's travel that counts as at rest.
pub const DEAD_ZONES: RangeInclusive<f64> = 0.02..=0.5;
/// Allowed loudness of a pop.
pub const VOLUMES: RangeInclusive<f64> = 0.0..=1.0;

/// The settings of a station.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Whether the user stands at the patient's other side, as left-handed users may prefer.
    pub other_side: bool,
    /// Rotation of the device to the left, seen from above, in degrees.
    pub device_yaw_deg: f64,
    /// Motion of the needle per motion of the handle.
    pub motion: f64,
    /// Speed of mouse and keys, relative to the default.
    pub pointer_speed: f64,
    /// Speed of a gamepad's sticks.
    pub stick_speed: f64,
    /// Fraction of a stick's travel that counts as at rest.
    pub stick_dead_zone: f64,
    /// Loudness of a pop, 0 to 1.
    pub volume: f64,
}

impl Default for Settings {
    fn default() -> Self {
        let StickFeel { speed, dead_zone } = StickFeel::default();
        Self {
            other_side: false,
            device_yaw_deg: 0.0,
            motion: 1.0,
            pointer_speed: 1.0,
            stick_speed: speed,
            stick_dead_zone: dead_zone,
            volume: 1.0,
        }
    }
}

impl Settings {
    /// Loads the settings of this station; the defaults if there is no file.
    ///
    /// # Errors
    /// If the file cannot be read, or has an unknown key or a value out of range.
    pub fn load() -> Result<Self, Failure> {
        let path = path()?;
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(Failure::refused(&path, error)),
        };
        let settings: Self = toml::from_str(&text).map_err(|error| Failure::refused(&path, error))?;
        settings.check().map_err(|why| Failure::refused(&path, why))?;
        Ok(settings)
    }

    /// Saves the settings.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self) -> Result<(), Failure> {
        let path = path()?;
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|error| Failure::refused(folder, error))?;
        }
        let text = toml::to_string(self).map_err(Failure::work)?;
        fs::write(&path, text).map_err(|error| Failure::refused(&path, error))
    }

    /// Returns the placement of the device at the patient.
    pub fn placement(&self) -> Placement {
        let side_deg = if self.other_side { 180.0 } else { 0.0 };
        Placement { yaw_rad: (self.device_yaw_deg + side_deg).to_radians(), motion: self.motion }
    }

    /// Returns the settings of a gamepad's sticks.
    pub fn sticks(&self) -> StickFeel {
        StickFeel { speed: self.stick_speed, dead_zone: self.stick_dead_zone }
    }

    fn check(&self) -> Result<(), String> {
        let numbers = [
            ("device_yaw_deg", self.device_yaw_deg, YAWS_DEG),
            ("motion", self.motion, MOTIONS),
            ("pointer_speed", self.pointer_speed, SPEEDS),
            ("stick_speed", self.stick_speed, SPEEDS),
            ("stick_dead_zone", self.stick_dead_zone, DEAD_ZONES),
            ("volume", self.volume, VOLUMES),
        ];
        let bad = numbers.into_iter().find(|(_, value, allowed)| !allowed.contains(value));
        bad.map_or(Ok(()), |(name, value, allowed)| {
            Err(format!("{name} = {value}; allowed: a number from {} to {}", allowed.start(), allowed.end()))
        })
    }
}

fn path() -> Result<PathBuf, Failure> {
    Ok(folders::config()?.join("settings.toml"))
}

#[cfg(test)]
mod tests {
    //! Fails if bad settings are accepted, which would fling the needle, or are rejected without
    //! the place and the reason.

    use super::*;

    #[test]
    fn settings_read_back_and_what_is_out_of_range_is_refused() {
        let settings = Settings { other_side: true, device_yaw_deg: -30.0, motion: 0.5, ..Settings::default() };
        let text = toml::to_string(&settings).unwrap();
        assert_eq!(toml::from_str::<Settings>(&text).unwrap(), settings);
        assert_eq!(toml::from_str::<Settings>("").unwrap(), Settings::default());
        assert!(toml::from_str::<Settings>("colour = 1").is_err(), "an unknown key is a mistake");
        for bad in [Settings { motion: 2.0, ..settings }, Settings { volume: f64::NAN, ..settings }] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
        assert_eq!(
            Settings { motion: 2.0, ..settings }.check().unwrap_err(),
            "motion = 2; allowed: a number from 0.5 to 1"
        );
    }

    #[test]
    fn the_other_side_turns_the_device_half_around() {
        let Placement { yaw_rad, .. } = Settings { other_side: true, ..Settings::default() }.placement();
        assert!((yaw_rad - std::f64::consts::PI).abs() < 1e-12);
    }
}
