//! Drift of the plate's resonance and damping with room temperature, finger warmth and amplitude.

use std::f64::consts::TAU;

use super::exposure::Exposure;
use crate::scenario::DriftTable;

/// Deviation of the plate from its initial state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tuning {
    /// Shift of the carrier mode's resonance, Hz; the second mode shifts in proportion.
    pub shift_hz: f64,
    /// Factor of the damping of both modes.
    pub damping: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            shift_hz: 0.0,
            damping: 1.0,
        }
    }
}

impl Tuning {
    /// Returns whether the two tunings differ enough to recompute the plate: Z_p changes by 1e-4.
    pub fn differs_from(&self, other: &Self) -> bool {
        (self.shift_hz - other.shift_hz).abs() > 5e-3 || (self.damping - other.damping).abs() > 1e-5
    }
}

/// Ratio of the time constants of spreading and direct warmth (assumed).
const SPREADS: f64 = 6.0;

/// Effect of a finger's warmth: a direct part, and a slower part as heat spreads.
#[derive(Debug, Clone)]
struct Warmth {
    near_heat: Exposure,
    far_heat: Exposure,
    spread: f64,
}

impl Warmth {
    fn new(time_s: f64, spread: f64) -> Self {
        Self {
            near_heat: Exposure::new(time_s),
            far_heat: Exposure::new(SPREADS * time_s),
            spread,
        }
    }

    /// Advances by `dt_s` and returns the fraction of the full effect.
    fn advance(&mut self, dt_s: f64, touching: bool) -> f64 {
        let near_heat = self.near_heat.advance(dt_s, touching);
        let far_heat = self.far_heat.advance(dt_s, touching);
        near_heat + self.spread * (far_heat - near_heat)
    }
}

/// Slow change of the plate.
#[derive(Debug, Clone)]
pub(super) struct PlateDrift {
    drift: DriftTable,
    of_resonance: Warmth,
    of_damping: Warmth,
}

impl PlateDrift {
    pub fn new(drift: &DriftTable) -> Self {
        Self {
            drift: drift.clone(),
            of_resonance: Warmth::new(drift.warmth_time_s, drift.warmth_spread),
            of_damping: Warmth::new(
                drift.warmth_time_s * drift.damping_time_ratio,
                drift.warmth_spread,
            ),
        }
    }

    /// Advances by `dt_s` to `time_s`, at this squared peak amplitude, and returns the plate's tuning.
    pub fn advance(
        &mut self,
        dt_s: f64,
        time_s: f64,
        touching: bool,
        amplitude2_m2: f64,
    ) -> Tuning {
        let d = &self.drift;
        let of_resonance = self.of_resonance.advance(dt_s, touching);
        let of_damping = self.of_damping.advance(dt_s, touching);
        let period_min = d.room_period_s / 60.0;
        let room_min = period_min / TAU * (TAU * time_s / d.room_period_s).sin();
        Tuning {
            shift_hz: d.room_hz_per_min * room_min
                + d.warmth_hz * of_resonance
                + d.amplitude_hz_per_um2 * 1e12 * amplitude2_m2,
            damping: (d.room_damping_per_min * room_min).exp()
                * (1.0 + d.warmth_damping * of_damping),
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    fn tuning_after(drift: DriftTable, seconds: u32, touching: impl Fn(u32) -> bool) -> Tuning {
        let mut plate = PlateDrift::new(&drift);
        (1..=seconds).fold(Tuning::default(), |_, s| {
            plate.advance(1.0, f64::from(s), touching(s), 0.0)
        })
    }

    #[test]
    fn the_room_moves_the_plate_by_its_rate_and_back_within_its_period() {
        let room = DriftTable {
            room_hz_per_min: 3.0,
            room_damping_per_min: 0.01,
            ..DriftTable::default()
        };
        let minute = tuning_after(room.clone(), 60, |_| false);
        assert_relative_eq!(minute.shift_hz, 3.0, max_relative = 0.02);
        assert_relative_eq!(minute.damping, 1.01, max_relative = 1e-3);
        // A quarter of a period of 1200 s: 3 Hz/min · 20 min/2π.
        assert_relative_eq!(
            tuning_after(room.clone(), 300, |_| false).shift_hz,
            9.549,
            max_relative = 1e-3
        );
        assert!(tuning_after(room, 1_200, |_| false).shift_hz.abs() < 1e-9);
    }

    #[test]
    fn a_finger_warms_the_plate_and_a_plate_let_go_cools() {
        let warm = DriftTable {
            warmth_hz: -10.0,
            warmth_damping: 0.2,
            ..DriftTable::default()
        };
        let warmed = tuning_after(warm.clone(), 5, |_| true);
        let share = 1.0 - (-1.0f64).exp();
        assert_relative_eq!(warmed.shift_hz, -10.0 * share, max_relative = 1e-12);
        assert_relative_eq!(warmed.damping, 1.0 + 0.2 * share, max_relative = 1e-12);
        let cooled = tuning_after(warm, 10, |s| s <= 5);
        assert_relative_eq!(
            cooled.shift_hz,
            -10.0 * share * (1.0 - share),
            max_relative = 1e-12
        );
    }

    #[test]
    fn heat_that_spreads_follows_later_and_the_damping_by_its_own_time() {
        let warm = DriftTable {
            warmth_hz: -10.0,
            warmth_damping: 0.2,
            warmth_spread: 0.4,
            damping_time_ratio: 2.0,
            ..DriftTable::default()
        };
        let share = |time_s: f64| 1.0 - (-5.0 / time_s).exp();
        let warmed = tuning_after(warm, 5, |_| true);
        let of_resonance = 0.6 * share(5.0) + 0.4 * share(30.0);
        let of_damping = 0.6 * share(10.0) + 0.4 * share(60.0);
        assert_relative_eq!(warmed.shift_hz, -10.0 * of_resonance, max_relative = 1e-12);
        assert_relative_eq!(warmed.damping, 1.0 + 0.2 * of_damping, max_relative = 1e-12);
    }

    #[test]
    fn amplitude_pulls_the_resonance_and_nothing_does_by_default() {
        let soft = DriftTable {
            amplitude_hz_per_um2: -0.3,
            ..DriftTable::default()
        };
        let tuning = PlateDrift::new(&soft).advance(1e-4, 0.0, false, 4e-12);
        assert_relative_eq!(tuning.shift_hz, -1.2, max_relative = 1e-12);
        let still = PlateDrift::new(&DriftTable::default()).advance(1.0, 77.0, true, 9e-12);
        assert_eq!(still, Tuning::default());
    }
}
