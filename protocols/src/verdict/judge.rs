//! The verdict on a trial.

use crate::analysis::{ExplorationAnalysis, TrialAnalysis};
use crate::redo_reason::RedoReason;
use crate::rules::{ForceBand, Quality, VerdictRules};
use crate::stretch::Stretch;
use serde::{Deserialize, Serialize};

/// Whether a trial is accepted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Verdict {
    /// The trial is kept.
    Accepted,
    /// The trial is to be repeated.
    Redo {
        /// All reasons; never empty.
        reasons: Vec<RedoReason>,
    },
}

/// Judges a trial by `rules`. The verdict gives every reason for a repetition, not only the first.
///
/// ```
/// use protocols::{Protocol, RedoReason, TrialAnalysis, TrialKey, Verdict, built_in, verdict::judge};
///
/// let text = built_in("huloux2021").expect("a built-in protocol");
/// let rules = Protocol::parse(text, "huloux2021.toml")?.verdict_rules("am-6hz-95");
/// let analysis = TrialAnalysis {
///     key: TrialKey { number: 3, attempt: 1, practice: false, condition: "am-6hz-95".to_owned() },
///     explorations: Vec::new(),
///     unloaded_mean_normal_n: Some(0.3),
///     clipped_frames: 0,
///     lost_frames: 0,
///     input_xruns: 0,
///     output_xruns: 0,
/// };
/// let Verdict::Redo { reasons } = judge(&analysis, &rules) else { panic!("accepted") };
/// assert_eq!(reasons[0], RedoReason::FingerOnPlate { mean_n: 0.3, limit_n: 0.1 });
/// assert_eq!(reasons[1].to_string(), "0 instances, 5 needed");
/// # Ok::<(), protocols::ProtocolError>(())
/// ```
pub fn judge(analysis: &TrialAnalysis, rules: &VerdictRules) -> Verdict {
    let mut reasons = Vec::new();
    reasons.extend(baseline(analysis, rules));
    for (i, exploration) in analysis.explorations.iter().enumerate() {
        reasons.extend(lift(i + 1, exploration, rules));
        reasons.extend(force(i + 1, exploration, rules));
        reasons.extend(speed(i + 1, exploration, rules));
    }
    reasons.extend(drop_outs(analysis, &rules.quality));
    reasons.extend(instances(analysis, rules));
    if reasons.is_empty() {
        Verdict::Accepted
    } else {
        Verdict::Redo { reasons }
    }
}

/// Returns the value if it is finite: NaN is not a measurement, and JSON, the format of the event log, cannot represent it.
fn finite(measured: Option<f64>) -> Option<f64> {
    measured.filter(|x| x.is_finite())
}

fn baseline(analysis: &TrialAnalysis, rules: &VerdictRules) -> Option<RedoReason> {
    let limit_n = rules.force.contact_n;
    match finite(analysis.unloaded_mean_normal_n) {
        None => Some(RedoReason::BaselineNotMeasured),
        Some(mean_n) if mean_n >= limit_n => Some(RedoReason::FingerOnPlate { mean_n, limit_n }),
        Some(_) => None,
    }
}

fn lift(
    exploration: usize,
    analysis: &ExplorationAnalysis,
    rules: &VerdictRules,
) -> Option<RedoReason> {
    let (lifted_s, limit_s) = (analysis.lifted_s, rules.lift_limit_s);
    (lifted_s >= limit_s).then_some(RedoReason::FingerLifted {
        exploration,
        lifted_s,
        limit_s,
    })
}

fn force(
    exploration: usize,
    analysis: &ExplorationAnalysis,
    rules: &VerdictRules,
) -> Option<RedoReason> {
    let ForceBand { min_n, max_n, .. } = rules.force;
    let Some(mean_n) = finite(analysis.mean_normal_n) else {
        // `lift` reports a finger that was off the plate throughout.
        if lift(exploration, analysis, rules).is_some() {
            return None;
        }
        return Some(RedoReason::NotMeasured { exploration });
    };
    (!(min_n..=max_n).contains(&mean_n)).then_some(RedoReason::ForceOutOfBand {
        exploration,
        mean_n,
        min_n,
        max_n,
    })
}

fn speed(
    exploration: usize,
    analysis: &ExplorationAnalysis,
    rules: &VerdictRules,
) -> Option<RedoReason> {
    let min_m_per_s = rules.speed_m_per_s * (1.0 - rules.speed_tolerance);
    let max_m_per_s = rules.speed_m_per_s * (1.0 + rules.speed_tolerance);
    let Some(speed_m_per_s) = finite(analysis.mean_speed_m_per_s) else {
        // Speed and force are usually missing together; `force` reports that.
        return finite(analysis.mean_normal_n).map(|_| RedoReason::NotMeasured { exploration });
    };
    (!(min_m_per_s..=max_m_per_s).contains(&speed_m_per_s)).then_some(RedoReason::SpeedOutOfBand {
        exploration,
        speed_m_per_s,
        min_m_per_s,
        max_m_per_s,
    })
}

fn drop_outs(analysis: &TrialAnalysis, quality: &Quality) -> Vec<RedoReason> {
    let mut reasons = Vec::new();
    if analysis.clipped_frames > quality.max_clipped_frames {
        reasons.push(RedoReason::Clipped {
            frames: analysis.clipped_frames,
            limit: quality.max_clipped_frames,
        });
    }
    if analysis.lost_frames > quality.max_lost_frames {
        reasons.push(RedoReason::LostSamples {
            frames: analysis.lost_frames,
            limit: quality.max_lost_frames,
        });
    }
    if analysis.input_xruns + analysis.output_xruns > quality.max_xruns {
        reasons.push(RedoReason::Xruns {
            input: analysis.input_xruns,
            output: analysis.output_xruns,
            limit: quality.max_xruns,
        });
    }
    reasons
}

fn instances(analysis: &TrialAnalysis, rules: &VerdictRules) -> Option<RedoReason> {
    let instances = analysis.instances();
    (instances < rules.min_instances as usize).then(|| RedoReason::TooFewInstances {
        found: instances,
        needed: rules.min_instances,
        mostly: commonest_rejection(analysis),
    })
}

fn commonest_rejection(analysis: &TrialAnalysis) -> Option<String> {
    let mut counts: Vec<(String, usize)> = Vec::new();
    let rejections = analysis
        .explorations
        .iter()
        .flat_map(|e| &e.stretches)
        .filter_map(Stretch::rejection);
    for text in rejections.map(|r| r.kind().to_owned()) {
        match counts.iter_mut().find(|(kind, _)| *kind == text) {
            Some((_, n)) => *n += 1,
            None => counts.push((text, 1)),
        }
    }
    counts
        .into_iter()
        .max_by_key(|(_, n)| *n)
        .map(|(text, _)| text)
}
