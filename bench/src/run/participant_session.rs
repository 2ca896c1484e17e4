//! The session on the disk, from its folder to the start of its log.

use std::collections::BTreeMap;
use std::sync::Arc;

use ::study::sessions;
use devices::Life;
use live::resumed::Resumed;
use protocols::{NOT_STATED, Person, PersonDetail, Session, TrialRecord};
use recording::study::event_log::Start;
use recording::study::{self, GeneratedBy, SessionFolder, Study};
use signalgen::StreamDirection;
use tasks::Clock;

use super::edited_protocol::{accepted_edits, file_name};
use super::files::{EarlierPart, earlier_history, machine, open_session};
use super::lost_recordings;
use super::plan::{NAME, SessionPlan, VERSION};

/// A session with its folder, locked for this program.
pub(super) struct ParticipantSession {
    pub(super) study: Study,
    pub(super) folder: SessionFolder,
    pub(super) number: u32,
    is_resumed: bool,
    pub(super) machine: Session,
    /// Attempts that no longer count as accepted, because their recordings are lost.
    pub(super) withdrawn: Vec<TrialRecord>,
    pub(super) resumed: Resumed,
    /// History of the earlier parts.
    pub(super) history: sessions::LoggedSession,
    /// Details of the participant in the study's table.
    pub(super) person: Person,
    /// Details to ask for.
    pub(super) ask: Vec<PersonDetail>,
    clock: Arc<dyn Clock>,
}

impl ParticipantSession {
    /// Opens the session's folder and restores the state of its earlier part.
    ///
    /// # Errors
    /// The study cannot be opened or has too little space, or the session cannot begin or be resumed.
    pub(super) fn open(
        plan: &SessionPlan,
        earlier: &EarlierPart,
        clock: Arc<dyn Clock>,
    ) -> anyhow::Result<Self> {
        let protocol = &plan.protocol.protocol;
        let generator = GeneratedBy {
            name: NAME.to_owned(),
            version: VERSION.to_owned(),
        };
        let study = Study::open_or_create(&plan.study, generator)?;
        study::require_room(
            &plan.study,
            protocol_check::session_bytes(plan.bench.config(), protocol),
        )?;
        let date = clock.day();
        let (number, folder, is_resumed) = open_session(&study, plan, &date)?;
        let history = earlier_history(plan, &folder);
        let mut machine = machine(plan, &folder, &history)?;
        let practice_trials = protocol.trials.practice;
        let withdrawn = lost_recordings::withdrawn(&mut machine, &earlier.losses, practice_trials);
        let resumed = Resumed::from_history(&history);
        study.describe(&plan.participant, &plan.person)?;
        let person = study.person(&plan.participant)?;
        let mut ask = plan.ask.clone();
        ask.retain(|detail| person.text(*detail) == NOT_STATED);
        Ok(Self {
            study,
            folder,
            number,
            is_resumed,
            machine,
            withdrawn,
            resumed,
            history,
            person,
            ask,
            clock,
        })
    }

    /// Copies the effective files into the folder and starts the log; returns the name of the protocol's copy.
    ///
    /// # Errors
    /// The protocol was edited, or a file cannot be written.
    pub(super) fn start(
        &mut self,
        plan: &SessionPlan,
        life: &Life,
        simulated: bool,
    ) -> anyhow::Result<String> {
        let (config, protocol) = (plan.bench.config(), &plan.protocol);
        let calibration = plan.bench.calibration();
        let name = &protocol.protocol.name;
        let protocol_edits = accepted_edits(plan, &self.folder, self.history.last_start.as_ref())?;
        let copy = self
            .folder
            .snapshot(&format!("{name}.toml"), &protocol.text)?;
        let protocol_file = file_name(&copy);
        self.folder.snapshot("bench.toml", &config.to_toml()?)?;
        if let Some(calibration) = calibration {
            self.folder
                .snapshot("calibration.toml", calibration.text())?;
        }
        let devices = [
            ("audio input", life.device(StreamDirection::Input)),
            ("audio output", life.device(StreamDirection::Output)),
            ("simulated", simulated.to_string()),
        ];
        let devices = devices.map(|(key, device)| (key.to_owned(), device));
        let copies = self.folder.copies()?;
        self.folder.log().start(Start {
            time: self.clock.utc().to_string(),
            resumed: self.is_resumed,
            participant: plan.participant.to_string(),
            session: self.number,
            protocol: name.clone(),
            protocol_file: Some(protocol_file.clone()),
            protocol_edits,
            copies,
            seed: plan.seed,
            software: NAME.to_owned(),
            version: VERSION.to_owned(),
            devices: BTreeMap::from(devices),
            calibration: calibration
                .map(|file| format!("{}, sha256 {}", file.label(), file.hash())),
            configuration: serde_json::to_value(config)?,
            rehearsed: plan.rehearsed.clone(),
            preflight: serde_json::to_value(plan.preflight.as_ref().map(|table| &table.rows))?,
        })?;
        Ok(protocol_file)
    }
}
