//! Identity of an analysed trial: distinct for every two recordings, so that rows grouped by it never mix two of them.

use analysis::Analysis;
use analysis::findings::RecordingFindings;

/// Identity of a trial.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrialKey {
    /// Participant; `None` if unknown.
    pub participant: Option<String>,
    /// Number of the participant's session; 0 if unknown.
    pub session: i64,
    /// Number of the trial; negative for a practice trial. Recordings without participant or trial are numbered in their order.
    pub trial: i64,
    /// Number of the attempt; 0 if unknown.
    pub attempt: i64,
    /// Condition; empty if unknown.
    pub condition: String,
}

impl TrialKey {
    /// Returns the name of the trial within its participant.
    #[must_use]
    pub fn name(&self) -> String {
        if self.session == 0 {
            return format!("recording {}", self.trial);
        }
        let practice = if self.trial < 0 { "practice " } else { "" };
        let attempt = match self.attempt {
            1 => String::new(),
            attempt => format!(", attempt {attempt}"),
        };
        let (session, trial) = (self.session, self.trial.abs());
        format!("session {session}, {practice}trial {trial}{attempt}")
    }
}

/// Returns the readable recordings of an analysis, each with its identity.
pub fn trials(analysed: &Analysis) -> Vec<(TrialKey, &RecordingFindings)> {
    let mut n_unknown = 0;
    let key = |findings: &RecordingFindings| {
        let manifest = &findings.manifest;
        let participant = findings.participant().map(str::to_owned);
        let condition = manifest.trial.as_ref();
        let condition = condition.map_or_else(String::new, |trial| trial.condition.clone());
        match (&manifest.participant, &manifest.trial) {
            (Some(person), Some(trial)) => {
                let number = i64::from(trial.number);
                TrialKey {
                    participant,
                    session: person.session.into(),
                    trial: if trial.practice { -number } else { number },
                    attempt: trial.attempt.into(),
                    condition,
                }
            }
            _ => {
                n_unknown += 1;
                TrialKey {
                    participant,
                    session: 0,
                    trial: n_unknown,
                    attempt: 0,
                    condition,
                }
            }
        }
    };
    let keys: Vec<TrialKey> = analysed.findings().map(key).collect();
    keys.into_iter().zip(analysed.findings()).collect()
}
