//! Units in which a column may be given, by the sizes of its values.

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
