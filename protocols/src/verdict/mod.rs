//! Judging a trial: accepted, or to be repeated and why.

#[cfg(test)]
mod tests;

use crate::protocol::{ForceBand, Quality};
use crate::selection::Stretch;
use crate::trial::{Direction, TrialKey, TrialOutcome, TrialRecord};
use serde::{Deserialize, Serialize};

/// What was measured in one exploration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExplorationAnalysis {
    /// Which way the finger slid.
    pub direction: Direction,
    /// Mean normal force over the plate's central part, N; `None` without a valid frame there.
    pub mean_normal_n: Option<f64>,
    /// Mean speed along the direction over the plate's central part, m/s; `None` without a valid frame there.
    pub mean_speed_m_per_s: Option<f64>,
    /// All rising stretches in order, accepted and rejected.
    pub stretches: Vec<Stretch>,
}

impl ExplorationAnalysis {
    /// Number of accepted stretches.
    pub fn instances(&self) -> usize {
        self.stretches
            .iter()
            .filter(|s| s.instance().is_some())
            .count()
    }
}

/// What was measured in one attempt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialAnalysis {
    /// Which attempt.
    pub key: TrialKey,
    /// One for each exploration, in order.
    pub explorations: Vec<ExplorationAnalysis>,
    /// Mean normal force while no finger should have been on the plate, N; `None` if it was not measured.
    pub unloaded_mean_normal_n: Option<f64>,
    /// Input frames at the converter's limit.
    pub clipped_frames: u64,
    /// Input frames lost, written as NaN.
    pub lost_frames: u64,
    /// Overruns of the input.
    pub input_xruns: u64,
    /// Underruns of the output.
    pub output_xruns: u64,
}

impl TrialAnalysis {
    /// Accepted stretches of all explorations.
    pub fn instances(&self) -> usize {
        self.explorations
            .iter()
            .map(ExplorationAnalysis::instances)
            .sum()
    }
}

/// What a trial is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictRules {
    /// Band of the mean normal force, and the force that means contact.
    pub force: ForceBand,
    /// The slider's speed, m/s.
    pub speed_m_per_s: f64,
    /// Allowed deviation from it, as a part of it.
    pub speed_tolerance: f64,
    /// Instances that a trial needs.
    pub min_instances: u32,
    /// Allowed drop-outs.
    pub quality: Quality,
}

/// Why a trial must be repeated; the text is for the operator. Explorations count from 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum RedoReason {
    /// The mean normal force of an exploration left the band.
    #[error(
        "exploration {exploration}: mean normal force {mean_n:.2} N, outside {min_n:.2} to {max_n:.2} N"
    )]
    ForceOutOfBand {
        /// Which exploration.
        exploration: usize,
        /// Its mean normal force, N.
        mean_n: f64,
        /// Lower end of the band, N.
        min_n: f64,
        /// Upper end of the band, N.
        max_n: f64,
    },
    /// The mean speed of an exploration was not the slider's.
    #[error("exploration {exploration}: mean speed {:.0} mm/s, outside {:.0} to {:.0} mm/s", .speed_m_per_s * 1e3, .min_m_per_s * 1e3, .max_m_per_s * 1e3)]
    SpeedOutOfBand {
        /// Which exploration.
        exploration: usize,
        /// Its mean speed, m/s.
        speed_m_per_s: f64,
        /// Least allowed speed, m/s.
        min_m_per_s: f64,
        /// Greatest allowed speed, m/s.
        max_m_per_s: f64,
    },
    /// Force or position of an exploration was not measured.
    #[error("exploration {exploration}: no valid force or position on the plate's central part")]
    NotMeasured {
        /// Which exploration.
        exploration: usize,
    },
    /// An input was driven into the converter's limit.
    #[error("{frames} clipped frames, {limit} allowed: lower the input gain or the amplitude")]
    Clipped {
        /// Clipped frames.
        frames: u64,
        /// Allowed.
        limit: u64,
    },
    /// Input frames were lost.
    #[error("{frames} lost frames, {limit} allowed")]
    LostSamples {
        /// Lost frames.
        frames: u64,
        /// Allowed.
        limit: u64,
    },
    /// The sound card ran over or dry.
    #[error("{input} input and {output} output xruns, {limit} allowed")]
    Xruns {
        /// Overruns of the input.
        input: u64,
        /// Underruns of the output.
        output: u64,
        /// Allowed together.
        limit: u64,
    },
    /// Too little to estimate from.
    #[error("{found} instances, {needed} needed{}", .mostly.as_ref().map(|m| format!("; most other stretches: {m}")).unwrap_or_default())]
    TooFewInstances {
        /// Accepted stretches.
        found: usize,
        /// Needed.
        needed: u32,
        /// The commonest reason of the rejected stretches.
        mostly: Option<String>,
    },
    /// A finger lay on the plate while its own impedance was read.
    #[error(
        "finger on the plate during the baseline: mean normal force {mean_n:.2} N, less than {limit_n:.2} N needed"
    )]
    FingerOnPlate {
        /// Mean normal force of the baseline, N.
        mean_n: f64,
        /// It must be below this, N.
        limit_n: f64,
    },
    /// The baseline's force was not measured.
    #[error("the normal force of the baseline was not measured")]
    BaselineNotMeasured,
    /// The bench did not deliver an analysis in time.
    #[error("the trial was not analysed in time")]
    NotAnalysed,
}

/// The judgement of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Verdict {
    /// Good.
    Accepted,
    /// To be repeated.
    Redo {
        /// Why; never empty.
        reasons: Vec<RedoReason>,
    },
}

/// Judges a trial. All reasons are collected, not only the first.
pub fn judge(analysis: &TrialAnalysis, rules: &VerdictRules) -> Verdict {
    let mut reasons = Vec::new();
    reasons.extend(baseline(analysis, rules));
    for (i, exploration) in analysis.explorations.iter().enumerate() {
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

/// NaN is no measurement, and JSON, which the event log is, cannot hold it.
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

fn force(exploration: usize, of: &ExplorationAnalysis, rules: &VerdictRules) -> Option<RedoReason> {
    let ForceBand { min_n, max_n, .. } = rules.force;
    let Some(mean_n) = finite(of.mean_normal_n) else {
        return Some(RedoReason::NotMeasured { exploration });
    };
    (!(min_n..=max_n).contains(&mean_n)).then_some(RedoReason::ForceOutOfBand {
        exploration,
        mean_n,
        min_n,
        max_n,
    })
}

fn speed(exploration: usize, of: &ExplorationAnalysis, rules: &VerdictRules) -> Option<RedoReason> {
    let min_m_per_s = rules.speed_m_per_s * (1.0 - rules.speed_tolerance);
    let max_m_per_s = rules.speed_m_per_s * (1.0 + rules.speed_tolerance);
    let Some(speed_m_per_s) = finite(of.mean_speed_m_per_s) else {
        // A missing speed mostly comes with a missing force, which `force` reports.
        return finite(of.mean_normal_n).map(|_| RedoReason::NotMeasured { exploration });
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
    let found = analysis.instances();
    (found < rules.min_instances as usize).then(|| RedoReason::TooFewInstances {
        found,
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
        match counts.iter_mut().find(|(known, _)| *known == text) {
            Some((_, n)) => *n += 1,
            None => counts.push((text, 1)),
        }
    }
    counts
        .into_iter()
        .max_by_key(|(_, n)| *n)
        .map(|(text, _)| text)
}

/// A session in numbers. Practice counts nowhere but in `practice`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SessionSummary {
    /// Trials in the protocol.
    pub planned: u32,
    /// Practice trials done.
    pub practice: u32,
    /// Trials judged good.
    pub accepted: u32,
    /// Trials judged bad and kept by the operator.
    pub accepted_anyway: u32,
    /// Trials given up at the redo limit.
    pub given_up: u32,
    /// Repetitions asked for by a verdict or by the operator at one.
    pub redone: u32,
    /// Attempts cut short.
    pub interrupted: u32,
    /// Instances in kept trials.
    pub instances: u64,
    /// Mean over the explorations of kept trials of their mean normal force, N.
    pub mean_normal_n: Option<f64>,
    /// Lost frames in all analysed attempts.
    pub lost_frames: u64,
    /// Clipped frames in all analysed attempts.
    pub clipped_frames: u64,
    /// Input and output xruns in all analysed attempts.
    pub xruns: u64,
}

impl SessionSummary {
    /// Sums up the attempts of a session that planned `planned` trials without practice.
    pub fn new(planned: u32, records: &[TrialRecord]) -> Self {
        let mut summary = Self {
            planned,
            ..Self::default()
        };
        let mut forces = Vec::new();
        for record in records {
            if let Some(analysis) = &record.analysis {
                summary.lost_frames += analysis.lost_frames;
                summary.clipped_frames += analysis.clipped_frames;
                summary.xruns += analysis.input_xruns + analysis.output_xruns;
            }
            if record.key.practice {
                summary.practice += u32::from(record.outcome.settles());
                continue;
            }
            let (count, kept) = match &record.outcome {
                TrialOutcome::Accepted => (&mut summary.accepted, true),
                TrialOutcome::AcceptedAnyway { .. } => (&mut summary.accepted_anyway, true),
                TrialOutcome::GivenUp { .. } => (&mut summary.given_up, false),
                TrialOutcome::Redo { .. } => (&mut summary.redone, false),
                TrialOutcome::Interrupted { .. } => (&mut summary.interrupted, false),
            };
            *count += 1;
            if let (true, Some(analysis)) = (kept, &record.analysis) {
                summary.instances += analysis.instances() as u64;
                forces.extend(analysis.explorations.iter().filter_map(|e| e.mean_normal_n));
            }
        }
        if !forces.is_empty() {
            summary.mean_normal_n = Some(forces.iter().sum::<f64>() / forces.len() as f64);
        }
        summary
    }
}
