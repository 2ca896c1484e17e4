//! Impedance of each sample at its lagged gap, and its derivatives.

use nalgebra::DMatrix;
use num_complex::Complex64;

use super::force_slopes::ForceSlopes;
use super::gap_slopes::GAP_PARAMETERS;
use super::law_choice::Laws;
use super::laws::{DoubtfulFinger, WideContact};
use super::model::LaggedModel;
use crate::least_squares::ImpedanceModel;
use contact::parameters::{
    AREA_EXPONENT, FILM_LOSS, FINGER_ANGLE, FINGER_SLOPES, IM_OFFSET, IM_Z_T, LN_FINGER,
    LN_LOSS_FACTOR, LN_RATIO, PARAMETERS, RE_OFFSET, RE_Z_T, RESIDUAL_MOBILITY, SOFTENING,
    TRAPPED_SHARE, WIDTH_SQUARE,
};
use contact::{Contact, StiffnessParts};

/// Finger of given parameters, before trends and loads act on it.
pub(crate) struct Finger {
    contact: Contact,
    /// Z_c/k_c, s.
    z_c_per_stiffness: Complex64,
    z_t: Complex64,
    z_p_offset: Complex64,
    finger_scale: Complex64,
    residual_mobility: Complex64,
    /// `None` with the laws as published.
    doubtful: Option<DoubtfulFinger>,
    softening: f64,
}

/// Finger at a sample: Eqs. 9 to 11 and the effect of other modes of the plate.
pub(super) struct SampleImpedance {
    contact: Contact,
    /// Contact stiffness, N/m.
    pub(super) k_c: f64,
    z_p: Complex64,
    pub(super) z_t: Complex64,
    pub(super) z_c: Complex64,
    pub(super) z_sum: Complex64,
    /// Z_t Z_c/(Z_t + Z_c), for a contact without width.
    pub(super) z_finger: Complex64,
    /// Factor that the other modes apply to `z_finger`.
    pub(super) mobility_factor: Complex64,
    pub(super) finger_scale: Complex64,
    /// Contact of finite width and its stiffness; `None` with the laws as published.
    wide: Option<(WideContact, StiffnessParts)>,
}

impl SampleImpedance {
    fn finger(&self) -> Complex64 {
        self.z_finger * self.mobility_factor * self.finger_scale
    }
}

/// Returns the offset of the plate's impedance, N·s/m.
pub(crate) fn plate_offset(parameters: &[f64; PARAMETERS]) -> Complex64 {
    Complex64::new(parameters[RE_OFFSET], parameters[IM_OFFSET])
}

/// Returns the ratio of the measured to the true finger part of Z_m.
pub(crate) fn finger_scale(parameters: &[f64; PARAMETERS]) -> Complex64 {
    let ln_scale = 2.0 * parameters[LN_RATIO] + parameters[LN_FINGER];
    Complex64::from_polar(ln_scale.exp(), parameters[FINGER_ANGLE])
}

impl LaggedModel<'_> {
    /// Returns the finger of given parameters; `None` outside the domain of the laws in doubt.
    pub(crate) fn finger(
        &self,
        parameters: &[f64; PARAMETERS],
        contact: Contact,
    ) -> Option<Finger> {
        let doubtful = match self.laws {
            Laws::Published => None,
            Laws::InDoubt => Some(DoubtfulFinger::new(parameters, self.carrier_rad_per_s)?),
        };
        Some(Finger {
            contact,
            z_c_per_stiffness: contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s),
            z_t: Complex64::new(parameters[RE_Z_T], parameters[IM_Z_T]),
            z_p_offset: plate_offset(parameters),
            finger_scale: finger_scale(parameters),
            residual_mobility: Complex64::I * parameters[RESIDUAL_MOBILITY],
            doubtful,
            softening: parameters[SOFTENING],
        })
    }

    /// Returns the finger at a sample.
    pub(super) fn impedance_at(&self, finger: &Finger, sample: usize) -> SampleImpedance {
        let contact = self.contact_at(&finger.contact, sample);
        let (gap, amplitude) = (self.gap[sample], self.loads.amplitude_m[sample]);
        let z_t = self.trend.z_t(finger.z_t, sample);
        let mut z_p = self.trend.z_p(self.z_p + finger.z_p_offset, sample);
        let wide = finger.doubtful.map(|doubtful| {
            z_p += self.softening_slope(sample) * finger.softening;
            let parts = contact.stiffness_parts_n_per_m(gap, amplitude);
            (doubtful.contact(&parts, z_t), parts)
        });
        let k_c = contact.stiffness_n_per_m(gap, amplitude);
        let z_c = match &wide {
            None => finger.z_c_per_stiffness * k_c,
            Some((wide, _)) => wide.z_c(),
        };
        let z_sum = z_t + z_c;
        let z_finger = match &wide {
            None => z_t * z_c / z_sum,
            Some((wide, _)) => wide.z_finger,
        };
        SampleImpedance {
            contact,
            k_c,
            z_p,
            z_t,
            z_c,
            z_sum,
            z_finger,
            mobility_factor: (1.0 + finger.residual_mobility * z_finger).inv(),
            finger_scale: self.trend.finger_scale(finger.finger_scale, sample),
            wide,
        }
    }

    /// Returns the finger's part of Z_m at a sample with another Z_t than the finger's, on a plate without other modes.
    pub(crate) fn finger_with_tissue(
        &self,
        finger: &Finger,
        z_t: Complex64,
        sample: usize,
    ) -> Complex64 {
        match &finger.doubtful {
            None => {
                let z_c = self.contact_impedance(finger, sample);
                z_t * z_c / (z_t + z_c)
            }
            Some(doubtful) => {
                let parts = self.stiffness_parts(finger, sample);
                doubtful.contact(&parts, z_t).z_finger
            }
        }
    }

    /// Returns 1/Z_t for a finger's part of Z_m at a sample, on a plate without other modes.
    pub(crate) fn tissue_mobility(
        &self,
        finger: &Finger,
        z_finger: Complex64,
        sample: usize,
    ) -> Complex64 {
        match &finger.doubtful {
            None => z_finger.inv() - self.contact_impedance(finger, sample).inv(),
            Some(doubtful) => {
                doubtful.tissue_mobility(&self.stiffness_parts(finger, sample), z_finger)
            }
        }
    }

    fn contact_impedance(&self, finger: &Finger, sample: usize) -> Complex64 {
        let contact = self.contact_at(&finger.contact, sample);
        let stiffness = contact.stiffness_n_per_m(self.gap[sample], self.loads.amplitude_m[sample]);
        contact.impedance_n_s_per_m(stiffness, self.carrier_rad_per_s)
    }

    fn stiffness_parts(&self, finger: &Finger, sample: usize) -> StiffnessParts {
        let contact = self.contact_at(&finger.contact, sample);
        contact.stiffness_parts_n_per_m(self.gap[sample], self.loads.amplitude_m[sample])
    }

    /// Writes Z_m at each sample, like [`evaluate`](ImpedanceModel::evaluate) but without slopes.
    pub(crate) fn impedances(
        &mut self,
        parameters: &[f64; PARAMETERS],
        z_m: &mut [Complex64],
    ) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let finger = self.finger(parameters, contact)?;
        for (index, z_m) in z_m.iter_mut().enumerate() {
            let z = self.impedance_at(&finger, self.lead + index);
            *z_m = z.z_p + z.finger() + self.transient.n_s_per_m[index];
        }
        Some(())
    }

    /// Returns the derivative of Z_m at each sample of the instance, real parts first, by the logarithm of the normal force at
    /// each sample, lead-in included, after [`evaluate`](ImpedanceModel::evaluate).
    pub(crate) fn response_to_force(&self) -> DMatrix<f64> {
        let (samples, total) = (self.z_m.len(), self.gap.len());
        // x_eq depends on f_n/S_f alone, and S_f goes with f_n^ν: ∂x_eq/∂ ln f_n = (ν − 1) ∂x_eq/∂ ln S at the same sample. The
        // lag spreads it over the neighbours and all later samples. k_c at a fixed gap goes with S_f:
        // ∂Z_m(t)/∂ ln f_n(t′) = (∂Z_m/∂x)(t) ∂x(t)/∂ ln f_n(t′) + δ(t, t′) ν ∂Z_m/∂ ln S.
        let area_slope = self.area_exponent - 1.0;
        let mut response = DMatrix::zeros(2 * samples, total);
        let (mut impulse, mut gap) = (vec![[0.0]; total], vec![[0.0]; total]);
        for sample in 0..total {
            self.gap_slopes
                .respond_to_area(sample, area_slope, &mut impulse, &mut gap);
            for (index, slopes) in self.force_slopes.iter().enumerate() {
                let [gap] = gap[self.lead + index];
                let mut by_force = slopes.by_gap * gap;
                if self.lead + index == sample {
                    by_force += slopes.by_ln_area * self.area_exponent;
                }
                response[(index, sample)] = by_force.re;
                response[(samples + index, sample)] = by_force.im;
            }
        }
        response
    }

    /// Writes the slopes of Z_m at a sample by the parameters that act through the gap, and keeps those by gap and area.
    ///
    /// A parameter of contact or load acts on k_c at a fixed gap and through the lagged gap, with Z_c = (η − i) k_c/ω:
    ///
    /// ```text
    /// dk_c/dθ = ∂k_c/∂θ + (∂k_c/∂x) ∂x/∂θ,   ∂Z_c/∂k_c = (η − i)/ω
    /// ```
    fn differentiate_contact(
        &mut self,
        sample: usize,
        z: &SampleImpedance,
        by_stiffness: Complex64,
        slope: &mut [Complex64; PARAMETERS],
    ) {
        let (gap, amplitude) = (self.gap[sample], self.loads.amplitude_m[sample]);
        let by_gap = z.contact.stiffness_slope_n_per_m2(gap, amplitude);
        let fixed_gap_slopes = z.contact.stiffness_slopes_n_per_m(gap, amplitude);
        self.force_slopes[sample - self.lead] = ForceSlopes {
            by_gap: by_stiffness * by_gap,
            by_ln_area: by_stiffness * fixed_gap_slopes.by_ln_area,
        };
        for (parameter, gap_slope) in GAP_PARAMETERS.into_iter().zip(self.gap_slopes_m(sample)) {
            let stiffness_slope = fixed_gap_slopes
                .by_parameter(parameter, &self.loads.slopes[sample])
                + by_gap * gap_slope;
            slope[parameter] = by_stiffness * stiffness_slope;
        }
    }

    /// Writes the same slopes where asperities, film and trapped air act on Z_m by different factors `by_part`.
    fn differentiate_parts(
        &mut self,
        sample: usize,
        z: &SampleImpedance,
        by_part: [Complex64; 3],
        slope: &mut [Complex64; PARAMETERS],
    ) {
        let (gap, amplitude) = (self.gap[sample], self.loads.amplitude_m[sample]);
        let part_slopes = z.contact.stiffness_part_slopes(gap, amplitude);
        let parts = || part_slopes.iter().zip(by_part);
        let by_gap: Complex64 = parts().map(|(part, factor)| factor * part.by_gap).sum();
        let load = &self.loads.slopes[sample];
        let at_fixed_gap = |parameter: usize| -> Complex64 {
            parts()
                .map(|(part, factor)| factor * part.by_contact.by_parameter(parameter, load))
                .sum()
        };
        self.force_slopes[sample - self.lead] = ForceSlopes {
            by_gap,
            by_ln_area: parts()
                .map(|(part, factor)| factor * part.by_contact.by_ln_area)
                .sum(),
        };
        for (parameter, gap_slope) in GAP_PARAMETERS.into_iter().zip(self.gap_slopes_m(sample)) {
            slope[parameter] = at_fixed_gap(parameter) + by_gap * gap_slope;
        }
        slope[TRAPPED_SHARE] = at_fixed_gap(TRAPPED_SHARE);
    }
}

impl ImpedanceModel<PARAMETERS> for LaggedModel<'_> {
    fn measurement(&self) -> &[Complex64] {
        self.z_m
    }

    /// White noise of force and velocity becomes noise of their ratio that grows as 1/|ṽ_p|.
    fn noise_shape(&self, index: usize) -> f64 {
        self.amplitude_m[self.lead + index].recip()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64; PARAMETERS],
        z_m: &mut [Complex64],
        slopes: &mut [[Complex64; PARAMETERS]],
    ) -> Option<()> {
        let contact = self.follow(parameters)?;
        self.area_exponent = parameters[AREA_EXPONENT];
        let loss_factor = parameters[LN_LOSS_FACTOR].exp();
        let finger_parameters = self.finger(parameters, contact)?;
        for (index, (z_m, slope)) in z_m.iter_mut().zip(slopes).enumerate() {
            let sample = self.lead + index;
            let z = self.impedance_at(&finger_parameters, sample);
            // From 1/Z_f = 1/Z_t + 1/Z_c: ∂Z_f/∂Z_c = (Z_t/(Z_t + Z_c))², ∂Z_f/∂Z_t = (Z_c/(Z_t + Z_c))². With Y = i y_r,
            // d(s Z_f/(1 + Y Z_f)) = s (dZ_f − Z_f² dY)/(1 + Y Z_f)² + (s Z_f/(1 + Y Z_f)) d ln s.
            // Z_c = (η − i) k_c/ω gives ∂Z_c/∂ ln η = η k_c/ω.
            let by_z_finger = z.mobility_factor * z.mobility_factor * z.finger_scale;
            let finger = z.finger();
            *z_m = z.z_p + finger + self.transient.n_s_per_m[index];
            let by_z_t = match (&finger_parameters.doubtful, &z.wide) {
                (Some(doubtful), Some((wide, parts))) => {
                    let finger_slopes = doubtful.slopes(wide, parts);
                    let by_part = finger_slopes.by_part.map(|factor| factor * by_z_finger);
                    self.differentiate_parts(sample, &z, by_part, slope);
                    slope[LN_LOSS_FACTOR] = finger_slopes.by_ln_loss_factor * by_z_finger;
                    slope[FILM_LOSS] = finger_slopes.by_film_loss * by_z_finger;
                    slope[WIDTH_SQUARE] += finger_slopes.by_width_square * by_z_finger;
                    slope[SOFTENING] = self.softening_slope(sample);
                    finger_slopes.by_z_t * by_z_finger
                }
                _ => {
                    let by_z_c = (z.z_t / z.z_sum).powi(2) * by_z_finger;
                    let by_stiffness = by_z_c * finger_parameters.z_c_per_stiffness;
                    self.differentiate_contact(sample, &z, by_stiffness, slope);
                    slope[LN_LOSS_FACTOR] = by_z_c * (loss_factor * z.k_c / self.carrier_rad_per_s);
                    for parameter in [FILM_LOSS, TRAPPED_SHARE, SOFTENING] {
                        slope[parameter] = Complex64::ZERO;
                    }
                    (z.z_c / z.z_sum).powi(2) * by_z_finger
                }
            };
            slope[LN_RATIO] += finger * FINGER_SLOPES[LN_RATIO];
            for parameter in [FINGER_ANGLE, LN_FINGER] {
                slope[parameter] = finger * FINGER_SLOPES[parameter];
            }
            slope[RESIDUAL_MOBILITY] = -Complex64::I * z.z_finger * z.z_finger * by_z_finger;
            slope[RE_Z_T] += by_z_t;
            slope[IM_Z_T] += by_z_t * Complex64::I;
            slope[IM_OFFSET] = Complex64::I;
            slope[RE_OFFSET] = Complex64::ONE;
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::FitConditions;
    use crate::least_squares::tests::assert_slopes_are_derivatives;
    use crate::loads::Loads;
    use crate::series::tests::with_instance;
    use contact::parameters::{
        CYCLE_AVERAGE, FILM_MEAN_MS, FILM_MOBILITY, LAG_EXPONENT, LN_AREA, LN_FORCE,
        RELATIVE_SHARE, TAU_MS,
    };

    /// Compares with the impedance under a force that is larger at one sample.
    #[test]
    fn the_response_to_the_force_is_the_derivative() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let (samples, _) = instance.with_lead_in(0.02).unwrap();
            let force = samples.normal_n.to_vec();
            let impedance = |normal_n: &[f64], exponent: f64| {
                let mut model = LaggedModel::new(instance, &conditions, 0.02, 0.6).unwrap();
                model.normal_n = normal_n;
                model.loads = Loads::new(samples.amplitude_m, normal_n, 0.6);
                let mut parameters = model.assumed_parameters(1.7e-6, 1.2e-3);
                (
                    parameters[RE_Z_T],
                    parameters[IM_Z_T],
                    parameters[AREA_EXPONENT],
                ) = (0.47, 3.16, exponent);
                let n = model.z_m.len();
                let mut z_m = vec![Complex64::ZERO; n];
                let mut slopes = vec![[Complex64::ZERO; PARAMETERS]; n];
                model.evaluate(&parameters, &mut z_m, &mut slopes).unwrap();
                (z_m, model.response_to_force())
            };
            for exponent in [0.0, 0.5] {
                let (_, response) = impedance(&force, exponent);
                for sample in [10, 60, 100] {
                    let step = 1e-5;
                    let impedance_with = |sign: f64| {
                        let mut force = force.clone();
                        force[sample] *= (sign * step).exp();
                        impedance(&force, exponent).0
                    };
                    let (above, below) = (impedance_with(1.0), impedance_with(-1.0));
                    for (index, (above, below)) in above.iter().zip(&below).enumerate() {
                        let slope = (above - below) / (2.0 * step);
                        let n = response.nrows() / 2;
                        let expected = Complex64::new(
                            response[(index, sample)],
                            response[(n + index, sample)],
                        );
                        assert!(
                            (slope - expected).norm() < 1e-5,
                            "{sample} {index}: {slope} {expected}"
                        );
                    }
                }
            }
        });
    }

    #[test]
    fn the_impedance_is_the_same_without_slopes() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model = LaggedModel::new(instance, &conditions, 0.02, 0.6).unwrap();
            let mut parameters = model.assumed_parameters(1.7e-6, 1.2e-3);
            (
                parameters[RE_Z_T],
                parameters[IM_Z_T],
                parameters[AREA_EXPONENT],
            ) = (0.47, 3.16, 0.3);
            (parameters[FINGER_ANGLE], parameters[RESIDUAL_MOBILITY]) = (0.03, 0.02);
            let n = model.z_m.len();
            let mut z_m = vec![Complex64::ZERO; n];
            let mut slopes = vec![[Complex64::ZERO; PARAMETERS]; n];
            model.evaluate(&parameters, &mut z_m, &mut slopes).unwrap();
            let mut z_m_without_slopes = vec![Complex64::ZERO; n];
            model
                .impedances(&parameters, &mut z_m_without_slopes)
                .unwrap();
            assert_eq!(z_m, z_m_without_slopes);
        });
    }

    /// Laws in doubt that are those published give the same impedance and slopes.
    #[test]
    fn the_published_laws_are_among_those_in_doubt() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model = LaggedModel::new(instance, &conditions, 0.02, 0.6).unwrap();
            let mut parameters = model.assumed_parameters(1.7e-6, 1.2e-3);
            (parameters[RE_Z_T], parameters[IM_Z_T]) = (0.47, 3.16);
            (parameters[AREA_EXPONENT], parameters[RESIDUAL_MOBILITY]) = (0.3, 0.02);
            let n = model.z_m.len();
            let [published, doubtful] = [Laws::Published, Laws::InDoubt].map(|laws| {
                model.set_laws(laws);
                let mut z_m = vec![Complex64::ZERO; n];
                let mut slopes = vec![[Complex64::ZERO; PARAMETERS]; n];
                model.evaluate(&parameters, &mut z_m, &mut slopes).unwrap();
                (z_m, slopes)
            });
            for sample in 0..n {
                assert!((published.0[sample] - doubtful.0[sample]).norm() < 1e-13);
                for parameter in 0..FILM_LOSS {
                    let [published, doubtful] =
                        [&published, &doubtful].map(|(_, slopes)| slopes[sample][parameter]);
                    let difference = (published - doubtful).norm();
                    assert!(
                        difference < 1e-10 * (1.0 + published.norm()),
                        "{sample} {parameter}: {published} {doubtful}"
                    );
                }
            }
        });
    }

    #[test]
    fn slopes_are_derivatives() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model = LaggedModel::new(instance, &conditions, 0.02, 0.6).unwrap();
            for (tau_s, area_ratio) in [(-0.2e-3, 1.0), (0.05e-3, 0.6), (1.2e-3, 1.3)] {
                let mut parameters = model.assumed_parameters(1.7e-6, tau_s);
                parameters[RE_Z_T] = 0.47;
                parameters[IM_Z_T] = 3.16;
                parameters[IM_OFFSET] = -0.3;
                parameters[RE_OFFSET] = 0.2;
                parameters[LN_AREA] += f64::ln(area_ratio);
                assert_slopes_are_derivatives(&mut model, parameters);
                parameters[TAU_MS] = parameters[TAU_MS].max(0.3);
                parameters[AREA_EXPONENT] = 0.4;
                parameters[FILM_MEAN_MS] = 0.2;
                parameters[LAG_EXPONENT] = 0.3;
                parameters[LN_RATIO] = -0.04;
                parameters[RESIDUAL_MOBILITY] = 0.02;
                parameters[FINGER_ANGLE] = 0.03;
                (parameters[LN_FINGER], parameters[LN_FORCE]) = (0.02, -0.05);
                model.follow_other_modes(&parameters).unwrap();
                parameters[FILM_MOBILITY] = 0.01;
                assert_slopes_are_derivatives(&mut model, parameters);
                model.follow_finger(&parameters).unwrap();
                model.set_laws(Laws::InDoubt);
                assert_slopes_are_derivatives(&mut model, parameters);
                for (parameter, value) in [
                    (FILM_LOSS, -0.1),
                    (TRAPPED_SHARE, 0.01),
                    (RELATIVE_SHARE, 0.2),
                    (CYCLE_AVERAGE, 0.4),
                    (SOFTENING, 0.003),
                    (WIDTH_SQUARE, 0.15),
                ] {
                    parameters[parameter] = value;
                }
                assert_slopes_are_derivatives(&mut model, parameters);
                model.set_laws(Laws::Published);
            }
        });
    }
}
