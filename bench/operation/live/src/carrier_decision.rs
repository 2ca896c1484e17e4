//! Decision on a new carrier between trials, after the plate's resonance has drifted.
//!
//! A new carrier is proposed at the verdict on a trial, and the operator or the protocol decides. The carrier changes at rest
//! only: no trial is open, the plate is not driven, and the machine does not begin the next trial while the decision is open.

use config::Effective;
use contact::uncertain::Uncertain;
use protocols::{NewCarrier, Protocol, ResonanceDrift};
use serde_json::{Map, Value, json};
use tui::event::{CarrierProposal, LogLevel, ValueAndStd};

/// Checks that the bench may be driven at its shifted resonance.
pub type RequireDrivable = Box<dyn Fn(&Effective) -> anyhow::Result<()> + Send>;

/// Largest distance of the carrier from the calibrated resonance, Hz; beyond it, the calibration of plate and pickup no longer
/// holds.
const REACH_HZ: f64 = 50.0;
/// Timeout of a proposal without an answer, s.
const ANSWER_TIMEOUT_S: f64 = 60.0;
/// Largest standard error of a drift that leads to a proposal, as a share of the drift limit.
const GREATEST_STD_SHARE: f64 = 0.5;

/// Proposal of a carrier at the present resonance.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Proposal {
    from_hz: f64,
    to_hz: f64,
    drift_hz: Uncertain,
    since_s: f64,
}

/// Effects that the session carries out for a decision.
#[derive(Debug)]
pub enum CarrierEffect {
    /// Show the event to the operator.
    Show(Box<tui::Event>),
    /// Write the fields to the log.
    Record(Map<String, Value>),
    /// Drive the following trials at a carrier shifted by this difference, Hz, on this bench.
    Change(f64, Box<Effective>),
}

/// State of the decision on the carrier.
pub struct CarrierDecision {
    /// `None` for a protocol that drives at fixed frequencies.
    rules: Option<ResonanceDrift>,
    attended: bool,
    calibrated_hz: f64,
    require: RequireDrivable,
    open_proposal: Option<Proposal>,
    /// Accepted proposal that waits for the bench to be at rest, and who accepted it.
    accepted_proposal: Option<(Proposal, &'static str)>,
    /// Drift at which the present carrier was last kept, Hz.
    kept_hz: f64,
    /// Effects to return at the next poll.
    next_effects: Vec<CarrierEffect>,
}

/// Carrier chosen in an earlier part of a session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecidedCarrier {
    /// Calibrated resonance of the plate at that time, Hz.
    pub calibrated_hz: f64,
    /// The carrier, Hz.
    pub to_hz: f64,
    /// Resonance drift that led to the choice, Hz.
    pub drift_hz: Uncertain,
}

impl CarrierDecision {
    /// Creates the decision for a session on `bench` with its calibrated resonance.
    pub fn new(
        protocol: &Protocol,
        bench: &Effective,
        require: RequireDrivable,
        attended: bool,
    ) -> Self {
        Self {
            rules: protocol
                .follows_resonance()
                .then_some(protocol.resonance_drift),
            attended,
            calibrated_hz: bench.config().plate.resonance_hz,
            require,
            open_proposal: None,
            accepted_proposal: None,
            kept_hz: 0.0,
            next_effects: Vec::new(),
        }
    }

    /// Resumes with the carrier chosen earlier, under the same conditions as a new one; the change follows as soon as the bench
    /// is at rest.
    #[must_use]
    pub fn resume(mut self, carrier: Option<DecidedCarrier>, bench: &Effective) -> Self {
        let from_hz = bench.config().plate.resonance_hz;
        let Some((carrier, _)) = carrier.zip(self.rules) else {
            return self;
        };
        let DecidedCarrier { to_hz, .. } = carrier;
        let proposal = Proposal {
            from_hz,
            to_hz,
            drift_hz: carrier.drift_hz,
            since_s: 0.0,
        };
        let calibrated_hz = carrier.calibrated_hz;
        let reach = if (calibrated_hz - from_hz).abs() < 1e-6 {
            self.reaches(bench, to_hz)
        } else {
            Err(format!(
                "the calibrated resonance was {calibrated_hz:.1} Hz then, and is {from_hz:.1} Hz now"
            ))
        };
        match reach {
            Ok(()) => self.accepted_proposal = Some((proposal, "resumed session")),
            Err(reason) => {
                self.next_effects = vec![
                    warn(format!(
                        "the carrier of this session was changed to {to_hz:.1} Hz, but the session goes on at {from_hz:.1} \
                         Hz: {reason}"
                    )),
                    proposal.record("carrier_out_of_reach", [("because", json!(reason))]),
                ];
            }
        }
        self
    }

    /// Returns whether the next trial must wait.
    pub fn is_open(&self) -> bool {
        self.open_proposal.is_some() || self.accepted_proposal.is_some()
    }

    /// Judges the resonance drift after a trial.
    pub fn judge(
        &mut self,
        drift_hz: Option<Uncertain>,
        bench: &Effective,
        now_s: f64,
    ) -> Vec<CarrierEffect> {
        let (Some(rules), Some(drift_hz)) = (self.rules, drift_hz) else {
            return Vec::new();
        };
        let is_known = drift_hz.std <= GREATEST_STD_SHARE * rules.limit_hz;
        let is_far = drift_hz.value.abs() > rules.limit_hz
            && (drift_hz.value - self.kept_hz).abs() > rules.limit_hz;
        if self.is_open() || !is_known || !is_far {
            return Vec::new();
        }
        let from_hz = bench.config().plate.resonance_hz;
        // Rounded to a whole number of hertz, because generator and demodulator represent its phase exactly.
        let to_hz = (from_hz + drift_hz.value).round();
        let proposal = Proposal {
            from_hz,
            to_hz,
            drift_hz,
            since_s: now_s,
        };
        if let Err(reason) = self.reaches(bench, to_hz) {
            self.kept_hz = drift_hz.value;
            let drift = drift_text(drift_hz);
            return vec![
                warn(format!(
                    "the plate's resonance {drift}, and the carrier stays: {reason}"
                )),
                proposal.record("carrier_out_of_reach", [("because", json!(reason))]),
            ];
        }
        let record = proposal.record("carrier_proposed", []);
        match rules.new_carrier {
            NewCarrier::Auto => {
                self.accepted_proposal = Some((proposal, "protocol"));
                vec![record]
            }
            NewCarrier::Ask if self.attended => {
                self.open_proposal = Some(proposal);
                vec![record, show(Some(&proposal))]
            }
            NewCarrier::Ask => {
                let drift = drift_text(drift_hz);
                let text = format!(
                    "the plate's resonance {drift}: {to_hz:.0} Hz would follow it, but no operator can confirm the \
                     change; resonance_drift.new_carrier = \"auto\" in the protocol changes the carrier without asking"
                );
                let mut effects = vec![record, warn(text)];
                effects.extend(self.keep(&proposal, "nobody to ask"));
                effects
            }
        }
    }

    fn reaches(&self, bench: &Effective, to_hz: f64) -> Result<(), String> {
        let shift_hz = to_hz - self.calibrated_hz;
        if shift_hz.abs() > REACH_HZ {
            return Err(format!(
                "{to_hz:.0} Hz is {shift_hz:+.0} Hz from the calibrated resonance, more than {REACH_HZ:.0} Hz; \
                 calibrate the plate again: friction-bench calibrate plate"
            ));
        }
        (self.require)(&bench.with_resonance(to_hz)).map_err(|error| format!("{error:#}"))
    }

    /// Takes the operator's answer; an answer to a proposal that has expired has no effect.
    pub fn answer(&mut self, take: bool) -> Vec<CarrierEffect> {
        let Some(proposal) = self.open_proposal.take() else {
            return Vec::new();
        };
        if take {
            self.accepted_proposal = Some((proposal, "operator"));
            return vec![show(None)];
        }
        self.keep(&proposal, "operator")
    }

    /// Changes to the accepted carrier once the bench is at rest, and drops a proposal that has timed out.
    pub fn poll(&mut self, bench: &Effective, at_rest: bool, now_s: f64) -> Vec<CarrierEffect> {
        if !self.next_effects.is_empty() {
            return std::mem::take(&mut self.next_effects);
        }
        if let Some(proposal) = self
            .open_proposal
            .take_if(|proposal| now_s - proposal.since_s > ANSWER_TIMEOUT_S)
        {
            return self.keep(&proposal, "no answer");
        }
        let Some((proposal, decider)) = self.accepted_proposal.take_if(|_| at_rest) else {
            return Vec::new();
        };
        self.kept_hz = 0.0;
        let Proposal { from_hz, to_hz, .. } = proposal;
        let drift = drift_text(proposal.drift_hz);
        vec![
            CarrierEffect::Change(to_hz - from_hz, Box::new(bench.with_resonance(to_hz))),
            proposal.record("carrier_changed", [("by", json!(decider))]),
            log(
                LogLevel::Info,
                format!(
                    "carrier {to_hz:.0} Hz from now on, not {from_hz:.0} Hz: the resonance {drift}"
                ),
            ),
        ]
    }

    /// Withdraws an open proposal because a trial begins, after which it is proposed again, or because the session ends.
    pub fn withdraw(&mut self, because: &'static str) -> Vec<CarrierEffect> {
        let accepted_proposal = self.accepted_proposal.take().map(|(proposal, _)| proposal);
        match self.open_proposal.take().or(accepted_proposal) {
            Some(proposal) => vec![proposal.kept_record(because), show(None)],
            None => Vec::new(),
        }
    }

    fn keep(&mut self, proposal: &Proposal, because: &'static str) -> Vec<CarrierEffect> {
        self.kept_hz = proposal.drift_hz.value;
        vec![proposal.kept_record(because), show(None)]
    }
}

impl Proposal {
    fn record<const N: usize>(&self, event: &str, details: [(&str, Value); N]) -> CarrierEffect {
        let data = [
            ("event", json!(event)),
            ("from_hz", json!(self.from_hz)),
            ("to_hz", json!(self.to_hz)),
            ("drift_hz", json!(self.drift_hz.value)),
            ("drift_std_hz", json!(self.drift_hz.std)),
        ];
        let data = data.into_iter().chain(details);
        CarrierEffect::Record(data.map(|(key, value)| (key.to_owned(), value)).collect())
    }

    fn kept_record(&self, because: &'static str) -> CarrierEffect {
        self.record("carrier_kept", [("because", json!(because))])
    }
}

fn drift_text(drift_hz: Uncertain) -> String {
    let Uncertain { value, std } = drift_hz;
    let decimals = statistics::error_decimals(std, 1);
    format!("moved by {value:+.decimals$} ± {std:.decimals$} Hz")
}

fn show(proposal: Option<&Proposal>) -> CarrierEffect {
    CarrierEffect::Show(Box::new(tui::Event::NewCarrier {
        proposal: proposal.map(|proposal| CarrierProposal {
            from_hz: proposal.from_hz,
            to_hz: proposal.to_hz,
            drift_hz: ValueAndStd {
                value: proposal.drift_hz.value,
                std: proposal.drift_hz.std,
            },
        }),
    }))
}

fn log(level: LogLevel, text: String) -> CarrierEffect {
    CarrierEffect::Show(Box::new(tui::Event::Log { level, text }))
}

fn warn(text: String) -> CarrierEffect {
    log(LogLevel::Warning, text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::Config;

    fn bench() -> Effective {
        let text = config::rigs::MOCK_BENCH;
        Effective::uncalibrated(Config::parse(text, "mock-bench.toml").unwrap())
    }

    /// Returns a decision under the demo protocol with these rules, on a bench that may be driven up to `most_hz`.
    fn decision(rules: &str, attended: bool, most_hz: f64) -> CarrierDecision {
        let text = protocols::built_in("demo").unwrap();
        let (head, _) = text.split_once("[resonance_drift]").unwrap();
        let text = format!("{head}[resonance_drift]\n{rules}");
        let protocol = Protocol::parse(&text, "demo.toml").unwrap();
        let require = Box::new(move |bench: &Effective| {
            let hz = bench.config().plate.resonance_hz;
            anyhow::ensure!(hz <= most_hz, "too high");
            Ok(())
        });
        CarrierDecision::new(&protocol, &bench(), require, attended)
    }

    fn drift(value: f64) -> Option<Uncertain> {
        Some(Uncertain { value, std: 0.3 })
    }

    /// Returns the effects in words: records, events and carrier changes.
    fn words(effects: &[CarrierEffect]) -> Vec<String> {
        let event_word = |event: &tui::Event| match event {
            tui::Event::NewCarrier { proposal: Some(_) } => "asks".to_owned(),
            tui::Event::NewCarrier { proposal: None } => "settled".to_owned(),
            tui::Event::Log { level, .. } => format!("{level:?}").to_lowercase(),
            event => panic!("{event:?}"),
        };
        let word = |effect: &CarrierEffect| match effect {
            CarrierEffect::Record(data) => data["event"].as_str().unwrap().to_owned(),
            CarrierEffect::Show(event) => event_word(event),
            CarrierEffect::Change(shift_hz, bench) => {
                format!("by {shift_hz} to {}", bench.config().plate.resonance_hz)
            }
        };
        effects.iter().map(word).collect()
    }

    /// Fault 45.
    #[test]
    fn the_operator_decides_and_the_carrier_changes_at_rest() {
        let (bench, mut decision) = (bench(), decision("limit_hz = 3.0", true, 1e5));
        let from_hz = bench.config().plate.resonance_hz;
        assert!(decision.judge(drift(2.9), &bench, 1.0).is_empty());
        let effects = decision.judge(drift(-4.2), &bench, 2.0);
        assert_eq!(words(&effects), ["carrier_proposed", "asks"]);
        assert!(decision.is_open() && decision.poll(&bench, true, 3.0).is_empty());
        assert_eq!(words(&decision.answer(true)), ["settled"]);
        assert!(decision.is_open() && decision.poll(&bench, false, 4.0).is_empty());
        let effects = decision.poll(&bench, true, 5.0);
        let to_hz = (from_hz - 4.2).round();
        let change = format!("by {} to {to_hz}", to_hz - from_hz);
        assert_eq!(
            words(&effects),
            [change.as_str(), "carrier_changed", "info"]
        );
        assert!(!decision.is_open() && decision.poll(&bench, true, 6.0).is_empty());
        // Drift is counted from the new carrier.
        assert!(decision.judge(drift(0.1), &bench, 7.0).is_empty());
    }

    /// A key pressed one phase too late, or twice, has no effect.
    #[test]
    fn an_answer_without_a_proposal_does_nothing() {
        let (bench, mut decision) = (bench(), decision("limit_hz = 3.0", true, 1e5));
        for take in [true, false] {
            assert!(decision.answer(take).is_empty());
            decision.judge(drift(5.0), &bench, 1.0);
            assert_eq!(
                words(&decision.withdraw("a trial began")),
                ["carrier_kept", "settled"]
            );
            assert!(decision.answer(take).is_empty() && !decision.is_open());
            assert!(decision.poll(&bench, true, 2.0).is_empty());
        }
        // The proposal is accepted, but a trial begins before the bench is at rest: the carrier does not change.
        decision.judge(drift(5.0), &bench, 1.0);
        decision.answer(true);
        assert_eq!(
            words(&decision.withdraw("a trial began")),
            ["carrier_kept", "settled"]
        );
        assert!(decision.poll(&bench, true, 2.0).is_empty());
    }

    #[test]
    fn a_kept_carrier_is_proposed_again_only_after_a_further_drift() {
        let (bench, mut decision) = (bench(), decision("limit_hz = 3.0", true, 1e5));
        decision.judge(drift(4.0), &bench, 1.0);
        assert_eq!(words(&decision.answer(false)), ["carrier_kept", "settled"]);
        assert!(decision.judge(drift(6.5), &bench, 2.0).is_empty());
        assert!(!decision.judge(drift(7.5), &bench, 3.0).is_empty());
        // The proposal times out.
        assert!(decision.poll(&bench, true, 62.9).is_empty());
        let late = decision.poll(&bench, true, 63.1);
        assert_eq!(words(&late), ["carrier_kept", "settled"]);
        assert!(!decision.is_open());
    }

    #[test]
    fn auto_accepts_the_carrier_and_no_operator_means_no_question() {
        let bench = bench();
        let mut auto = decision("limit_hz = 3.0\nnew_carrier = \"auto\"", false, 1e5);
        let effects = auto.judge(drift(4.0), &bench, 1.0);
        assert_eq!(words(&effects), ["carrier_proposed"]);
        assert_eq!(words(&auto.poll(&bench, true, 1.0)).len(), 3);
        let mut headless = decision("limit_hz = 3.0", false, 1e5);
        let effects = headless.judge(drift(4.0), &bench, 1.0);
        let expected = ["carrier_proposed", "warning", "carrier_kept", "settled"];
        assert_eq!(words(&effects), expected);
        assert!(!headless.is_open());
    }

    /// Covers carriers too far from the calibration, carriers beyond the bench's limits, and poorly known drifts.
    #[test]
    fn a_carrier_out_of_reach_is_not_proposed() {
        let bench = bench();
        let calibrated_hz = bench.config().plate.resonance_hz;
        let out_of_reach = ["warning", "carrier_out_of_reach"];
        let mut wide = decision("limit_hz = 50.0\nnew_carrier = \"auto\"", true, 1e5);
        assert_eq!(words(&wide.judge(drift(50.6), &bench, 1.0)), out_of_reach);
        // The warning appears once.
        assert!(!wide.is_open() && wide.judge(drift(50.7), &bench, 2.0).is_empty());
        let shifted_bench = bench.with_resonance(calibrated_hz + 48.0);
        let mut narrow = decision("limit_hz = 3.0", true, 1e5);
        assert_eq!(
            words(&narrow.judge(drift(3.2), &shifted_bench, 1.0)),
            out_of_reach
        );
        assert_eq!(
            words(&narrow.judge(drift(-3.2), &shifted_bench, 1.0)).len(),
            2
        );
        assert!(narrow.is_open());
        let mut refused = decision("limit_hz = 3.0", true, calibrated_hz);
        assert_eq!(words(&refused.judge(drift(4.0), &bench, 1.0)), out_of_reach);
        let mut unknown = decision("limit_hz = 3.0", true, 1e5);
        let vague = Uncertain {
            value: 9.0,
            std: 1.6,
        };
        assert!(unknown.judge(Some(vague), &bench, 1.0).is_empty());
        assert!(unknown.judge(None, &bench, 1.0).is_empty());
    }

    #[test]
    fn a_resumed_session_goes_on_at_its_carrier_under_the_conditions_of_a_new_one() {
        let bench = bench();
        let calibrated_hz = bench.config().plate.resonance_hz;
        let earlier_carrier = |to_hz: f64, calibrated_hz: f64| DecidedCarrier {
            calibrated_hz,
            to_hz,
            drift_hz: Uncertain {
                value: to_hz - calibrated_hz,
                std: 0.3,
            },
        };
        let resumed = |decided, most_hz: f64| {
            decision("limit_hz = 3.0", true, most_hz).resume(decided, &bench)
        };
        let to_hz = calibrated_hz - 7.0;
        let mut reachable = resumed(Some(earlier_carrier(to_hz, calibrated_hz)), 1e5);
        // No trial begins before the change, and the change waits for rest.
        assert!(reachable.is_open() && reachable.poll(&bench, false, 0.0).is_empty());
        let change = format!("by -7 to {to_hz}");
        let effects = reachable.poll(&bench, true, 0.0);
        assert_eq!(
            words(&effects),
            [change.as_str(), "carrier_changed", "info"]
        );
        let CarrierEffect::Record(data) = &effects[1] else {
            panic!("{effects:?}");
        };
        assert_eq!(data["by"], "resumed session");
        assert!(!reachable.is_open() && reachable.judge(drift(0.1), &bench, 1.0).is_empty());

        let expected = ["warning", "carrier_out_of_reach"];
        for (decided, most_hz) in [
            (earlier_carrier(to_hz, calibrated_hz - 1.0), 1e5),
            (earlier_carrier(calibrated_hz + 51.0, calibrated_hz), 1e5),
            (
                earlier_carrier(calibrated_hz + 7.0, calibrated_hz),
                calibrated_hz,
            ),
        ] {
            let mut unreachable = resumed(Some(decided), most_hz);
            assert!(!unreachable.is_open());
            assert_eq!(
                words(&unreachable.poll(&bench, true, 0.0)),
                expected,
                "{decided:?}"
            );
            assert!(unreachable.poll(&bench, true, 0.0).is_empty());
        }
        assert!(!resumed(None, 1e5).is_open());
    }

    #[test]
    fn a_protocol_with_a_fixed_frequency_keeps_it() {
        let text = protocols::built_in("demo").unwrap();
        let text = text.replace("\"plate resonance\"", "35000.0");
        let protocol = Protocol::parse(&text, "demo.toml").unwrap();
        let mut fixed = CarrierDecision::new(&protocol, &bench(), Box::new(|_| Ok(())), true);
        assert!(fixed.judge(drift(20.0), &bench(), 1.0).is_empty());
        let decided = DecidedCarrier {
            calibrated_hz: bench().config().plate.resonance_hz,
            to_hz: 35_003.0,
            drift_hz: drift(3.0).unwrap(),
        };
        let mut fixed = fixed.resume(Some(decided), &bench());
        assert!(!fixed.is_open() && fixed.poll(&bench(), true, 1.0).is_empty());
    }
}
