//! The tasks of a session, wired to the bench.

use std::sync::Arc;

use analysis::amplitude_profile::AmplitudeProfile;
use anyhow::Context;
use contact::AssumedConstants;
use crossbeam_channel::Receiver;
use devices::drive_control::waveform;
use devices::loudspeaker::Loudspeaker;
use devices::recorded_bench::{recorded_plate, recorded_room};
use devices::room::RoomTask;
use devices::{Bench, DeviceReadings, Life, ThreadPriorities};
use live::carrier_decision::CarrierDecision;
use live::interference::Interference;
use live::live_side::LiveSide;
use live::participant_screen::ParticipantScreen;
use live::participant_skin::ParticipantSkin;
use live::readiness::Readiness;
use live::refit::Refit;
use operator_ui::console::{DashboardThread, Front};
use protocols::{SessionEvent, SessionEventKind};
use recorder::RecorderGauge;
use recording::manifest::RecordedRoom;
use safety::Signals;
use signalgen::DriveSettings;
use tasks::{Slot, Task};

use super::files::begin_recording;
use super::participant_session::ParticipantSession;
use super::plan::SessionPlan;
use crate::apparatus::Watcher;
use crate::session::{Admit, KeptUp, Questions, SessionReport, SessionTask, Wiring};
use journal::{Entry, Journal, entry_queue};
use participant_displays::Displays;

/// Error of a session with a failed part.
const FAILED: &str = "a part of the bench failed and the session ended; its recordings are kept, and the same command with --resume goes on";

/// Everything around the bench that a session shows itself on.
pub(super) struct Surroundings {
    pub(super) front: Box<dyn Front>,
    pub(super) watchers: Vec<Watcher>,
    pub(super) displays: Displays,
    pub(super) sound: Option<Loudspeaker>,
}

/// A session ready to run.
pub(super) struct ComposedSession {
    life: Life,
    tasks: Vec<Box<dyn Task>>,
    report: Receiver<SessionReport>,
    signals: Arc<Signals>,
    gauges: Arc<DeviceReadings>,
    recorder: RecorderGauge,
}

impl ComposedSession {
    /// Wires the tasks. `protocol_file` is the session's copy of the protocol.
    ///
    /// # Errors
    /// The session's log cannot be written.
    pub(super) fn new(
        plan: &SessionPlan,
        session: ParticipantSession,
        protocol_file: String,
        bench: Bench,
        surroundings: Surroundings,
    ) -> anyhow::Result<Self> {
        let (effective, protocol) = (plan.bench.clone(), &plan.protocol.protocol);
        let config = effective.config();
        let Surroundings {
            front,
            watchers,
            mut displays,
            sound,
        } = surroundings;
        let Bench {
            life,
            drive,
            batches,
            recording,
            notices,
            gauge,
            button,
            field_box,
            signals,
            gauges,
            first_tasks,
            last_tasks,
            has_position: _,
        } = bench;
        let begin = {
            let (signals, gauges) = (signals.clone(), gauges.clone());
            let priorities = move || ThreadPriorities::now(&signals, &gauges);
            let folder = session.folder.folder().to_owned();
            let file = (session.number, protocol_file);
            begin_recording(plan, file, folder, (&life, field_box), priorities)
        };
        let (entries, journal_entries) = entry_queue();
        for record in session.withdrawn {
            let kind = SessionEventKind::TrialSettled { record };
            entries.send(Entry::Event(SessionEvent { t_s: 0.0, kind }));
        }
        let (reports, report) = crossbeam_channel::bounded(1);
        let (live, refit) = live_side(plan, session.resumed.skin);
        let carrier_hz: Arc<Slot<f64>> = Arc::default();
        let interference = Interference::new(recording.clone(), config, plan.carrier_hz)
            .following(carrier_hz.clone());
        let at_displays = displays.tasks(&entries);
        let (room, look_for_room) = RoomTask::new(plan.study.clone());
        let wiring = Wiring {
            begin,
            admit: admission(plan.settings),
            batches,
            recording,
            notices: notices.clone(),
            gauge: gauge.clone(),
            room,
            session_bytes: protocol_check::session_bytes(config, protocol),
            drive,
            screen: ParticipantScreen::new(protocol, config.plate.length_m, button.is_none()),
            readiness: Readiness::new(button),
            front,
            watchers,
            displays,
            sound,
            journal: entries,
            live,
            carrier: CarrierDecision::new(
                protocol,
                &effective,
                plan.require_drivable(),
                !plan.headless,
            )
            .resume(session.resumed.carrier, &effective),
            carrier_hz,
            signals: signals.clone(),
            gauges: gauges.clone(),
            stop: life.stop().clone(),
            report: reports,
        };
        // A session without an operator asks nobody.
        let ask = if plan.headless {
            Vec::new()
        } else {
            session.ask
        };
        let task = SessionTask::new(
            session.machine,
            plan.bench.clone(),
            wiring,
            plan.consent_by.clone(),
            Questions::new(ask),
            plan.headless,
        );
        let journal = Journal::new(
            (session.study, plan.participant.clone()),
            session.folder,
            journal_entries,
            notices,
            life.clock().clone(),
        )?;
        let mut tasks = first_tasks;
        tasks.push(Box::new(task));
        tasks.push(Box::new(refit));
        tasks.push(Box::new(interference));
        tasks.push(Box::new(look_for_room));
        tasks.extend(at_displays);
        tasks.extend(last_tasks);
        tasks.push(Box::new(journal));
        Ok(Self {
            life,
            tasks,
            report,
            signals,
            gauges,
            recorder: gauge,
        })
    }

    /// Runs the tasks to their end and waits for the operator's screen; returns the report.
    ///
    /// # Errors
    /// A task failed.
    pub(super) fn run(
        self,
        dashboard: Option<DashboardThread>,
    ) -> anyhow::Result<(SessionReport, KeptUp)> {
        let close_screen = || dashboard.map_or(Ok(()), DashboardThread::join);
        let is_simulated = self.life.clock().is_simulated();
        self.life.run(self.tasks, close_screen).context(FAILED)?;
        let report = self
            .report
            .try_recv()
            .context("the session ended without a report")?;
        let mut kept_up = KeptUp::read(&self.signals, &self.gauges, &self.recorder);
        if is_simulated {
            // A simulated clock may run faster than the disk.
            kept_up.recorder_lag_s = None;
        }
        Ok((report, kept_up))
    }
}

/// Returns the check and conversion of the protocol's drives for the bench in its current state.
fn admission(settings: DriveSettings) -> Admit {
    Box::new(move |drive, bench| Ok(settings.admit(waveform(drive, bench.config()))?))
}

/// Returns the live side, and the task of its fits; both continue from the participant's skin so far.
fn live_side(plan: &SessionPlan, skin: ParticipantSkin) -> (LiveSide, Refit) {
    let profile = AmplitudeProfile::from(&recorded_plate(&plan.bench));
    let room = recorded_room(plan.bench.config());
    let measured_pa = room.map(RecordedRoom::ambient_pressure_pa);
    let assumed = AssumedConstants::ESTIMATION.with_measured_pressure(measured_pa);
    let (refits, fits, refit) = Refit::new(assumed, profile, skin);
    let contact_n = plan.protocol.protocol.force.contact_n;
    let modal_mass_kg = plan.bench.config().plate.modal_mass_kg;
    (
        LiveSide::new(contact_n, modal_mass_kg, (refits, fits)),
        refit,
    )
}
