//! Minima of sampled curves.

use crate::film::CurvePoint;

/// Returns the place of the least value of an even curve, refined by the parabola through it and its neighbours.
pub(crate) fn least(curve: &[CurvePoint]) -> Option<CurvePoint> {
    let index = (0..curve.len())
        .filter(|index| curve[*index].residual.is_finite())
        .min_by(|a, b| curve[*a].residual.total_cmp(&curve[*b].residual))?;
    Some(refined(curve, index))
}

fn refined(curve: &[CurvePoint], index: usize) -> CurvePoint {
    let middle = curve[index];
    let (Some(before), Some(after)) =
        (index.checked_sub(1).map(|i| curve[i]), curve.get(index + 1))
    else {
        return middle;
    };
    let bend = before.residual - 2.0 * middle.residual + after.residual;
    let tilt = 0.5 * (after.residual - before.residual);
    if bend.is_nan() || bend <= 0.0 {
        return middle;
    }
    let step_s = after.delay_s - middle.delay_s;
    let place = (-tilt / bend).clamp(-1.0, 1.0);
    CurvePoint {
        delay_s: middle.delay_s + place * step_s,
        residual: middle.residual + 0.5 * place * tilt,
    }
}

/// Returns the places of all local minima within, smallest first.
pub(crate) fn minima(curve: &[CurvePoint]) -> Vec<CurvePoint> {
    let is_minimum = |index: &usize| {
        let here = curve[*index].residual;
        let previous = index.checked_sub(1).map(|i| curve[i].residual);
        let following = curve.get(index + 1).map(|point| point.residual);
        previous.is_some_and(|previous| here <= previous)
            && following.is_some_and(|following| here < following)
    };
    let places = (0..curve.len()).filter(is_minimum);
    let mut minima: Vec<CurvePoint> = places.map(|index| refined(curve, index)).collect();
    minima.sort_by(|a, b| a.residual.total_cmp(&b.residual));
    minima
}
