//! Findings of an analysis, the source of results, tables and figures.

use std::collections::BTreeMap;
use std::path::PathBuf;

use contact::{AssumedConstants, FittedFinger};
use envelope_files::EnvelopeError;
use estimation::FitConditions;
use estimation::trial::SharedFit;
use protocols::{Direction, SelectionRules};

use crate::amplitude_profile::mode_across;
use crate::analysis_settings::Settings;
use crate::error_budget::ErrorBudget;
pub use crate::estimate::{Deltas, InstanceAnalysis, InstanceEstimate, Method};
pub use crate::exploration_findings::ExplorationFindings;
use crate::flaw::Flaw;
use crate::force_clock::ForceClock;
use crate::force_zero::ForceZero;
pub use crate::model_check::Band;
pub use crate::plate_reading::PlateReading;
use crate::recording_series::{RecordingSeries, SampledInstance};
use crate::sample_statistics::{ByMethod, MuAgreement, SampleStatistics};
use crate::unloaded_plate::UnloadedError;
use crate::vibration::Vibration;
use crate::within_laws;
use plausibility::Implausible;
use recording::manifest::{Manifest, ManifestError, RecordedPlate, RecordedRoom};
use recording::pipeline::DemodulationError;
use recording::pipeline::PickupOffset;
use recording::reader::ReadError;
use serde::{Deserialize, Serialize};
use study::provenance::{self, Provenance};

/// All recordings of one analysis.
#[derive(Debug, Default)]
pub struct Analysis {
    /// Assumed numbers.
    pub settings: Settings,
    /// Recordings, in the order given.
    pub recordings: Vec<RecordingAnalysis>,
    /// Agreement of estimated with measured friction over all samples.
    pub agreement: ByMethod<MuAgreement>,
}

impl Analysis {
    /// Returns every estimated instance with its recording.
    pub fn instances(&self) -> impl Iterator<Item = (&RecordingFindings, &InstanceAnalysis)> {
        self.findings().flat_map(|findings| {
            findings
                .instances
                .iter()
                .map(move |instance| (findings, instance))
        })
    }

    pub(crate) fn numbered_findings_mut(
        &mut self,
    ) -> impl Iterator<Item = (usize, &mut RecordingFindings)> {
        let recordings = self.recordings.iter_mut().enumerate();
        recordings.filter_map(|(number, r)| Some((number, r.findings.as_mut().ok()?)))
    }

    /// Returns the account of the concerns about the recordings that could be read.
    #[must_use]
    pub fn provenance(&self) -> provenance::Account {
        let findings = self.findings();
        provenance::Account::new(
            findings.map(|findings| (findings.participant(), &findings.provenance)),
        )
    }

    /// Returns the recordings that could be read.
    pub fn findings(&self) -> impl Iterator<Item = &RecordingFindings> {
        self.numbered_findings().map(|(_, findings)| findings)
    }

    /// Returns the recordings that could be read, each with its number in `recordings`, by which a
    /// [`SeriesSource`](crate::SeriesSource) has its series.
    pub fn numbered_findings(&self) -> impl Iterator<Item = (usize, &RecordingFindings)> {
        let recordings = self.recordings.iter().enumerate();
        recordings.filter_map(|(number, r)| Some((number, r.findings.as_ref().ok()?)))
    }
}

/// Analysis of a recording.
#[derive(Debug)]
pub struct RecordingAnalysis {
    /// Folder, as given.
    pub path: PathBuf,
    /// Participant, as in [`RecordingFindings::participant`], also if the recording cannot be read.
    pub participant: Option<String>,
    /// Findings, or the reason why the recording cannot be read.
    pub findings: Result<RecordingFindings, RecordingError>,
}

/// Reasons why a recording cannot be analysed at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// A file is missing, unreadable or breaks a rule of the format.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The intervals contain more rows than can be analysed.
    #[error("{file}: more than {limit} rows within the intervals, the most that are analysed")]
    TooManyRows {
        /// The file.
        file: &'static str,
        /// Largest number of rows.
        limit: usize,
    },
    /// The audio cannot be demodulated with the stated constants.
    #[error(transparent)]
    Demodulation(#[from] DemodulationError),
    /// The envelopes cannot be read.
    #[error(transparent)]
    Envelopes(#[from] EnvelopeError),
    /// An earlier analysis, of which only the words are left, could not read the recording.
    #[error("{0}")]
    Known(String),
    /// The description does not fit the recording.
    #[error("recording.toml: {0}")]
    Description(#[from] ManifestError),
}

/// Findings in a recording. They are small: its time series are a [`RecordingSeries`].
#[derive(Debug, Serialize, Deserialize)]
pub struct RecordingFindings {
    /// Folder, as given.
    pub path: PathBuf,
    /// Participant: the pseudonym, preceded by the study's name if several studies are analysed.
    pub participant: Option<String>,
    /// Description of the recording.
    pub manifest: Manifest,
    /// Vibration of the plate; `None` if only forces were recorded.
    pub vibration: Option<Vibration>,
    /// Provenance by this description and the session's log.
    pub provenance: Provenance,
    /// Selection rules of the instances.
    pub rules: SelectionRules,
    /// Deviation of the pickup from its stated values, read from the unloaded plate; corrected in all other findings.
    pub pickup: PickupOffset,
    /// Zero of the force sensor, subtracted in all other findings.
    pub zero: ForceZero,
    /// Clock of the forces; `None` if it cannot be told.
    pub force_clock: Option<ForceClock>,
    /// Errors of the constants; those of the forces include the zero's, relative to the mean force of the touch, and the crosstalk
    /// that the recording shows if none is stated.
    pub errors: ErrorBudget,
    /// Impedance of the unloaded plate; `None` if it could not be read.
    pub z_p: Option<PlateReading>,
    /// Explorations.
    pub explorations: Vec<ExplorationFindings>,
    /// Estimated instances, in time order.
    pub instances: Vec<InstanceAnalysis>,
    /// Parameters shared by the instances, fitted together; `None` if the fit failed. Its errors include the laws in doubt.
    pub trial: Option<SharedFit>,
    /// The same with the laws as published taken as true; [`fit_within_laws`](Self::fit_within_laws) returns it where they hold.
    pub within_laws: Option<SharedFit>,
    /// Statistics over the samples of all instances.
    pub sample_statistics: ByMethod<SampleStatistics>,
    /// Self-sensed against measured normal force, by amplitude.
    pub model_check: Vec<Band>,
    /// Stretches without an estimate.
    pub rejected: Vec<RejectedStretch>,
    /// Defects of the recording.
    pub flaws: Vec<Flaw>,
}

impl RecordingFindings {
    /// Returns the participant, if known. Equal pseudonyms in two studies are two people.
    pub fn participant(&self) -> Option<&str> {
        self.participant.as_deref()
    }

    /// Returns whether no estimate can be used until the readings are corrected.
    pub fn is_spoilt(&self) -> bool {
        self.withheld_reason().is_some()
    }

    /// Returns the reason why all estimates are withheld, if a flaw makes them meaningless.
    pub fn withheld_reason(&self) -> Option<String> {
        let found = self.implausible().find(|flaw| flaw.spoils_estimates())?;
        Some(format!("withheld because of a flaw ({})", found.name()))
    }

    /// Returns the implausible readings.
    pub(crate) fn implausible(&self) -> impl Iterator<Item = &Implausible> {
        self.flaws.iter().filter_map(|flaw| match flaw {
            Flaw::Implausible(found) => Some(found),
            _ => None,
        })
    }

    /// Returns whether the analysis has a result: an instance, the plate's impedance of a recording without explorations, or
    /// friction and amplitudes of a recording that lacks a stream or an unloaded interval, and so can have no instance.
    pub fn has_result(&self) -> bool {
        let is_plate_alone = self.flaws.contains(&Flaw::NoExploration) && self.z_p.is_some();
        let is_lack = |flaw: &Flaw| {
            matches!(
                flaw,
                Flaw::Missing(_) | Flaw::Unloaded(UnloadedError::NoInterval)
            )
        };
        let is_partial = self.flaws.iter().any(is_lack)
            && self.explorations.iter().any(|exploration| {
                exploration.stroke.n > 0 || exploration.stroke.amplitude_m.is_finite()
            });
        !self.instances.is_empty() || is_plate_alone || is_partial
    }

    /// Returns the plate's constants; `None` if only forces were recorded.
    pub fn plate(&self) -> Option<&RecordedPlate> {
        self.vibration.as_ref().map(|vibration| &vibration.plate)
    }

    /// Returns the frequency to which impedances refer, Hz; `None` if only forces were recorded.
    pub fn carrier_hz(&self) -> Option<f64> {
        self.vibration
            .as_ref()
            .map(|vibration| vibration.carrier_hz)
    }

    /// Returns the constants of skin and air of a fit: those of the settings, with the ambient pressure of the recording if it
    /// states one.
    fn assumed(&self, settings: &Settings) -> AssumedConstants {
        let room = self.manifest.room;
        let measured_pa = room.map(RecordedRoom::ambient_pressure_pa);
        settings.assumed().with_measured_pressure(measured_pa)
    }

    /// Returns the conditions shared by all fits; `None` if Z_p is not known.
    pub(crate) fn conditions(&self, settings: &Settings) -> Option<FitConditions> {
        let assumed = self.assumed(settings);
        let z_p = self.z_p?;
        let Vibration {
            carrier_hz, plate, ..
        } = self.vibration.as_ref()?;
        let mode_across = plate.across.as_ref().map(mode_across);
        Some(z_p.conditions(assumed, *carrier_hz, &self.errors, mode_across))
    }

    /// Returns the parameters shared by the instances with the laws as published taken as true. `None` if a fit cannot be used, or
    /// if any has signs of misfit: this one, so that these laws do not hold, or that with the laws in doubt.
    #[must_use]
    pub fn fit_within_laws(&self) -> Option<&SharedFit> {
        within_laws::holding(self.trial.as_ref()?, self.within_laws.as_ref())
    }

    /// Returns the finger of the first instance usable by `dynamic`, which the model check extrapolates.
    pub fn first_finger<'a>(&self, series: &'a RecordingSeries) -> Option<&'a FittedFinger> {
        let (_, sampled) = self.first_dynamic_instance(series)?;
        Some(&sampled.finger)
    }

    /// Returns the first instance usable by `dynamic`, with its samples.
    pub(crate) fn first_dynamic_instance<'a>(
        &self,
        series: &'a RecordingSeries,
    ) -> Option<(&InstanceAnalysis, &'a SampledInstance)> {
        let mut instances = self.instances.iter().zip(&series.instances);
        instances.find(|(instance, _)| instance.estimate_by(Method::Dynamic).is_some())
    }
}

/// Stretch of rising amplitude without an estimate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RejectedStretch {
    /// Direction of the exploration.
    pub direction: Direction,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Reason of the rejection.
    pub reason: String,
    /// Kind of the reason, without its numbers.
    pub kind: String,
}

/// Returns the kinds of rejection with their numbers, most frequent first.
pub fn rejection_counts<'a>(kinds: impl IntoIterator<Item = &'a str>) -> Vec<(&'a str, usize)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for kind in kinds {
        *counts.entry(kind).or_default() += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    counts
}
