//! Check that the sound card keeps its rate: a device that is not a sound card delivers as fast as it is read.

use anyhow::bail;
use signalgen::BlockHeader;

/// Largest number of frames, as a multiple of those that the rate allows.
const FACTOR: f64 = 3.0;
/// Length of a backlog that may come at once, as after the computer stood still, s.
const BACKLOG_S: f64 = 5.0;

/// Compares the frames that the card delivers with the time that passes.
#[derive(Debug)]
pub struct CardPace {
    rate_hz: f64,
    /// First frame, and its arrival, ns.
    start: Option<(u64, u64)>,
}

impl CardPace {
    /// Counts from the first block on.
    #[must_use]
    pub fn new(rate_hz: f64) -> Self {
        Self {
            rate_hz,
            start: None,
        }
    }

    /// Takes the next block, read at `now_ns` by the bench's clock.
    ///
    /// # Errors
    /// If the card has delivered far more than its rate allows.
    pub fn take(&mut self, header: &BlockHeader, now_ns: u64) -> anyhow::Result<()> {
        let (frame, began_ns) = *self.start.get_or_insert((header.first_frame, now_ns));
        let passed_s = now_ns.saturating_sub(began_ns) as f64 * 1e-9;
        let delivered_s = header.first_frame.saturating_sub(frame) as f64 / self.rate_hz;
        if delivered_s > FACTOR * passed_s + BACKLOG_S {
            bail!(
                "the sound card delivered {delivered_s:.0} s of samples within {passed_s:.1} s: it is not a sound card \
                 (alsa:null discards and invents samples), or it runs at another rate; name another device as \
                 audio.input_device and audio.output_device in bench.toml, see `friction-bench devices`"
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signalgen::{BlockTime, DriveState};

    fn header(first_frame: u64) -> BlockHeader {
        BlockHeader {
            first_frame,
            frames: 256,
            dropped_frames: 0,
            time: BlockTime::default(),
            arrived_ns: 0,
            input_xruns: 0,
            output_xruns: 0,
            drive: DriveState::default(),
        }
    }

    #[test]
    fn a_card_keeps_its_rate_and_catches_up_and_a_null_device_does_not() {
        let rate_hz = 192_000.0;
        for (speed, keeps) in [(1.0, true), (1.0001, true), (2.0, true), (100.0, false)] {
            let mut pace = CardPace::new(rate_hz);
            let is_kept = (0..100u64).all(|i| {
                let now_ns = i * 100_000_000;
                let frame = (now_ns as f64 * 1e-9 * rate_hz * speed) as u64;
                pace.take(&header(frame), now_ns).is_ok()
            });
            assert_eq!(is_kept, keeps, "{speed}");
        }
        // Four seconds at once, after the computer stood still.
        let mut pace = CardPace::new(rate_hz);
        pace.take(&header(0), 1_000).unwrap();
        pace.take(&header(768_000), 2_000).unwrap();
    }
}
