//! Reasons to put a measured constant not in force, with their remedies.

/// A result beyond a limit of `[calibration]`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum RejectedResult {
    /// The pickup's reading falls with the amplitude.
    #[error(
        "the pickup reads less where the amplitude is more: check that the amplitudes are in the order of the levels"
    )]
    PickupFalls,
    /// The pickup's points are on no line.
    #[error(
        "the points depart from a line by {:.2} % of the largest amplitude, more than calibration.pickup_nonlinearity = {limit}: repeat the worst one",
        100.0 * nonlinearity
    )]
    PickupBent {
        /// Largest departure, as a share of the largest amplitude.
        nonlinearity: f64,
        /// Limit.
        limit: f64,
    },
    /// The pickup's sensitivity is not known well enough.
    #[error(
        "the sensitivity is known to {} % only, calibration.pickup_error = {limit}: take more points, or higher levels",
        if *relative < 1.0 { format!("{:.2}", 100.0 * relative) } else { "more than 100".to_owned() }
    )]
    PickupUncertain {
        /// Relative standard error.
        relative: f64,
        /// Limit.
        limit: f64,
    },
    /// The meter's volts are not known well enough.
    #[error(
        "the volts are known to {:.1} % only, calibration.meter_tolerance = {limit}: use a better meter, or one that reads the carrier",
        100.0 * relative
    )]
    VoltsUncertain {
        /// Relative standard error.
        relative: f64,
        /// Limit.
        limit: f64,
    },
    /// The meter's readings are on no line through zero.
    #[error(
        "the readings depart from a line through zero by {:.1} % of the largest: repeat the worst one; check the meter's range",
        100.0 * nonlinearity
    )]
    VoltsBent {
        /// Largest departure, as a share of the largest reading.
        nonlinearity: f64,
    },
    /// The meter reads other volts than the bench.
    #[error(
        "the meter reads {per_commanded:.4} V for each volt commanded and {per_read_back:.4} V for each volt read back, more than calibration.meter_tolerance = {limit} off: {cause}; at limits.drive_v = {drive_v} V the plate gets {plate_v:.1} V.{slip} If the meter is right, set output.volts_per_unit = {output_volts_per_unit:.2} and channels.drive.volts_per_unit = {drive_volts_per_unit:.2} in bench.toml, and calibrate again"
    )]
    VoltsOff {
        /// Volts of the meter per volt commanded.
        per_commanded: f64,
        /// Volts of the meter per volt read back.
        per_read_back: f64,
        /// Limit of either's departure from 1.
        limit: f64,
        /// The constant that is wrong.
        cause: &'static str,
        /// Largest drive of a session, V.
        drive_v: f64,
        /// Volts that the plate gets then.
        plate_v: f64,
        /// Slip of a unit that would explain the ratio, as a sentence after a blank; empty without one.
        slip: String,
        /// `output.volts_per_unit` by the meter.
        output_volts_per_unit: f64,
        /// `channels.drive.volts_per_unit` by the meter.
        drive_volts_per_unit: f64,
    },
    /// The plate's response is not that of one resonance.
    #[error(
        "the response departs from a resonance by {:.2} % of its peak, more than calibration.plate_residual = {limit}: check that nothing touches the plate and that its clamp is tight",
        100.0 * residual
    )]
    PlateResidual {
        /// RMS departure, as a share of the peak.
        residual: f64,
        /// Limit.
        limit: f64,
    },
    /// The plate's constants are not known well enough.
    #[error(
        "the fit leaves errors of {resonance:.2} half bandwidths in the resonance, {:.1} % in Q and {:.1} % in the static response, more than calibration.plate_error = {limit}: check the plate's clamp and neighbouring modes, and measure with less noise or in finer steps",
        100.0 * quality,
        100.0 * static_ratio
    )]
    PlateUncertain {
        /// Error of the resonance, half bandwidths.
        resonance: f64,
        /// Relative error of Q.
        quality: f64,
        /// Relative error of the static response.
        static_ratio: f64,
        /// Limit of the largest.
        limit: f64,
    },
    /// Q is not that of a free plate.
    #[error(
        "Q = {quality:.1} is outside calibration.quality = [{low}, {high}]: a finger or a loose clamp damps the plate"
    )]
    PlateQuality {
        /// Q.
        quality: f64,
        /// Least Q.
        low: f64,
        /// Greatest Q.
        high: f64,
    },
    /// The resonance is far from that of the last calibration.
    #[error(
        "the resonance has moved by {drift_hz:+.1} Hz since the last calibration, more than calibration.drift_hz = {limit_hz}: check the plate, its clamp and the temperature"
    )]
    PlateMoved {
        /// Change, Hz.
        drift_hz: f64,
        /// Limit, Hz.
        limit_hz: f64,
    },
    /// The pickup is not calibrated.
    #[error(
        "the force factor needs the pickup's sensitivity: run `friction-bench calibrate pickup` first"
    )]
    PickupUnknown,
    /// The resonance of a sweep is that of the bench in another unit.
    #[error(
        "the resonance, {resonance_hz:.0} Hz, is {ratio:.4} times that of the bench, {configured_hz:.0} Hz: correct the unit of the frequencies in --columns, as in f[{unit}] or f[Hz]"
    )]
    SweepUnit {
        /// Resonance of the sweep, Hz.
        resonance_hz: f64,
        /// Over that of the bench.
        ratio: f64,
        /// Resonance of the bench, Hz.
        configured_hz: f64,
        /// Unit of the frequencies that would explain the ratio.
        unit: &'static str,
    },
    /// The modal mass of a sweep is not that of the bench.
    #[error(
        "the modal mass, {mass_kg:.4e} kg, is not that of bench.toml, plate.modal_mass_kg = {configured_kg}: write {mass_kg:.4e} there, then run the command again"
    )]
    SweepMass {
        /// Modal mass by the sweep, kg.
        mass_kg: f64,
        /// Modal mass of the configuration, kg.
        configured_kg: f64,
    },
    /// The sensitivity of an axis of the force sensor is not known well enough.
    #[error(
        "the sensitivity of the {axis} axis is known to {:.2} % only, calibration.force_error = {limit}: use heavier or more masses, or better known ones",
        100.0 * relative
    )]
    ForceUncertain {
        /// Axis.
        axis: &'static str,
        /// Relative standard error.
        relative: f64,
        /// Limit.
        limit: f64,
    },
    /// A force on one axis is read on the other.
    #[error(
        "{crosstalk:.3} N of {axis} force are made of each newton on the other axis, more than calibration.force_crosstalk = {limit}: level the plate and the pulley's thread, and turn the sensor into its axes"
    )]
    ForceCrosstalk {
        /// Axis that reads the force of the other.
        axis: &'static str,
        /// Newtons per newton.
        crosstalk: f64,
        /// Limit.
        limit: f64,
    },
    /// The masses' readings are on no line.
    #[error(
        "the masses depart from the matrix by {:.2} % of the largest force on the {axis} axis, more than calibration.force_nonlinearity = {limit}: measure the worst one again, or use lighter ones",
        100.0 * nonlinearity
    )]
    ForceBent {
        /// Axis.
        axis: &'static str,
        /// Largest departure, as a share of the largest force.
        nonlinearity: f64,
        /// Limit.
        limit: f64,
    },
    /// An axis is noisy.
    #[error(
        "the noise of the {axis} axis is {noise:.1e} N/√Hz, more than calibration.force_noise_n_per_sqrt_hz = {limit}: check its shield and supply"
    )]
    ForceNoise {
        /// Axis.
        axis: &'static str,
        /// Noise, N/√Hz.
        noise: f64,
        /// Limit, N/√Hz.
        limit: f64,
    },
    /// The zero of an axis drifts.
    #[error(
        "the zero of the {axis} axis drifts by {:+.1} mN/min, more than calibration.force_drift_n_per_min = {limit} N/min: let the sensor warm up, and calibrate again",
        1e3 * drift_n_per_min
    )]
    ForceDrift {
        /// Axis.
        axis: &'static str,
        /// Drift, N/min.
        drift_n_per_min: f64,
        /// Limit, N/min.
        limit: f64,
    },
    /// The zero of an axis does not come back after a load.
    #[error(
        "the zero of the {axis} axis comes back only within {:.1} mN after a load, more than calibration.force_zero_return_n = {limit} N: something rubs or slips, or the sensor creeps",
        1e3 * zero_return_n
    )]
    ForceZeroReturn {
        /// Axis.
        axis: &'static str,
        /// Difference, N.
        zero_return_n: f64,
        /// Limit, N.
        limit: f64,
    },
}

/// Returns the reasons in words.
pub(crate) fn in_words(rejected: &[RejectedResult]) -> Vec<String> {
    rejected.iter().map(ToString::to_string).collect()
}
