//! What a person has set at this station, kept between attempts: `settings.toml` in the folder of settings.

use std::fs;
use std::io::ErrorKind;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use haptics::devices::gamepad::StickFeel;
use haptics::mapping::Placement;
use serde::{Deserialize, Serialize};

use crate::exit::Failure;
use crate::folders;

/// Degrees that a device may be turned by.
pub const YAWS_DEG: RangeInclusive<f64> = -180.0..=180.0;
/// Motion of the needle per motion of the handle. Never more than 1, which would make tissue stiffer than the device can show.
pub const MOTIONS: RangeInclusive<f64> = 0.5..=1.0;
/// Speed of mouse, keys and sticks, as a factor on the usual one.
pub const SPEEDS: RangeInclusive<f64> = 0.25..=4.0;
/// Part of a stick's way that counts as at rest.
pub const DEAD_ZONES: RangeInclusive<f64> = 0.02..=0.5;
/// Loudness of a pop.
pub const VOLUMES: RangeInclusive<f64> = 0.0..=1.0;

/// The settings of a station.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The person stands at the patient's other side, as left-handed people may want to.
    pub other_side: bool,
    /// How far the device is turned to the left, seen from above, in degrees.
    pub device_yaw_deg: f64,
    /// Motion of the needle per motion of the handle.
    pub motion: f64,
    /// Speed of mouse and keys.
    pub pointer_speed: f64,
    /// Speed of a gamepad's sticks.
    pub stick_speed: f64,
    /// Part of a stick's way that counts as at rest.
    pub stick_dead_zone: f64,
    /// Loudness of a pop.
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
    /// The settings of this station; the usual ones where none were kept.
    ///
    /// # Errors
    /// When the file cannot be read, or holds a value that is out of range.
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

    /// Keeps them for the next time.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn save(&self) -> Result<(), Failure> {
        let path = path()?;
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|error| Failure::refused(folder, error))?;
        }
        let text = toml::to_string(self).map_err(Failure::work)?;
        fs::write(&path, text).map_err(|error| Failure::refused(&path, error))
    }

    /// How the device is placed at the patient.
    pub fn placement(&self) -> Placement {
        let side_deg = if self.other_side { 180.0 } else { 0.0 };
        Placement { yaw_rad: (self.device_yaw_deg + side_deg).to_radians(), motion: self.motion }
    }

    /// How a gamepad's sticks feel.
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
            Err(format!("{name} = {value}: must be a number from {} to {}", allowed.start(), allowed.end()))
        })
    }
}

fn path() -> Result<PathBuf, Failure> {
    Ok(folders::config()?.join("settings.toml"))
}

#[cfg(test)]
mod tests {
    //! A station whose settings cannot be read must say where and why, and must not throw a needle about.

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
            "motion = 2: must be a number from 0.5 to 1"
        );
    }

    #[test]
    fn the_other_side_turns_the_device_half_around() {
        let Placement { yaw_rad, .. } = Settings { other_side: true, ..Settings::default() }.placement();
        assert!((yaw_rad - std::f64::consts::PI).abs() < 1e-12);
    }
}
