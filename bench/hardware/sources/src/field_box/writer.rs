//! Transmitter of the bench's command words to the box.

use std::collections::VecDeque;
use std::io;

use field_box_wire::{Report, ToBox, Word};

use crate::serial::Speaking;

/// Largest number of unacknowledged words kept: more than fit into any time for which a box may be deaf.
const MOST_UNHEARD: usize = 1024;

/// The transmitting end of the box's line.
pub(super) struct Writer {
    port: Speaking,
    word: Word,
    /// Number of the word that last switched the enable on; `None` while it is off.
    enabled_by: Option<u16>,
    /// Whether the box has acknowledged that word; the number itself recurs after 2¹⁶ words.
    enable_heard: bool,
    /// Unacknowledged words with their times, ns.
    unacknowledged: VecDeque<(u16, u64)>,
}

impl Writer {
    pub(super) fn new(port: Speaking) -> Self {
        Self {
            port,
            word: Word {
                sequence: 0,
                enable: false,
                heartbeat: false,
            },
            enabled_by: None,
            enable_heard: false,
            unacknowledged: VecDeque::new(),
        }
    }

    /// Requests the box's identification.
    pub(super) fn ask(&mut self) -> io::Result<()> {
        self.port.write_all(&ToBox::Ask.encode())
    }

    /// Sends the present word with a changed level. Before an enable is switched on, a word without it is sent: a box that
    /// stopped, or restarted since, requires that.
    pub(super) fn say(&mut self, now_ns: u64, change: impl FnOnce(&mut Word)) -> io::Result<()> {
        let previous = self.word;
        change(&mut self.word);
        if self.word.enable && !previous.enable {
            self.unacknowledged.clear();
            let enable_word = std::mem::replace(&mut self.word, previous);
            self.send(now_ns)?;
            self.word = Word {
                sequence: self.word.sequence,
                ..enable_word
            };
            self.enabled_by = Some(self.word.sequence.wrapping_add(1));
            self.enable_heard = false;
        } else if !self.word.enable {
            self.enabled_by = None;
        }
        self.send(now_ns)
    }

    /// Sends the present word with the next number.
    fn send(&mut self, now_ns: u64) -> io::Result<()> {
        self.word.sequence = self.word.sequence.wrapping_add(1);
        if self.unacknowledged.len() == MOST_UNHEARD {
            self.unacknowledged.pop_front();
        }
        self.unacknowledged.push_back((self.word.sequence, now_ns));
        self.port.write_all(&ToBox::Word(self.word).encode())
    }

    /// Records the acknowledgement in `report`; returns whether the box has acknowledged the present enable.
    pub(super) fn acknowledge(&mut self, report: &Report) -> bool {
        // The acknowledged word is one of those sent since, or an earlier one.
        let includes = |number: u16, since: usize| {
            usize::from(report.word_number.wrapping_sub(number)) < since
        };
        while let Some(&(number, _)) = self.unacknowledged.front()
            && includes(number, self.unacknowledged.len())
        {
            self.unacknowledged.pop_front();
        }
        let Some(number) = self.enabled_by else {
            return false;
        };
        let since = usize::from(self.word.sequence.wrapping_sub(number)) + 1;
        self.enable_heard |= includes(number, since);
        self.enable_heard
    }

    /// Returns the age of the oldest unacknowledged word while the enable is on, ns; 0 otherwise.
    pub(super) fn unheard_ns(&self, now_ns: u64) -> u64 {
        let oldest = self
            .unacknowledged
            .front()
            .filter(|_| self.enabled_by.is_some());
        oldest.map_or(0, |(_, said_ns)| now_ns.saturating_sub(*said_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use field_box_wire::Levels;

    /// Time between two words, ns.
    const BEAT_NS: u64 = 2_000_000;

    fn report(word_number: u16) -> Report {
        Report {
            sequence: 0,
            device_us: 0,
            counts: [0; 2],
            position: 0,
            levels: Levels::default(),
            stop: None,
            word_number,
        }
    }

    /// Fault 41.
    #[test]
    fn a_box_that_has_heard_of_the_enable_has_heard_of_it_for_ever() {
        let mut writer = Writer::new(Box::new(io::sink()));
        let mut now_ns = 0;
        let mut beat = |writer: &mut Writer, enable| {
            now_ns += BEAT_NS;
            let beat_word = |word: &mut Word| {
                word.enable = enable;
                word.heartbeat = !word.heartbeat;
            };
            writer.say(now_ns, beat_word).unwrap();
            now_ns
        };
        for armed in 0..2 {
            for _ in 0..9 {
                beat(&mut writer, false);
                assert!(!writer.acknowledge(&report(writer.word.sequence)));
            }
            let previous = writer.word.sequence;
            beat(&mut writer, true);
            assert!(
                !writer.acknowledge(&report(previous)),
                "it speaks of before"
            );
            // Four minutes, in which the numbers recur three times; the box acknowledges one word late.
            for k in 0..120_000u32 {
                let now_ns = beat(&mut writer, true);
                let late = writer.word.sequence.wrapping_sub(1);
                assert!(writer.acknowledge(&report(late)), "{armed}: {k}");
                assert!(writer.unheard_ns(now_ns) <= BEAT_NS);
            }
        }
        // A restarted box acknowledges no word, and none of those that wait.
        for _ in 0..9 {
            beat(&mut writer, true);
        }
        let now_ns = beat(&mut writer, true);
        let unrelated = writer.word.sequence.wrapping_sub(20_000);
        assert!(writer.acknowledge(&report(unrelated)), "it had heard");
        assert!(writer.unheard_ns(now_ns) >= 9 * BEAT_NS);
    }
}
