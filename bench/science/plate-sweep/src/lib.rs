//! The constants of a plate from a sweep that an impedance analyser or a vibrometer measured elsewhere.
//!
//! | quantity | response of the mode, with A = static response | gives in addition to f0 and Q |
//! | --- | --- | --- |
//! | admittance Y, or impedance 1/Y | charge over voltage, Y/(iω): A = γ²/k_p beside the clamped capacitance C0 | C0 and its loss, the coupling; γ = ω0 √(A m_p) |
//! | displacement over voltage | as it is: A = γ/k_p | γ = ω0² A m_p |
//! | velocity over voltage | over iω | as the displacement |
//!
//! The motional branch of the Butterworth–Van Dyke circuit is that mode: an electrode's current is γ times the velocity where
//! the force is γ times the voltage, so its charge is γ x, and x = γ U/k_p at low frequency. No sweep tells γ and the modal mass
//! apart: one of them must be known ([`ModalScale`]). No sweep of this kind gives the pickup's sensitivity or phase.
//!
//! [`Sweep::read`] takes a table as analysers write it, [`Sweep::new`] arrays; [`SweepFit::new`] finds the resonances, fits the
//! strongest or the one nearest to a frequency with [`metrology::plate_fit`], and names the others. A sweep with phases of the
//! other sign (exp(−iωt)) is recognised by the sense in which its resonances turn: clockwise with growing frequency. It is
//! fitted with its conjugate, and says so.
//!
//! No input or output, no threads: `clippy.toml` in the parent folder disallows them.

mod column_choice;
mod encoding;
mod heading;
mod modal_scale;
mod resonances;
mod sweep;
mod sweep_fault;
mod sweep_fit;
mod sweep_table;
mod sweep_unit;
mod swept_quantity;

pub use column_choice::ColumnChoice;
pub use encoding::text_of;
pub use modal_scale::{ModalScale, SweptConstants};
pub use sweep::Sweep;
pub use sweep_fault::{LEAST_FREQUENCIES, SweepFault};
pub use sweep_fit::{ClampedCapacitance, FurtherMode, SweepFit};
pub use swept_quantity::{SweptQuantity, UnknownQuantity};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
