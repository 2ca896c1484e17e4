//! What the bench says to the box.

use std::collections::VecDeque;
use std::io;

use field_box_wire::{Report, ToBox, Word};

use crate::serial::Speaking;

/// Most words whose sending is remembered: more than come within any time for which a box may be deaf.
const MOST_UNHEARD: usize = 1024;

/// The speaking end of the box's line.
pub(super) struct Writer {
    port: Speaking,
    word: Word,
    /// Number of the word that last turned the enable on; `None` while it is off.
    enabled_by: Option<u16>,
    /// Words that the box has not acted on, as far as it has said, with their times, ns.
    unheard: VecDeque<(u16, u64)>,
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
            unheard: VecDeque::new(),
        }
    }

    /// Asks who the box is.
    pub(super) fn ask(&mut self) -> io::Result<()> {
        self.port.write_all(&ToBox::Ask.encode())
    }

    /// Says the present word with a changed level. An enable that is turned on is let go of first: a box that stopped, or
    /// was powered since, wants that.
    pub(super) fn say(&mut self, now_ns: u64, change: impl FnOnce(&mut Word)) -> io::Result<()> {
        let before = self.word;
        change(&mut self.word);
        if self.word.enable && !before.enable {
            self.unheard.clear();
            let on = std::mem::replace(&mut self.word, before);
            self.send(now_ns)?;
            self.word = Word {
                sequence: self.word.sequence,
                ..on
            };
            self.enabled_by = Some(self.word.sequence.wrapping_add(1));
        } else if !self.word.enable {
            self.enabled_by = None;
        }
        self.send(now_ns)
    }

    /// Sends the present word under the next number.
    fn send(&mut self, now_ns: u64) -> io::Result<()> {
        self.word.sequence = self.word.sequence.wrapping_add(1);
        if self.unheard.len() == MOST_UNHEARD {
            self.unheard.pop_front();
        }
        self.unheard.push_back((self.word.sequence, now_ns));
        self.port.write_all(&ToBox::Word(self.word).encode())
    }

    /// Takes what the box says that it has heard; returns whether the report is of a box that has heard of the enable
    /// that is on.
    pub(super) fn heard(&mut self, report: &Report) -> bool {
        let includes = |number: u16| report.heard.wrapping_sub(number) < u16::MAX / 2;
        while let Some(&(number, _)) = self.unheard.front()
            && includes(number)
        {
            self.unheard.pop_front();
        }
        self.enabled_by.is_some_and(includes)
    }

    /// Returns for how long the oldest word has not been heard while the enable is on, ns.
    pub(super) fn unheard_ns(&self, now_ns: u64) -> u64 {
        let oldest = self.unheard.front().filter(|_| self.enabled_by.is_some());
        oldest.map_or(0, |(_, said_ns)| now_ns.saturating_sub(*said_ns))
    }
}
