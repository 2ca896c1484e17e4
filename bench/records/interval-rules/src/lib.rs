//! Rules that find unloaded stretches and explorations in a recording without marks.
//!
//! - [`Rule::parse`] reads `normal < 0.05 N for 0.3 s` or `40 to 60 mm/s for 0.5 s`; a [`RuleError`] names the word that is wrong.
//! - [`Rule::spans`] finds the stretches of a [`Series`] in which the rule holds, each with its reason.
//! - [`Rule::explorations`] adds the direction, by the sign of the velocity.
//! - [`velocity`] is the velocity of a series of positions.
//!
//! ```
//! use interval_rules::{Rule, Series, velocity};
//!
//! // A finger that rests for a second, slides by 50 mm in one, and rests.
//! let time_s: Vec<f64> = (0..3000).map(|n| 1e-3 * f64::from(n)).collect();
//! let position_m: Vec<f64> = time_s.iter().map(|t| 0.05 * (t - 1.0).clamp(0.0, 1.0)).collect();
//! let velocity_m_per_s = velocity(&Series { time_s: &time_s, values: &position_m });
//! let velocity = Series { time_s: &time_s, values: &velocity_m_per_s };
//! let rule = Rule::parse("40 to 60 mm/s for 0.5 s")?;
//! let slides = rule.explorations(&velocity, &velocity);
//! assert_eq!(slides.len(), 1);
//! assert!((slides[0].span.from_s - 1.0).abs() < 0.02 && (slides[0].span.to_s - 2.0).abs() < 0.02);
//! # Ok::<(), interval_rules::RuleError>(())
//! ```
//!
//! # Noise and gaps
//! A running median of three samples removes single stray ones (Tukey 1977), and a low-pass filter noise: first-order sections,
//! two forwards and two backwards in time, with −3 dB at 20 Hz; it neither delays nor overshoots (critically damped: Robertson
//! and Dowling 2003, Journal of Electromyography and Kinesiology 13). Samples that are not numbers, or not later than the one
//! before, are skipped. A gap of more than 50 ms, or three sampling intervals of a slow series, ends a span.
//!
//! No input or output, no threads: `clippy.toml` next to this crate's `Cargo.toml` disallows them.

mod error;
mod quantity;
mod rule;
mod series;
mod spans;

pub use error::RuleError;
pub use quantity::Quantity;
pub use rule::{Condition, Rule};
pub use series::{Series, velocity};
pub use spans::{DirectedSpan, Span};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
