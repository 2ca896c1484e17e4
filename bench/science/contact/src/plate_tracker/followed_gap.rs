use super::sample::FingerLoad;
use crate::finger::FittedFinger;

/// Time after which the gap no longer depends on its initial value, s: some ten τ.
const SETTLED_S: f64 = 0.02;
/// Largest interval between consecutive samples, s.
const LONGEST_STEP_S: f64 = 0.01;

/// Gap computed from a finger's parameters, the amplitude and the measured force, with the levitation lag.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FollowedGap {
    now: Option<Followed>,
}

#[derive(Debug, Clone, Copy)]
struct Followed {
    since_s: f64,
    time_s: f64,
    equilibrium_m: f64,
    gap_m: f64,
}

impl FollowedGap {
    /// Advances the gap to the next sample; returns it once it no longer depends on its initial value. Restarts where the
    /// model has no gap.
    pub(super) fn follow(
        &mut self,
        time_s: f64,
        finger: &FittedFinger,
        load: &FingerLoad,
    ) -> Option<f64> {
        let previous = self.now.take();
        let equilibrium_m = finger
            .contact()
            .equilibrium_gap_m(load.amplitude_m, load.normal_n)
            .ok()?;
        let start = Followed {
            since_s: time_s,
            time_s,
            equilibrium_m,
            gap_m: equilibrium_m,
        };
        let now = match previous {
            Some(previous) if (0.0..LONGEST_STEP_S).contains(&(time_s - previous.time_s)) => {
                Followed {
                    since_s: previous.since_s,
                    gap_m: previous.gap_at(time_s, equilibrium_m, finger.tau_s()),
                    ..start
                }
            }
            _ => start,
        };
        self.now = Some(now);
        (now.gap_m > 0.0 && time_s - now.since_s >= SETTLED_S).then_some(now.gap_m)
    }
}

impl Followed {
    /// Solves τ dx/dt = x_eq − x for an equilibrium that moves linearly to `equilibrium_m`.
    fn gap_at(&self, time_s: f64, equilibrium_m: f64, tau_s: f64) -> f64 {
        let step_s = time_s - self.time_s;
        if !(tau_s > 0.0 && step_s > 0.0) {
            return equilibrium_m;
        }
        // x_eq(t) = x_eq⁰ + b t over the step h: x(t) = x_eq(t) − τ b + (x⁰ − x_eq⁰ + τ b) e^(−t/τ), exactly.
        let behind_m = tau_s * (equilibrium_m - self.equilibrium_m) / step_s;
        let forgotten = (self.gap_m - self.equilibrium_m + behind_m) * (-step_s / tau_s).exp();
        equilibrium_m - behind_m + forgotten
    }
}
