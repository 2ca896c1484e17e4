//! Priors of the skin and the plate for the fit of a trial.

use statistics::NORMAL_95;

use super::layout::{Law, SharedParameter};
use crate::conditions::{CONTACT_WIDTH_M, ModeAcross};
use contact::uncertain::Uncertain;

/// A log-normal distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogNormal {
    /// Median, in the quantity's own unit.
    pub median: f64,
    /// Standard deviation of the natural logarithm.
    pub ln_std: f64,
}

impl LogNormal {
    /// Returns the distribution with 95 % between two values.
    #[must_use]
    pub fn from_interval_95(low: f64, high: f64) -> Self {
        Self {
            // ln low and ln high lie 1.96 standard deviations on either side of their middle.
            median: (low * high).sqrt(),
            ln_std: (high / low).ln() / (2.0 * NORMAL_95),
        }
    }

    /// Returns the distribution of the natural logarithm.
    fn ln(self) -> Normal {
        Normal {
            mean: self.median.ln(),
            std: self.ln_std,
        }
    }
}

/// A normal distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// Mean, in the quantity's own unit.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
}

/// Priors of a trial's parameters. They are wide: they keep a short trial plausible and leave a full one to its data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialPriors {
    /// Apparent contact area S, m². Default 95 % between 60 and 450 mm².
    pub contact_area_m2: LogNormal,
    /// q0 for the assumed E and ν, rad/m. Default 95 % between 0.5 and 5 × 10⁴.
    pub q0_rad_per_m: LogNormal,
    /// Loss factor η. Default 95 % between 0.1 and 0.6.
    pub loss_factor: LogNormal,
    /// Levitation lag τ, s. Default 95 % between 0.1 and 10 ms.
    pub tau_s: LogNormal,
    /// Exponent ν of the contact area's growth with the normal force. Default 0.3 ± 0.3, which covers 0, Hertz's 2/3 and the
    /// values measured on finger pads in between (Adams et al. 2013).
    pub area_exponent: Normal,
    /// Time over which the film averages the squared amplitude, s. Default 95 % between 0.03 and 0.3 ms, one to ten cycles
    /// of the carrier.
    pub film_mean_s: LogNormal,
    /// Exponent of the levitation lag's growth with the gap. Default 0.25 ± 0.15: the law is unknown (decision 21).
    pub lag_exponent: Normal,
    /// Growth of the logarithm of the amplitude over 30 mm along the plate, relative to the measurement. Default 0 ± 0.015.
    pub amplitude_tilt: Normal,
    /// Increase of the logarithm of the amplitude 30 mm from the centre on both sides. Default −0.01 ± 0.02.
    pub amplitude_bow: Normal,
    /// Standard deviation of the angle by which the finger's part of Z_m is rotated, rad, both for the component common to all
    /// places and for that of each place; their means are 0. Default 0.02: the effect of a second mode a kilohertz away.
    pub finger_angle_std_rad: f64,
    /// Standard deviation of the residual mobility that a second mode adds to the finger's part of Z_m, m/(N·s), for the common
    /// component and for that of each place. Default 0.003: a mode of 20 g a kilohertz away has 0.004.
    pub residual_mobility_std_m_per_n_s: f64,
    /// Standard deviation of the offset of the plate's reactance, N·s/m; its mean is 0. Default 3, thirty hertz for a plate of
    /// 8 g.
    pub plate_reactance_std_n_s_per_m: f64,
    /// Standard deviation of the offset of the plate's damping, N·s/m; its mean is 0. Default 0.5, 7 % of the published
    /// plate's damping.
    pub plate_damping_std_n_s_per_m: f64,
    /// Priors of the laws in doubt.
    pub laws: LawPriors,
}

/// Priors of the laws in doubt. All but the width on a known mode lie about the published law, on both sides of it, also where only
/// one side is physical: a fit of a finger that follows the published laws is then not drawn away from them. The widths follow from
/// measurements where there are any, and otherwise from films that obey Reynolds' equation (docs/laws.md).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawPriors {
    /// Loss factor of film and trapped air less that of the asperities. Default 0 ± 0.3, from Reynolds' equation: a film over a
    /// whole fingertip has a loss factor of 0.06 at a gap of 8 µm and 0.7 at a squeeze number of 9, where it carries half as much
    /// (Langlois 1962, linearised); the asperities have 0.3, and the film of Huloux 2021 none. Strips of 1 mm, with 1.4 at 8 µm, are
    /// outside.
    pub film_loss: Normal,
    /// Share of the film that answers at the carrier as trapped air. Default 0 ± 0.3, from Reynolds' equation: at a gap of 8 µm,
    /// ridges with open grooves have 0.01 of p0 S/x and strips of 1 mm 0.3. A closed film has 1 (Salbu 1964), which one trial shows.
    pub trapped_air: Normal,
    /// Share of the skin's motion that the film follows. Default 0 ± 0.5: by its definition a film between plate and skin has 1,
    /// and the published one 0. Fingertips oscillate on the plate, more in phase with it the less damping they have (Fenton Friesen,
    /// Wiertlewski and Colgate 2016).
    pub relative_motion: Normal,
    /// Exponent of the asperities' average over a cycle. Default 0 ± 0.5: 0 as published, 1 if asperities follow every cycle. Seen
    /// by stroboscope, the contact changes within the cycle, partly out of phase with the plate (Wiertlewski, Fenton Friesen and
    /// Colgate 2016).
    pub cycle_average: Normal,
    /// Change of the plate's reactance with its squared amplitude, N·s/m per µm². Default 0 ± 0.0035: a resonance that falls or
    /// rises by 1 ppm/µm² with a modal mass of 8 g, 2 m_p ω · 10⁻⁶. Piezo ceramics soften with the amplitude (Guyomar, Aurelle
    /// and Eyraud 1997); the size for a plate of glass is an assumption.
    pub softening_n_s_per_m_um2: Normal,
    /// Square of the contact's width over that of the mode's wavelength, where the wavelength is unknown. Default 0 ± 0.18, which
    /// covers a width of 0.6 wavelengths: 13 mm of the published plate.
    pub width_square: Normal,
    /// Width of the contact, m, where the mode's wavelength is known. Default 11 ± 3 mm: on touch screens the contacts of index
    /// fingers are 5 to 17 mm wide, 9.4 mm in the mean and 10.8 mm at a usual tap (Microsoft, "Contact area size").
    pub width_m: Normal,
}

impl LawPriors {
    /// Returns each prior with its name.
    pub fn named(&mut self) -> [(&'static str, &mut Normal); 7] {
        [
            ("film_loss", &mut self.film_loss),
            ("trapped_air", &mut self.trapped_air),
            ("relative_motion", &mut self.relative_motion),
            ("cycle_average", &mut self.cycle_average),
            ("softening_n_s_per_m_um2", &mut self.softening_n_s_per_m_um2),
            ("width_square", &mut self.width_square),
            ("width_m", &mut self.width_m),
        ]
    }

    /// Returns the prior of κ = (w/λ)² on a mode of known wavelength.
    fn width_square_on(&self, mode: ModeAcross) -> Normal {
        let Uncertain { value, std } = mode.width_square(Uncertain {
            value: self.width_m.mean,
            std: self.width_m.std,
        });
        Normal { mean: value, std }
    }
}

impl Default for LawPriors {
    fn default() -> Self {
        let about_0 = |std: f64| Normal { mean: 0.0, std };
        Self {
            film_loss: about_0(0.3),
            trapped_air: about_0(0.3),
            relative_motion: about_0(0.5),
            cycle_average: about_0(0.5),
            softening_n_s_per_m_um2: about_0(3.5e-3),
            width_square: about_0(0.18),
            width_m: Normal {
                mean: CONTACT_WIDTH_M,
                std: 3e-3,
            },
        }
    }
}

impl TrialPriors {
    /// Returns the prior of a shared parameter; the mode across the plate is known if its wavelength is.
    pub(super) fn shared(
        &self,
        parameter: SharedParameter,
        mode_across: Option<ModeAcross>,
    ) -> Normal {
        let about_0 = |std: f64| Normal { mean: 0.0, std };
        match parameter {
            SharedParameter::LnArea => self.contact_area_m2.ln(),
            SharedParameter::LnQ0 => self.q0_rad_per_m.ln(),
            SharedParameter::LnLossFactor => self.loss_factor.ln(),
            SharedParameter::LnTau => self.tau_s.ln(),
            SharedParameter::AreaExponent => self.area_exponent,
            SharedParameter::LnFilmMean => self.film_mean_s.ln(),
            SharedParameter::LagExponent => self.lag_exponent,
            SharedParameter::Course(_) => about_0(1.0),
            SharedParameter::Tilt => self.amplitude_tilt,
            SharedParameter::Bow => self.amplitude_bow,
            SharedParameter::Angle => about_0(self.finger_angle_std_rad),
            SharedParameter::ResidualMobility => about_0(self.residual_mobility_std_m_per_n_s),
            SharedParameter::Law(law) => match law {
                Law::FilmLoss => self.laws.film_loss,
                Law::TrappedAir => self.laws.trapped_air,
                Law::RelativeMotion => self.laws.relative_motion,
                Law::CycleAverage => self.laws.cycle_average,
                Law::Softening => self.laws.softening_n_s_per_m_um2,
                Law::Width => mode_across.map_or(self.laws.width_square, |mode| {
                    self.laws.width_square_on(mode)
                }),
            },
        }
    }

    /// Returns the priors for a plate with a measured amplitude along its length, for which the data are corrected.
    #[must_use]
    pub fn with_mode_shape(self) -> Self {
        let residual_prior = |prior: Normal| Normal {
            mean: 0.0,
            std: prior.std.min(3e-3),
        };
        Self {
            amplitude_tilt: residual_prior(self.amplitude_tilt),
            amplitude_bow: residual_prior(self.amplitude_bow),
            ..self
        }
    }
}

impl Default for TrialPriors {
    fn default() -> Self {
        Self {
            contact_area_m2: LogNormal::from_interval_95(60e-6, 450e-6),
            q0_rad_per_m: LogNormal::from_interval_95(5e3, 5e4),
            loss_factor: LogNormal::from_interval_95(0.1, 0.6),
            tau_s: LogNormal::from_interval_95(1e-4, 1e-2),
            area_exponent: Normal {
                mean: 0.3,
                std: 0.3,
            },
            film_mean_s: LogNormal::from_interval_95(3e-5, 3e-4),
            lag_exponent: Normal {
                mean: 0.25,
                std: 0.15,
            },
            amplitude_tilt: Normal {
                mean: 0.0,
                std: 0.015,
            },
            amplitude_bow: Normal {
                mean: -0.01,
                std: 0.02,
            },
            finger_angle_std_rad: 0.02,
            residual_mobility_std_m_per_n_s: 0.003,
            plate_reactance_std_n_s_per_m: 3.0,
            plate_damping_std_n_s_per_m: 0.5,
            laws: LawPriors::default(),
        }
    }
}
