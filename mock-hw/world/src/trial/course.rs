//! Durations and places of a trial on the screen.

/// Time before the first unloaded stretch, s.
pub(super) const SETTLE_S: f64 = 0.2;
/// Length of an unloaded stretch, s.
pub(super) const BASELINE_S: f64 = 0.8;
/// Time from a start mark on the screen to its end without a button, s.
pub(super) const PATIENCE_S: f64 = 20.0;
pub(super) const COUNTDOWN_S: f64 = 3.0;
pub(super) const FEEDBACK_S: f64 = 3.0;
/// Time after a finger's last touch before the plate counts as unloaded, s.
pub(super) const LIFTED_S: f64 = 0.2;
/// Time to reach a start mark and press the button, s: typical.
pub(super) const PLACING_S: f64 = 1.1;
/// Ends of the slider's travel along the plate, m.
pub(super) const TRAVEL_M: [f64; 2] = [0.010, 0.095];
pub(super) const SPEED_M_PER_S: f64 = 0.050;
pub(super) const TRAVEL_S: f64 = (TRAVEL_M[1] - TRAVEL_M[0]) / SPEED_M_PER_S;
/// Normal forces requested on the screen, N.
pub(super) const BAND_N: (f64, f64) = (0.5, 0.8);

/// End of the first unloaded stretch, s.
pub(super) const UNLOADED_S: f64 = SETTLE_S + BASELINE_S;
/// Typical length of a stroke with its countdown and the mean force shown after it, s.
pub(super) const STROKE_S: f64 = PLACING_S + COUNTDOWN_S + TRAVEL_S + FEEDBACK_S;
/// Typical length of the unloaded stretch at the end, less the display of a mean force, s.
pub(super) const TAIL_S: f64 = 0.5 + LIFTED_S + BASELINE_S - FEEDBACK_S;
/// Time that a stroke needs after its slider has started, s.
pub(super) const REST_OF_STROKE_S: f64 = TRAVEL_S + 1.0 + LIFTED_S + BASELINE_S;
