//! Where the samples of a channel are lost or clipped.

use std::collections::VecDeque;
use std::ops::Range;

/// Runs of lost and of clipped samples, oldest first; what lies behind every later window is forgotten.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flaws {
    lost: VecDeque<Range<u64>>,
    clipped: VecDeque<Range<u64>>,
}

impl Flaws {
    pub(crate) fn note_lost(&mut self, sample: u64) {
        extend(&mut self.lost, sample);
    }

    pub(crate) fn note_clipped(&mut self, sample: u64) {
        extend(&mut self.clipped, sample);
    }

    pub(crate) fn lost_within(&self, window: &Range<u64>) -> bool {
        count(&self.lost, window) > 0
    }

    pub(crate) fn clipped_within(&self, window: &Range<u64>) -> u32 {
        count(&self.clipped, window)
    }

    pub(crate) fn forget_before(&mut self, sample: u64) {
        for runs in [&mut self.lost, &mut self.clipped] {
            while runs.front().is_some_and(|run| run.end <= sample) {
                runs.pop_front();
            }
        }
    }
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
