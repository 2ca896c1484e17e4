//! Errors of sources that are no longer available.

use impedance::clock_alignment::TOLERANCE;
use safety::GpioError;

use crate::field_box::FieldBoxGone;
use crate::pace::clock_cause;

/// A source that has become unavailable for good.
#[derive(Debug, thiserror::Error)]
pub enum SourceGone {
    /// The serial port no longer exists.
    #[error("the force sensor's port is gone: {}", bounded_files::cause(.0))]
    Port(std::io::Error),
    /// The network is down.
    #[error("the force sensor's network is gone: {}", bounded_files::cause(.0))]
    Network(std::io::Error),
    /// The sensor's clock does not match its configuration.
    #[error(
        "the force sensor counts {counted_hz:.0} samples a second, and force.netft.sample_hz = {stated_hz}: forces would be \
         placed wrongly; set it to the device's rate"
    )]
    Rate {
        /// Configured rate, Hz.
        stated_hz: f64,
        /// Rate by the host's clock, Hz.
        counted_hz: f64,
    },
    /// The source's clock deviates by more than the alignment can follow.
    #[error(
        "the clock of the {source_name} runs {} against the sound card's ({fast_ppm:+.0} ppm), over the limit of {:.0} %: its \
         readings would get wrong times; {}, and start again \
         (the card itself: {card_ppm:+.0} ppm against this computer)",
        fast_or_slow(*fast_ppm), 100.0 * TOLERANCE,
        remedy(*fast_ppm)
    )]
    Clock {
        /// Name of the source.
        source_name: &'static str,
        /// Excess rate of its clock over the sound card's, parts per million.
        fast_ppm: f64,
        /// Excess rate of the sound card's clock over the computer's, parts per million.
        card_ppm: f64,
    },
    /// The source sends faster than the bench reads.
    #[error(
        "the {source_name} sends faster than it can be read: for {for_s:.1} s data were always waiting, and its readings come \
         late or are lost; lower its rate, or look whether another program sends to it, and start again"
    )]
    Flood {
        /// Name of the source.
        source_name: &'static str,
        /// Time since its buffer was last empty, s.
        for_s: f64,
    },
    /// A line of this computer cannot be read.
    #[error(transparent)]
    Line(#[from] GpioError),
    /// The card with the encoder's counter can no longer be read.
    #[error("{0}")]
    Card(String),
    /// The field box can no longer be read, or is not supported by this version.
    #[error(transparent)]
    FieldBox(#[from] FieldBoxGone),
}

/// Excess rate beyond which no oscillator is off, parts per million.
const NO_OSCILLATOR_PPM: f64 = 2e4;

/// Returns the probable cause of a clock with this excess rate, and its remedy.
fn remedy(fast_ppm: f64) -> String {
    let cause = clock_cause(1.0 + 1e-6 * fast_ppm)
        .unwrap_or("give it a crystal, or correct the microseconds that it sends");
    if fast_ppm.abs() < NO_OSCILLATOR_PPM {
        return cause.to_owned();
    }
    format!(
        "this computer was too busy to read the card or the sensor in time: end other programs; or {cause}"
    )
}

fn fast_or_slow(fast_ppm: f64) -> String {
    let percent = 1e-4 * fast_ppm.abs();
    let way = if fast_ppm < 0.0 { "slow" } else { "fast" };
    format!("{percent:.2} % {way}")
}
