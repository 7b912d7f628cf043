//! Command-line options for haptic devices, shared by all commands that use them.

use std::path::PathBuf;

use haptics::{inverse3, openhaptics};

/// Where to look for haptic devices.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Haptic devices")]
pub struct DeviceArgs {
    /// Library of an OpenHaptics device; the system's libHD.so or HD.dll if absent
    #[arg(long, value_name = "FILE", env = "STYLET_OPENHAPTICS")]
    openhaptics: Option<PathBuf>,
    /// Name of the OpenHaptics device in the vendor's set-up; the default device if absent
    #[arg(long, value_name = "NAME", env = "STYLET_OPENHAPTICS_DEVICE")]
    openhaptics_device: Option<String>,
    /// Address of the Haply Inverse Service
    #[arg(long, value_name = "URL", env = "STYLET_INVERSE3", default_value_t = inverse3::Inverse3Options::default().url)]
    inverse3: String,
    /// Identifier of the Inverse3; the first one if absent
    #[arg(long, value_name = "ID", env = "STYLET_INVERSE3_DEVICE")]
    inverse3_device: Option<String>,
    /// Largest force of the Inverse3, in N
    #[arg(long, value_name = "N", default_value_t = inverse3::Inverse3Options::default().max_force_n, value_parser = force_n)]
    inverse3_max_force: f64,
}

impl DeviceArgs {
    /// Returns the options for opening an OpenHaptics device.
    pub fn openhaptics(&self) -> openhaptics::OpenHapticsOptions {
        let standard = openhaptics::OpenHapticsOptions::default();
        let library = self.openhaptics.clone().map_or(standard.library, PathBuf::into_os_string);
        openhaptics::OpenHapticsOptions { library, device: self.openhaptics_device.clone() }
    }

    /// Returns the options for opening an Inverse3.
    pub fn inverse3(&self) -> inverse3::Inverse3Options {
        inverse3::Inverse3Options {
            url: self.inverse3.clone(),
            device_id: self.inverse3_device.clone(),
            max_force_n: self.inverse3_max_force,
            ..inverse3::Inverse3Options::default()
        }
    }
}

fn force_n(text: &str) -> Result<f64, String> {
    let greatest_n = inverse3::Inverse3Options::default().max_force_n;
    match text.parse::<f64>() {
        Ok(force_n) if force_n > 0.0 && force_n <= greatest_n => Ok(force_n),
        _ => Err(format!("a force in N above 0, at most {greatest_n}")),
    }
}

/// Devices at their default places.
#[cfg(test)]
impl Default for DeviceArgs {
    fn default() -> Self {
        let inverse3::Inverse3Options { url, max_force_n, .. } = inverse3::Inverse3Options::default();
        Self {
            openhaptics: None,
            openhaptics_device: None,
            inverse3: url,
            inverse3_device: None,
            inverse3_max_force: max_force_n,
        }
    }
}
