//! Friction of explorations, of recordings without an instance: those of forces alone, on any surface and under any modulator.

use analysis::Analysis;
use analysis::stroke::Stroke;

use crate::groups::{self, Group, Trial, Unit};
use crate::trial_key;

/// Group of explorations with its means.
pub type StrokeGroup = Group<{ StrokeQuantity::ALL.len() }>;

/// Described quantity of an exploration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StrokeQuantity {
    /// Mean friction.
    Mu,
    /// Contrast of the stimulus.
    Contrast,
    /// Mean normal force, N.
    Force,
    /// Mean speed, m/s.
    Speed,
}

impl StrokeQuantity {
    /// All quantities, in the order of their display.
    pub const ALL: [Self; 4] = [Self::Mu, Self::Contrast, Self::Force, Self::Speed];

    /// Returns its heading for people, with the unit.
    #[must_use]
    pub fn heading(self) -> &'static str {
        match self {
            Self::Mu => "μ",
            Self::Contrast => "contrast (%)",
            Self::Force => "force (N)",
            Self::Speed => "speed (mm/s)",
        }
    }

    /// Returns the factor from the SI unit to the unit of its heading, and the number of decimals for people.
    #[must_use]
    pub fn format(self) -> (f64, usize) {
        match self {
            Self::Mu => (1.0, 3),
            Self::Contrast => (100.0, 1),
            Self::Force => (1.0, 2),
            Self::Speed => (1e3, 1),
        }
    }

    /// Returns its value in an exploration; NaN if it was not measured.
    #[must_use]
    pub fn value(self, stroke: &Stroke) -> f64 {
        match self {
            Self::Mu => stroke.mu,
            Self::Contrast => stroke.effect.map_or(f64::NAN, |effect| effect.contrast),
            Self::Force => stroke.normal_n,
            Self::Speed => stroke.speed_m_per_s,
        }
    }
}

/// Returns the groups of the recordings without an instance that have friction; empty if there are none.
pub(crate) fn groups(analysed: &Analysis) -> Vec<StrokeGroup> {
    let trials = trial_key::trials(analysed).into_iter();
    let trials = trials.filter(|(_, findings)| findings.instances.is_empty());
    let trials = trials.map(|(key, findings)| {
        let strokes = findings
            .explorations
            .iter()
            .map(|exploration| &exploration.stroke);
        let values = strokes
            .filter(|stroke| stroke.mu.is_finite())
            .map(|stroke| StrokeQuantity::ALL.map(|quantity| quantity.value(stroke)));
        let instances = values.collect();
        Trial { key, instances }
    });
    let trials: Vec<Trial<_>> = trials.filter(|trial| !trial.instances.is_empty()).collect();
    match trials.is_empty() {
        true => Vec::new(),
        false => groups::groups(&trials, Unit::Explorations),
    }
}
