//! Finger on the plate: film, stiffness and friction, advanced by slow steps.

use super::friction::{Friction, relative_friction};
use super::mechanics::SkinContact;
use super::mode_under_finger::ModeUnderFinger;
use super::squeeze_film::{Laws, SqueezeFilm};
use crate::fingertip::Fingertip;
use crate::person::FingerState;
use crate::scenario::Scenario;

/// Contact during a slow step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touched {
    /// Mean gap, m.
    pub gap_m: f64,
    /// Contact stiffness at that gap, N/m.
    pub k_c_n_per_m: f64,
    /// Spring and damper until the next slow step, evaluated at the middle of that time.
    pub contact: SkinContact,
    /// Friction coefficient without vibration.
    pub mu0: f64,
    /// Friction coefficient of full sliding.
    pub mu: f64,
    /// Lateral force, N.
    pub lateral_n: f64,
    /// Apparent contact area, m².
    pub area_m2: f64,
    /// Time constant of levitation, s.
    pub lag_s: f64,
}

/// The film's state while the finger touches.
#[derive(Debug, Clone, Copy)]
struct FilmContact {
    gap_m: f64,
    target_m: f64,
    normal_n: f64,
    amplitude2_m2: f64,
}

impl FilmContact {
    /// Returns the state extrapolated to the middle of the next step, which lasts `step_per_lag` time constants. A spring held
    /// constant for a step would lag by half a step unless all the quantities that it depends on are extrapolated.
    fn half_a_step_ahead(&self, last: &Self, step_per_lag: f64) -> Self {
        let extrapolate = |now: f64, last: f64| (now + 0.5 * (now - last)).max(0.0);
        let target_m = extrapolate(self.target_m, last.target_m);
        let middle_m = 0.5 * (self.target_m + target_m);
        Self {
            gap_m: middle_m + (self.gap_m - middle_m) * (-0.5 * step_per_lag).exp(),
            target_m,
            normal_n: extrapolate(self.normal_n, last.normal_n),
            amplitude2_m2: extrapolate(self.amplitude2_m2, last.amplitude2_m2),
        }
    }
}

/// Contact state of a finger that touches the plate or not.
#[derive(Debug, Clone)]
pub(super) struct Touch {
    laws: Laws,
    /// Modes across the finger's width; `None` if uniform there.
    mode: Option<ModeUnderFinger>,
    ambient_pressure_pa: f64,
    omega_rad_per_s: f64,
    contact: Option<FilmContact>,
    friction: Friction,
}

impl Touch {
    pub fn new(scenario: &Scenario, fingertip: &Fingertip) -> Self {
        let presliding_m = scenario.film.presliding_m;
        Self {
            laws: Laws::new(&scenario.laws),
            mode: ModeUnderFinger::new(scenario, fingertip.pad.contact_area_m2),
            ambient_pressure_pa: scenario.film.ambient_pressure_pa,
            omega_rad_per_s: scenario.plate.omega_rad_per_s(),
            contact: None,
            friction: Friction::new(&scenario.friction, presliding_m, &fingertip.pad),
        }
    }

    /// Returns Z_t of the skin under a normal force, N·s/m.
    pub fn z_t(&self, skin: &Fingertip, normal_n: f64) -> [f64; 2] {
        let factor = self.laws.tissue_factor(normal_n);
        skin.z_t_n_s_per_m.map(|z| z * factor)
    }

    /// Advances by `dt_s` on a plate with this squared peak amplitude on the mode's crest.
    pub fn press(
        &mut self,
        dt_s: f64,
        skin: &Fingertip,
        finger: &FingerState,
        amplitude2_m2: f64,
    ) -> Touched {
        let (normal_n, pad) = (finger.normal_n, &skin.pad);
        let area_m2 = pad.area_m2(normal_n);
        let moments = self.mode.as_mut().map(|mode| mode.moments(area_m2));
        // The film's force goes with the mean square over the contact.
        let amplitude2_m2 = amplitude2_m2 * moments.map_or(1.0, |moments| moments.second);
        let (laws, pressure_pa) = (&self.laws, self.ambient_pressure_pa);
        let film_on = |area_m2| SqueezeFilm::new(laws, pad, pressure_pa, skin.sigma_t_m, area_m2);
        let film = film_on(area_m2);
        let guess_m = self.contact.map_or(0.0, |c| c.target_m);
        let target_m = film.equilibrium(normal_n, amplitude2_m2, guess_m);
        let gap_m = self.contact.map_or(target_m, |c| {
            let middle = 0.5 * (c.target_m + target_m);
            middle + (c.gap_m - middle) * (-dt_s / film.lag(c.gap_m)).exp()
        });
        let lag_s = film.lag(gap_m);
        let now = FilmContact {
            gap_m,
            target_m,
            normal_n,
            amplitude2_m2,
        };
        let mid_contact =
            now.half_a_step_ahead(&self.contact.replace(now).unwrap_or(now), dt_s / lag_s);
        // An attraction could make the stiffness negative, and the plate's motion unstable.
        let mid_film = film_on(pad.area_m2(mid_contact.normal_n));
        let k_c = mid_film
            .stiffness(mid_contact.gap_m, mid_contact.amplitude2_m2)
            .max(0.0);
        let damping = film.loss_factor(k_c) * k_c / self.omega_rad_per_s;
        let mut contact = SkinContact::point(k_c, damping);
        if let Some(moments) = moments.filter(|_| k_c > 0.0) {
            let without_film = mid_film.stiffness(mid_contact.gap_m, 0.0);
            contact = moments.share(contact, 1.0 - without_film / k_c);
        }
        let velocity = finger.velocity_m_per_s;
        let mu0 = skin.mu0 * self.friction.factor(dt_s, pad, normal_n, velocity);
        let mu = mu0 * relative_friction(pad, film.relative_asperities(gap_m, normal_n));
        Touched {
            gap_m,
            k_c_n_per_m: film.stiffness(gap_m, amplitude2_m2),
            contact,
            mu0,
            mu,
            lateral_n: self.friction.lateral_n(dt_s, mu, normal_n, velocity),
            area_m2,
            lag_s,
        }
    }

    /// Advances by `dt_s` off the plate; returns whether the finger touched before.
    pub fn lift(&mut self, dt_s: f64) -> bool {
        self.friction.lift(dt_s);
        self.contact.take().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The spring held for a step equals the stiffness at its middle, while amplitude, force, area and gap all change.
    #[test]
    fn the_spring_of_a_step_is_that_of_its_middle() {
        const STEP_S: f64 = 1e-4;
        let mut scenario = Scenario::default();
        scenario.film.area_force_exponent = 0.5;
        let skin = Fingertip::draw(&scenario, 3);
        let mut touch = Touch::new(&scenario, &skin);
        let steps: Vec<Touched> = (0..800)
            .map(|step| {
                let turn = std::f64::consts::TAU * f64::from(step) * STEP_S;
                let finger = FingerState {
                    normal_n: 0.6 + 0.1 * (9.0 * turn).sin(),
                    touching: true,
                    ..FingerState::default()
                };
                let amplitude_m = 2e-6 * (1.0 - 0.9 * (6.0 * turn).cos());
                touch.press(STEP_S, &skin, &finger, amplitude_m.powi(2))
            })
            .collect();
        let mut mismatch = 0.0_f64;
        for pair in steps[200..].windows(2) {
            let (now, next) = (pair[0].k_c_n_per_m, pair[1].k_c_n_per_m);
            let difference = pair[0].contact.stiffness_n_per_m - 0.5 * (now + next);
            mismatch = mismatch.max(difference.abs() / steps[200].k_c_n_per_m);
        }
        let change = |pair: &[Touched]| (pair[1].k_c_n_per_m - pair[0].k_c_n_per_m).abs();
        let largest = steps[200..].windows(2).map(change).fold(0.0, f64::max);
        let half_a_step = 0.5 * largest / steps[200].k_c_n_per_m;
        assert!(mismatch < 0.05 * half_a_step, "{mismatch} of {half_a_step}");
    }
}
