//! Check that the sound card still delivers.

use anyhow::bail;

/// Time without audio after which the card counts as gone, ns.
const CARD_TIMEOUT_NS: u64 = 10_000_000_000;
/// Longest time between two polls that counts as silence of the card, ns: during a longer one the program was stopped.
const LONGEST_LOOK_NS: u64 = 100_000_000;

/// Time for which the card has delivered nothing; the safety watch stops the drive long before it ends the program.
#[derive(Default)]
pub(crate) struct CardSilence {
    looked_ns: Option<u64>,
    lasts_ns: u64,
}

impl CardSilence {
    /// Takes a poll at `now_ns`.
    ///
    /// # Errors
    /// If the card has been silent for too long.
    pub(crate) fn require_alive(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let previous_ns = self.looked_ns.replace(now_ns).unwrap_or(now_ns);
        self.lasts_ns += now_ns.saturating_sub(previous_ns).min(LONGEST_LOOK_NS);
        if self.lasts_ns >= CARD_TIMEOUT_NS {
            bail!(
                "the sound card has delivered nothing for {} s: is it still plugged in and switched on? \
                 `friction-bench devices` lists the connected devices; the recording up to then is kept",
                CARD_TIMEOUT_NS / 1_000_000_000
            );
        }
        Ok(())
    }

    /// Notes that a block has arrived.
    pub(crate) fn end(&mut self) {
        self.lasts_ns = 0;
    }
}
