//! Protocol files: what is driven, explored, judged and repeated.

mod raw;
mod rules;
#[cfg(test)]
mod tests;

use crate::selection::SelectionRules;
use crate::trial::Direction;
use crate::verdict::VerdictRules;
use serde::{Deserialize, Serialize};
use strict::TomlError;

/// The built-in protocols, name and text: `huloux2021` is the published one, `demo` a short form of it.
pub const BUILT_IN: [(&str, &str); 2] = [
    ("huloux2021", include_str!("../../huloux2021.toml")),
    ("demo", include_str!("../../demo.toml")),
];

/// The text of a built-in protocol, `None` if there is none of that name.
pub fn built_in(name: &str) -> Option<&'static str> {
    BUILT_IN
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, text)| *text)
}

/// Why a text is not a protocol.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProtocolError {
    /// It is not the TOML that a protocol consists of.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A value out of its range or at odds with another.
    #[error("{file}{}: `{key}` = {value} is not allowed; allowed: {allowed}", .line.map(|l| format!(", line {l}")).unwrap_or_default())]
    Value {
        /// The file, as the caller named it.
        file: String,
        /// Where the key stands, from 1.
        line: Option<usize>,
        /// Dotted path of the key.
        key: String,
        /// The value as given, with its unit.
        value: String,
        /// What is allowed.
        allowed: String,
    },
}

/// A validated protocol. The fields are those of the file, see `huloux2021.toml`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Protocol {
    /// Short name, used in file names: lower case letters, digits, `-`, `_`.
    pub name: String,
    /// What it is for.
    pub description: String,
    /// Where it was published; may be empty.
    pub citation: String,
    /// At least one; each carries the whole drive that it means.
    pub conditions: Vec<Condition>,
    /// How many trials, in what order.
    pub trials: Trials,
    /// What the participant does in a trial.
    pub exploration: Exploration,
    /// Durations.
    pub timing: Timing,
    /// What counts as pressing rightly.
    pub force: ForceBand,
    /// Breaks.
    pub rest: Rest,
    /// How often a trial may be repeated because of its verdict.
    pub redo: RedoLimits,
    /// What counts as an instance.
    pub selection: Selection,
    /// What makes a recording too bad to keep.
    pub quality: Quality,
    /// How long the session waits before it gives a trial up.
    pub timeouts: Timeouts,
}

/// What the carrier's frequency is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Carrier {
    /// The plate's resonance as calibrated or configured.
    PlateResonance,
    /// A fixed frequency, Hz.
    Hz(f64),
}

/// An amplitude-modulated drive: A(t) = mean · (1 + index · sin 2πft).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Carrier frequency.
    pub carrier: Carrier,
    /// Peak voltage of the carrier across the actuators, averaged over the modulation, V.
    pub mean_amplitude_v: f64,
    /// Modulation frequency f, Hz.
    pub modulation_hz: f64,
    /// Modulation index, 0 to 1.
    pub modulation_index: f64,
}

impl Drive {
    /// Largest peak voltage that the modulation reaches, V.
    pub fn peak_amplitude_v(&self) -> f64 {
        self.mean_amplitude_v * (1.0 + self.modulation_index)
    }
}

/// A named drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// Name, unique in the protocol.
    pub name: String,
    /// What is driven.
    pub drive: Drive,
}

/// In what order the conditions come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// As listed, over and over.
    Fixed,
    /// Each block of all conditions shuffled by seed and participant.
    Randomised,
    /// Rows of a Williams design, by participant number.
    Counterbalanced,
}

/// How many trials, in what order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trials {
    /// Practice trials before the others.
    pub practice: u32,
    /// Trials of each condition.
    pub per_condition: u32,
    /// Order of the conditions.
    pub order: Order,
    /// Seed of the order, unless the operator gives another.
    pub seed: u64,
}

/// What the participant does in a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exploration {
    /// One exploration each, in this order.
    pub directions: Vec<Direction>,
    /// Left end of the slider's travel, m.
    pub from_m: f64,
    /// Right end of the slider's travel, m.
    pub to_m: f64,
    /// The slider's speed, m/s.
    pub speed_m_per_s: f64,
    /// Whether a sound marks start and end.
    pub cues: bool,
}

impl Exploration {
    /// The slider of an exploration in `direction`.
    pub fn slider(&self, direction: Direction) -> Slider {
        let (from_m, to_m) = match direction {
            Direction::LeftToRight => (self.from_m, self.to_m),
            Direction::RightToLeft => (self.to_m, self.from_m),
        };
        Slider {
            from_m,
            to_m,
            speed_m_per_s: self.speed_m_per_s,
        }
    }
}

/// The moving slider that the finger follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slider {
    /// Where it starts, m.
    pub from_m: f64,
    /// Where it stops, m.
    pub to_m: f64,
    /// Its speed, m/s, positive in either direction.
    pub speed_m_per_s: f64,
}

impl Slider {
    /// How long it moves, s.
    pub fn duration_s(&self) -> f64 {
        (self.to_m - self.from_m).abs() / self.speed_m_per_s
    }

    /// Where it is `elapsed_s` after it started, m; it rests at its ends before and after.
    pub fn position_m(&self, elapsed_s: f64) -> f64 {
        let part = (elapsed_s / self.duration_s()).clamp(0.0, 1.0);
        (1.0 - part) * self.from_m + part * self.to_m
    }
}

/// Durations, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// From drive on to the start of the baseline at the earliest.
    pub settle_s: f64,
    /// Length of the baseline without finger.
    pub baseline_s: f64,
    /// Countdown before the slider moves.
    pub countdown_s: f64,
    /// How long the mean force is shown.
    pub feedback_s: f64,
    /// How long the operator may overrule a verdict.
    pub verdict_s: f64,
}

/// Normal forces, N.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForceBand {
    /// Least mean normal force of an exploration.
    pub min_n: f64,
    /// Greatest mean normal force of an exploration.
    pub max_n: f64,
    /// At and above it the finger is on the plate; below half of it, off.
    pub contact_n: f64,
}

/// Breaks between trials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// A break after this many trials, practice not counted; 0 for none.
    pub every_trials: u32,
    /// The participant's button ends it after this time, s; the operator at any time.
    pub min_s: f64,
}

/// How often verdicts may repeat a trial. Interruptions (pause, safety, timeouts) do not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RedoLimits {
    /// Repetitions of one trial.
    pub max_per_trial: u32,
    /// Repetitions in the session.
    pub max_total: u32,
}

/// What counts as an instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Selection {
    /// Length about the plate's centre that is kept, m.
    pub central_m: f64,
    /// Allowed deviation from the slider's speed, as a part of it.
    pub speed_tolerance: f64,
    /// Length of an instance, s.
    pub instance_s: f64,
    /// Instances that a trial needs.
    pub min_instances: u32,
}

/// What makes a recording too bad to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// Clipped input frames allowed in a trial.
    pub max_clipped_frames: u64,
    /// Lost input frames allowed in a trial.
    pub max_lost_frames: u64,
    /// Input and output xruns allowed in a trial, together.
    pub max_xruns: u64,
}

/// How long the session waits, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timeouts {
    /// For the finger to leave the plate.
    pub lift_finger_s: f64,
    /// For the finger on the plate and the ready button.
    pub place_finger_s: f64,
    /// For the analysis of a finished trial.
    pub analysis_s: f64,
}

impl Protocol {
    /// Reads and validates a protocol; `file` is only used to name it in errors.
    ///
    /// # Errors
    /// [`ProtocolError`], which names the key, its line, the value and what is allowed.
    pub fn parse(text: &str, file: &str) -> Result<Self, ProtocolError> {
        let raw: raw::RawProtocol = strict::parse(text, file)?;
        rules::validate(raw).map_err(|broken| ProtocolError::Value {
            file: file.to_owned(),
            line: strict::line_of(text, &broken.key),
            key: broken.key,
            value: broken.value,
            allowed: broken.allowed,
        })
    }

    /// Trials in a session without repetitions, practice included.
    pub fn planned_trials(&self) -> u32 {
        self.trials.practice + self.trials.per_condition * self.conditions.len() as u32
    }

    /// The selection rules on a plate whose centre lies at `centre_m`.
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

    /// The rules of this protocol's verdicts.
    pub fn verdict_rules(&self) -> VerdictRules {
        VerdictRules {
            force: self.force,
            speed_m_per_s: self.exploration.speed_m_per_s,
            speed_tolerance: self.selection.speed_tolerance,
            min_instances: self.selection.min_instances,
            quality: self.quality,
        }
    }
}
