//! What the composition root makes of the command line: the hardware, and who stands around it.

use std::path::PathBuf;

use calibration::operator::Hands;
use devices::Hardware;
use devices::loudspeaker::Tone;

/// Is told what the participant sees and hears: a display, a simulated person.
pub type Watcher = Box<dyn FnMut(&tui::ParticipantView, bool, Option<Tone>) + Send>;

/// The hardware of a bench, real or simulated, and who stands around it.
pub struct Apparatus {
    /// The bench itself.
    pub hardware: Hardware,
    /// Who else sees and hears what the participant does.
    pub watchers: Vec<Watcher>,
    /// Does what a calibration asks of its operator; `None` where that takes a person.
    pub hands: Option<Hands>,
    /// The simulated vibrometer's port, where known amplitudes come from when no other source is named.
    pub vibrometer_port: Option<PathBuf>,
}
