//! Model fitted by `dynamic` and `trial`: the impedance of one instance with a gap that lags behind its equilibrium.
//!
//! For the measured amplitude |x̃_p| and normal force f_n of each sample, in the order of the code:
//!
//! ```text
//! S_f = S (f_n/f̄)^ν                                           contact area under the load
//! T d(a²)/dt = |x̃_p|² − a²,  then a times r                    amplitude at the film
//! F f_n = p_c S_f e^(−x_eq/σ_t) + (5/4) p0 S_f a²/x_eq²        equilibrium (Huloux 2021, Eqs. 13–17)
//! τ (x/10 µm)^p dx/dt = x_eq − x                               levitation lag
//! k_c = p_c S_f e^(−x/σ_t)/σ_t + 2 · (5/4) p0 S_f a²/x³        stiffness (Eq. 18); the forces need not balance
//! Z_c = (η − i) k_c/ω,  Z_f = Z_t Z_c/(Z_t + Z_c)              contact and finger (Eqs. 7, 9)
//! Z_m = Z_p + Δ + s Z_f/(1 + Y Z_f) + transient                s = L r² e^(iφ), Y = i y_r
//! ```
//!
//! Parameters are ln σ_t, Z_t, τ, Δ, ln S, ln q0, ln η, ν, T, p, ln r, φ and y_r; ln L and ln F are 0 except in the effect of
//! calibration errors. p_c = 0.375 q0 σ_t E/(1 − ν_P²) with Poisson's ratio ν_P. A finger where the mode shape is r times that
//! at the pickup is driven at r ṽ_p, and its force acts on the mode as r f̃_c: hence r². Other modes, of mobility Y at the
//! finger, slow the plate under it: from ṽ_f = ṽ_p − Y f̃_c and f̃_c = Z_f ṽ_f follow f̃_c/ṽ_p = Z_f/(1 + Y Z_f) and
//! ṽ_f/ṽ_p = 1/(1 + Y Z_f). `dynamic` has ν = T = p = ln r = φ = y_r = 0. Within an instance ln σ_t, Z_t, Z_p and φ may be
//! linear in time (`trend.rs`). Other laws than those published have further parameters (`laws.rs`).

mod corrections;
mod force_slopes;
mod gap;
mod gap_slopes;
mod impedance;
mod laws;
mod model;

pub(super) use gap_slopes::GAP_PARAMETERS;
pub(super) use impedance::{Finger, finger_scale, plate_offset};
pub(super) use laws::{Laws, SampleLaws};
pub(super) use model::LaggedModel;
