//! Refits in narrower bands, which show what the model lacks.

use super::problem::{PARAMETERS, Terms};
use super::response::Response;
use super::solution::PlateSolution;

/// Widths of the narrower bands, of the whole one.
const WIDTHS: [f64; 2] = [0.5, 0.75];
/// Values in a band in addition to the parameters.
const SPARE: usize = 4;
/// Change of a parameter above which its square counts as more than scatter, in variances of the change: 1 % of refits of white
/// noise.
const LEAST_VARIANCES: f64 = 6.6;

/// Returns the largest squared change of each parameter in a narrower band, in excess of the change that the scatter explains.
///
/// A refit of a part of the data differs from the whole fit by a variance that is the difference of theirs (Hausman 1978).
pub(super) fn excess_changes(responses: &[Response], whole: &PlateSolution) -> [f64; PARAMETERS] {
    let centre_hz = whole.resonance_hz();
    let farthest_hz = responses
        .iter()
        .map(|r| (r.frequency_hz - centre_hz).abs())
        .fold(0.0, f64::max);
    let mut excess = [0.0; PARAMETERS];
    for width in WIDTHS {
        let part: Vec<Response> = responses
            .iter()
            .filter(|r| (r.frequency_hz - centre_hz).abs() <= width * farthest_hz)
            .copied()
            .collect();
        // A second mode may lie outside the narrower band: it stays as it is in the whole one.
        let (part, terms) = match whole.terms {
            Terms::SecondMode => (without_second(part, whole), Terms::Slope),
            terms => (part, terms),
        };
        if 2 * part.len() < terms.count() + SPARE || part.len() == responses.len() {
            continue;
        }
        let Ok(refit) = PlateSolution::new(&part, whole.starting_point(), terms) else {
            continue;
        };
        for (i, excess) in excess.iter_mut().enumerate().take(terms.count()) {
            let change = (refit.parameters[i] - whole.parameters[i]).powi(2);
            let explained =
                whole.scatter() * (refit.unit_variance[i] - whole.unit_variance[i]).max(0.0);
            if change > LEAST_VARIANCES * explained {
                *excess = f64::max(*excess, change - explained);
            }
        }
    }
    excess
}

/// Returns the responses less the second mode of a solution.
fn without_second(mut responses: Vec<Response>, solution: &PlateSolution) -> Vec<Response> {
    for response in &mut responses {
        response.ratio -= solution.second_mode(response.frequency_hz);
    }
    responses
}
