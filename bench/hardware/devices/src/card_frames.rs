//! Map to the audio clock from the card's count of frames, which leaves out the frames lost in an xrun.

use std::collections::VecDeque;

/// Most stretches kept; each begins where frames were lost.
const KEPT: usize = 64;

/// Maps frames as the card counts them to frames of the audio clock.
#[derive(Debug, Default)]
pub(crate) struct CardFrames {
    /// First card frame of each stretch, and the number of frames to add from there on.
    stretches: VecDeque<(u64, u64)>,
    /// End of the accepted frames, by the card's count.
    end: u64,
}

impl CardFrames {
    /// Notes that the `frames` frames from card frame `card` on are those from `audio` on.
    pub(crate) fn accept(&mut self, card: u64, frames: u64, audio: u64) {
        let lag = audio.saturating_sub(card);
        if self
            .stretches
            .back()
            .is_none_or(|&(_, previous)| previous != lag)
        {
            self.stretches.push_back((card, lag));
            if self.stretches.len() > KEPT {
                self.stretches.pop_front();
            }
        }
        self.end = card + frames;
    }

    /// Returns the frame of the audio clock; `None` until the card's frame has been accepted.
    pub(crate) fn audio(&self, card: f64) -> Option<f64> {
        if card >= self.end as f64 {
            return None;
        }
        let stretch = self
            .stretches
            .iter()
            .rfind(|(from, _)| *from as f64 <= card);
        let (_, lag) = stretch.or(self.stretches.front())?;
        Some(card + *lag as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_before_and_after_a_loss_each_have_their_place() {
        let mut frames = CardFrames::default();
        assert_eq!(frames.audio(0.0), None);
        frames.accept(0, 100, 0);
        frames.accept(100, 100, 100);
        assert_eq!(
            (frames.audio(150.5), frames.audio(200.0)),
            (Some(150.5), None)
        );
        // 37 frames were lost.
        frames.accept(200, 100, 237);
        assert_eq!(frames.audio(199.0), Some(199.0));
        assert_eq!(frames.audio(200.0), Some(237.0));
        assert_eq!(frames.audio(-3.0), Some(-3.0));
        for lost in 0..1000 {
            frames.accept(300 + 10 * lost, 10, 340 + 11 * lost);
        }
        assert_eq!(frames.audio(10_299.0), Some(10_299.0 + 40.0 + 999.0));
        assert!(frames.stretches.len() <= KEPT);
    }
}
