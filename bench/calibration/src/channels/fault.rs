//! What can be wrong with the channels, each by its name, with what to do.

use metrology::signal_path::PathFault;

/// A fault of an input, of the cables, or of the way from the generator to them.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChannelsFault {
    /// What a sound layer does to the carrier.
    #[error(transparent)]
    Path(#[from] PathFault),
    /// One input is silent while another is not.
    #[error(
        "input {input} is silent: {share:.1e} of what input {loudest} reads; its cable is out or broken, or the patch does not reach it"
    )]
    Silent {
        /// The silent input.
        input: u16,
        /// The loudest one.
        loudest: u16,
        /// What it reads of that.
        share: f64,
    },
    /// The drive comes in on another input.
    #[error(
        "the drive comes in on input {found}, not on input {expected} as [channels.drive] says: the channels are swapped; exchange the cables, or the indices in bench.toml"
    )]
    Swapped {
        /// Where it should be.
        expected: u16,
        /// Where it is.
        found: u16,
    },
    /// An input whose cable should be out still has it in.
    #[error("input {input} still carries the drive: take its cable out and terminate it")]
    StillConnected {
        /// The input.
        input: u16,
    },
    /// An input that does not show what the others show.
    #[error(
        "input {input} does not carry the patched signal: it reads {spread_db:.1} dB more at one tone than at another beside it; is the plate's cable still in it?"
    )]
    NotPatched {
        /// The input.
        input: u16,
        /// How unevenly it reads tones about the carrier, dB.
        spread_db: f64,
    },
    /// Peaks are cut off at the faintest level.
    #[error(
        "input {input} is saturated: its peaks are cut off at {level:.3} of full scale while only {drive_v:.2} V are played; lower its gain, or take its phantom power or boost off"
    )]
    Saturated {
        /// The input.
        input: u16,
        /// Where, of full scale.
        level: f64,
        /// Drive level, V peak.
        drive_v: f64,
    },
    /// A channel lost its place during the measurement.
    #[error(
        "input {input} slipped by {samples:+} samples against the others while it was measured ({phase_rad:+.2} rad at the carrier): the sound layer does not keep the channels together; use a raw device, longer buffers, and one clock for all channels"
    )]
    Slipped {
        /// The input.
        input: u16,
        /// Later than before, samples.
        samples: i32,
        /// As phase at the carrier.
        phase_rad: f64,
    },
    /// A channel lies elsewhere than at the calibration before.
    #[error(
        "input {input} has slipped by {samples:+.2} samples since the calibration before: the sound layer does not keep the channels together between openings; a plate calibrated then does not hold. Find the cause, then move the old calibration away"
    )]
    SlippedSince {
        /// The input.
        input: u16,
        /// Later than before, samples.
        samples: f64,
    },
    /// The read-back is not what was commanded.
    #[error(
        "{commanded_v:.2} V were commanded and {returned_v:.2} V read back at the carrier: compare output.volts_per_unit and channels.drive.volts_per_unit with the gains, and the amplifier's bandwidth"
    )]
    Level {
        /// Commanded, V peak.
        commanded_v: f64,
        /// Read back, V peak.
        returned_v: f64,
    },
    /// Too much crosstalk.
    #[error(
        "crosstalk too high: input {input} reads the drive at {crosstalk_db:.1} dB, more than calibration.crosstalk_db = {limit_db}: separate the cables, terminate what is open, use inputs that are not neighbours"
    )]
    Crosstalk {
        /// The input.
        input: u16,
        /// Of the drive's reading, dB.
        crosstalk_db: f64,
        /// Allowed, dB.
        limit_db: f64,
    },
    /// Too much noise.
    #[error(
        "input {input} is noisy: {density:.1e} of full scale per √Hz about the carrier, more than calibration.input_noise_units_per_sqrt_hz = {limit:.1e}: lower its gain, or look for a switched supply nearby"
    )]
    Noisy {
        /// The input.
        input: u16,
        /// Sample units per √Hz.
        density: f64,
        /// Allowed.
        limit: f64,
    },
    /// Levels not on a line.
    #[error(
        "input {input} is not linear: its levels depart from a line by {percent:.2} %, more than calibration.input_nonlinearity = {limit}: is an automatic gain or a limiter on?"
    )]
    NotLinear {
        /// The input.
        input: u16,
        /// Departure, % of the largest level.
        percent: f64,
        /// Allowed, as a fraction.
        limit: f64,
    },
    /// Too late or too early.
    #[error(
        "input {input} is {samples:+.2} samples later than the drive's, more than calibration.delay_samples = {limit}: are both inputs of one converter, on one clock?"
    )]
    Delayed {
        /// The input.
        input: u16,
        /// Later, samples.
        samples: f64,
        /// Allowed.
        limit: f64,
    },
    /// Wires exchanged.
    #[error(
        "input {input} is inverted against the drive's: its wires, or those of the drive's, are exchanged"
    )]
    Inverted {
        /// The input.
        input: u16,
    },
    /// Not known well enough.
    #[error(
        "gain and phase of input {input} are known to {error:.1e} only, calibration.input_error = {limit:.1e}: something changes while it is measured; look at its cable and at the tones between the carrier's"
    )]
    Uncertain {
        /// The input.
        input: u16,
        /// Standard error, relative and rad.
        error: f64,
        /// Allowed.
        limit: f64,
    },
    /// More noise than at the calibration.
    #[error(
        "input {input} has {ratio:.1} times the noise that was calibrated: a gain was changed, a cable has come loose, or a switched supply is on"
    )]
    NoisierThanCalibrated {
        /// The input.
        input: u16,
        /// Now over then.
        ratio: f64,
    },
}
