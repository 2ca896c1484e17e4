//! Connections of a session.

use std::sync::Arc;

use config::Effective;
use crossbeam_channel::{Receiver, Sender};
use devices::DeviceReadings;
use devices::acquisition::RecordingCommand;
use devices::drive_control::DriveControl;
use devices::loudspeaker::Loudspeaker;
use devices::room::Room;
use live::carrier_decision::CarrierDecision;
use live::live_side::LiveSide;
use live::participant_screen::ParticipantScreen;
use operator_ui::console::Front;
use protocols::TrialKey;
use recorder::{Begin, RecorderGauge, RecorderNotice};
use recording::manifest::EventKind;
use recording::pipeline::Batch;
use safety::Signals;
use signalgen::Program;
use tasks::{Slot, StopFlag};
use tui::event::LogLevel;

use super::report::SessionReport;
use crate::apparatus::Watcher;
use journal::EntrySender;
use live::readiness::Readiness;
use participant_displays::Displays;

/// Creates the manifest and the folder of an attempt's recording on the bench in its current state.
pub type BeginRecording =
    Box<dyn FnMut(&TrialKey, &protocols::Drive, &Effective) -> anyhow::Result<Begin> + Send>;

/// Makes a program of a protocol's drive for the bench in its current state.
pub type Admit = Box<dyn Fn(&protocols::Drive, &Effective) -> anyhow::Result<Program> + Send>;

/// Connections of a session.
pub struct Wiring {
    /// Manifest and folder of each recording.
    pub begin: BeginRecording,
    /// Programs of the protocol's drives.
    pub admit: Admit,
    /// Batches from the acquisition.
    pub batches: Receiver<Batch>,
    /// Commands to the acquisition.
    pub recording: Sender<RecordingCommand>,
    /// Notices from the recorder.
    pub notices: Receiver<RecorderNotice>,
    /// The recorder's gauge.
    pub gauge: RecorderGauge,
    /// Free space on the study's disk.
    pub room: Room,
    /// Disk space that a session of this protocol may take, bytes.
    pub session_bytes: u64,
    /// The drive.
    pub drive: DriveControl,
    /// Source of the participant's "ready".
    pub readiness: Readiness,
    /// The operator's front end.
    pub front: Box<dyn Front>,
    /// Observers of the participant's view and tones.
    pub watchers: Vec<Watcher>,
    /// The participant's displays.
    pub displays: Displays,
    /// The part of the participant's screen that stays the same through the session.
    pub screen: ParticipantScreen,
    /// The participant's loudspeaker.
    pub sound: Option<Loudspeaker>,
    /// The session's log.
    pub journal: EntrySender,
    /// Live values, and the contact from the fits after each trial.
    pub live: LiveSide,
    /// The decision on a new carrier.
    pub carrier: CarrierDecision,
    /// The carrier, once it has changed, Hz.
    pub carrier_hz: Arc<Slot<f64>>,
    /// Signals that the safety watch judges.
    pub signals: Arc<Signals>,
    /// Gauges for the screen.
    pub gauges: Arc<DeviceReadings>,
    /// Ends the bench.
    pub stop: StopFlag,
    /// Receives the report at the end.
    pub report: Sender<SessionReport>,
}

impl Wiring {
    /// Shows a line to the operator.
    pub(super) fn log(&mut self, level: LogLevel, text: impl Into<String>) {
        let text = text.into();
        self.front.show(tui::Event::Log { level, text });
    }

    /// Sends a command to the acquisition, which ends before the session only if it failed, and that stops the bench.
    pub(super) fn send(&self, command: RecordingCommand) {
        let _ = self.recording.send(command);
    }

    /// Adds an event to the open recording, if there is one.
    pub(super) fn mark(&self, kind: EventKind, text: impl Into<String>) {
        self.send(RecordingCommand::Event(kind, Some(text.into())));
    }

    /// Turns the masking noise for the participant on or off.
    pub(super) fn mask(&self, is_masked: bool) {
        if let Some(sound) = &self.sound {
            sound.mask(is_masked);
        }
    }

    /// Returns how far the recorder or the log is behind the session, s, the greater of the two.
    pub(super) fn behind_s(&self) -> f64 {
        self.gauge.behind_s().max(self.journal.behind_s())
    }

    /// Reconnects the participant's display if it is lost and does not reconnect automatically.
    pub(super) fn reconnect_displays(&mut self) {
        for text in self.displays.reconnect() {
            self.log(LogLevel::Error, text);
        }
        self.look_at_displays();
    }

    /// Reports notices and losses of the displays to the operator.
    pub(super) fn look_at_displays(&mut self) {
        for (level, text) in self.displays.notices() {
            self.log(level, text);
        }
        if self.displays.look() {
            let lost = self.displays.loss().map(str::to_owned);
            self.front.show(tui::Event::ParticipantDisplay { lost });
        }
    }

    /// Returns the time until the hour's driving time allows another trial, s.
    pub(super) fn drive_wait_s(&self) -> f64 {
        self.signals.dose.get().map_or(0.0, |dose| dose.wait_s)
    }
}
