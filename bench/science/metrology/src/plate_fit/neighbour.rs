//! A second mode near the plate's.

use num_complex::Complex64;

use super::linear::LinearFit;
use super::problem::{Terms, mode};
use super::response::Response;
use super::solution::{PlateSolution, StartingPoint};

/// Root mean square residual, of the largest response, below which no second mode is sought: what is left cannot move the
/// constants by more than a few thousandths.
const LEAST_RESIDUAL: f64 = 1e-3;
/// Resonances tried, and qualities over that of the plate's mode.
const RESONANCES: usize = 61;
const QUALITY_RATIOS: [f64; 3] = [0.4, 1.0, 2.5];
/// Smallest F ratio of a second mode: the best of the modes tried reaches 8 once in a thousand records of white noise.
const LEAST_F_RATIO: f64 = 12.0;
/// Fewest degrees of freedom with a second mode.
const LEAST_FREEDOM: usize = 8;
/// Smallest peak of a second mode, of that of the plate's mode.
const LEAST_SHARE: f64 = 5e-3;
/// Distance beyond the band within which a second mode may lie, of the band's width.
const BEYOND: f64 = 0.5;
const QUALITIES: std::ops::Range<f64> = 2.0..1e6;

/// A mode near the plate's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Its resonance, Hz.
    pub resonance_hz: f64,
    /// Its quality factor.
    pub quality: f64,
    /// Its peak over that of the plate's mode.
    pub share: f64,
}

/// Returns the solution with a second mode, and that mode, if the residuals of `single` show one.
pub(super) fn with_neighbour(
    responses: &[Response],
    single: &PlateSolution,
    largest: f64,
) -> Option<(PlateSolution, Neighbour)> {
    let freedom = (2 * responses.len()).checked_sub(Terms::SecondMode.count())?;
    let residual = (single.squares / responses.len() as f64).sqrt() / largest;
    if freedom < LEAST_FREEDOM || residual < LEAST_RESIDUAL {
        return None;
    }
    let start = second_mode_start(responses, single)?;
    let both = PlateSolution::new(responses, start, Terms::SecondMode).ok()?;
    let f_ratio = (single.squares - both.squares) / 4.0 / both.scatter();
    let p = &both.parameters;
    let neighbour = Neighbour {
        resonance_hz: both.reference_hz * (1.0 + p[8]),
        quality: p[9].exp(),
        share: Complex64::new(p[10], p[11]).norm() * p[9].exp() / (p[2] + p[1]).exp(),
    };
    let band = [responses.first()?, responses.last()?].map(|r| r.frequency_hz);
    let beyond = BEYOND * (band[1] - band[0]);
    let is_near = (band[0] - beyond..=band[1] + beyond).contains(&neighbour.resonance_hz);
    // A mode as broad as the band is background.
    let is_narrow = neighbour.resonance_hz / neighbour.quality < band[1] - band[0];
    let is_seen = f_ratio > LEAST_F_RATIO
        && neighbour.share > LEAST_SHARE
        && is_near
        && is_narrow
        && QUALITIES.contains(&neighbour.quality);
    is_seen.then_some((both, neighbour))
}

/// Returns the starting point with the second mode that lowers the residuals most.
fn second_mode_start(responses: &[Response], single: &PlateSolution) -> Option<StartingPoint> {
    let (resonance_hz, quality) = (single.resonance_hz(), single.quality());
    let phase = single.parameters[3];
    let data: Vec<Complex64> = responses.iter().map(|r| r.ratio).collect();
    let column = |value: &dyn Fn(f64) -> Complex64| {
        let frequencies = responses.iter().map(|r| r.frequency_hz);
        frequencies.map(value).collect::<Vec<_>>()
    };
    let fixed = [
        column(&|f| mode(f / resonance_hz, quality) * Complex64::cis(-phase * f / resonance_hz)),
        column(&|_| Complex64::ONE),
        column(&|f| Complex64::from(f / resonance_hz - 1.0)),
    ];
    let from_hz = responses.first()?.frequency_hz;
    let span_hz = responses.last()?.frequency_hz - from_hz;
    let tried = (0..RESONANCES).flat_map(|n| {
        let share = n as f64 / (RESONANCES - 1) as f64;
        let second_hz = from_hz + span_hz * ((1.0 + 2.0 * BEYOND) * share - BEYOND);
        QUALITY_RATIOS.map(|ratio| (second_hz, ratio * quality))
    });
    let fits = tried.filter_map(|(second_hz, second_quality)| {
        let mut columns = fixed.to_vec();
        columns.push(column(&|f| mode(f / second_hz, second_quality)));
        let fit = LinearFit::new(columns, &data)?;
        Some((fit, second_hz, second_quality))
    });
    let (fit, second_hz, second_quality) =
        fits.min_by(|a, b| a.0.squares.total_cmp(&b.0.squares))?;
    let mut start = single.starting_point();
    let [main, offset, slope, second] = fit.coefficients.try_into().ok()?;
    start.parameters[2] = main.norm().ln();
    start.parameters[3] = phase - main.arg();
    start.parameters[4..].copy_from_slice(&[
        offset.re,
        offset.im,
        slope.re,
        slope.im,
        second_hz / start.reference_hz - 1.0,
        second_quality.ln(),
        second.re,
        second.im,
    ]);
    Some(start)
}
