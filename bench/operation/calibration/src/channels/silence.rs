//! Signals of an input in silence, other than noise.

use metrology::disturbance::Sort;
use metrology::spectrum::Spectrum;

/// Smallest amplitude of a tone in silence that is reported, of full scale.
const AUDIBLE: f64 = 1e-5;
/// Smallest constant offset that is reported, of full scale.
const OFFSET: f64 = 1e-3;
/// Largest number of tones reported for one input.
const MOST_TONES: usize = 5;

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
        let kind = match Sort::of_tone(tone.frequency_hz, carrier_hz) {
            Sort::Hum => "mains hum",
            Sort::InBand => "a tone within the carrier's band",
            Sort::OutOfBand | Sort::Offset => "a foreign tone",
        };
        lines.push(format!(
            "input {input}: {kind} at {:.0} Hz, {:.1e} of full scale",
            tone.frequency_hz, tone.amplitude
        ));
    }
    lines
}
