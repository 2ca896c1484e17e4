//! Units in which a column may be given, by the sizes of its values.

use force_alignment::TellingFactor;

/// Smallest and largest ratio of the lateral to the normal force of a finger that slides over a plate at rest.
pub(crate) const FRICTION: [f64; 2] = [0.1, 5.0];
/// Smallest and largest contact area of a finger pad, m²: two and a half standard deviations about the median of 164 mm².
pub(crate) const CONTACT_AREA_M2: [f64; 2] = [45e-6, 600e-6];
/// Largest force of a finger, N; the bench's own limit is 20 N.
pub const LARGEST_N: f64 = 20.0;
/// Hectopascals of a millimetre of mercury.
pub(crate) const HPA_PER_MMHG: f64 = 1.333_22;
/// Usual forces of a sliding finger, N, by which a unit is recognised.
const USUAL_N: [f64; 2] = [0.05, 5.0];
/// Units in which a force may be given in place of newtons: newtons per unit, name, and remedy.
const FORCE_UNITS: [(f64, &str, &str); 8] = [
    (1e-3, "millinewtons", "divide by 1000"),
    (9.806_65e-3, "grams", "multiply by 0.00980665"),
    (1e-6, "micronewtons", "divide by 1000000"),
    (9.806_65e-6, "milligrams", "multiply by 0.00000980665"),
    (9.806_65, "kilograms", "multiply by 9.80665"),
    (4.448_22, "pounds", "multiply by 4.44822"),
    (1e3, "kilonewtons", "multiply by 1000"),
    (1e6, "meganewtons", "multiply by 1000000"),
];

/// Usual travels on a plate, m, by which a unit is recognised.
const USUAL_TRAVEL_M: [f64; 2] = [0.01, 0.5];

/// Units in which a position may be given in place of metres: metres per unit, name, and remedy.
const POSITION_UNITS: [(f64, &str, &str); 4] = [
    (1e-3, "millimetres", "divide by 1000"),
    (1e-2, "centimetres", "divide by 100"),
    (0.0254, "inches", "multiply by 0.0254"),
    (1e-6, "micrometres", "divide by 1000000"),
];

/// Returns the units in which `force_n` would be a usual force of a finger, in words with their remedies.
pub(crate) fn force_remedy(force_n: f64) -> String {
    let [least_n, most_n] = USUAL_N;
    let units = FORCE_UNITS.iter();
    let fitting = units.filter(|(newtons, ..)| (least_n..=most_n).contains(&(newtons * force_n)));
    let words: Vec<String> = fitting
        .map(|(_, unit, remedy)| format!("it looks like {unit}: {remedy}"))
        .collect();
    if words.is_empty() {
        return "it looks like volts or counts of the sensor: multiply them by its sensitivity; or no finger was on the plate"
            .to_owned();
    }
    words.join(", or ")
}

/// Returns the units in which `travel_m` would be a usual travel, in words with their remedies.
pub(crate) fn position_remedy(travel_m: f64) -> String {
    let [least_m, most_m] = USUAL_TRAVEL_M;
    let fitting = POSITION_UNITS
        .iter()
        .filter(|(metres, ..)| (least_m..=most_m).contains(&(metres * travel_m)));
    let words: Vec<String> = fitting
        .map(|(_, unit, remedy)| format!("it looks like {unit}: {remedy}"))
        .collect();
    if words.is_empty() {
        return "it looks like counts of an encoder: multiply them by the metres of a count"
            .to_owned();
    }
    words.join(", or ")
}

/// Median contact area of a finger pad, m²; the area that fits grows with the cube of a force.
const USUAL_AREA_M2: f64 = 164e-6;

/// Returns the height above the sea at which the standard atmosphere has this pressure, m (ICAO 1993).
pub(crate) fn height_m(pressure_hpa: f64) -> f64 {
    44_330.8 * (1.0 - (pressure_hpa / 1013.25).powf(0.190_263))
}

/// Returns the remark about a usual factor near a ratio.
pub(crate) fn nearest(ratio: f64, near: Option<TellingFactor>) -> String {
    near.map_or_else(String::new, |near| {
        let distance = 100.0 * (ratio / near.factor).ln().abs();
        format!(
            "; {} is a usual factor, and {distance:.0} % from it",
            near.number()
        )
    })
}

/// Returns the factor by which a normal force is too large if the usual area of a finger pad becomes `area_m2` by it.
pub(crate) fn force_factor(area_m2: f64) -> f64 {
    (area_m2 / USUAL_AREA_M2).cbrt()
}
