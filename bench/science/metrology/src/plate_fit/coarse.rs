//! Rough values of a resonance from the largest response and its neighbours.

use super::plate_fit_error::{LEAST_TONES, PlateFitError};
use super::response::Response;

/// Rough values of a resonance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarseResonance {
    /// Resonance, Hz.
    pub resonance_hz: f64,
    /// Quality factor.
    pub quality: f64,
}

/// Requires responses that a fit can use.
pub(super) fn require_usable(responses: &[Response]) -> Result<(), PlateFitError> {
    let count = responses.len();
    if count < LEAST_TONES {
        return Err(PlateFitError::TooFew { count });
    }
    if let Some(invalid) = responses.iter().find(|r| !r.ratio.is_finite()) {
        return Err(PlateFitError::NotFinite {
            frequency_hz: invalid.frequency_hz,
        });
    }
    Ok(())
}

/// Returns rough values of f₀ (Hz) and Q from the largest response and its neighbours, to choose a narrower band.
///
/// # Errors
/// When there are too few tones, or the largest is the first or the last.
pub fn find_resonance(responses: &[Response]) -> Result<CoarseResonance, PlateFitError> {
    require_usable(responses)?;
    let count = responses.len();
    // 1/|H|² is a parabola in f about the resonance: without noise, exact from the peak and its neighbours.
    let peak = (0..count)
        .max_by(|&a, &b| {
            responses[a]
                .ratio
                .norm()
                .total_cmp(&responses[b].ratio.norm())
        })
        .unwrap_or(0);
    if peak == 0 || peak == count - 1 {
        return Err(PlateFitError::OutOfBand {
            from_hz: responses[0].frequency_hz,
            to_hz: responses[count - 1].frequency_hz,
            peak_hz: responses[peak].frequency_hz,
        });
    }
    let point_at = |i: usize| {
        let r = responses[i];
        (r.frequency_hz, r.ratio.norm_sqr().recip())
    };
    // y = 1/|H|² ∝ (1 − r²)² + r²/Q² ≈ 4 (r − 1)² + 1/Q². Divided differences of y = y₀ + c (f − f₀)²: s₁ = c (f₁ + f₂ − 2f₀)
    // and (s₂ − s₁)/(f₃ − f₁) = c.
    let ((f1, y1), (f2, y2), (f3, y3)) = (point_at(peak - 1), point_at(peak), point_at(peak + 1));
    let (s1, s2) = ((y2 - y1) / (f2 - f1), (y3 - y2) / (f3 - f2));
    let bend = (s2 - s1) / (f3 - f1);
    let resonance_hz = if bend > 0.0 {
        (0.5 * (f1 + f2 - s1 / bend)).clamp(f1, f3)
    } else {
        f2
    };
    // y = y_least (1 + (2Q (f − f₀)/f₀)²), so c/y_least = (2Q/f₀)².
    let least = y2 - bend * (f2 - resonance_hz).powi(2);
    let quality = 0.5 * resonance_hz * (bend / least).sqrt();
    let quality = if quality.is_finite() && quality > 1.0 {
        quality
    } else {
        resonance_hz / (f3 - f1)
    };
    Ok(CoarseResonance {
        resonance_hz,
        quality,
    })
}
