//! The apparatus selected by the command line: the hardware, and the observers and hands around it.

use std::path::PathBuf;

use calibration_rig::operator::Hands;
use config::{AudioHost, Config};
use devices::Hardware;
use safety::Pace;

use crate::cli;
use participant_displays::Displays;

pub use live::monitor_task::Watcher;

/// The hardware of a bench, real or simulated, with the observers and hands around it.
pub struct BenchHardware {
    /// The bench itself.
    pub hardware: Hardware,
    /// Observers of the participant's view and tones.
    pub watchers: Vec<Watcher>,
    /// The participant's displays.
    pub displays: Displays,
    /// Performs a calibration's requests to its operator; `None` if a person must.
    pub hands: Option<Hands>,
    /// Port of the simulated vibrometer, the source of known amplitudes if no other is named.
    pub vibrometer_port: Option<PathBuf>,
    /// Port of the simulated voltmeter, for a check of the volts; `None` if that needs a real meter.
    pub voltmeter_port: Option<PathBuf>,
    /// Presses the e-stop and releases it after a moment; `None` if a person must.
    pub estop_hand: Option<Box<dyn FnOnce() + Send>>,
    /// Injected faults, in the form of `--fault`; measurements are then a rehearsal.
    pub rehearsed: Vec<String>,
    /// Injects faults into simulated hardware; `None` if a person must.
    pub fault_hand: Option<drill::FaultHand>,
}

/// Prefix of the names of JACK servers that tests run without a card.
const TEST_SERVER: &str = "friction-bench-test";

/// Returns the pace of the sound card of these options.
#[must_use]
pub fn pace(config: &Config, options: &cli::HardwareOptions) -> Pace {
    let is_test_server = || {
        let server = std::env::var("JACK_DEFAULT_SERVER").unwrap_or_default();
        config.audio.host == AudioHost::Jack && server.starts_with(TEST_SERVER)
    };
    if options.mock.is_some() || is_test_server() {
        Pace::Simulated
    } else {
        Pace::Card
    }
}
