//! Disk space of a session.

use config::Config;
use protocols::Protocol;
use recording::AudioFormat;
use recording::study::DataRates;

/// Returns the disk space that a session may take, bytes: 1.5 times the planned trials, each with a margin beyond the
/// slider's own time.
#[must_use]
pub fn session_bytes(config: &Config, protocol: &Protocol) -> u64 {
    let slide_s = protocol
        .exploration
        .slider(protocols::Direction::LeftToRight)
        .duration_s();
    let explorations = protocol.exploration.directions.len() as f64;
    let timing = &protocol.timing;
    let trial_s = 10.0 + explorations * (slide_s + timing.countdown_s + timing.feedback_s + 5.0);
    let rates = DataRates {
        audio: AudioFormat {
            sample_rate_hz: config.audio.rate_hz,
            channels: config.audio.input_channels,
        },
        force_hz: 10_000.0,
        position_hz: 1_000.0,
    };
    rates.bytes(trial_s * 1.5 * f64::from(protocol.planned_trials()))
}
