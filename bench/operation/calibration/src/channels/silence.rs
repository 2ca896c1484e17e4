//! Signals of an input in silence, other than noise.

use metrology::spectrum::Spectrum;

/// Smallest amplitude of a tone in silence that is reported, of full scale.
const AUDIBLE: f64 = 1e-5;
/// Smallest constant offset that is reported, of full scale.
const OFFSET: f64 = 1e-3;
/// Highest frequency at which a tone counts as mains hum, Hz.
const HUM_HZ: f64 = 1e3;
/// Largest number of tones reported for one input.
const MOST_TONES: usize = 5;
/// Distance from the carrier within which a tone falls into the envelope's band, Hz.
const ENVELOPE_BAND_HZ: f64 = 2.5e3;
/// Returns the signals in an input's silence other than noise, a line each: a constant offset, mains hum, foreign tones.
pub(super) fn warnings(input: u16, spectrum: &Spectrum, carrier_hz: f64) -> Vec<String> {
    let mut lines = Vec::new();
    if spectrum.mean.abs() > OFFSET {
        lines.push(format!(
            "input {input}: a constant offset of {:+.4} of full scale",
            spectrum.mean
        ));
    }
    let tones = spectrum.peaks();
    for tone in tones
        .iter()
        .filter(|tone| tone.amplitude > AUDIBLE)
        .take(MOST_TONES)
    {
        let is_mains = |mains_hz: f64| {
            let multiple = (tone.frequency_hz / mains_hz).round();
            multiple >= 1.0 && (tone.frequency_hz - multiple * mains_hz).abs() < 3.0
        };
        let kind = if tone.frequency_hz < HUM_HZ && (is_mains(50.0) || is_mains(60.0)) {
            "mains hum"
        } else if (tone.frequency_hz - carrier_hz).abs() < ENVELOPE_BAND_HZ {
            "a tone within the carrier's band"
        } else {
            "a foreign tone"
        };
        lines.push(format!(
            "input {input}: {kind} at {:.0} Hz, {:.1e} of full scale",
            tone.frequency_hz, tone.amplitude
        ));
    }
    lines
}
