//! Resolution and band of the noise measurement of an input.

/// Resolution of the spectra of silence, Hz.
pub(super) const NOISE_RESOLUTION_HZ: f64 = 10.0;
/// Distance from the carrier to either side over which the noise is measured, Hz.
const NOISE_BAND_HZ: f64 = 2e3;

/// Returns the band about the carrier in which the noise is measured, Hz.
pub(super) fn noise_band(carrier_hz: f64, rate_hz: f64) -> [f64; 2] {
    [
        (carrier_hz - NOISE_BAND_HZ).max(0.0),
        (carrier_hz + NOISE_BAND_HZ).min(0.49 * rate_hz),
    ]
}
