//! Small effects that are computed at a minimum and held fixed while the parameters are searched: the skin's inertia, and the
//! film's motion by other modes of the plate.

use num_complex::Complex64;

use super::model::LaggedModel;
use crate::transient::Row;
use contact::parameters::PARAMETERS;

impl LaggedModel<'_> {
    /// Computes the impedance due to the skin's inertia, taking the fitted reactance as that of a mass or a spring alone. With
    /// both, it may vary more steeply with frequency (Foster 1924), which the carrier does not show.
    pub(crate) fn follow_transient(&mut self, parameters: &[f64; PARAMETERS]) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let omega = self.carrier_rad_per_s;
        let finger = self.finger(parameters, contact)?;
        let rows: Vec<Row> = (self.lead..self.gap.len())
            .map(|sample| {
                let z = self.impedance_at(&finger, sample);
                // A mass has m_t = Im Z_t/ω. For a spring, k_t/ω² = |Im Z_t|/ω takes its place, as k_c/ω² does for the contact.
                // ∂Z_m/∂Z_f = s/(1 + Y Z_f)² carries the finger's transient over to Z_m.
                Row {
                    contact_fraction: z.z_t / z.z_sum,
                    skin_fraction: z.z_c / z.z_sum,
                    contact_kg: z.k_c / omega.powi(2),
                    skin_kg: z.z_t.im.abs() / omega,
                    finger_factor: z.mobility_factor * z.mobility_factor * z.finger_scale,
                }
            })
            .collect();
        self.transient.follow(&rows);
        Some(())
    }

    /// Computes the film's motion by other modes, which the finger drives: with their residual mobility Y, its velocity is
    /// 1 − Y Z times that at the pickup.
    pub(crate) fn follow_other_modes(&mut self, parameters: &[f64; PARAMETERS]) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let finger = self.finger(parameters, contact)?;
        for sample in 0..self.gap.len() {
            let z = self.impedance_at(&finger, sample);
            // |1 − i y_f Z|² ≈ 1 + 2 y_f Im Z, so ∂ ln a²/∂y_f = 2 Im Z.
            self.loads.slopes[sample].ln_film_by_mobility = 2.0 * z.z_finger.im;
        }
        Some(())
    }

    /// Returns the measured Z_m minus the contribution of the skin's inertia, N·s/m.
    pub(crate) fn z_m_without_inertia(&self) -> Vec<Complex64> {
        let samples = self.z_m.iter().zip(&self.transient.n_s_per_m);
        samples.map(|(z_m, inertia)| z_m - inertia).collect()
    }
}
