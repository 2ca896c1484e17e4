//! What the composition root makes of the command line: the hardware, and who stands around it.

use std::path::PathBuf;

use calibration::operator::Hands;
use config::{AudioHost, Config};
use devices::Hardware;
use devices::loudspeaker::Tone;
use safety::Pace;

use crate::cli;
use crate::displays::Displays;

/// Is told what the participant sees and hears: a simulated person.
pub type Watcher = Box<dyn FnMut(&tui::ParticipantView, bool, Option<Tone>) + Send>;

/// The hardware of a bench, real or simulated, and who stands around it.
pub struct Apparatus {
    /// The bench itself.
    pub hardware: Hardware,
    /// Who else sees and hears what the participant does.
    pub watchers: Vec<Watcher>,
    /// What the participant sees.
    pub displays: Displays,
    /// Does what a calibration asks of its operator; `None` where that takes a person.
    pub hands: Option<Hands>,
    /// The simulated vibrometer's port, where known amplitudes come from when no other source is named.
    pub vibrometer_port: Option<PathBuf>,
    /// The simulated voltmeter's port, where a check of the volts reads; `None` where that takes a meter.
    pub voltmeter_port: Option<PathBuf>,
    /// Presses and releases the e-stop after a moment; `None` where that takes a person.
    pub estop_hand: Option<Box<dyn FnOnce() + Send>>,
    /// Faults that are injected, in the form of `--fault`: what is measured is a rehearsal.
    pub rehearsed: Vec<String>,
    /// Brings faults over simulated hardware; `None` where that takes a person.
    pub fault_hand: Option<drill::FaultHand>,
}

/// Beginning of the names of JACK servers that tests run without a card.
const TEST_SERVER: &str = "friction-bench-test";

/// Returns what lets time pass for the sound card of these options.
#[must_use]
pub fn pace(config: &Config, options: &cli::Hardware) -> Pace {
    let of_a_test = || {
        let server = std::env::var("JACK_DEFAULT_SERVER").unwrap_or_default();
        config.audio.host == AudioHost::Jack && server.starts_with(TEST_SERVER)
    };
    if options.mock.is_some() || of_a_test() {
        Pace::Simulated
    } else {
        Pace::Card
    }
}
