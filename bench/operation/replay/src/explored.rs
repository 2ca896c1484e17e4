//! Explorations of a recording so far, which are fitted together.

use analysis::error_budget::ErrorBudget;
use analysis::force_zero::ForceZero;
use analysis::measurements::Measurements;
use analysis::vibration::Vibration;
use live::trial_fit::{FitRequest, SelectedExploration};
use protocols::{SelectionRules, Stretch};
use recording::manifest::Manifest;

use crate::unloaded::Unloaded;

/// Explorations so far: time span, s, and stretches of each.
#[derive(Debug, Default)]
pub(crate) struct Explored(Vec<((f64, f64), Vec<Stretch>)>);

impl Explored {
    /// Adds an exploration.
    pub(crate) fn add(&mut self, span_s: (f64, f64), stretches: Vec<Stretch>) {
        self.0.push((span_s, stretches));
    }

    /// Returns the number of explorations.
    pub(crate) fn count(&self) -> u32 {
        self.0.len() as u32
    }

    /// Removes all explorations.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Returns the request to fit all of them as one trial, from a record that is corrected for the deviation of the pickup and has
    /// its forces against their zero.
    pub(crate) fn request(
        &self,
        (manifest, vibration): (&Manifest, &Vibration),
        unloaded: &Unloaded,
        (record, zero): (Measurements, &ForceZero),
        rules: SelectionRules,
    ) -> FitRequest {
        let spans_s: Vec<(f64, f64)> = self.0.iter().map(|(span_s, _)| *span_s).collect();
        let touch = record.force_under_finger(&spans_s, rules.contact_n);
        let stated = manifest.standard_errors.unwrap_or_default();
        let explorations = self
            .0
            .iter()
            .map(|((start_s, end_s), stretches)| SelectedExploration {
                start_s: *start_s,
                end_s: *end_s,
                stretches: stretches.clone(),
            });
        FitRequest {
            label: match self.count() {
                1 => "exploration 1".to_owned(),
                count => format!("explorations 1 to {count}"),
            },
            carrier_hz: vibration.carrier_hz,
            errors: ErrorBudget::without_assumptions(zero.standard_errors(stated, &touch)),
            pickup: unloaded.pickup,
            plate: unloaded.plate,
            record,
            explorations: explorations.collect(),
            rules,
        }
    }
}
