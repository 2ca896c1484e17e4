//! `[session]`: ranges of the constants drawn for one session of the bench.

use rand::{Rng, RngExt};

use super::force_sensor_table::ForceSensorTable;
use super::plate_table::PlateTable;
use super::ranges::drawable;

drawable! {
    /// Ranges, given by both ends, from which constants of the bench are drawn by seed; a constant without a range keeps its
    /// value. Times are drawn on a logarithmic scale. The ranges of a scenario are assumptions.
    SessionTable => SessionDrawn, "session";
    /// Largest rate of change of the resonance with the room's temperature, Hz/min.
    room_hz_per_min: linear, -60.0, 60.0, "Hz/min";
    /// Relative rate of change of the damping with the room's temperature at the same time, 1/min.
    room_damping_per_min: linear, -0.05, 0.05, "1/min";
    /// Shift of the resonance by the finger's warmth, Hz.
    warmth_hz: linear, -100.0, 100.0, "Hz";
    /// Relative change of the damping by the finger's warmth.
    warmth_damping: linear, -0.5, 1.0, "";
    /// Time constant of warming, s.
    warmth_time_s: log, 0.1, 1e4, "s";
    /// Share by which the amplitude is lower at both ends.
    end_drop: linear, -0.5, 0.5, "";
    /// Share by which the amplitude is higher at the far end and lower at the near one.
    end_tilt: linear, -0.3, 0.3, "";
    /// Distance of the second mode's resonance from the carrier mode's, above or below at random by seed, Hz.
    second_mode_off_hz: linear, 300.0, 1e4, "Hz";
    /// Half waves of the second mode along the plate.
    second_mode_half_waves: linear, 0.0, 10.0, "";
    /// Resonance of the mount along the plate, Hz.
    lateral_resonance_hz: linear, 100.0, 20e3, "Hz";
    /// Lag of the lateral axis, s.
    lateral_lag_s: linear, 0.0, 0.02, "s";
    /// Share of the warmth that acts more slowly.
    warmth_spread: linear, 0.0, 1.0, "";
    /// Ratio of the time constant of the damping to that of the resonance.
    damping_time_ratio: log, 0.1, 10.0, "";
    /// Modal mass of the second mode, kg.
    second_mode_mass_kg: log, 1e-3, 1.0, "kg";
}

impl SessionTable {
    /// Draws the constants with a range into `plate` and `sensor`.
    pub(super) fn draw(
        &self,
        rng: &mut impl Rng,
        plate: &mut PlateTable,
        sensor: &mut ForceSensorTable,
    ) {
        let values = self.draw_values(rng);
        let is_above = rng.random::<bool>();
        let set = |target: &mut f64, value: Option<f64>| {
            if let Some(value) = value {
                *target = value;
            }
        };
        let drift = &mut plate.drift;
        set(&mut drift.room_hz_per_min, values.room_hz_per_min);
        set(&mut drift.room_damping_per_min, values.room_damping_per_min);
        set(&mut drift.warmth_hz, values.warmth_hz);
        set(&mut drift.warmth_damping, values.warmth_damping);
        set(&mut drift.warmth_time_s, values.warmth_time_s);
        set(&mut drift.warmth_spread, values.warmth_spread);
        set(&mut drift.damping_time_ratio, values.damping_time_ratio);
        set(&mut plate.end_drop, values.end_drop);
        set(&mut plate.end_tilt, values.end_tilt);
        if let Some(off_hz) = values.second_mode_off_hz {
            let side = if is_above { 1.0 } else { -1.0 };
            plate.second_mode.resonance_hz = plate.resonance_hz + side * off_hz;
        }
        set(
            &mut plate.second_mode.half_waves,
            values.second_mode_half_waves,
        );
        set(
            &mut plate.second_mode.modal_mass_kg,
            values.second_mode_mass_kg,
        );
        if values.lateral_resonance_hz.is_some() {
            sensor.lateral_resonance_hz = values.lateral_resonance_hz;
        }
        set(&mut sensor.lateral_lag_s, values.lateral_lag_s);
    }
}
