//! `run`: a participant's session, from the files to the last line of the summary.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use contact::AssumedConstants;
use jiff::tz::TimeZone;
use protocols::{
    ParticipantId, Protocol, Session, SessionEventKind, TrialKey, records_from_events,
};
use signalgen::{Direction, DriveSettings};

use crate::assembly::{Bench, Hardware};
use crate::calibration::Held;
use crate::config::Config;
use crate::drive::{carrier_hz, settings, waveform};
use crate::front::{Dashboard, Front, Headless};
use crate::journal::Journal;
use crate::readiness::Readiness;
use crate::recording::AudioFormat;
use crate::recording::manifest::{self, Manifest};
use crate::recording::recorder::Begin;
use crate::refit::Refit;
use crate::session::{BeginRecording, Report, SessionTask, Watcher, Wiring, summary_lines};
use crate::sound::Sound;
use crate::study::event_log::{Document, Start};
use crate::study::{self, DataRates, GeneratedBy, Study, TrialLabel};

/// What the operator asks for, checked as far as it can be without hardware.
pub struct Plan {
    /// Hardware.
    pub config: Arc<Config>,
    /// Protocol and the text that it was read from.
    pub protocol: Protocol,
    /// The protocol's file as it was read.
    pub protocol_text: String,
    /// Who takes part.
    pub participant: ParticipantId,
    /// Study folder.
    pub study: PathBuf,
    /// Who holds the signed consent.
    pub consent_by: Option<String>,
    /// Go on with the last session.
    pub resume: bool,
    /// Begin another session of a participant who has one.
    pub new_session: bool,
    /// Seed of every random choice.
    pub seed: u64,
    /// No dashboard.
    pub headless: bool,
    /// The calibration in force, its constants already in `config`; `None` is an uncalibrated session.
    pub calibration: Option<Held>,
    settings: DriveSettings,
    carrier_hz: f64,
}

/// Reads a protocol by the name of a built-in one or by its path.
///
/// # Errors
/// When there is none, or it cannot be used.
pub fn read_protocol(name: &str) -> anyhow::Result<(Protocol, String)> {
    let (text, file) = match protocols::built_in(name) {
        Some(text) => (text.to_owned(), format!("{name}.toml (built in)")),
        None => {
            let text = std::fs::read_to_string(name).with_context(|| {
                let built_in: Vec<_> = protocols::BUILT_IN.iter().map(|(name, _)| *name).collect();
                format!(
                    "cannot read the protocol {name}; built-in protocols are {}",
                    built_in.join(", ")
                )
            })?;
            (text, name.to_owned())
        }
    };
    Ok((Protocol::parse(&text, &file)?, text))
}

impl Plan {
    /// Checks protocol against hardware, participant and consent: nothing is opened, made or driven.
    ///
    /// # Errors
    /// Names what to change.
    pub fn new(config: Config, options: &crate::cli::Run) -> anyhow::Result<Self> {
        let Some(participant) = &options.participant else {
            bail!("who takes part? name the participant, such as --participant sub-01");
        };
        let participant: ParticipantId = participant.parse()?;
        if options.headless && options.consent_by.is_none() {
            bail!(
                "no consent: nothing is driven before it is recorded that {participant} has consented; \
                 name the operator who holds the signed form: --consent-by NAME"
            );
        }
        if options
            .consent_by
            .as_ref()
            .is_some_and(|name| name.trim().is_empty())
        {
            bail!("--consent-by is empty: name the operator who holds the signed form");
        }
        let (protocol, protocol_text) = read_protocol(&options.protocol)?;
        if config.force.is_none() {
            bail!("a participant's session needs [force] in bench.toml; `monitor` runs without it");
        }
        let settings = settings(&config)?;
        for condition in &protocol.conditions {
            settings
                .admit(waveform(&condition.drive, &config))
                .with_context(|| {
                    format!("condition {} of protocol {}", condition.name, protocol.name)
                })?;
        }
        let carriers: Vec<f64> = protocol
            .conditions
            .iter()
            .map(|condition| carrier_hz(condition.drive.carrier, &config))
            .collect();
        if let Some(other) = carriers.iter().find(|&&hz| hz != carriers[0]) {
            bail!(
                "protocol {} drives at {} Hz and at {other} Hz: one session has one carrier",
                protocol.name,
                carriers[0]
            );
        }
        crate::assembly::impedance_chain(&config, carriers[0])?;
        Ok(Self {
            carrier_hz: carriers[0],
            config: Arc::new(config),
            seed: options.hardware.seed.unwrap_or(protocol.trials.seed),
            protocol,
            protocol_text,
            participant,
            study: options.study.clone(),
            consent_by: options.consent_by.clone(),
            resume: options.resume,
            new_session: options.new_session,
            headless: options.headless,
            calibration: None,
            settings,
        })
    }

    fn format(&self) -> AudioFormat {
        AudioFormat {
            sample_rate_hz: self.config.audio.rate_hz,
            channels: self.config.audio.input_channels,
        }
    }
}

/// Disk space that a session may take, bytes: every trial twice, half a minute each beside the slider's own time.
#[must_use]
pub fn session_bytes(config: &Config, protocol: &Protocol) -> u64 {
    let slide_s = protocol
        .exploration
        .slider(protocols::Direction::LeftToRight)
        .duration_s();
    let explorations = protocol.exploration.directions.len() as f64;
    let timing = &protocol.timing;
    let trial_s = 10.0 + explorations * (slide_s + timing.countdown_s + timing.feedback_s + 5.0);
    let rates = DataRates {
        audio: AudioFormat {
            sample_rate_hz: config.audio.rate_hz,
            channels: config.audio.input_channels,
        },
        force_hz: 10_000.0,
        position_hz: 1_000.0,
    };
    rates.bytes(trial_s * 1.5 * f64::from(protocol.planned_trials()))
}

/// Runs the session to its end.
///
/// # Errors
/// When a part of the bench is missing or fails; a session that ends early for reasons of its own is a [`Report`].
pub fn run(
    plan: Plan,
    hardware: Hardware,
    out: impl Write + Send + 'static,
) -> anyhow::Result<Report> {
    let Hardware {
        host,
        lines,
        force_port,
        vibrometer_port: _,
        claim: _claim,
        hands: _,
        clock,
        schedule,
        mut watchers,
        simulated,
    } = hardware;
    let config = plan.config.clone();
    let bench = Bench::open(&config, plan.carrier_hz, &host, lines, force_port, &clock)?;
    if let Some(held) = &plan.calibration {
        held.require_opened(&config, &bench.streams, clock.as_ref())?;
    }
    make_safe_on_panic_and_signal(&bench)?;
    let Bench {
        streams,
        health: _,
        drive,
        kill,
        batches,
        recording,
        notices,
        gauge,
        button,
        has_position,
        shared,
        before,
        after,
        stop,
    } = bench;

    let generated_by = GeneratedBy {
        name: NAME.to_owned(),
        version: VERSION.to_owned(),
    };
    let study = Study::open_or_create(&plan.study, generated_by)?;
    study::require_room(&plan.study, session_bytes(&config, &plan.protocol))?;
    let date = clock.utc().to_zoned(TimeZone::UTC).date().to_string();
    let (number, session, resumed) = open_session(&study, &plan, &date)?;
    let machine = machine(&plan, &session)?;
    let mut session = session;
    session.snapshot(&format!("{}.toml", plan.protocol.name), &plan.protocol_text)?;
    session.snapshot("bench.toml", &config.to_toml()?)?;
    if let Some(held) = &plan.calibration {
        session.snapshot("calibration.toml", held.text())?;
    }
    let device = |direction| streams.device(direction).to_string();
    session.log().start(Start {
        time: clock.utc().to_string(),
        resumed,
        participant: plan.participant.to_string(),
        session: number,
        protocol: plan.protocol.name.clone(),
        seed: plan.seed,
        software: NAME.to_owned(),
        version: VERSION.to_owned(),
        devices: BTreeMap::from([
            ("audio input".to_owned(), device(Direction::Input)),
            ("audio output".to_owned(), device(Direction::Output)),
            ("simulated".to_owned(), simulated.to_string()),
        ]),
        calibration: plan
            .calibration
            .as_ref()
            .map(|held| format!("{}, sha256 {}", held.label, held.hash)),
        configuration: serde_json::to_value(config.as_ref())?,
    })?;
    let begin = begin_recording(&plan, number, session.folder().to_owned(), &streams);

    let (mut front, dashboard) = front(&plan, stop.clone(), out)?;
    front.show(tui::Event::Session(tui::event::SessionHeader {
        participant: Some(plan.participant.to_string()),
        protocol: Some(plan.protocol.name.clone()),
        study: Some(plan.study.display().to_string()),
        calibration_label: plan.calibration.as_ref().map(|held| held.label.clone()),
        uncalibrated: plan.calibration.is_none(),
        simulated,
        plate_length_m: config.plate.length_m,
        kept_m: Some(kept(&config, &plan.protocol)),
    }));
    front.show(tui::Event::ForceBand {
        min_n: plan.protocol.force.min_n,
        max_n: plan.protocol.force.max_n,
    });
    if !has_position {
        let text = "no encoder: positions are not recorded, and no stretch can be selected live";
        front.show(warning(text.to_owned()));
    }
    if button.is_none() {
        let text = "no button: a finger at rest on the plate for a second counts as ready";
        front.show(warning(text.to_owned()));
    }
    let sound = match Sound::open(&host, &config.sound) {
        Ok(sound) => sound,
        Err(error) => {
            front.show(warning(format!(
                "no sound for the participant: {error:#}; the session goes on without"
            )));
            None
        }
    };

    let (entries, journal_entries) = crossbeam_channel::unbounded();
    let (reports, report) = crossbeam_channel::bounded(1);
    let (refits, fits, refit) = Refit::new(plan.carrier_hz, AssumedConstants::ESTIMATION);
    let admit = {
        let (config, settings) = (config.clone(), plan.settings);
        Box::new(move |drive: &protocols::Drive| Ok(settings.admit(waveform(drive, &config))?))
    };
    let wiring = Wiring {
        batches,
        recording,
        notices,
        gauge,
        study_folder: plan.study.clone(),
        drive,
        readiness: Readiness::new(button),
        front,
        watchers: std::mem::take(&mut watchers),
        sound,
        journal: entries,
        refits,
        fits,
        shared,
        stop: stop.clone(),
    };
    let task = SessionTask::new(
        machine,
        config,
        admit,
        begin,
        wiring,
        plan.consent_by.clone(),
        plan.headless,
        reports,
    );
    let journal = Journal::new(session, journal_entries, clock.clone())?;

    let mut tasks = before;
    tasks.push(Box::new(task));
    tasks.push(Box::new(refit));
    tasks.extend(after);
    tasks.push(Box::new(journal));
    streams.play()?;
    let ran = schedule.run(tasks, &clock, &stop);
    kill.kill();
    drop(streams);
    let closed = dashboard.map_or(Ok(()), crate::front::DashboardThread::join);
    ran?;
    closed?;
    report
        .try_recv()
        .context("the session ended without a report")
}

/// On a panic in any thread the drive goes first, then the terminal; signals ask for an orderly stop.
///
/// # Errors
/// When a signal cannot be taken.
pub fn make_safe_on_panic_and_signal(bench: &Bench) -> anyhow::Result<()> {
    make_safe(&bench.kill, &bench.stop)
}

/// The same for a drive without a whole bench.
///
/// # Errors
/// When a signal cannot be taken.
pub fn make_safe(
    kill: &signalgen::KillSwitch,
    stop: &crate::schedule::StopFlag,
) -> anyhow::Result<()> {
    let kill = kill.clone();
    tui::install_panic_hook(move || kill.kill());
    for signal in [
        signal_hook::consts::SIGINT,
        signal_hook::consts::SIGTERM,
        signal_hook::consts::SIGHUP,
    ] {
        signal_hook::flag::register(signal, stop.shared())?;
    }
    Ok(())
}

fn warning(text: String) -> tui::Event {
    tui::Event::Log {
        level: tui::event::LogLevel::Warning,
        text,
    }
}

const NAME: &str = "friction-bench";
const VERSION: &str = env!("CARGO_PKG_VERSION");

fn front(
    plan: &Plan,
    stop: crate::schedule::StopFlag,
    out: impl Write + Send + 'static,
) -> anyhow::Result<(Box<dyn Front>, Option<crate::front::DashboardThread>)> {
    if plan.headless {
        return Ok((Box::new(Headless::new(out)), None));
    }
    let (dashboard, thread) = Dashboard::open(stop)?;
    Ok((Box::new(dashboard), Some(thread)))
}

fn kept(config: &Config, protocol: &Protocol) -> (f64, f64) {
    let half_m = protocol.selection.central_m / 2.0;
    (
        config.plate.centre_m - half_m,
        config.plate.centre_m + half_m,
    )
}

fn open_session(
    study: &Study,
    plan: &Plan,
    date: &str,
) -> anyhow::Result<(u32, study::Session, bool)> {
    let participant = &plan.participant;
    let next = study.next_session(participant)?;
    if plan.resume {
        let last = next - 1;
        if last == 0 {
            bail!(
                "{participant} has no session in {} to go on with",
                study.folder().display()
            );
        }
        let session = study.resume_session(participant, last)?;
        require_same_order(plan, &session)?;
        return Ok((last, session, true));
    }
    if next > 1 && !plan.new_session {
        bail!(
            "{participant} already has {} in {}: --resume goes on with it, --new-session begins another",
            study.session_folder(participant, next - 1).display(),
            study.folder().display()
        );
    }
    Ok((
        next,
        study.begin_session(participant, next, date, &plan.protocol.name)?,
        false,
    ))
}

/// A session goes on in the order that it began with, or not at all.
fn require_same_order(plan: &Plan, session: &study::Session) -> anyhow::Result<()> {
    let began = session
        .log_before()
        .documents
        .iter()
        .find_map(|document| match document {
            Document::Start(start) => Some(start),
            _ => None,
        });
    let Some(began) = began else { return Ok(()) };
    if began.protocol != plan.protocol.name {
        bail!(
            "{} was begun with the protocol {}, not with {}: name it with --protocol, or begin another session with --new-session",
            session.folder().display(),
            began.protocol,
            plan.protocol.name
        );
    }
    if began.seed != plan.seed {
        bail!(
            "{} was begun with the seed {}, not with {}, and would go on in another order: add --seed {}, or begin another session with --new-session",
            session.folder().display(),
            began.seed,
            plan.seed,
            began.seed
        );
    }
    Ok(())
}

/// The state machine, after what an interrupted session's log tells of.
fn machine(plan: &Plan, session: &study::Session) -> anyhow::Result<Session> {
    let events: Vec<SessionEventKind> = session
        .log_before()
        .documents
        .iter()
        .filter_map(|document| match document {
            Document::Event(event) => {
                serde_json::from_value(serde_json::Value::Object(event.data.clone())).ok()
            }
            _ => None,
        })
        .collect();
    let records = records_from_events(&events);
    let mut machine = Session::resume(
        plan.protocol.clone(),
        plan.participant.clone(),
        plan.seed,
        &records,
    )?;
    if plan.resume {
        // A recording may have been begun that the log did not come to tell of.
        for label in session.recorded_labels()? {
            let number = label.number_in_session(plan.protocol.trials.practice);
            machine.leave_out(number, label.attempt);
        }
    }
    Ok(machine)
}

fn begin_recording(
    plan: &Plan,
    session: u32,
    folder: PathBuf,
    streams: &signalgen::audio::Streams,
) -> BeginRecording {
    let config = plan.config.clone();
    let (protocol, participant, seed) = (
        plan.protocol.name.clone(),
        plan.participant.to_string(),
        plan.seed,
    );
    let practice_trials = plan.protocol.trials.practice;
    let format = plan.format();
    let hardware = recorded_hardware(&config, streams, plan.calibration.as_ref());
    Box::new(move |key: &TrialKey, drive: &protocols::Drive| {
        Ok(Begin {
            folder: trial_folder(&folder, key, practice_trials)?,
            format,
            manifest: Manifest {
                format: manifest::FORMAT,
                carrier_hz: carrier_hz(drive.carrier, &config),
                modulation_hz: drive.modulation_hz,
                modulation_index: drive.modulation_index,
                channels: recorded_channels(&config),
                plate: recorded_plate(&config),
                intervals: Vec::new(),
                participant: Some(manifest::Participant {
                    id: participant.clone(),
                    session,
                }),
                trial: Some(manifest::Trial {
                    number: TrialLabel::new(key, practice_trials).number,
                    attempt: key.attempt,
                    practice: key.practice,
                    condition: key.condition.clone(),
                    protocol: protocol.clone(),
                    seed,
                    end: None,
                    interruption: None,
                }),
                hardware: Some(hardware.clone()),
                software: Some(manifest::Software {
                    name: NAME.to_owned(),
                    version: VERSION.to_owned(),
                }),
                events: Vec::new(),
            },
        })
    })
}

fn trial_folder(session: &Path, key: &TrialKey, practice_trials: u32) -> anyhow::Result<PathBuf> {
    let path = session.join(TrialLabel::new(key, practice_trials).to_string());
    if path.exists() {
        bail!(
            "{} exists: nothing is overwritten; go on with --resume",
            path.display()
        );
    }
    Ok(path)
}

fn recorded_channels(config: &Config) -> manifest::Channels {
    let (drive, pickup) = (&config.channels.drive, &config.channels.pickup);
    manifest::Channels {
        drive: manifest::DriveChannel {
            index: drive.index,
            volts_per_unit: drive.volts_per_unit,
            clip_units: Some(drive.clip_units),
        },
        pickup: manifest::PickupChannel {
            index: pickup.index,
            metres_per_unit: pickup.metres_per_unit,
            phase_rad: pickup.phase_rad,
            clip_units: Some(pickup.clip_units),
        },
    }
}

fn recorded_plate(config: &Config) -> manifest::Plate {
    manifest::Plate {
        resonance_hz: config.plate.resonance_hz,
        modal_mass_kg: config.plate.modal_mass_kg,
        force_factor_n_per_v: config.plate.force_factor_n_per_v,
        centre_m: config.plate.centre_m,
    }
}

fn recorded_hardware(
    config: &Config,
    streams: &signalgen::audio::Streams,
    held: Option<&Held>,
) -> manifest::Hardware {
    let mut channel_names: Vec<String> = (0..config.audio.input_channels)
        .map(|index| format!("input {index}"))
        .collect();
    channel_names[usize::from(config.channels.drive.index)] = "drive".to_owned();
    channel_names[usize::from(config.channels.pickup.index)] = "pickup".to_owned();
    manifest::Hardware {
        input_device: streams.device(Direction::Input).to_string(),
        output_device: streams.device(Direction::Output).to_string(),
        sample_rate_hz: config.audio.rate_hz,
        sample_format: format!("{:?}", config.audio.sample_format).to_lowercase(),
        channel_names,
        force_sensor: config
            .force
            .as_ref()
            .map(|force| format!("serial, {:?}", force.protocol).to_lowercase()),
        position_sensor: config
            .encoder
            .as_ref()
            .map(|_| "quadrature encoder".to_owned()),
        uncalibrated: held.is_none(),
        calibration: held.map(Held::recorded),
    }
}

/// The lines printed at the end.
pub fn report_lines(report: &Report, study: &Path, participant: &ParticipantId) -> Vec<String> {
    let mut lines = summary_lines(&report.summary, &report.account);
    let folder = study.join(participant.as_str());
    lines.push(format!("recordings        {}", folder.display()));
    match &report.reason {
        Some(reason) => {
            lines.push(format!("ended early       {reason}"));
            lines.push("to go on          the same command with --resume".to_owned());
        }
        None => lines.push(format!(
            "to results        friction-bench analyze {} --table --figures figures",
            folder.display()
        )),
    }
    lines
}

/// Adds a watcher to the hardware's: the participant's own terminal.
///
/// # Errors
/// When the device is no terminal or cannot be opened.
pub fn participant_display(path: &Path) -> anyhow::Result<Watcher> {
    let theme = tui::Theme::from_no_color(std::env::var_os("NO_COLOR").as_deref());
    let display = tui::ParticipantDisplay::open(path, theme)?;
    Ok(Box::new(move |view, _, _| display.show(view.clone())))
}
