//! Self-consistency of the forces and the film of a recording.
//!
//! A finger on the plate changes the plate's impedance, and friction falls with the plate's amplitude. Both are seen on the clock
//! of drive and pickup, and both are in the forces. So a recording states the offset of the forces' clock against the drive's,
//! and its rate, without a further signal:
//!
//! 1. [`contact`]: the impedance in excess of the free plate's follows the normal force. Landing and lift-off, and each
//!    minimum of the amplitude between them, place the forces within a fraction of a modulation period.
//! 2. [`friction`]: within that range, the lateral force is explained best by the amplitude where the clocks agree. Minima one
//!    modulation period away are excluded by the first step.
//!
//! Neither uses a constant of the finger or a scale of a channel: in each bin of amplitude, impedance and lateral force are any
//! line of the normal force.
//!
//! | topic | item |
//! | --- | --- |
//! | offset and rate of a recording | [`align`] |
//! | common rate of several recordings of a clock | [`joint_rate`] |
//! | factors of amplifiers, RMS and peak-to-peak values | [`TellingFactor`] |
//! | columns of forces that are exchanged | [`roles`] |
//! | zero of the lateral force by strokes there and back | [`strokes`] |

mod bins;
pub mod contact;
mod film;
pub mod friction;
mod grid;
mod least;
pub mod roles;
pub mod strokes;
mod telling_factor;

pub use film::{CurvePoint, Estimate, FalseMinimum, Film, ForceSample, Unaligned, joint_rate};
pub use grid::ForceGrid;
pub use telling_factor::{Cause, TellingFactor};

use contact::{ContactSearch, Shift};
use friction::Slides;

/// Clock of the forces against that of drive and pickup.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// Delay of the forces at [`centre_s`](Self::centre_s), s: positive if they come late. The error includes the time by
    /// which friction follows the film, which a recording cannot distinguish from a delay.
    pub delay_s: Estimate,
    /// Standard error of the delay without that time, s: that of a difference between recordings of a bench.
    pub random_std_s: f64,
    /// Excess of the rate of the forces' clock, of its stated times over true ones, relative.
    pub rate: Estimate,
    /// Time at which the delay is stated, s, on the drive's clock.
    pub centre_s: f64,
    /// Time from the first to the last slide, s.
    pub length_s: f64,
    shift: Shift,
}

/// Evidence of an alignment, to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Residual of the contact over the delay.
    pub contact: Vec<CurvePoint>,
    /// Residual of the friction over further delays than the one found.
    pub friction: Vec<CurvePoint>,
    /// Minima of the friction's residual that the contact excludes.
    pub false_minima: Vec<FalseMinimum>,
}

impl Alignment {
    /// Returns the ppm of `t_drive = offset + t_file (1 + ppm 1e-6)`, with its standard error.
    #[must_use]
    pub fn ppm(&self) -> Estimate {
        Estimate {
            value: 1e6 * ((1.0 + self.rate.value).recip() - 1.0),
            std: 1e6 * self.rate.std,
        }
    }

    /// Returns the offset of `t_drive = offset + t_file (1 + ppm 1e-6)`, s, with its standard error, for a rate of `ppm`.
    #[must_use]
    pub fn offset_s(&self, ppm: f64) -> Estimate {
        let file_s = self.centre_s + self.delay_s.value;
        Estimate {
            value: self.centre_s - file_s * (1.0 + 1e-6 * ppm),
            std: self.delay_s.std,
        }
    }
}

/// Finds the delay and rate of the forces' clock against that of drive and pickup.
///
/// # Errors
/// [`Unaligned`], which names the reason why it cannot be told.
pub fn align(film: &Film<'_>, forces: &[ForceSample]) -> Result<Alignment, Unaligned> {
    let grid = ForceGrid::new(forces).ok_or(Unaligned::TooShort)?;
    let search = ContactSearch::new(film, &grid).ok_or(Unaligned::TooShort)?;
    let contact = search.best().ok_or(Unaligned::NoContact)?;
    let slides = Slides::new(film, &grid).ok_or(Unaligned::TooShort)?;
    let fit = slides.fit(&search, &contact)?;
    Ok(Alignment {
        delay_s: fit.delay_s,
        random_std_s: fit.random_std_s,
        rate: fit.rate,
        centre_s: slides.centre_s(),
        length_s: slides.length_s(),
        shift: fit.shift,
    })
}

/// Returns the residuals about an alignment of the same film and forces.
#[must_use]
pub fn curves(film: &Film<'_>, forces: &[ForceSample], alignment: &Alignment) -> Option<Curves> {
    let grid = ForceGrid::new(forces)?;
    let search = ContactSearch::new(film, &grid)?;
    let (friction, minima) = Slides::new(film, &grid)?.curve(alignment.shift);
    let false_minima = minima.into_iter().map(|minimum| FalseMinimum {
        delay_s: minimum.delay_s,
        residual: minimum.residual,
        contact_ratio: search.ratio(minimum.delay_s, alignment.shift),
    });
    let false_minima = false_minima.collect();
    Some(Curves {
        contact: search.curve(alignment.shift.rate),
        friction: about(friction, alignment.shift.delay_s),
        false_minima,
    })
}

/// Returns the residual of the friction over further delays of the forces than the one found, of the same film and forces.
#[must_use]
pub fn friction_curve(
    film: &Film<'_>,
    forces: &[ForceSample],
    alignment: &Alignment,
) -> Vec<CurvePoint> {
    let grid = ForceGrid::new(forces);
    let slides = grid.as_ref().and_then(|grid| Slides::new(film, grid));
    let curve = slides.map_or_else(Vec::new, |slides| slides.curve(alignment.shift).0);
    about(curve, alignment.shift.delay_s)
}

/// Returns the finite points of a curve about a delay.
fn about(curve: Vec<CurvePoint>, delay_s: f64) -> Vec<CurvePoint> {
    let finite = curve.into_iter().filter(|point| point.residual.is_finite());
    let shifted = finite.map(|point| CurvePoint {
        delay_s: point.delay_s - delay_s,
        ..point
    });
    shifted.collect()
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
