//! Resonances within a sweep.

use std::ops::Range;

use metrology::plate_fit::{CHANNEL_MATCH, CoarseResonance, LinearFit, PlateFit, Response};
use num_complex::Complex64;

/// Lowest quality factor tried, and the ratio of each to the one before.
const LOWEST_QUALITY: f64 = 4.0;
const QUALITY_RATIO: f64 = 1.6;
/// Distance of the frequencies tried, and half-width of the band about each, bandwidths.
const STEP: f64 = 0.4;
const HALF_BAND: f64 = 3.0;
/// Largest number of responses in the band of a trial.
const TRIAL_RESPONSES: usize = 64;
/// Fewest responses in the band of a trial, and within a bandwidth of its frequency.
const LEAST_IN_BAND: usize = 7;
const LEAST_NEAR: usize = 3;
/// Smallest logarithm of the likelihood ratio of a resonance against a straight line.
const LEAST_LIKELIHOOD: f64 = 12.0;
/// Largest number of resonances that are fitted.
const MOST_FITTED: usize = 16;
/// Largest number of responses of a fit that only judges a resonance.
const JUDGED_RESPONSES: usize = 400;
/// Half-widths of the band of a fit, bandwidths: the first with enough responses is taken.
const HALF_WIDTHS: [f64; 5] = [2.0, 2.5, 3.0, 4.0, 6.0];
const ENOUGH_RESPONSES: usize = 16;
/// Largest relative error of a quality and of a static response by which a resonance counts as found.
const LARGEST_ERROR: f64 = 0.4;
/// Smallest peak of a resonance, in root mean square residuals.
const LEAST_PEAK: f64 = 3.0;
/// Lowest resonance, Hz.
const LOWEST_HZ: f64 = 900.0;

/// A resonance that was tried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    coarse: CoarseResonance,
    pub(crate) likelihood: f64,
}

/// A resonance that was fitted, with its band.
#[derive(Clone, Debug)]
pub(crate) struct FoundResonance {
    pub(crate) fit: PlateFit,
    /// Responses of the fit.
    pub(crate) responses: Vec<Response>,
    /// Band from which they are.
    pub(crate) band: Range<usize>,
}

impl FoundResonance {
    pub(crate) fn bandwidth_hz(&self) -> f64 {
        self.fit.resonance_hz.value / self.fit.quality.value
    }
}

/// Returns the responses from `from_hz` to `to_hz`.
fn band(responses: &[Response], from_hz: f64, to_hz: f64) -> Range<usize> {
    let start = responses.partition_point(|r| r.frequency_hz < from_hz);
    start..responses.partition_point(|r| r.frequency_hz <= to_hz)
}

/// Returns at most `most` of the responses, evenly picked.
pub(crate) fn thinned(responses: &[Response], most: usize) -> Vec<Response> {
    let step = responses.len().div_ceil(most).max(1);
    responses.iter().step_by(step).copied().collect()
}

/// Returns the places in the sweep that a resonance explains far better than a straight line does, the clearest first, each
/// farther from a clearer one than their bandwidths.
pub(crate) fn candidates(responses: &[Response]) -> Vec<Candidate> {
    let mut tried = Vec::new();
    let mut quality = LOWEST_QUALITY;
    let mut has_any = true;
    while has_any {
        has_any = false;
        let mut next_hz = LOWEST_HZ;
        for response in responses {
            let resonance_hz = response.frequency_hz;
            if resonance_hz < next_hz {
                continue;
            }
            next_hz = resonance_hz * (1.0 + STEP / quality);
            let coarse = CoarseResonance {
                resonance_hz,
                quality,
            };
            let Some(likelihood) = likelihood(responses, coarse) else {
                continue;
            };
            has_any = true;
            if likelihood > LEAST_LIKELIHOOD {
                tried.push(Candidate { coarse, likelihood });
            }
        }
        quality *= QUALITY_RATIO;
        // The lowest qualities may need a wider sweep than this.
        has_any |= quality < 100.0;
    }
    tried.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
    let bandwidth_hz =
        |candidate: &Candidate| candidate.coarse.resonance_hz / candidate.coarse.quality;
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in tried {
        let is_apart = |other: &Candidate| {
            let distance_hz = (candidate.coarse.resonance_hz - other.coarse.resonance_hz).abs();
            distance_hz > bandwidth_hz(&candidate).max(bandwidth_hz(other))
        };
        if kept.iter().all(is_apart) {
            kept.push(candidate);
        }
        if kept.len() == MOST_FITTED {
            break;
        }
    }
    kept
}

/// Returns the logarithm of the likelihood ratio of a resonance beside a straight line against the line alone, less that of its
/// parameters; `None` where the responses are too few.
fn likelihood(responses: &[Response], coarse: CoarseResonance) -> Option<f64> {
    let CoarseResonance {
        resonance_hz,
        quality,
    } = coarse;
    let bandwidth_hz = resonance_hz / quality;
    let reach_hz = HALF_BAND * bandwidth_hz;
    let near = band(
        responses,
        resonance_hz - bandwidth_hz,
        resonance_hz + bandwidth_hz,
    );
    let range = band(responses, resonance_hz - reach_hz, resonance_hz + reach_hz);
    if near.len() < LEAST_NEAR || range.len() < LEAST_IN_BAND {
        return None;
    }
    let part = thinned(&responses[range], TRIAL_RESPONSES);
    let column = |value: &dyn Fn(f64) -> Complex64| {
        let frequencies = part.iter().map(|response| response.frequency_hz);
        frequencies.map(value).collect::<Vec<_>>()
    };
    let line = [
        column(&|_| Complex64::ONE),
        column(&|f| Complex64::from((f - resonance_hz) / bandwidth_hz)),
    ];
    let mode = column(&|f| {
        let r = f / resonance_hz;
        Complex64::new(1.0 - r * r, r / quality).inv()
    });
    let data: Vec<Complex64> = part.iter().map(|response| response.ratio).collect();
    let without = LinearFit::new(line.to_vec(), &data)?.squares;
    let [one, slope] = line;
    let with = LinearFit::new(vec![one, slope, mode], &data)?.squares;
    let n = part.len() as f64;
    // Two complex parameters of the line, and four real ones of a resonance.
    let freedom = (n - 4.0).max(1.0);
    let floor = f64::MIN_POSITIVE.max(1e-24 * without);
    Some(freedom * (without.max(floor) / with.max(floor)).ln() - 2.0 * n.ln())
}

/// Fits the resonance of a candidate in a band that follows its bandwidth; `None` if the responses determine none there.
pub(crate) fn found(responses: &[Response], candidate: Candidate) -> Option<FoundResonance> {
    let mut coarse = candidate.coarse;
    let mut last = None;
    for _ in 0..5 {
        let band = fit_band(responses, coarse);
        let part = thinned(&responses[band.clone()], JUDGED_RESPONSES);
        let fit = PlateFit::from_start(&part, coarse, CHANNEL_MATCH).ok()?;
        let fitted = CoarseResonance {
            resonance_hz: fit.resonance_hz.value,
            quality: fit.quality.value,
        };
        let moved_hz = (fitted.resonance_hz - coarse.resonance_hz).abs();
        let is_settled = moved_hz < 0.05 * fitted.resonance_hz / fitted.quality
            && (fitted.quality / coarse.quality).ln().abs() < 0.05;
        coarse = fitted;
        last = Some(FoundResonance {
            fit,
            responses: part,
            band,
        });
        if is_settled {
            break;
        }
    }
    last.filter(|found| is_resonance(responses, found))
}

/// Returns whether a fit is that of a resonance within the sweep.
fn is_resonance(responses: &[Response], found: &FoundResonance) -> bool {
    let fit = &found.fit;
    let resonance_hz = fit.resonance_hz.value;
    let band = &responses[found.band.clone()];
    let below = band
        .iter()
        .filter(|r| r.frequency_hz < resonance_hz)
        .count();
    let largest = band.iter().map(|r| r.ratio.norm()).fold(0.0, f64::max);
    let errors = fit.constant_errors();
    let [from_hz, to_hz] = [&responses[0], &responses[responses.len() - 1]].map(|r| r.frequency_hz);
    below >= 2
        && band.len() - below >= 2
        && fit.quality.value > 2.0
        && found.bandwidth_hz() < to_hz - from_hz
        && errors.quality < LARGEST_ERROR
        && errors.static_ratio < LARGEST_ERROR
        && fit.mode_peak() > LEAST_PEAK * fit.residual * largest
}

/// Returns the band about a resonance in which it is fitted.
fn fit_band(responses: &[Response], coarse: CoarseResonance) -> Range<usize> {
    let bandwidth_hz = coarse.resonance_hz / coarse.quality;
    let about = |half_width: f64| {
        let reach_hz = half_width * bandwidth_hz;
        band(
            responses,
            coarse.resonance_hz - reach_hz,
            coarse.resonance_hz + reach_hz,
        )
    };
    let mut bands = HALF_WIDTHS.into_iter().map(about);
    let enough = bands.find(|band| band.len() >= ENOUGH_RESPONSES);
    enough.unwrap_or_else(|| about(HALF_WIDTHS[HALF_WIDTHS.len() - 1]))
}
