//! Where and how the noise of an input is read.

/// Resolution of the spectra of silence, Hz.
pub(super) const NOISE_RESOLUTION_HZ: f64 = 10.0;
/// The noise is read so far to either side of the carrier, Hz.
const NOISE_BAND_HZ: f64 = 2e3;

/// Where the noise about the carrier is looked at, Hz.
pub(super) fn noise_band(carrier_hz: f64, rate_hz: f64) -> [f64; 2] {
    [
        (carrier_hz - NOISE_BAND_HZ).max(0.0),
        (carrier_hz + NOISE_BAND_HZ).min(0.49 * rate_hz),
    ]
}
