//! The protocol: conditions, explorations, verdict rules and limits of repetition.

use super::drive::{Carrier, Condition};
use super::exploration::Exploration;
use super::sections::{RedoLimits, ResonanceDrift, Rest, Selection, Timeouts, Timing, Trials};
use crate::rules::{ForceBand, Quality, SelectionRules, VerdictRules};
use participant_texts::{Language, OwnTexts, Texts};
use participants::AskedOfParticipant;
use serde::Serialize;

/// A validated protocol. The fields are those of the file, see `huloux2021.toml`.
///
/// ```
/// use protocols::{Direction, Protocol, built_in};
///
/// let text = built_in("huloux2021").expect("a built-in protocol");
/// let protocol = Protocol::parse(text, "huloux2021.toml")?;
/// assert_eq!(protocol.planned_trials(), 12);
/// let slider = protocol.exploration.slider(Direction::LeftToRight);
/// assert!((slider.duration_s() - 1.7).abs() < 1e-9);
/// # Ok::<(), protocols::ProtocolError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Protocol {
    /// Short name, used in file names: lower case letters, digits, `-`, `_`.
    pub name: String,
    /// Purpose, for the reader.
    pub description: String,
    /// Source publication; may be empty.
    pub citation: String,
    /// Language of the participant's screen.
    pub language: Language,
    /// The laboratory's own texts, in place of those of the language.
    pub texts: OwnTexts,
    /// Details asked of each participant; none by default.
    pub participant: AskedOfParticipant,
    /// Conditions, at least one, each with its whole drive.
    pub conditions: Vec<Condition>,
    /// Number and order of the trials.
    pub trials: Trials,
    /// Explorations of a trial.
    pub exploration: Exploration,
    /// Durations of the steps of a trial.
    pub timing: Timing,
    /// Band of the normal force asked of the participant.
    pub force: ForceBand,
    /// Breaks between trials.
    pub rest: Rest,
    /// Limits of repetitions because of a verdict.
    pub redo: RedoLimits,
    /// Limits of an instance.
    pub selection: Selection,
    /// Limits of clipped and lost samples.
    pub quality: Quality,
    /// Times after which the session stops waiting.
    pub timeouts: Timeouts,
    /// Handling of the carrier after the plate's resonance has drifted.
    pub resonance_drift: ResonanceDrift,
}

impl Protocol {
    /// Returns the number of trials in a session without repetitions, practice included.
    pub fn planned_trials(&self) -> u32 {
        self.trials.practice + self.trials.per_condition * self.conditions.len() as u32
    }

    /// Returns the largest number of repetitions by verdicts in a session; practice is not repeated.
    ///
    /// ```
    /// use protocols::{Protocol, built_in};
    ///
    /// let text = built_in("huloux2021").expect("a built-in protocol");
    /// let mut protocol = Protocol::parse(text, "huloux2021.toml")?;
    /// assert_eq!(protocol.most_repetitions(), protocol.redo.max_total);
    /// protocol.trials.per_condition = 1;
    /// protocol.conditions.truncate(1);
    /// assert_eq!(protocol.most_repetitions(), protocol.redo.max_per_trial);
    /// # Ok::<(), protocols::ProtocolError>(())
    /// ```
    pub fn most_repetitions(&self) -> u32 {
        let trials = self.planned_trials() - self.trials.practice;
        self.redo
            .max_total
            .min(trials.saturating_mul(self.redo.max_per_trial))
    }

    /// Returns the texts of the participant's screen.
    pub fn texts(&self) -> Texts {
        Texts::in_language(self.language).replaced_by(&self.texts)
    }

    /// Returns whether every condition drives the plate at its resonance, so that the carrier may follow it.
    pub fn follows_resonance(&self) -> bool {
        let mut carriers = self
            .conditions
            .iter()
            .map(|condition| condition.drive.carrier);
        carriers.all(|carrier| carrier == Carrier::PlateResonance)
    }

    /// Returns the selection rules for a plate with its centre at `centre_m`.
    pub fn selection_rules(&self, centre_m: f64) -> SelectionRules {
        SelectionRules {
            centre_m,
            central_m: self.selection.central_m,
            speed_m_per_s: self.exploration.speed_m_per_s,
            speed_tolerance: self.selection.speed_tolerance,
            instance_s: self.selection.instance_s,
            contact_n: self.force.contact_n,
        }
    }

    /// Returns whether the amplitude of a condition rises, so that there are instances; that of an unknown one does.
    pub fn is_modulated(&self, condition: &str) -> bool {
        let named = |candidate: &&Condition| candidate.name == condition;
        let drive = { self.conditions.iter() }
            .find(named)
            .map(|found| found.drive);
        drive.is_none_or(|drive| drive.modulation_index > 0.0)
    }

    /// Returns the rules of this protocol's verdicts on trials under a condition: without a modulation there are no instances, and none
    /// are needed.
    pub fn verdict_rules(&self, condition: &str) -> VerdictRules {
        VerdictRules {
            force: self.force,
            speed_m_per_s: self.exploration.speed_m_per_s,
            speed_tolerance: self.selection.speed_tolerance,
            lift_limit_s: self.selection.instance_s,
            min_instances: match self.is_modulated(condition) {
                true => self.selection.min_instances,
                false => 0,
            },
            quality: self.quality,
        }
    }
}
