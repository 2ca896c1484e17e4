//! Rows of the tables of instances, estimates and samples.

use std::sync::Arc;

use analysis::estimate::{InstanceAnalysis, InstanceEstimate, Method, PlateOffset};
use analysis::findings::RecordingFindings;
use analysis::instance::PreparedInstance;
use analysis::recording_series::EstimateSeries;
use analysis::within_laws::WithinLaws;
use analysis::{AveragedModels, RecordingSeries};
use contact::uncertain::Uncertain;
use estimation::ModelledSeries;
use estimation::trial::SharedFit;

use crate::column::Columns;
use crate::trial_entry::{TrialEntry, TrialRow};

/// Instance with its estimate by one method, if that method has one.
pub(crate) struct InstanceRow<'a> {
    entry: &'a TrialEntry<'a>,
    /// Number of the instance in its recording, from 1.
    pub(crate) number: i64,
    pub(crate) instance: &'a InstanceAnalysis,
    pub(crate) method: Method,
    estimate: Option<&'a InstanceEstimate>,
}

impl TrialRow for InstanceRow<'_> {
    fn entry(&self) -> &TrialEntry<'_> {
        self.entry
    }
}

/// Sample of an instance.
pub(crate) struct SampleRow<'a> {
    pub(crate) row: &'a InstanceRow<'a>,
    pub(crate) samples: &'a PreparedInstance,
    pub(crate) estimate: &'a EstimateSeries,
    /// Model with the participant's average σ_t; `None` if it allows no such contact.
    averaged: Option<&'a ModelledSeries>,
    pub(crate) index: usize,
}

impl SampleRow<'_> {
    /// Returns whether there is a model with the participant's average σ_t.
    pub(crate) fn has_average(&self) -> bool {
        self.averaged.is_some()
    }

    /// Returns a value of the model with the participant's average σ_t; NaN if it allows no such contact.
    pub(crate) fn averaged(&self, value: impl Fn(&ModelledSeries) -> f64) -> f64 {
        self.averaged.map_or(f64::NAN, value)
    }
}

impl TrialRow for SampleRow<'_> {
    fn entry(&self) -> &TrialEntry<'_> {
        self.row.entry
    }
}

/// Row that belongs to an instance.
pub(crate) trait OfInstance: TrialRow {
    fn instance_row(&self) -> &InstanceRow<'_>;
}

impl OfInstance for InstanceRow<'_> {
    fn instance_row(&self) -> &InstanceRow<'_> {
        self
    }
}

impl OfInstance for SampleRow<'_> {
    fn instance_row(&self) -> &InstanceRow<'_> {
        self.row
    }
}

/// Returns a row for each instance, with its estimate by `method`.
pub(crate) fn by_method<'a>(entries: &'a [TrialEntry<'a>], method: Method) -> Vec<InstanceRow<'a>> {
    let rows = entries.iter().flat_map(|entry| entry.rows(method));
    rows.collect()
}

/// Returns a row for each instance and method that estimates it.
pub(crate) fn by_all_methods<'a>(entries: &'a [TrialEntry<'a>]) -> Vec<InstanceRow<'a>> {
    let rows = entries
        .iter()
        .flat_map(|entry| instances(entry, &Method::ALL));
    rows.filter(|row| row.estimate.is_some()).collect()
}

impl TrialEntry<'_> {
    /// Returns a row for each instance, with its estimate by `method`.
    pub(crate) fn rows(&self, method: Method) -> Vec<InstanceRow<'_>> {
        instances(self, &[method])
    }
}

fn instances<'a>(entry: &'a TrialEntry<'a>, methods: &[Method]) -> Vec<InstanceRow<'a>> {
    let numbered = entry.findings.instances.iter().zip(1..);
    let rows = numbered.flat_map(|(instance, number)| {
        methods.iter().map(move |&method| InstanceRow {
            entry,
            number,
            instance,
            method,
            estimate: instance.estimate(method),
        })
    });
    rows.collect()
}

/// Returns a row for each sample of these instances of a recording, with its series and its models with the participant's average σ_t.
pub(crate) fn samples<'a>(
    rows: &'a [InstanceRow<'a>],
    series: &'a RecordingSeries,
    models: &'a [AveragedModels],
) -> Vec<SampleRow<'a>> {
    let samples = rows.iter().filter_map(|row| {
        let number = usize::try_from(row.number - 1).ok()?;
        let instance = series.instances.get(number)?;
        let estimate = instance.estimate(row.method)?;
        let models = models.get(number);
        Some((0..row.len()).map(move |index| SampleRow {
            row,
            samples: &instance.samples,
            estimate,
            averaged: models.and_then(|models| models.get(row.method).as_ref()),
            index,
        }))
    });
    samples.flatten().collect()
}

/// Adds the columns that identify an instance within its trial, and the method.
pub(crate) fn instance_columns<R: OfInstance>(columns: &mut Columns<'_, R>, method: &'static str) {
    columns.integer(
        "instance",
        "number of the instance in its recording, from 1",
        |row| row.instance_row().number,
    );
    let names = Method::ALL.map(|method| (method, Arc::<str>::from(method.name())));
    columns.text("method", method, |row| {
        let method = row.instance_row().method;
        let name = names.iter().find(|(candidate, _)| *candidate == method);
        name.map_or_else(|| "".into(), |(_, name)| Arc::clone(name))
    });
    columns.integer(
        "exploration",
        "number of the slide in its recording, from 1",
        |row| row.instance_row().instance.exploration as i64 + 1,
    );
    let directions: [Arc<str>; 2] = ["left_to_right".into(), "right_to_left".into()];
    columns.text(
        "direction",
        "direction of the slide: left_to_right or right_to_left",
        |row| {
            Arc::clone(match row.instance_row().instance.direction {
                protocols::Direction::LeftToRight => &directions[0],
                protocols::Direction::RightToLeft => &directions[1],
            })
        },
    );
}

impl<'a> InstanceRow<'a> {
    /// Returns the findings of its recording.
    pub(crate) fn findings(&self) -> &'a RecordingFindings {
        self.entry.findings
    }

    /// Returns a value of the estimate; NaN without one.
    pub(crate) fn estimated(&self, value: impl Fn(&InstanceEstimate) -> f64) -> f64 {
        self.estimate.map_or(f64::NAN, value)
    }

    pub(crate) fn estimate(&self) -> Option<&'a InstanceEstimate> {
        self.estimate
    }

    /// Returns a number of the plate's offset; 0 if none was fitted.
    pub(crate) fn offset(&self, value: impl Fn(&PlateOffset) -> f64) -> f64 {
        self.estimated(|estimate| estimate.plate_offset.as_ref().map_or(0.0, &value))
    }

    /// Returns the fit of the whole recording, for a row by `trial`.
    pub(crate) fn trial(&self) -> Option<&'a SharedFit> {
        let trial = self.entry.findings.trial.as_ref();
        trial.filter(|_| self.method == Method::Trial)
    }

    /// Returns a number of the whole recording's fit by the published laws where these hold, for a row by `trial`.
    pub(crate) fn shared_within_laws(&self, value: impl Fn(&SharedFit) -> f64) -> f64 {
        let fit = self.trial().and(self.entry.findings.fit_within_laws());
        fit.map_or(f64::NAN, value)
    }

    /// Returns a number of the instance's estimates by the published laws where these hold, for a row by `trial`.
    pub(crate) fn within_laws(&self, value: impl Fn(&WithinLaws) -> f64) -> f64 {
        let estimates = self.trial().and(self.instance.within_laws.as_ref());
        estimates.map_or(f64::NAN, value)
    }

    /// Returns a number of the whole recording's fit, or `fallback` for the other methods.
    pub(crate) fn shared(&self, fallback: f64, value: impl Fn(&SharedFit) -> f64) -> f64 {
        self.trial().map_or(fallback, value)
    }

    /// Returns a number of the recording's friction; 0 for the other methods.
    pub(crate) fn friction(&self, value: impl Fn(&SharedFit) -> Option<Uncertain>) -> f64 {
        self.shared(0.0, |shared| {
            value(shared).map_or(f64::NAN, |friction| friction.value)
        })
    }

    /// Returns the signs of misfit: of the instance, or by `trial` of the recording.
    pub(crate) fn misfit(&self) -> Vec<String> {
        let texts = |signs: &[_]| signs.iter().map(ToString::to_string).collect();
        match (self.trial(), self.estimate) {
            (Some(shared), _) => shared.misfit.iter().map(ToString::to_string).collect(),
            (None, Some(estimate)) => texts(&estimate.misfit),
            (None, None) => Vec::new(),
        }
    }

    pub(crate) fn mean_amplitude_ratio(&self) -> f64 {
        self.instance.mean_amplitude_ratio(self.method)
    }

    pub(crate) fn len(&self) -> usize {
        self.instance.samples
    }
}
