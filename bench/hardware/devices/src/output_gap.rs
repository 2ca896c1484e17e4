//! Gaps of the drive. If only the output underruns, the input continues: the recording is complete, but the drive
//! pauses, and returns with its phase turned by as many frames as it paused.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use impedance::sample_loss::{PhaseJump, TimestampEstimate, lost_frames};
use num_complex::Complex64;
use recording::manifest::{AFTER_REPORT_S, BEFORE_REPORT_S, EventKind, RecordingEvent};

use crate::lost_frames::{LEAST_AMPLITUDE, LossFinder, Lost, TIMESTAMP_S, TOLERANCE_RAD, WINDOW};

/// Length and spacing of the short windows in which the carrier is tracked, samples.
const SHORT: usize = 64;
const HOP: usize = 32;
/// Relative change of the carrier, from one short window to the next but one, that marks the edge of a gap. The
/// steepest modulation, ramps included, changes it by less.
const EDGE: f64 = 0.15;
/// Time between two searches, s: each takes a third of a millisecond.
const SEARCH_EVERY_S: f64 = 0.01;
/// Samples over which the level inside a gap is measured, one period of the carrier or more.
const LEVEL: usize = 6;
/// Share of the drive's power below which the drive counts as paused.
const PAUSED: f64 = 0.1;
/// Longest search, from the first of several xruns that are each reported while the gap of another is sought, in units
/// of [`AFTER_REPORT_S`]: an output that underruns for ever must cost neither memory nor time.
const MOST_RENEWALS: u64 = 2;

/// Output xrun, with its trace in the drive channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputXrun {
    /// Number of the first output xrun that it covers: reports of one gap have one number.
    pub number: u64,
    /// Number of the last output xrun so far.
    pub last: u64,
    /// First frame, on the audio clock, at which the drive may be wrong.
    pub from: u64,
    /// Frame after the last at which the drive may be wrong.
    pub to: u64,
    /// Frames that the output lost.
    pub gap: Gap,
}

/// Frames that the output lost in an xrun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gap {
    /// Still sought; a later report of the same xrun follows.
    Sought,
    /// The drive paused for this many frames.
    Of(Lost),
    /// The drive went on without a gap.
    Nowhere,
    /// Not known: the drive was silent, or input frames were lost too.
    Unknown,
}

impl std::fmt::Display for Gap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Sought => f.write_str("the gap of the drive is being sought"),
            Self::Of(Lost::Exactly(frames)) => {
                write!(f, "the drive paused for exactly {frames} frames")
            }
            Self::Of(Lost::About(frames)) => {
                write!(f, "the drive was broken off, for about {frames} frames")
            }
            Self::Nowhere => f.write_str("the drive went on without a gap"),
            Self::Unknown => f.write_str("the drive may have a gap here; its length is not known"),
        }
    }
}

impl OutputXrun {
    /// Returns the event for a recording that began at frame `begin`; `None` if the gap ended before it.
    pub fn event(&self, begin: u64) -> Option<RecordingEvent> {
        let sample = self.from.max(begin) - begin;
        let end = self.to.checked_sub(begin).filter(|&end| end > 0)?;
        let frames = match self.gap {
            Gap::Nowhere => 0,
            Gap::Of(Lost::Exactly(frames)) if self.from >= begin => frames,
            _ => end - sample,
        };
        Some(RecordingEvent {
            kind: EventKind::OutputXrun,
            sample,
            frames: Some(frames),
            text: Some(self.gap.to_string()),
        })
    }
}

/// Watches the drive channel for the gaps of output xruns.
pub struct OutputGapWatch {
    finder: LossFinder,
    channels: usize,
    drive_channel: usize,
    /// Window of [`SHORT`] samples, with the sum 2.
    short_window: Vec<f64>,
    frames_before: usize,
    frames_after: u64,
    search_every: u64,
    search_due: u64,
    /// Newest drive samples; the first is frame `begin` of the audio clock.
    recent: VecDeque<f32>,
    begin: u64,
    xruns: u64,
    search: Option<Sought>,
    reported: bool,
}

/// Xruns with a gap that is still sought.
#[derive(Debug, Clone, Copy)]
struct Sought {
    /// Number of the first xrun.
    number: u64,
    /// Frame at which the first xrun was reported.
    since: u64,
    /// Frame after the last at which the gap of the newest may begin.
    latest: u64,
    /// Frame at which the search ends: `latest`, but no later than [`MOST_RENEWALS`] allows.
    until: u64,
}

impl OutputGapWatch {
    /// Makes a watch for a stream of `channels` channels that carries the drive, at `carrier_hz`, in `drive_channel`.
    pub fn new(
        carrier_hz: f64,
        sample_rate_hz: u32,
        channels: usize,
        drive_channel: usize,
    ) -> Self {
        let rate_hz = f64::from(sample_rate_hz);
        Self {
            finder: LossFinder::new(carrier_hz, sample_rate_hz),
            channels,
            drive_channel,
            short_window: (0..SHORT)
                .map(|n| (1.0 - (TAU * (n as f64 + 0.5) / SHORT as f64).cos()) * 2.0 / SHORT as f64)
                .collect(),
            search_every: (SEARCH_EVERY_S * rate_hz) as u64,
            search_due: 0,
            frames_before: (BEFORE_REPORT_S * rate_hz) as usize,
            frames_after: (AFTER_REPORT_S * rate_hz) as u64,
            recent: VecDeque::new(),
            begin: 0,
            xruns: 0,
            search: None,
            reported: false,
        }
    }

    /// Expects the drive at another carrier from now on.
    pub fn retune(&mut self, carrier_hz: f64) {
        self.finder = LossFinder::new(carrier_hz, self.finder.sample_rate_hz());
    }

    /// Takes interleaved samples that begin at frame `first` of the audio clock, with the stream's count of output
    /// xruns. Returns the state of an xrun: once when it is reported, and once when its gap was found or given up.
    pub fn take(&mut self, first: u64, samples: &[f32], xruns: u64) -> Option<OutputXrun> {
        if self.search.is_none() {
            self.forget_but(self.frames_before);
        }
        if self.recent.is_empty() {
            self.begin = first;
        }
        self.recent.extend(
            samples
                .iter()
                .skip(self.drive_channel)
                .step_by(self.channels),
        );
        if xruns > self.xruns {
            self.xruns = xruns;
            self.seek(first);
            self.reported = false;
        }
        let search = self.search?;
        if self.end() >= self.search_due {
            self.search_due = self.end() + self.search_every;
            let report = self.search(search);
            if report.is_some() {
                self.search = None;
                return report;
            }
        }
        (!std::mem::replace(&mut self.reported, true)).then(|| self.xrun(search, Gap::Sought))
    }

    /// Searches for the gap of an xrun reported at a frame, together with that of an xrun already under search.
    fn seek(&mut self, reported: u64) {
        let (number, since) = self.search.map_or((self.xruns, reported), |search| {
            (search.number, search.since)
        });
        let latest = reported + self.frames_after;
        self.search = Some(Sought {
            number,
            since,
            latest,
            until: latest.min(since + MOST_RENEWALS * self.frames_after),
        });
    }

    /// Gives up a search, as when a recording ends.
    pub fn give_up(&mut self) -> Option<OutputXrun> {
        let search = self.search.take();
        search.map(|search| self.xrun(search, Gap::Unknown))
    }

    /// Gives up a search because input frames are lost too: the phase then has another reason to jump.
    pub fn lose(&mut self) -> Option<OutputXrun> {
        let report = self.give_up();
        self.recent.clear();
        report
    }

    fn end(&self) -> u64 {
        self.begin + self.recent.len() as u64
    }

    fn forget_but(&mut self, newest: usize) {
        let old = self.recent.len().saturating_sub(newest);
        self.recent.drain(..old);
        self.begin += old as u64;
    }

    /// Returns the xrun with the whole time in which its gap may lie.
    fn xrun(&self, search: Sought, gap: Gap) -> OutputXrun {
        OutputXrun {
            number: search.number,
            last: self.xruns,
            from: search.since.saturating_sub(self.frames_before as u64),
            to: self.end().max(search.latest),
            gap,
        }
    }

    fn search(&mut self, target: Sought) -> Option<OutputXrun> {
        let is_over = self.end() >= target.until;
        let has_several = self.xruns > target.number;
        if has_several && !is_over {
            // The gap of the first says nothing about later gaps.
            return None;
        }
        if target.until < target.latest {
            return is_over.then(|| self.xrun(target, Gap::Unknown));
        }
        let samples = self.recent.make_contiguous();
        let (gap, edges) = match edges(&self.finder, &self.short_window, samples) {
            // The drive has not been back long enough to read its phase.
            Some((_, end)) if samples.len() < end + WINDOW => {
                return is_over.then(|| self.xrun(target, Gap::Unknown));
            }
            Some((first, end)) => match gap(&self.finder, samples, first, end) {
                // The gap may still continue.
                Gap::Unknown if !is_over => return None,
                gap => (gap, Some((first, end))),
            },
            None if !is_over => return None,
            None if level(samples) < LEAST_AMPLITUDE => (Gap::Unknown, None),
            None => (Gap::Nowhere, None),
        };
        let xrun = match edges {
            Some((first, end)) => {
                let xrun = OutputXrun {
                    number: target.number,
                    last: self.xruns,
                    from: self.begin + first as u64,
                    to: self.begin + end as u64,
                    gap,
                };
                // A later xrun must not find this gap again.
                self.forget_but(self.recent.len() - end);
                xrun
            }
            None => self.xrun(target, gap),
        };
        Some(xrun)
    }
}

/// Returns the peak amplitude of a carrier with the same power.
fn level(samples: &[f32]) -> f64 {
    let power: f64 = samples.iter().map(|&x| f64::from(x).powi(2)).sum();
    (2.0 * power / samples.len().max(1) as f64).sqrt()
}

/// Returns the first sample that may belong to a gap, and the sample after the last.
fn edges(finder: &LossFinder, window: &[f64], samples: &[f32]) -> Option<(usize, usize)> {
    let rotation = Complex64::from_polar(1.0, -finder.step_rad());
    // Referred to the first of all samples.
    let phasor = |start: usize| {
        let mut turn = Complex64::from_polar(1.0, -(finder.step_rad() * start as f64) % TAU);
        let mut sum = Complex64::ZERO;
        for (&x, w) in samples[start..].iter().zip(window) {
            sum += f64::from(x) * w * turn;
            turn *= rotation;
        }
        sum
    };
    let starts = (0..samples.len().saturating_sub(SHORT)).step_by(HOP);
    let phasors: Vec<Complex64> = starts.map(phasor).collect();
    let is_edge = |i: &usize| {
        let (previous, current) = (phasors[i - 2], phasors[*i]);
        let larger = previous.norm().max(current.norm());
        larger > LEAST_AMPLITUDE && (current - previous).norm() > EDGE * larger
    };
    let mut edges = (2..phasors.len()).filter(is_edge);
    let first = edges.next()?;
    let last = edges.next_back().unwrap_or(first);
    Some(((first - 2) * HOP, last * HOP + SHORT))
}

fn gap(finder: &LossFinder, samples: &[f32], first: usize, end: usize) -> Gap {
    let Some(from) = first.checked_sub(WINDOW) else {
        return Gap::Unknown;
    };
    let (before, after) = (&samples[from..first], &samples[end..end + WINDOW]);
    let (start_phasor, end_phasor) = (finder.phasor(before), finder.phasor(after));
    let least = start_phasor.norm().min(end_phasor.norm());
    if least < LEAST_AMPLITUDE {
        return Gap::Unknown;
    }
    let paused = samples[first..end]
        .windows(LEVEL)
        .filter(|piece| level(piece).powi(2) < PAUSED * least.powi(2))
        .count();
    // A pause shorter than a period shows in the phase alone.
    let paused = if paused > 0 { paused + LEVEL - 1 } else { 0 };
    let turned = finder.step_rad() * (end - from) as f64;
    let expected = start_phasor * Complex64::from_polar(1.0, turned % TAU);
    let jump = PhaseJump {
        jump_rad: (expected * end_phasor.conj()).arg(),
        tolerance_rad: TOLERANCE_RAD,
    };
    let rate_hz = f64::from(finder.sample_rate_hz());
    let estimate = TimestampEstimate {
        frames: paused as f64,
        uncertainty_frames: TIMESTAMP_S * rate_hz,
    };
    match lost_frames(finder.carrier_hz(), finder.sample_rate_hz(), jump, estimate) {
        Ok(0) => Gap::Nowhere,
        Ok(frames) => Gap::Of(Lost::Exactly(frames)),
        Err(_) => Gap::Of(Lost::About(paused as u64)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RATE_HZ: u32 = 192_000;
    const BLOCK: usize = 64;

    /// Returns the final report of a watch on an output that pauses at `start` for `lost` frames, and reports it at
    /// `reported`.
    fn final_report(
        lost: usize,
        start: usize,
        reported: usize,
        modulation_hz: f64,
        amplitude: f64,
    ) -> OutputXrun {
        let frames = reported + 60_000;
        let mut played = 0u32;
        let samples: Vec<f32> = (0..frames)
            .flat_map(|n| {
                let silent = (start..start + lost).contains(&n);
                let t_s = f64::from(played) / f64::from(RATE_HZ);
                played += u32::from(!silent);
                let envelope = amplitude * (1.0 + 0.95 * (TAU * modulation_hz * t_s).sin());
                let drive = envelope * (TAU * 35_000.0 * t_s).sin();
                [0.0, if silent { 0.0 } else { drive as f32 }]
            })
            .collect();
        let mut watch = OutputGapWatch::new(35_000.0, RATE_HZ, 2, 1);
        let reports: Vec<OutputXrun> = samples
            .chunks(2 * BLOCK)
            .enumerate()
            .filter_map(|(i, block)| {
                let first = i * BLOCK;
                watch.take(first as u64, block, u64::from(first >= reported))
            })
            .collect();
        match reports[..] {
            [search_report, report] => {
                assert_eq!((search_report.gap, search_report.number), (Gap::Sought, 1));
                // The report may extend to the first search after the last possible sample.
                let most = search_report.to + 1_920 + BLOCK as u64;
                assert!(
                    search_report.from <= report.from && report.to <= most,
                    "{reports:?}"
                );
                report
            }
            // The gap was over when the xrun was reported.
            [report] if reported > start + lost => report,
            _ => panic!("{reports:?}"),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// Fault 6.
        #[test]
        fn the_gap_of_the_output_is_exact_to_the_frame(
            lost in 1usize..5_000,
            start in 30_000usize..60_000,
            late in -4_000i32..4_000,
            modulation_hz in 0.0..20.0f64,
        ) {
            let reported = (start as i32 + late) as usize;
            let xrun = final_report(lost, start, reported, modulation_hz, 0.3);
            prop_assert_eq!(xrun.gap, Gap::Of(Lost::Exactly(lost as u64)));
            let near = 200;
            prop_assert!(xrun.from <= start as u64 && start as u64 <= xrun.from + near, "{:?}", xrun);
            let end = (start + lost) as u64;
            prop_assert!(end <= xrun.to && xrun.to <= end + near, "{:?}", xrun);
        }
    }

    #[test]
    fn a_harmless_xrun_is_distinguished_from_an_undecided_one() {
        assert_eq!(final_report(0, 30_000, 30_000, 6.0, 0.3).gap, Gap::Nowhere);
        assert_eq!(
            final_report(500, 30_000, 30_000, 6.0, 0.0).gap,
            Gap::Unknown
        );
    }

    /// Fault 6.
    #[test]
    fn xruns_that_keep_coming_are_each_accounted_for_in_bounded_memory() {
        const BLOCK_FRAMES: usize = 480;
        let mut watch = OutputGapWatch::new(12_000.0, 48_000, 1, 0);
        let silence = [0.0; BLOCK_FRAMES];
        let (mut reported, mut settled, mut most) = (Vec::new(), Vec::new(), 0);
        for block in 0..200_u64 {
            // Two of three blocks bring an xrun, for two seconds.
            let xruns = block - block / 3;
            let first = BLOCK_FRAMES as u64 * block;
            let report = watch.take(first, &silence, xruns);
            most = most.max(watch.recent.len());
            match report {
                Some(xrun) if xrun.gap == Gap::Sought => reported.push(first),
                Some(xrun) => settled.push(xrun),
                None => {}
            }
        }
        settled.extend(watch.give_up());
        let longest =
            watch.frames_before + (MOST_RENEWALS * watch.frames_after) as usize + 2 * BLOCK_FRAMES;
        assert!(most <= longest, "{most} samples are kept, {longest} do");
        assert!(settled.len() >= 4, "{} in 2 s", settled.len());
        for first in reported {
            let contains_first = |xrun: &OutputXrun| xrun.from <= first && first <= xrun.to;
            assert!(
                settled.iter().any(contains_first),
                "{first} is in none of {settled:?}"
            );
        }
    }

    /// Fault 6.
    #[test]
    fn a_second_xrun_within_the_search_leaves_none_of_the_firsts_time_out() {
        let mut watch = OutputGapWatch::new(35_000.0, RATE_HZ, 1, 0);
        let silence = [0.0; 1000];
        let reports = (0..200_u64).filter_map(|block| {
            let xruns = u64::from(block >= 50) + u64::from(block >= 80);
            watch.take(1000 * block, &silence, xruns)
        });
        let final_reports: Vec<_> = reports.filter(|xrun| xrun.gap != Gap::Sought).collect();
        let [xrun] = final_reports[..] else {
            panic!("{final_reports:?}");
        };
        assert_eq!((xrun.gap, xrun.from), (Gap::Unknown, 30_800));
        assert_eq!((xrun.number, xrun.last), (1, 2));
        assert!(xrun.to >= 80_000 + 48_000, "{xrun:?}");
    }

    /// Fault 6.
    #[test]
    fn the_gaps_of_two_xruns_are_found_together_however_soon_the_second_follows() {
        // The second is reported before the gap of the first is over; its gap comes later.
        let (gaps, reports_at) = ([60_000..60_500_usize, 75_000..75_300], [60_200, 60_300]);
        let mut played = 0_u32;
        let samples: Vec<f32> = (0..140_000)
            .map(|n| {
                let silent = gaps.iter().any(|gap| gap.contains(&n));
                let t_s = f64::from(played) / f64::from(RATE_HZ);
                played += u32::from(!silent);
                let drive = 0.3 * (TAU * 35_000.0 * t_s).sin();
                if silent { 0.0 } else { drive as f32 }
            })
            .collect();
        let mut watch = OutputGapWatch::new(35_000.0, RATE_HZ, 1, 0);
        let reports = samples.chunks(BLOCK).enumerate().filter_map(|(i, block)| {
            let first = i * BLOCK;
            let xruns = reports_at
                .iter()
                .filter(|report_at| **report_at <= first)
                .count();
            watch.take(first as u64, block, xruns as u64)
        });
        let final_reports: Vec<_> = reports.filter(|xrun| xrun.gap != Gap::Sought).collect();
        let [xrun] = final_reports[..] else {
            panic!("{final_reports:?}");
        };
        assert!(xrun.from <= 60_000 && 75_300 <= xrun.to, "{xrun:?}");
        assert_eq!(xrun.gap, Gap::Of(Lost::Exactly(800)));
    }

    #[test]
    fn losses_of_the_input_leave_the_gap_unknown_in_all_the_time_that_it_may_be_in() {
        let mut watch = OutputGapWatch::new(35_000.0, RATE_HZ, 1, 0);
        let silence = [0.0; 1000];
        for first in (0..40_000).step_by(1000) {
            assert_eq!(watch.take(first, &silence, 0), None);
        }
        let open_report = watch.take(40_000, &silence, 1).unwrap();
        let unknown_report = watch.lose().unwrap();
        assert_eq!(
            (open_report.gap, unknown_report.gap),
            (Gap::Sought, Gap::Unknown)
        );
        assert_eq!((unknown_report.from, unknown_report.to), (20_800, 88_000));
        assert_eq!((watch.give_up(), watch.lose()), (None, None));
    }
}
