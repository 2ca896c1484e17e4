//! The plan of a session, checked as far as it can be without hardware.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use config::{Config, Effective};
use devices::drive_control::{carrier_hz, settings};
use devices::recorded_bench::{recorded_errors, recorded_profile};
use protocols::{OffPlateError, ParticipantId, Person, PersonDetail, Protocol};
use safety::Pace;
use signalgen::DriveSettings;
use strict_toml::InFile;

use super::concerns::{ConcernKind, concerns, require_accepted};
use crate::apparatus::pace;
use crate::verbosity::Verbosity;
use crate::{calibrate, dates};
use live::carrier_decision::RequireDrivable;
use preflight::Table;

pub(super) const NAME: &str = "friction-bench";
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The plan of a session, checked as far as it can be without hardware.
pub struct SessionPlan {
    /// The bench.
    pub bench: Arc<Effective>,
    /// The protocol and its file.
    pub protocol: ProtocolFile,
    /// The participant.
    pub participant: ParticipantId,
    /// Study folder.
    pub study: PathBuf,
    /// Operator who holds the signed consent.
    pub consent_by: Option<String>,
    /// Details of the participant from the command line.
    pub person: Person,
    /// Details that the protocol asks for and the command line does not give.
    pub ask: Vec<PersonDetail>,
    /// Whether to resume the last session.
    pub resume: bool,
    /// Whether to resume with a protocol that was edited since.
    pub accept_edited_protocol: bool,
    /// Whether to repeat all accepted trials with lost recordings, not only the last.
    pub repeat_lost: bool,
    /// Whether to begin another session of a participant who has one.
    pub new_session: bool,
    /// Seed of every random choice.
    pub seed: u64,
    /// Whether to run without a dashboard.
    pub headless: bool,
    /// The preflight that this session passed, for its log.
    pub preflight: Option<Table>,
    /// Amount of output before the dashboard opens.
    pub verbosity: Verbosity,
    /// Injected faults, in the form of `--fault`; recordings are then a rehearsal.
    pub rehearsed: Vec<String>,
    /// Safety-relevant measurements that are missing or outdated, a line each.
    pub(super) unverified: Vec<String>,
    /// Path of the calibration; the plate's warmth lies next to it.
    pub(super) calibration: PathBuf,
    pub(super) settings: DriveSettings,
    pub(super) carrier_hz: f64,
    pub(super) pace: Pace,
}

/// A protocol and its source text.
#[derive(Debug, Clone)]
pub struct ProtocolFile {
    /// The protocol.
    pub protocol: Protocol,
    /// The file's text.
    pub text: String,
    /// Name of the file in errors.
    pub file: String,
}

impl ProtocolFile {
    /// Reads a built-in protocol by its name, or a file by its path.
    ///
    /// # Errors
    /// The file does not exist, with the built-in protocol that was probably meant; cannot be read; or is not a usable
    /// protocol.
    pub fn read(name: &str) -> anyhow::Result<Self> {
        let (text, file) = match protocols::built_in(name) {
            Some(text) => (text.to_owned(), format!("{name}.toml (built in)")),
            None => (read_text(name)?, name.to_owned()),
        };
        Ok(Self {
            protocol: Protocol::parse(&text, &file)?,
            text,
            file,
        })
    }

    /// Requires the protocol's slider to stay on the plate.
    ///
    /// # Errors
    /// [`InFile`] names the file, the line, the key, its value and the plate's length.
    pub fn require_on_plate(&self, config: &Config) -> Result<(), InFile<OffPlateError>> {
        self.protocol
            .require_on_plate(config.plate.length_m)
            .map_err(|error| {
                let key = error.key();
                InFile::at_key(error, key, &self.text, &self.file)
            })
    }
}

fn read_text(name: &str) -> anyhow::Result<String> {
    bounded_files::read_text(Path::new(name), bounded_files::TEXT_LIMIT_BYTES).map_err(|error| {
        if error.kind() != std::io::ErrorKind::NotFound {
            return anyhow::Error::from(error).context(format!("cannot read the protocol {name}"));
        }
        let names: Vec<_> = protocols::BUILT_IN.iter().map(|(name, _)| *name).collect();
        let suggestion = protocols::nearest_built_in(name)
            .map(|nearest| format!("; did you mean `{nearest}`?"))
            .unwrap_or_default();
        anyhow::anyhow!(
            "no protocol is called `{name}`, and no file has this name{suggestion}; built-in protocols: {}",
            names.join(", ")
        )
    })
}

impl SessionPlan {
    /// Checks the protocol against hardware, participant and consent, without opening, creating or driving anything.
    ///
    /// # Errors
    /// Names the option or setting to change.
    pub fn new(bench: Effective, options: &crate::cli::Run) -> anyhow::Result<Self> {
        let Some(participant) = &options.participant else {
            bail!("missing participant: pass --participant ID, such as --participant sub-01");
        };
        let participant: ParticipantId = participant.parse()?;
        if options.headless && options.consent_by.is_none() {
            bail!(
                "no consent: the consent of {participant} must be recorded before anything is driven; name the \
                 operator who has the signed form: --consent-by NAME"
            );
        }
        if options
            .consent_by
            .as_ref()
            .is_some_and(|name| name.trim().is_empty())
        {
            bail!("--consent-by is empty: name the operator who has the signed form");
        }
        let file = ProtocolFile::read(&options.protocol)?;
        let protocol = &file.protocol;
        let (person, ask) = person(options, protocol)?;
        let bench = match options.pressure_hpa {
            Some(pressure_hpa) => bench.with_ambient_pressure("--pressure-hpa", pressure_hpa)?,
            None => bench,
        };
        let config = bench.config();
        if config.force.is_none() {
            bail!(
                "a participant's session needs a force sensor: describe it in [force] of bench.toml. Without one, `check`, \
                 `monitor` and `calibrate output|channels|pickup|plate` run"
            );
        }
        file.require_on_plate(config)?;
        if let Some(profile) = recorded_profile(&bench) {
            profile.validate().context(
                "the amplitude along the plate in the calibration cannot be used: measure it again with \
                 `friction-bench calibrate plate --along N`, or take it out with a new `calibrate pickup`",
            )?;
        }
        if let Some(errors) = recorded_errors(&bench) {
            errors.validate().context(
                "the calibration is too uncertain to be recorded: calibrate pickup, plate and force again; \
                 plate.modal_mass_relative_error in bench.toml is part of standard_errors.impedance_relative",
            )?;
        }
        let pace = pace(config, &options.hardware);
        protocol_check::require_possible(protocol, &bench, pace, dates::now())?;
        let settings = settings(config)?;
        Ok(Self {
            carrier_hz: carrier_hz(protocol.conditions[0].drive.carrier, config),
            pace,
            unverified: dates::unverified(&bench, pace),
            bench: Arc::new(bench),
            seed: options.hardware.seed.unwrap_or(protocol.trials.seed),
            protocol: file,
            participant,
            person,
            ask,
            study: options.study.clone(),
            calibration: calibrate::path(&options.hardware),
            consent_by: options.consent_by.clone(),
            resume: options.resume,
            accept_edited_protocol: options.accept_edited_protocol,
            repeat_lost: options.repeat_lost,
            new_session: options.new_session,
            headless: options.headless,
            preflight: None,
            verbosity: Verbosity::default(),
            rehearsed: Vec::new(),
            settings,
        })
    }
}

impl SessionPlan {
    /// Requires the operator to accept the settings of this session that are hardly ever meant; the log states those accepted.
    ///
    /// # Errors
    /// A setting is not accepted.
    pub fn accept(&mut self, kinds: &[ConcernKind]) -> anyhow::Result<()> {
        let concerns = concerns(self.bench.config(), &self.protocol.protocol, dates::now());
        let accepted = require_accepted(&concerns, kinds, !self.headless)?;
        self.unverified.extend(accepted);
        Ok(())
    }

    /// Returns the check that a bench passes before its plate is driven at a shifted resonance.
    pub(super) fn require_drivable(&self) -> RequireDrivable {
        let (protocol, settings) = (self.protocol.protocol.clone(), self.settings);
        let pace = self.pace;
        Box::new(move |bench| {
            protocol_check::require_drivable(&protocol, bench, &settings, pace, dates::now())
        })
    }
}

/// Returns the participant's details from the command line, and the details that the protocol asks for in addition.
fn person(
    options: &crate::cli::Run,
    protocol: &Protocol,
) -> anyhow::Result<(Person, Vec<PersonDetail>)> {
    let mut person = Person::default();
    let mut ask = protocol.participant.ask.clone();
    let answers = [&options.age, &options.sex, &options.handedness];
    for (detail, answer) in PersonDetail::ALL.into_iter().zip(answers) {
        let Some(text) = answer else { continue };
        if !ask.contains(&detail) {
            bail!(
                "protocol {} does not ask for the participant's {detail}, so it must not be stored: leave out \
                 --{detail}, or add {detail} to participant.ask in the protocol",
                protocol.name
            );
        }
        person.set(detail, text)?;
        ask.retain(|question| *question != detail);
    }
    Ok((person, ask))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::{Cli, Command};

    fn plan(bench: &str, arguments: &[&str]) -> anyhow::Result<SessionPlan> {
        let run = ["friction-bench", "run", "--mock", "--participant", "sub-01"];
        let cli = Cli::try_parse_from(run.iter().chain(arguments)).unwrap();
        let Command::Run(options) = cli.command else {
            panic!("not a session");
        };
        let config = Config::parse(bench, "bench.toml").unwrap();
        SessionPlan::new(Effective::uncalibrated(config), &options)
    }

    #[test]
    fn a_session_states_the_ambient_pressure_of_its_option_or_of_the_bench() {
        let stated = format!(
            "{}\n[room]\npressure_hpa = 950.0\n",
            config::rigs::MOCK_BENCH
        );
        for (bench, arguments, expected) in [
            (config::rigs::MOCK_BENCH, &[][..], None),
            (&stated, &[], Some(950.0)),
            (&stated, &["--pressure-hpa", "850"], Some(850.0)),
        ] {
            let plan = plan(bench, arguments).unwrap();
            let room = devices::recorded_bench::recorded_room(plan.bench.config());
            assert_eq!(room.map(|room| room.pressure_hpa), expected);
        }
        let error = plan(&stated, &["--pressure-hpa", "85000"]).err().unwrap();
        assert!(error.to_string().contains("500 to 1100 hPa"), "{error}");
    }
}
