//! Files of a session: its folder, the log that it is resumed from, and the manifest of each recording.

use std::path::{Path, PathBuf};

use anyhow::bail;
use config::Effective;
use devices::drive_control::carrier_hz;
use devices::recorded_bench as recorded;
use devices::{Life, ThreadPriorities};
use protocols::{Session, TrialKey};
use recorder::Begin;
use recording::AudioFormat;
use recording::manifest::{self, Manifest};
use recording::study::event_log::ExitStatus;
use recording::study::{self, Study, StudyError, TrialLabel};
use sources::field_box::FieldBoxDevice;
use tui::event::Crop;

use super::lost_recordings;
use super::plan::{NAME, SessionPlan, VERSION};
use crate::outcome::progress_bar;
use crate::session::BeginRecording;
use ::study::sessions;
use ::study::verification::LostRecording;

/// Opens the participant's next session, or the session that `--resume` continues; returns its number, its folder, and
/// whether it is resumed.
///
/// # Errors
/// Names the session that already exists or does not, and the remedy.
pub(super) fn open_session(
    study: &Study,
    plan: &SessionPlan,
    date: &str,
) -> anyhow::Result<(u32, study::SessionFolder, bool)> {
    let participant = &plan.participant;
    let number = session_number(study, plan)?;
    if plan.resume {
        let session = study.resume_session(participant, number)?;
        require_same_order(plan, &session)?;
        return Ok((number, session, true));
    }
    let protocol = &plan.protocol.protocol.name;
    let session = study.begin_session(participant, number, date, protocol)?;
    Ok((number, session, false))
}

/// Returns the number of the session that begins, or that `--resume` continues.
fn session_number(study: &Study, plan: &SessionPlan) -> anyhow::Result<u32> {
    let participant = &plan.participant;
    let next = study.next_session(participant)?;
    if plan.resume {
        if next == 1 {
            bail!(
                "{participant} has no session in {} to go on with",
                study.folder().display()
            );
        }
        return Ok(next - 1);
    }
    if next > 1 && !plan.new_session {
        bail!(
            "{participant} already has {} in {}: --resume goes on with it, --new-session begins another",
            study.session_folder(participant, next - 1).display(),
            study.folder().display()
        );
    }
    Ok(next)
}

/// Requires, before anything is driven, that the participant's session may begin or be resumed. Creates nothing.
///
/// # Errors
/// As the opening of a session, as far as the study's folder shows it.
pub fn require_session(plan: &SessionPlan) -> anyhow::Result<()> {
    match Study::open(&plan.study) {
        Ok(study) => session_number(&study, plan).map(drop),
        // The session creates the study.
        Err(StudyError::NoStudy { .. }) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

/// The state of the session to be resumed.
#[derive(Default)]
pub(super) struct EarlierPart {
    /// The last attempt in words, and whether its recording has no defects.
    pub(super) last_trial: Option<(String, bool)>,
    /// Accepted trials to repeat because their recordings are lost.
    pub(super) losses: Vec<LostRecording>,
    /// The crops recorded so far, for the operator's screen.
    pub(super) crops: Vec<Crop>,
}

impl EarlierPart {
    /// Reads the log and the recordings of the session to be resumed; the result is empty without such a session.
    ///
    /// # Errors
    /// The log has gaps, so that the remaining trials are unknown; or recordings of accepted trials are lost and the
    /// operator has not asked to repeat those trials.
    pub(super) fn read(plan: &SessionPlan) -> anyhow::Result<Self> {
        if !plan.resume {
            return Ok(Self::default());
        }
        let Some(folder) = last_session(plan)? else {
            return Ok(Self::default());
        };
        let mut earlier = Self::compare(plan, &folder)?;
        if !plan.headless {
            earlier.crops = past_crops(plan, &folder);
        }
        Ok(earlier)
    }

    /// Compares the log with the recordings.
    fn compare(plan: &SessionPlan, folder: &Path) -> anyhow::Result<Self> {
        let Some((log, history)) = ::study::verification::trusted_log(folder)? else {
            return Ok(Self::default());
        };
        // Opening a complete session refuses to resume it.
        let is_complete = log
            .stop()
            .is_some_and(|stop| stop.exit_status == ExitStatus::Success);
        let losses = if is_complete {
            Vec::new()
        } else {
            lost_recordings::to_repeat(plan, folder, &history)?
        };
        let last_trial = match ::study::verification::last_trial(folder, &history)? {
            None => ("no trial was recorded before this".to_owned(), true),
            Some(trial) => {
                let words = ::study::verification::trial_words(&trial);
                let others = ::study::verification::unlogged_words(folder, &history);
                let words = format!("the last trial before this: {words}{others}");
                (words, trial.defects.is_empty() && others.is_empty())
            }
        };
        Ok(Self {
            last_trial: Some(last_trial),
            losses,
            crops: Vec::new(),
        })
    }
}

/// Returns the crops recorded so far, except from unreadable recordings, which are reported elsewhere.
fn past_crops(plan: &SessionPlan, folder: &Path) -> Vec<Crop> {
    let labels = ::study::verification::recordings(folder).unwrap_or_default();
    let bar = progress_bar(labels.len() as u64, plan.verbosity);
    let crops = labels.iter().flat_map(|label| {
        bar.inc(1);
        replay::past_crops(&folder.join(label.to_string()), *label).unwrap_or_default()
    });
    let crops = crops.collect();
    bar.finish_and_clear();
    crops
}

/// Returns the folder of the participant's last session.
fn last_session(plan: &SessionPlan) -> anyhow::Result<Option<PathBuf>> {
    let participant = plan.study.join(plan.participant.as_str());
    let number = study::last_session(&participant)?;
    Ok(number.map(|number| participant.join(study::session_name(number))))
}

/// Requires a resumed session to keep the protocol and the seed that it began with.
fn require_same_order(plan: &SessionPlan, session: &study::SessionFolder) -> anyhow::Result<()> {
    let history = earlier_history(plan, session);
    let Some(began) = history.start else {
        return Ok(());
    };
    if began.protocol != plan.protocol.protocol.name {
        bail!(
            "{} was begun with the protocol {}, not with {}: name it with --protocol, or begin another session with --new-session",
            session.folder().display(),
            began.protocol,
            plan.protocol.protocol.name
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

/// Returns the history of the session by its log before this part, counted by the protocol of this part.
pub(super) fn earlier_history(
    plan: &SessionPlan,
    session: &study::SessionFolder,
) -> sessions::LoggedSession {
    let practice_trials = plan.protocol.protocol.trials.practice;
    sessions::history(session.earlier_log(), practice_trials)
}

/// Returns the state machine after the `history` of an interrupted session.
pub(super) fn machine(
    plan: &SessionPlan,
    session: &study::SessionFolder,
    history: &sessions::LoggedSession,
) -> anyhow::Result<Session> {
    let mut machine = Session::resume(
        plan.protocol.protocol.clone(),
        plan.participant.clone(),
        plan.seed,
        &history.records,
    )?;
    if plan.resume {
        // A recording may have begun without an entry in the log.
        for label in session.recorded_labels()? {
            let number = label.number_in_session(plan.protocol.protocol.trials.practice);
            machine.leave_out(number, label.attempt);
        }
    }
    Ok(machine)
}

/// Returns the function that creates the manifest and the folder of each attempt's recording, for the session with this
/// number and the protocol in this file. The provenance is that of the effective bench.
pub(super) fn begin_recording(
    plan: &SessionPlan,
    (session, protocol_file): (u32, String),
    folder: PathBuf,
    (life, field_box): (&Life, Option<FieldBoxDevice>),
    priorities: impl Fn() -> ThreadPriorities + Send + 'static,
) -> BeginRecording {
    let bench = plan.bench.clone();
    let (protocol, participant, seed) = (
        plan.protocol.protocol.name.clone(),
        plan.participant.to_string(),
        plan.seed,
    );
    let practice_trials = plan.protocol.protocol.trials.practice;
    let format = AudioFormat {
        sample_rate_hz: bench.config().audio.rate_hz,
        channels: bench.config().audio.input_channels,
    };
    let hardware = recorded::recorded_hardware(&bench, life, &plan.unverified, &plan.rehearsed);
    Box::new(
        move |key: &TrialKey, drive: &protocols::Drive, bench: &Effective| {
            let config = bench.config();
            let hardware =
                recorded::present_hardware(&hardware, config, priorities(), field_box.as_ref());
            let label = TrialLabel::new(key, practice_trials);
            Ok(Begin {
                folder: folder.join(label.to_string()),
                format,
                manifest: Manifest {
                    format: manifest::FORMAT,
                    streams: manifest::Streams::Signals(manifest::RecordedSignals {
                        carrier: manifest::Carrier::Steady(carrier_hz(drive.carrier, config)),
                        modulation: manifest::Modulation {
                            frequency_hz: drive.modulation_hz,
                            index: drive.modulation_index,
                        },
                        channels: recorded::recorded_channels(config),
                        plate: recorded::recorded_plate(bench),
                    }),
                    contact: manifest::RecordedContact::default(),
                    standard_errors: recorded::recorded_errors(bench),
                    room: recorded::recorded_room(config),
                    intervals: Vec::new(),
                    participant: Some(manifest::Participant {
                        id: participant.clone(),
                        session,
                    }),
                    trial: Some(manifest::Trial {
                        number: label.number,
                        attempt: label.attempt,
                        practice: label.is_practice(),
                        condition: key.condition.clone(),
                        protocol: protocol.clone(),
                        protocol_file: Some(protocol_file.clone()),
                        seed,
                        end: None,
                        interruption: None,
                    }),
                    hardware: Some(hardware),
                    software: Some(manifest::Software {
                        name: NAME.to_owned(),
                        version: VERSION.to_owned(),
                    }),
                    origin: None,
                    clocks: Vec::new(),
                    events: Vec::new(),
                },
            })
        },
    )
}
