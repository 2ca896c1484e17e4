//! Cosine fitted to the amplitude across the plate.

use metrology::mode_across::{CosineFit, PlaceAcross};

use crate::survey::profile_point::ProfilePoint;

/// Points of the drawn cosine.
const DRAWN: u32 = 200;

/// Fits a cosine to the places; `None` if they determine none.
pub(crate) fn fit(places: &[ProfilePoint]) -> Option<CosineFit> {
    let places = places.iter().map(|place| PlaceAcross {
        across_m: place.position_m,
        amplitude: place.ratio,
        error: place.error,
    });
    CosineFit::new(&places.collect::<Vec<_>>())
}

/// Returns the fitted amplitude from the first place to the last, by the distance in mm.
pub(crate) fn curve(places: &[ProfilePoint], fit: &CosineFit) -> Vec<(f64, f64)> {
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return Vec::new();
    };
    let reach_m = last.position_m - first.position_m;
    let point = |i| {
        let across_m = first.position_m + reach_m * f64::from(i) / f64::from(DRAWN);
        (1e3 * across_m, fit.amplitude_at(across_m))
    };
    (0..=DRAWN).map(point).collect()
}
