//! State of the bench's lines, and its lost devices.

use drawing::numbers::ago;

use crate::bench_facts::BenchLine;

/// State of the bench's lines; `None` for a line that is not wired or not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineStates {
    /// Whether the e-stop's loop is open: pressed or cut.
    pub estop_open: Option<bool>,
    /// Whether the heartbeat is running.
    pub heartbeat_beats: Option<bool>,
    /// Whether the participant's button is pressed.
    pub button_pressed: Option<bool>,
    /// Number of presses of the button so far.
    pub button_presses: u64,
    /// Time since the e-stop's loop was last open, s.
    pub estop_open_ago_s: Option<f64>,
    /// Time since the button was last pressed, s.
    pub button_press_ago_s: Option<f64>,
}

impl LineStates {
    /// Describes the present and the last state of `line`; also returns whether the plate may be driven in that state.
    #[must_use]
    pub fn describe(&self, line: BenchLine) -> Option<(String, bool)> {
        let presses = match self.button_presses {
            1 => "pressed".to_owned(),
            count => format!("pressed ×{count},"),
        };
        let (on, (yes, no), well, last) = match line {
            BenchLine::Estop => {
                let last = self.estop_open_ago_s.map(|s| format!("open {}", ago(s)));
                (self.estop_open?, ("PRESSED OR CUT", "closed"), false, last)
            }
            BenchLine::Heartbeat => (self.heartbeat_beats?, ("beats", "no beats"), true, None),
            BenchLine::Button => {
                let last = self.button_press_ago_s;
                let last = last.map(|s| format!("{presses} {}", ago(s)));
                (self.button_pressed?, ("pressed", "not pressed"), true, last)
            }
            BenchLine::Encoder | BenchLine::ForceSensor | BenchLine::SoundCard => return None,
        };
        Some(match last {
            _ if on => (yes.to_owned(), well),
            Some(last) => (format!("{no}; {last}"), true),
            None => (no.to_owned(), true),
        })
    }
}

/// Devices that the program has lost and does not open again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LostDevices {
    /// Whether the force sensor is lost.
    pub force_sensor: bool,
    /// Whether the encoder is lost.
    pub encoder: bool,
    /// Whether the sound card is lost.
    pub sound_card: bool,
}

impl LostDevices {
    /// Returns whether `line` is a lost device.
    #[must_use]
    pub fn includes(self, line: BenchLine) -> bool {
        match line {
            BenchLine::ForceSensor => self.force_sensor,
            BenchLine::Encoder => self.encoder,
            BenchLine::SoundCard => self.sound_card,
            BenchLine::Estop | BenchLine::Heartbeat | BenchLine::Button => false,
        }
    }

    /// Returns whether a device is lost.
    #[must_use]
    pub fn any(self) -> bool {
        self != Self::default()
    }
}
