//! Positions of lost and clipped samples of a channel.

use std::collections::VecDeque;
use std::ops::Range;

/// Number and range of flawed samples of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flawed {
    /// Index of the first flawed sample.
    pub first: u64,
    /// Index of the last flawed sample.
    pub last: u64,
    /// Number of flawed samples; sound ones between them are not counted.
    pub samples: u64,
}

/// Flawed samples of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChannelFlaws {
    /// Samples that are NaN or infinite.
    pub lost: Option<Flawed>,
    /// Samples at or above the clip level.
    pub clipped: Option<Flawed>,
}

/// Runs of lost and of clipped samples, oldest first; runs before all later windows are dropped.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flaws {
    lost: VecDeque<Range<u64>>,
    clipped: VecDeque<Range<u64>>,
    fresh: ChannelFlaws,
}

impl Flaws {
    pub(crate) fn note_lost(&mut self, sample: u64) {
        extend(&mut self.lost, sample);
        add(&mut self.fresh.lost, sample);
    }

    pub(crate) fn note_clipped(&mut self, sample: u64) {
        extend(&mut self.clipped, sample);
        add(&mut self.fresh.clipped, sample);
    }

    /// Returns the flaws recorded since the last call.
    pub(crate) fn take_fresh(&mut self) -> ChannelFlaws {
        std::mem::take(&mut self.fresh)
    }

    pub(crate) fn lost_within(&self, window: &Range<u64>) -> bool {
        count(&self.lost, window) > 0
    }

    pub(crate) fn clipped_within(&self, window: &Range<u64>) -> u32 {
        count(&self.clipped, window)
    }

    pub(crate) fn drop_before(&mut self, sample: u64) {
        for runs in [&mut self.lost, &mut self.clipped] {
            while runs.front().is_some_and(|run| run.end <= sample) {
                runs.pop_front();
            }
        }
    }
}

fn add(flawed: &mut Option<Flawed>, sample: u64) {
    let flawed = flawed.get_or_insert(Flawed {
        first: sample,
        last: sample,
        samples: 0,
    });
    flawed.last = sample;
    flawed.samples += 1;
}

fn extend(runs: &mut VecDeque<Range<u64>>, sample: u64) {
    match runs.back_mut() {
        Some(last) if last.end == sample => last.end += 1,
        _ => runs.push_back(sample..sample + 1),
    }
}

fn count(runs: &VecDeque<Range<u64>>, window: &Range<u64>) -> u32 {
    let overlap = |run: &Range<u64>| {
        run.end
            .min(window.end)
            .saturating_sub(run.start.max(window.start))
    };
    runs.iter().map(overlap).sum::<u64>() as u32
}
