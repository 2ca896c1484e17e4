//! Temperature of the plate, estimated from its drive: no sensor measures it.

/// Thermal constants of a plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateHeat {
    /// Force factor γ, N/V.
    pub force_factor_n_per_v: f64,
    /// Angular frequency of the carrier ω, rad/s.
    pub omega_rad_per_s: f64,
    /// Heat capacity, J/K.
    pub capacity_j_per_k: f64,
    /// Heat loss to the room, W/K.
    pub loss_w_per_k: f64,
    /// Temperature of the room, °C.
    pub room_c: f64,
    /// Temperature at which the drive stops, °C.
    pub limit_c: f64,
}

/// Temperature below the limit at which the drive may resume, K.
const COOLER_K: f64 = 2.0;

impl PlateHeat {
    /// Returns the largest mean power that the actuators give to the plate and to the objects that touch it, W: the
    /// force γU times the velocity ωx, as if they were in phase, which they are at resonance.
    #[must_use]
    pub fn power_w(&self, drive_v: f64, amplitude_m: f64) -> f64 {
        let force_n = self.force_factor_n_per_v * drive_v;
        0.5 * force_n * self.omega_rad_per_s * amplitude_m
    }

    /// Returns the rise above the room after `seconds` of `power_w`, from a rise of `rise_k`, K: the exact solution of
    /// C dΔT/dt = P − G ΔT for constant power.
    ///
    /// ```
    /// let plate = safety::PlateHeat {
    ///     force_factor_n_per_v: 0.13,
    ///     omega_rad_per_s: 220e3,
    ///     capacity_j_per_k: 14.0,
    ///     loss_w_per_k: 0.1,
    ///     room_c: 25.0,
    ///     limit_c: 40.0,
    /// };
    /// let rise_k = plate.rise_after(0.0, 1.0, 140.0);
    /// assert!((rise_k - 10.0 * (1.0 - (-1f64).exp())).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn rise_after(&self, rise_k: f64, power_w: f64, seconds: f64) -> f64 {
        let steady_k = power_w / self.loss_w_per_k;
        let decay = (-seconds * self.loss_w_per_k / self.capacity_j_per_k).exp();
        steady_k + (rise_k - steady_k) * decay
    }

    /// Returns the time in which an undriven plate cools from a rise of `rise_k` to 2 K below the limit, s.
    #[must_use]
    pub fn wait_s(&self, rise_k: f64) -> f64 {
        let allowed_k = self.limit_c - COOLER_K - self.room_c;
        let constant_s = self.capacity_j_per_k / self.loss_w_per_k;
        constant_s * (rise_k / allowed_k).ln().max(0.0)
    }

    /// Returns the temperature of a plate that is `rise_k` above the room, °C.
    #[must_use]
    pub fn surface_c(&self, rise_k: f64) -> f64 {
        self.room_c + rise_k
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLATE: PlateHeat = PlateHeat {
        force_factor_n_per_v: 0.13,
        omega_rad_per_s: 219_911.5,
        capacity_j_per_k: 14.0,
        loss_w_per_k: 0.1,
        room_c: 25.0,
        limit_c: 40.0,
    };

    #[test]
    fn the_published_drive_gives_seven_tenths_of_a_watt() {
        // 24 V and 2 µm at resonance: 3.12 N times 0.44 m/s, halved.
        assert!((PLATE.power_w(24.0, 2.02e-6) - 0.693).abs() < 1e-3);
    }

    #[test]
    fn short_steps_and_a_long_one_agree() {
        let mut rise_k = 0.0;
        for _ in 0..50_000 {
            rise_k = PLATE.rise_after(rise_k, 2.0, 0.002);
        }
        assert!((rise_k - PLATE.rise_after(0.0, 2.0, 100.0)).abs() < 1e-6);
    }

    #[test]
    fn after_the_wait_it_is_two_kelvin_below_the_limit() {
        let wait_s = PLATE.wait_s(15.0);
        let rise_k = PLATE.rise_after(15.0, 0.0, wait_s);
        assert!((PLATE.surface_c(rise_k) - 38.0).abs() < 1e-9);
        assert_eq!(PLATE.wait_s(3.0), 0.0);
    }
}
