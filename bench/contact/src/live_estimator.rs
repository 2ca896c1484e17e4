//! Gap and friction frame by frame while the finger slides, from the last fit.

use num_complex::Complex64;

use crate::error::{ModelError, positive};
use crate::finger::{FittedFinger, PARAMETERS};
use crate::inversion::Dependent;

/// Slope at the last of five samples, oldest first, least squares of a parabola, per interval: no delay.
const CAUSAL_SLOPE: [f64; FRAMES] = [
    26.0 / 70.0,
    -27.0 / 70.0,
    -40.0 / 70.0,
    -13.0 / 70.0,
    54.0 / 70.0,
];
const FRAMES: usize = 5;

/// One demodulated frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveFrame {
    /// Envelope-corrected Z_m, N·s/m.
    pub z_m_corrected_n_s_per_m: Complex64,
    /// |x̃_p|, peak, m.
    pub amplitude_m: f64,
    /// Measured normal force, N, if there is a sensor: μ/μ0 then refers to it, else to the self-sensed force.
    pub normal_n: Option<f64>,
}

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertain {
    /// The value.
    pub value: f64,
    /// Its standard error; infinite if the parameters' is unknown.
    pub std: f64,
}

/// What one frame says about the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveEstimate {
    /// k_c, N/m.
    pub k_c_n_per_m: Uncertain,
    /// ⟨x_t⟩, m.
    pub gap_m: Uncertain,
    /// μ/μ0; `None` without a force sensor until five frames are in.
    pub mu_ratio: Option<Uncertain>,
    /// Self-sensed normal force, N; `None` until five frames are in.
    pub self_sensed_normal_n: Option<Uncertain>,
}

/// Estimates each frame from it and the four before; allocates nothing.
#[derive(Debug, Clone)]
pub struct LiveEstimator {
    finger: FittedFinger,
    interval_s: f64,
    history: [Dependent<PARAMETERS>; FRAMES],
    filled: usize,
}

impl LiveEstimator {
    /// # Errors
    /// If the frame interval is not positive.
    pub fn new(finger: FittedFinger, interval_s: f64) -> Result<Self, ModelError> {
        Ok(Self {
            finger,
            interval_s: positive("frame interval", "s", interval_s)?,
            history: [Dependent::unknown(); FRAMES],
            filled: 0,
        })
    }

    /// From now on with the parameters of a newer fit.
    pub fn refit(&mut self, finger: FittedFinger) {
        self.finger = finger;
        self.reset();
    }

    /// Forgets earlier frames: call it when frames were lost or the finger was lifted.
    pub fn reset(&mut self) {
        self.filled = 0;
    }

    /// Takes the next frame.
    ///
    /// # Errors
    /// If the frame has no gap; earlier frames are then forgotten.
    pub fn update(&mut self, frame: &LiveFrame) -> Result<LiveEstimate, ModelError> {
        let reading = match self
            .finger
            .read(frame.z_m_corrected_n_s_per_m, frame.amplitude_m)
        {
            Ok(reading) => reading,
            Err(error) => {
                self.reset();
                return Err(error);
            }
        };
        self.history.rotate_left(1);
        self.history[FRAMES - 1] = reading.gap;
        self.filled = (self.filled + 1).min(FRAMES);

        let force = (self.filled == FRAMES).then(|| {
            self.finger.normal_force(
                &self.history,
                &CAUSAL_SLOPE,
                self.interval_s,
                FRAMES - 1,
                frame.amplitude_m,
            )
        });
        let ratio = match frame.normal_n {
            Some(normal_n) => {
                positive("normal force", "N", normal_n)?;
                Some(self.finger.inversion.friction_ratio(&reading.gap, normal_n))
            }
            None => force.map(|force| self.ratio_of(&reading.gap, &force)),
        };
        let uncertain = |quantity: Dependent<PARAMETERS>| Uncertain {
            value: quantity.value,
            std: self.finger.inversion.std(&quantity),
        };
        Ok(LiveEstimate {
            k_c_n_per_m: uncertain(reading.k_c),
            gap_m: uncertain(reading.gap),
            mu_ratio: ratio.map(uncertain),
            self_sensed_normal_n: force.map(uncertain),
        })
    }

    /// μ/μ0 where the normal force is itself an estimate.
    fn ratio_of(
        &self,
        gap: &Dependent<PARAMETERS>,
        force: &Dependent<PARAMETERS>,
    ) -> Dependent<PARAMETERS> {
        let ratio = self.finger.inversion.friction_ratio(gap, force.value);
        let share = ratio.value / force.value;
        Dependent {
            value: ratio.value,
            slopes: ratio.slopes - force.slopes * share,
            noise: ratio.noise.hypot(share * force.noise),
        }
    }
}
