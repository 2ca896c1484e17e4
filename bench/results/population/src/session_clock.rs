//! Rate of the forces' clock in a session, common to its recordings: each has an offset of its own, all have one clock.

use std::collections::BTreeMap;
use std::fmt;

use force_alignment::{Estimate, joint_rate};
use serde::Serialize;

use analysis::findings::{Analysis, RecordingFindings};
use analysis::force_clock::ForceClock;

/// Shortest slides together from which a common rate is stated, s.
const SHORTEST_S: f64 = 60.0;
/// Standard errors of a common rate beyond which it is a fault of the recordings.
const CERTAIN_ERRORS: f64 = 4.0;
/// Smallest common rate that is a fault, ppm: clocks of crystals agree within it.
const SMALLEST_PPM: f64 = 100.0;

/// Clock of the forces in a session.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SessionClock {
    /// Participant, as in the recordings.
    pub participant: Option<String>,
    /// Number of the session.
    pub session: u32,
    /// Number of recordings that show the clock.
    pub recordings: usize,
    /// Length of their slides together, s.
    pub length_s: f64,
    /// Excess of the rate of true times over the file's, parts per million.
    pub ppm: f64,
    /// Standard error of it.
    pub ppm_std: f64,
    /// Whether all of these recordings have the rate corrected.
    pub is_corrected: bool,
}

impl SessionClock {
    fn new((participant, session): (Option<&str>, u32), clocks: &[&ForceClock]) -> Option<Self> {
        let length_s = clocks.iter().map(|clock| clock.length_s).sum();
        if clocks.len() < 2 || length_s < SHORTEST_S {
            return None;
        }
        let rate = |clock: &&ForceClock| Estimate {
            value: clock.ppm.value,
            std: clock.ppm.std,
        };
        let rates: Vec<Estimate> = clocks.iter().map(rate).collect();
        let common = joint_rate(&rates)?;
        Some(Self {
            participant: participant.map(str::to_owned),
            session,
            recordings: clocks.len(),
            length_s,
            ppm: common.value,
            ppm_std: common.std,
            is_corrected: clocks.iter().all(|clock| clock.is_rate_corrected),
        })
    }

    /// Returns whether the rate is a fault that is left in the estimates.
    #[must_use]
    pub fn is_fault(&self) -> bool {
        let least_ppm = SMALLEST_PPM.max(CERTAIN_ERRORS * self.ppm_std);
        !self.is_corrected && self.ppm.abs() > least_ppm
    }
}

impl fmt::Display for SessionClock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let participant = self
            .participant
            .as_deref()
            .unwrap_or("without a participant");
        write!(
            f,
            "{participant}, session {}: together, its {} recordings show a clock of the forces that is {:.0} ± {:.0} ppm off: multiply \
             time_s of force.csv and position.csv by {:.6}, and state the true rate of the sensor",
            self.session,
            self.recordings,
            self.ppm,
            statistics::NORMAL_95 * self.ppm_std,
            1.0 + 1e-6 * self.ppm
        )
    }
}

/// Returns the clocks of the sessions that are long enough, in order.
#[must_use]
pub fn session_clocks(analysed: &Analysis) -> Vec<SessionClock> {
    let mut sessions: BTreeMap<(Option<&str>, u32), Vec<&ForceClock>> = BTreeMap::new();
    for findings in analysed.findings() {
        if let Some((session, clock)) = session(findings).zip(findings.force_clock.as_ref()) {
            let key = (findings.participant(), session);
            sessions.entry(key).or_default().push(clock);
        }
    }
    let clocks = sessions.into_iter();
    clocks
        .filter_map(|(key, clocks)| SessionClock::new(key, &clocks))
        .collect()
}

fn session(findings: &RecordingFindings) -> Option<u32> {
    let participant = findings.manifest.participant.as_ref()?;
    Some(participant.session)
}

#[cfg(test)]
mod tests {
    use super::*;
    use analysis::force_clock::Measured;

    fn clock(ppm: f64, std: f64, length_s: f64) -> ForceClock {
        ForceClock {
            at_s: 10.0,
            length_s,
            offset_s: Measured {
                value: 0.0,
                std: 1e-3,
            },
            ppm: Measured { value: ppm, std },
            is_offset_corrected: false,
            is_rate_corrected: false,
            residual: Vec::new(),
        }
    }

    #[test]
    fn recordings_together_show_a_rate_that_none_shows_alone() {
        let rates = [
            (-350.0, 120.0),
            (-270.0, 110.0),
            (-330.0, 130.0),
            (-280.0, 100.0),
        ];
        let clocks = rates.map(|(ppm, std)| clock(ppm, std, 20.0));
        let clocks: Vec<&ForceClock> = clocks.iter().collect();
        let session = SessionClock::new((Some("sub-01"), 2), &clocks).unwrap();
        assert_eq!((session.recordings, session.length_s), (4, 80.0));
        assert!(
            (session.ppm + 305.0).abs() < 25.0 && session.ppm_std < 60.0,
            "{session:?}"
        );
        assert!(session.is_fault());
        let text = session.to_string();
        assert!(
            text.contains("sub-01, session 2") && text.contains("by 0.99969"),
            "{text}"
        );
        assert_eq!(SessionClock::new((None, 1), &clocks[..2]), None, "40 s");
        assert_eq!(
            SessionClock::new((None, 1), &[&clock(0.0, 1.0, 90.0)]),
            None
        );
    }

    #[test]
    fn a_rate_within_its_errors_or_a_crystals_is_no_fault() {
        for (ppm, std) in [(60.0, 1.0), (300.0, 200.0)] {
            let clocks = [clock(ppm, std, 40.0), clock(ppm, std, 40.0)];
            let clocks: Vec<&ForceClock> = clocks.iter().collect();
            let session = SessionClock::new((None, 1), &clocks).unwrap();
            assert!(!session.is_fault(), "{session:?}");
        }
    }
}
