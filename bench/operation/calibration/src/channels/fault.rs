//! Faults of the channels with their remedies.

use metrology::signal_path::PathFault;
use safety::DELAY_WITHIN_S;

/// A fault of an input, of the cables, or of the path from the generator to the inputs.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChannelsFault {
    /// The path from the generator does not carry the tone.
    #[error(transparent)]
    Path(#[from] PathFault),
    /// An input is silent while another is not.
    #[error(
        "input {input} is silent: {share:.1e} of what input {loudest} reads; its cable is out or broken, or the patch does not reach it"
    )]
    Silent {
        /// The silent input.
        input: u16,
        /// The loudest input.
        loudest: u16,
        /// Level over that of the loudest input.
        share: f64,
    },
    /// The loop delay varies between openings of the streams by more than the safety watch can tolerate.
    #[error(
        "the loop's delay was {:.1} to {:.1} ms over {openings} openings of the streams, and the watch accepts {:.0} ms about one value: link both directions (one duplex device, such as hw:…, or JACK without xruns), shorten audio.buffer_frames, or use another device",
        1e3 * least_s,
        1e3 * most_s,
        1e3 * DELAY_WITHIN_S
    )]
    DelaySpread {
        /// Shortest delay, s.
        least_s: f64,
        /// Longest delay, s.
        most_s: f64,
        /// Number of openings.
        openings: usize,
    },
    /// The drive is on another input.
    #[error(
        "the drive comes in on input {found}, not on input {expected} as [channels.drive] says: the channels are swapped; exchange the cables, or the indices in bench.toml"
    )]
    Swapped {
        /// Expected input.
        expected: u16,
        /// Actual input.
        found: u16,
    },
    /// The cable of an input was not disconnected.
    #[error("input {input} still carries the drive: disconnect its cable and terminate the input")]
    StillConnected {
        /// The input.
        input: u16,
    },
    /// An input does not carry the patched signal.
    #[error(
        "input {input} does not carry the patched signal: it reads {spread_db:.1} dB more at one tone than at another beside it; check that the plate's cable is not still in it"
    )]
    NotPatched {
        /// The input.
        input: u16,
        /// Spread of its levels over the tones about the carrier, dB.
        spread_db: f64,
    },
    /// The peaks of an input are cut off at the faintest level.
    #[error(
        "input {input} is saturated: its peaks are cut off at {level:.3} of full scale while only {drive_v:.2} V are played; lower its gain, or switch off its phantom power or boost"
    )]
    Saturated {
        /// The input.
        input: u16,
        /// Clipping level, of full scale.
        level: f64,
        /// Drive level, V peak.
        drive_v: f64,
    },
    /// A channel slipped during the measurement.
    #[error(
        "input {input} slipped by {samples:+} samples against the others while it was measured ({phase_rad:+.2} rad at the carrier): the sound layer does not keep the channels together; use a raw device, longer buffers, and one clock for all channels"
    )]
    Slipped {
        /// The input.
        input: u16,
        /// Additional delay, samples.
        samples: i32,
        /// Delay as a phase at the carrier, rad.
        phase_rad: f64,
    },
    /// A channel has slipped since the previous calibration.
    #[error(
        "input {input} has slipped by {samples:+.2} samples since the calibration before: the sound layer does not keep the channels together between openings; the plate's calibration no longer holds. Find the cause, then move the old calibration away"
    )]
    SlippedSince {
        /// The input.
        input: u16,
        /// Additional delay, samples.
        samples: f64,
    },
    /// The read-back differs from the command.
    #[error(
        "{commanded_v:.2} V were commanded and {returned_v:.2} V read back at the carrier: compare output.volts_per_unit and channels.drive.volts_per_unit with the gains, and the amplifier's bandwidth"
    )]
    Level {
        /// Commanded level, V peak.
        commanded_v: f64,
        /// Level read back, V peak.
        returned_v: f64,
    },
    /// An input reads too much of the drive.
    #[error(
        "crosstalk too high: input {input} reads the drive at {crosstalk_db:.1} dB, more than calibration.crosstalk_db = {limit_db}: separate the cables, terminate what is open, use inputs that are not neighbours"
    )]
    Crosstalk {
        /// The input.
        input: u16,
        /// Crosstalk relative to the drive's reading, dB.
        crosstalk_db: f64,
        /// Largest crosstalk allowed, dB.
        limit_db: f64,
    },
    /// An input is too noisy.
    #[error(
        "input {input} is noisy: {density:.1e} of full scale per √Hz about the carrier, more than calibration.input_noise_units_per_sqrt_hz = {limit:.1e}: lower its gain, or look for a switched supply nearby"
    )]
    Noisy {
        /// The input.
        input: u16,
        /// Noise density, sample units/√Hz.
        density: f64,
        /// Largest noise density allowed, sample units/√Hz.
        limit: f64,
    },
    /// The levels of an input are not linear.
    #[error(
        "input {input} is not linear: its levels depart from a line by {percent:.2} %, more than calibration.input_nonlinearity = {limit}: switch off any automatic gain or limiter"
    )]
    NotLinear {
        /// The input.
        input: u16,
        /// Largest residual, % of the largest level.
        percent: f64,
        /// Largest residual allowed, as a fraction.
        limit: f64,
    },
    /// The delay of an input is too large, in either direction.
    #[error(
        "input {input} is {samples:+.2} samples later than the drive's, more than calibration.delay_samples = {limit}: use two inputs of one converter on one clock"
    )]
    Delayed {
        /// The input.
        input: u16,
        /// Delay behind the drive's input, samples.
        samples: f64,
        /// Largest delay allowed, samples.
        limit: f64,
    },
    /// An input has the opposite polarity.
    #[error(
        "input {input} is inverted against the drive's: its wires, or those of the drive's, are exchanged"
    )]
    Inverted {
        /// The input.
        input: u16,
    },
    /// Gain and phase of an input are too uncertain.
    #[error(
        "gain and phase of input {input} are known to {error:.1e} only, calibration.input_error = {limit:.1e}: something changes while it is measured; look at its cable and at the tones between the carrier's"
    )]
    Uncertain {
        /// The input.
        input: u16,
        /// Standard error, relative and rad.
        error: f64,
        /// Largest standard error allowed.
        limit: f64,
    },
    /// An input has more noise than at the calibration.
    #[error(
        "input {input} has {ratio:.1} times the noise that was calibrated: a gain was changed, a cable has come loose, or a switched supply is on"
    )]
    NoisierThanCalibrated {
        /// The input.
        input: u16,
        /// Ratio of the present noise to the calibrated one.
        ratio: f64,
    },
}
