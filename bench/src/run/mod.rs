//! `run`: a participant's session, from the files to the last line of the summary.

mod edited_protocol;
mod files;
mod lost_recordings;
mod plan;
pub(crate) mod recorded_plate;

use drill::rehearsed;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use analysis::amplitude_profile::AmplitudeProfile;
use anyhow::Context;
use config::{Config, Effective};
use contact::AssumedConstants;
use devices::drive_control::waveform;
use devices::driving_time;
use devices::loudspeaker::Loudspeaker;
use devices::room::RoomTask;
use devices::{Bench, Boot, Life, ThreadPriorities};
use jiff::tz::TimeZone;
use operator_ui::console::{Dashboard, DashboardThread, Front, Headless, Lines, StopKeys};
use protocols::{NOT_STATED, ParticipantId, PersonDetail, Protocol, SessionEvent};
use recording::study::event_log::Start;
use recording::study::{self, GeneratedBy, Study};
use signalgen::StreamDirection;
use tasks::Slot;
use tui::event::LogLevel::{self, Info, Warning};

use crate::apparatus::Apparatus;
use crate::session::{KeptUp, Questions, Report, SessionTask, Wiring, summary_lines};
use escaping::quoted;
use files::{EarlierPart, begin_recording, earlier_part, machine, open_session, past_crops};
use journal::{Entry, Journal, entry_queue};
use live::carrier_decision::CarrierDecision;
use live::interference::Interference;
use live::live_side::LiveSide;
use live::participant_screen::ParticipantScreen;
use live::past_trials::past_trials;
use live::readiness::Readiness;
use live::refit::Refit;
use live::resumed::Resumed;
use plan::{NAME, VERSION};
use recorded_plate::recorded_profile;

pub use plan::{Plan, ProtocolFile, session_bytes};

/// Runs the session to its end. `open_front` opens the operator's screen; quitting that screen ends the bench.
///
/// # Errors
/// When a part of the bench is missing or fails; a session that ends early for other reasons is a [`Report`].
pub fn run(
    plan: Plan,
    apparatus: Apparatus,
    open_front: impl FnOnce(&Plan, &Life) -> anyhow::Result<SessionFront>,
) -> anyhow::Result<(Report, KeptUp)> {
    let Apparatus {
        hardware,
        watchers,
        mut displays,
        hands: _,
        vibrometer_port: _,
        voltmeter_port: _,
        estop_hand: _,
        rehearsed: _,
        fault_hand: _,
    } = apparatus;
    let simulated = hardware.simulated;
    let effective = plan.bench.clone();
    let config = effective.config();
    let facts = operator_ui::bench_page::facts(config, effective.file(), &hardware);
    let protocol = &plan.protocol.protocol;
    // Before the sound card waits to be read.
    let earlier = if plan.resume {
        earlier_part(&plan)?
    } else {
        EarlierPart::default()
    };
    let crops = if plan.resume && !plan.headless {
        past_crops(&plan)?
    } else {
        Vec::new()
    };
    let driving = protocol.driving_time();
    let participant_folder = plan.study.join(plan.participant.as_str());
    let ledger = driving_time::of_participant(
        &participant_folder,
        &plan.calibration,
        config,
        &driving,
        &hardware,
    )?;
    let clock = hardware.clock.clone();
    if !plan.resume {
        driving_time::require_left(&ledger, driving.hour_s, clock.as_ref())?;
    }
    let mut bench = Bench::open(&effective, plan.carrier_hz, hardware)?;
    bench.require_calibration_holds(&effective)?;
    let stop = bench.stop().clone();

    let generator = GeneratedBy {
        name: NAME.to_owned(),
        version: VERSION.to_owned(),
    };
    let study = Study::open_or_create(&plan.study, generator)?;
    study::require_room(&plan.study, session_bytes(config, protocol))?;
    let date = clock.utc().to_zoned(TimeZone::UTC).date().to_string();
    let (number, session, resumed) = open_session(&study, &plan, &date)?;
    let mut machine = machine(&plan, &session)?;
    let withdrawn =
        lost_recordings::withdrawn(&mut machine, &earlier.losses, protocol.trials.practice);
    let resumption = Resumed::from_documents(&session.earlier_log().documents);
    study.describe(&plan.participant, &plan.person)?;
    let recorded_person = study.person(&plan.participant)?;
    let mut ask = plan.ask.clone();
    ask.retain(|detail| recorded_person.text(*detail) == NOT_STATED);
    let to_drive_s = driving.trial_s * f64::from(machine.trials_left());
    let left = driving_time::require_left(&ledger, to_drive_s.min(driving.hour_s), clock.as_ref())?;
    bench.charge(ledger, Boot::now())?;
    let Bench {
        life,
        drive,
        batches,
        recording,
        notices,
        gauge,
        button,
        has_position,
        field_box,
        signals,
        gauges,
        first_tasks,
        last_tasks,
    } = bench;
    let mut session = session;
    let protocol_edits = edited_protocol::accepted_edits(&plan, &session)?;
    let followed = session.snapshot(&format!("{}.toml", protocol.name), &plan.protocol.text)?;
    let protocol_file = edited_protocol::file_name(&followed);
    session.snapshot("bench.toml", &config.to_toml()?)?;
    if let Some(calibration) = effective.calibration() {
        session.snapshot("calibration.toml", calibration.text())?;
    }
    session.log().start(Start {
        time: clock.utc().to_string(),
        resumed,
        participant: plan.participant.to_string(),
        session: number,
        protocol: protocol.name.clone(),
        protocol_file: Some(protocol_file.clone()),
        protocol_edits,
        seed: plan.seed,
        software: NAME.to_owned(),
        version: VERSION.to_owned(),
        devices: BTreeMap::from([
            (
                "audio input".to_owned(),
                life.device(StreamDirection::Input),
            ),
            (
                "audio output".to_owned(),
                life.device(StreamDirection::Output),
            ),
            ("simulated".to_owned(), simulated.to_string()),
        ]),
        calibration: effective
            .calibration()
            .map(|calibration| format!("{}, sha256 {}", calibration.label(), calibration.hash())),
        configuration: serde_json::to_value(config)?,
        rehearsed: plan.rehearsed.clone(),
        preflight: serde_json::to_value(plan.preflight.as_ref().map(|table| &table.rows))?,
    })?;
    let priorities = {
        let (signals, gauges) = (signals.clone(), gauges.clone());
        move || ThreadPriorities::now(&signals, &gauges)
    };
    let folder = session.folder().to_owned();
    let begin = begin_recording(
        &plan,
        (number, protocol_file),
        folder,
        (&life, field_box),
        priorities,
    );

    let (mut front, dashboard) = open_front(&plan, &life)?;
    front.show(tui::Event::Session(tui::event::SessionHeader {
        replayed: false,
        participant: Some(plan.participant.to_string()),
        protocol: Some(protocol.name.clone()),
        study: Some(plan.study.display().to_string()),
        calibration_label: effective
            .calibration()
            .map(|calibration| calibration.label().to_owned()),
        uncalibrated: effective.calibration().is_none(),
        simulated,
        plate_length_m: config.plate.length_m,
        kept_m: Some(central_section_m(config, protocol)),
    }));
    let past_events = past_trials(
        machine.records(),
        &session.earlier_log().documents,
        protocol,
    );
    let crops = crops.into_iter().map(tui::Event::Crop);
    past_events
        .into_iter()
        .chain(crops)
        .for_each(|event| front.show(event));
    front.show(tui::Event::Bench(facts));
    front.show(tui::Event::ForceBand {
        min_n: protocol.force.min_n,
        max_n: protocol.force.max_n,
    });
    if let Some((text, is_intact)) = earlier.last_trial {
        front.show(log(if is_intact { Info } else { Warning }, text));
    }
    for recording in &earlier.losses {
        front.show(log(Warning, lost_recordings::warning(recording)));
    }
    for text in config.safety.dead_man_in_words().into_iter().chain([left]) {
        front.show(log(Info, text));
    }
    if let Some(notice) = rehearsed::notice(&plan.rehearsed) {
        front.show(log(Warning, notice));
    }
    let warned = config.safety_notices(plan.carrier_hz);
    for notice in warned.into_iter().chain(plan.unverified.clone()) {
        front.show(log(Warning, notice));
    }
    if !has_position {
        let text = "no encoder: positions are not recorded, and no stretch can be selected live";
        front.show(log(Warning, text.to_owned()));
    }
    if button.is_none() {
        let text = "no button: a finger at rest on the plate for a second counts as ready";
        front.show(log(Warning, text.to_owned()));
    }
    let sound = match Loudspeaker::open(life.host(), &config.sound) {
        Ok(sound) => sound,
        Err(error) => {
            front.show(log(
                Warning,
                format!("no sound for the participant: {error:#}; the session goes on without"),
            ));
            None
        }
    };

    if plan.headless && !ask.is_empty() {
        let unstated: Vec<_> = ask.drain(..).map(|detail| detail.to_string()).collect();
        front.show(log(Info, format!("not stated: {}", unstated.join(", "))));
    }
    for detail in PersonDetail::ALL {
        let (typed, recorded) = (plan.person.text(detail), recorded_person.text(detail));
        if typed != NOT_STATED && typed != recorded {
            front.show(log(
                Warning,
                format!(
                    "participants.tsv already has {detail} {recorded} for {}: {typed} is ignored",
                    plan.participant
                ),
            ));
        }
    }
    let questions = Questions::new(ask);
    let (entries, journal_entries) = entry_queue();
    for kind in withdrawn.into_iter().map(lost_recordings::event) {
        entries.send(Entry::Event(SessionEvent { t_s: 0.0, kind }));
    }
    let (reports, report) = crossbeam_channel::bounded(1);
    let (refits, fits, refit) = {
        let profile = recorded_profile(&effective);
        let profile = profile.as_ref().map(AmplitudeProfile::new);
        let assumed = AssumedConstants::ESTIMATION;
        let skin = resumption.skin.used(&assumed, None);
        if skin.trials > 0 {
            skin.lines()
                .into_iter()
                .for_each(|line| front.show(log(Info, line)));
        }
        Refit::new(assumed, profile.unwrap_or_default(), resumption.skin)
    };
    let admit = {
        let settings = plan.settings;
        Box::new(move |drive: &protocols::Drive, bench: &Effective| {
            Ok(settings.admit(waveform(drive, bench.config()))?)
        })
    };
    let machinery = (signals.clone(), gauges.clone(), gauge.clone());
    let last_notices = notices.clone();
    let carrier_hz: Arc<Slot<f64>> = Arc::default();
    let interference = Interference::new(recording.clone(), effective.config(), plan.carrier_hz)
        .following(carrier_hz.clone());
    let at_displays = displays.tasks(&entries);
    let (room, look_for_room) = RoomTask::new(plan.study.clone());
    let wiring = Wiring {
        batches,
        recording,
        notices,
        gauge,
        room,
        session_bytes: session_bytes(config, protocol),
        drive,
        screen: ParticipantScreen::new(protocol, config.plate.length_m, button.is_none()),
        readiness: Readiness::new(button),
        front,
        watchers,
        displays,
        sound,
        journal: entries,
        live: {
            let contact_n = protocol.force.contact_n;
            LiveSide::new(contact_n, config.plate.modal_mass_kg, (refits, fits))
        },
        carrier: {
            let require = plan.require_drivable();
            CarrierDecision::new(protocol, &effective, require, !plan.headless)
                .resume(resumption.carrier, &effective)
        },
        carrier_hz,
        signals,
        gauges,
        stop,
    };
    let task = SessionTask::new(
        machine,
        effective,
        admit,
        begin,
        wiring,
        plan.consent_by.clone(),
        questions,
        plan.headless,
        reports,
    );
    let journal = Journal::new(
        (study, plan.participant.clone()),
        session,
        journal_entries,
        last_notices,
        clock.clone(),
    )?;

    let mut tasks = first_tasks;
    tasks.push(Box::new(task));
    tasks.push(Box::new(refit));
    tasks.push(Box::new(interference));
    tasks.push(Box::new(look_for_room));
    tasks.extend(at_displays);
    tasks.extend(last_tasks);
    tasks.push(Box::new(journal));
    life.run(tasks, || dashboard.map_or(Ok(()), DashboardThread::join))?;
    let report = report
        .try_recv()
        .context("the session ended without a report")?;
    let (signals, gauges, recorder) = machinery;
    Ok((report, KeptUp::read(&signals, &gauges, &recorder)))
}

fn log(level: LogLevel, text: String) -> tui::Event {
    tui::Event::Log { level, text }
}

/// The operator's front end of a session, and the thread of its screen if there is one.
pub type SessionFront = (Box<dyn Front>, Option<DashboardThread>);

/// Returns the dashboard on this process's terminal; a headless session writes lines to `out` instead.
pub fn terminal_front(
    out: impl Write + Send + 'static,
) -> impl FnOnce(&Plan, &Life) -> anyhow::Result<SessionFront> {
    move |plan, life| {
        if plan.headless {
            return Ok((Box::new(Headless::new(Lines::start(out)?)), None));
        }
        let stop = life.stop().clone();
        let keys = StopKeys::new(life.drive_stop().clone()).with_end(stop.clone());
        let (dashboard, thread) = Dashboard::open(stop, keys)?;
        Ok((Box::new(dashboard), Some(thread)))
    }
}

fn central_section_m(config: &Config, protocol: &Protocol) -> (f64, f64) {
    let half_m = protocol.selection.central_m / 2.0;
    (
        config.plate.centre_m - half_m,
        config.plate.centre_m + half_m,
    )
}

/// Returns the lines printed at the end.
pub fn report_lines(
    report: &Report,
    kept_up: &KeptUp,
    study: &Path,
    participant: &ParticipantId,
) -> Vec<String> {
    let mut lines = summary_lines(&report.summary, &report.account);
    lines.push(kept_up.line());
    let folder = study.join(participant.as_str());
    lines.push(format!("recordings        {}", folder.display()));
    match &report.reason {
        Some(reason) => {
            lines.push(format!("ended early       {reason}"));
            lines.push("to resume         the same command with --resume".to_owned());
        }
        None => lines.push(format!(
            "to results        friction-bench analyze {} --table --figures figures",
            quoted(&folder)
        )),
    }
    lines
}
