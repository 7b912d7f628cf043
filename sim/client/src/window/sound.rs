//! The sound of a pop: a short click, for users who cannot feel it. Its caption is among the
//! messages.

use std::num::{NonZeroU16, NonZeroU32};
use std::path::Path;

use rodio::buffer::SamplesBuffer;
use rodio::{DeviceSinkBuilder, MixerDeviceSink};

/// Sample rate, in Hz.
const RATE_HZ: u32 = 48_000;
/// Duration of a pop, in s.
const LASTS_S: f32 = 0.12;

/// The loudspeaker, if there is one.
pub struct Sound {
    /// Whether the user wants to hear it.
    pub on: bool,
    /// Loudness of a pop, from 0 to 1.
    volume: f32,
    sink: Option<MixerDeviceSink>,
}

impl Sound {
    /// Opens the loudspeaker, with a loudness from 0 to 1; without one it stays silent.
    pub fn open(volume: f32) -> Self {
        let sink = has_sound_card().then(DeviceSinkBuilder::open_default_sink).and_then(Result::ok);
        Self { on: sink.is_some() && volume > 0.0, volume, sink }
    }

    /// Plays a pop.
    pub fn pop(&self) {
        if let (true, Some(sink)) = (self.on, &self.sink) {
            sink.mixer().add(SamplesBuffer::new(NonZeroU16::MIN, click_sample_rate(), click_samples(self.volume)));
        }
    }
}

/// Checked first: without a sound card the system's library writes errors to the terminal.
fn has_sound_card() -> bool {
    !cfg!(target_os = "linux") || Path::new("/dev/snd").exists()
}

fn click_sample_rate() -> NonZeroU32 {
    NonZeroU32::new(RATE_HZ).unwrap_or(NonZeroU32::MIN)
}

/// Synthesizes a rupturing membrane: a decaying tone of falling pitch.
fn click_samples(volume: f32) -> Vec<f32> {
    let mut phase = 0.0_f32;
    let samples = 0..(LASTS_S * RATE_HZ as f32) as u32;
    let at = samples.map(|sample| sample as f32 / RATE_HZ as f32);
    at.map(|t_s| {
        phase += std::f32::consts::TAU * (90.0 + 260.0 * (-t_s / 0.02).exp()) / RATE_HZ as f32;
        volume * 0.5 * phase.sin() * (-t_s / 0.03).exp()
    })
    .collect()
}
