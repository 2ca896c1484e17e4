//! The command line.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand, ValueEnum};
use faults::{FaultKind, RehearsedFault};
use study::exclusions::SessionTrial;

pub use crate::analyze_options::Analyze;
pub use crate::hardware_options::HardwareOptions;
use crate::hardware_options::SIMULATION;
pub use crate::import_options::Import;
pub use crate::list_options::{List, ListFormat};
pub use crate::protocol_options::{ProtocolCheck, ProtocolCommand, ProtocolOptions};
use crate::run::ConcernKind;
use calibration::swept_plate::SweepOptions;
use calibration_rig::instrument_line::LineUnit;
use calibration_rig::reference_options::ReferenceOptions;
use drill::fault_option::{self, NamedFault};
pub use participant_window::participant_options::ParticipantOptions;
pub use replay::Speed;

/// Heading of the options of every command.
const GLOBAL: &str = "Global options";
/// Heading of the options that resume a session.
const RESUMING: &str = "Sessions begun before";
/// Heading of the options on the participant.
const PARTICIPANT: &str = "Participant's details and screen";

/// Exit status of `export`.
const EXPORT_STATUS: &str = "Exit status: 0 if every recording was exported, 1 if some could not be and are named, 2 if none was, as into a \
     folder with other files.";

/// Exit status of `archive`.
const ARCHIVE_STATUS: &str = "Exit status: 0 if every recording is in the archive, 1 if some could not be archived and are named, 2 if none was, as \
     into a folder with other files. No original is changed or removed.";

/// Exit status of `list`.
const LIST_STATUS: &str = "Exit status: 0 if every recording can be read, 1 if some cannot and are listed as unreadable, 2 if there is none.";

/// Test bench controller for ultrasonic friction modulation.
#[derive(Debug, Parser)]
#[command(version = env!("FRICTION_BENCH_VERSION"), about, arg_required_else_help = true, max_term_width = 100)]
pub struct Cli {
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
    /// Amount of output.
    #[command(flatten)]
    pub printing: Printing,
}

impl Cli {
    /// Parses the command line, or ends the program with its error or the list of faults that it asks for; applies the theme.
    #[must_use]
    pub fn read() -> Self {
        if fault_option::asks_for_list(std::env::args_os()) {
            // A closed output does not change the end of the program.
            let _ = standard_streams::stdout().write_all(fault_option::list().as_bytes());
            std::process::exit(0);
        }
        if let Some(text) = std::env::args_os()
            .skip(1)
            .find_map(|argument| help::command_line::pasted_dash(argument.to_str()?))
        {
            let text = escaping::escaped(&text);
            let _ = standard_streams::stderr().write_all(text.as_bytes());
            std::process::exit(2);
        }
        let cli = Self::try_parse().unwrap_or_else(|error| end(&error));
        if let Some(theme) = cli.printing.theme {
            tui::choose_theme(theme);
        }
        cli
    }
}

/// Ends the program with the help or the error of the command line, in the characters of the user's locale.
fn end(error: &clap::Error) -> ! {
    let mut text = error.render().to_string();
    let is_changed = help::command_line::replace_words(&mut text);
    if !standard_streams::is_ascii() && !is_changed {
        error.exit();
    }
    // A closed output does not change the end.
    let _ = if error.use_stderr() {
        standard_streams::stderr().write_all(text.as_bytes())
    } else {
        standard_streams::stdout().write_all(text.as_bytes())
    };
    std::process::exit(error.exit_code())
}

/// Amount of output in addition to the result.
#[derive(Debug, Clone, Copy, Args)]
pub struct Printing {
    /// Print the files read and the time taken on standard error.
    #[arg(short, long, global = true, conflicts_with = "quiet", help_heading = GLOBAL)]
    pub verbose: bool,
    /// Print no progress on standard error; warnings and errors remain.
    #[arg(short, long, global = true, help_heading = GLOBAL)]
    pub quiet: bool,
    /// Colours of the dashboard: default, light, high-contrast or monochrome; NO_COLOR takes precedence.
    #[arg(long, global = true, value_name = "THEME", help_heading = GLOBAL)]
    pub theme: Option<tui::Theme>,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a participant's session according to a protocol.
    #[command(override_usage = "friction-bench run --participant <ID> [OPTIONS]")]
    Run(Run),
    /// Open the participant's window on a monitor, for sessions that run with --participant-window.
    Participant(ParticipantOptions),
    /// Show live data without a participant or a protocol.
    Monitor(Monitor),
    /// Measure the bench's constants and write them to the calibration file.
    #[command(subcommand)]
    Calibrate(Calibrate),
    /// Print a template of a protocol, or check a protocol on this bench.
    Protocol(ProtocolOptions),
    /// Rehearse faults: the operator responds to one after another, and the times are recorded.
    Drill(Drill),
    /// Replay a recording on the dashboard, or list the recordings of a study.
    Replay(replay::ReplayOptions),
    /// Check that the bench is connected, works and matches its calibration.
    Check(Check),
    /// Ask about the bench's hardware, write its configuration, and check it.
    Init(setup::InitOptions),
    /// Calibrate a simulated bench, run a session of a virtual participant on it, and analyse it.
    Demo(demo::DemoOptions),
    /// List the audio devices, serial ports and GPIO chips of this computer.
    Devices(Devices),
    /// Import recordings made elsewhere into a study, by a map; look at their files, or guess the map.
    #[command(
        override_usage = "friction-bench import <MAP> --study <DIR> [--remove]\n       friction-bench import <MAP> --dry-run\n       friction-bench import --look <FILE>...\n       friction-bench import --guess <FILE>... --to <MAP>"
    )]
    Import(Import),
    /// Analyse recordings: impedance, gap and friction by each method.
    #[command(alias = "analyse")]
    Analyze(Analyze),
    /// Export a study to MATLAB, NumPy, tables of text or a BIDS dataset.
    #[command(override_usage = "friction-bench export <STUDY> --to <DIR> --as <FORMAT> [OPTIONS]", after_help = EXPORT_STATUS)]
    Export(export::ExportOptions),
    /// Archive recordings 10 to 60 times smaller, with envelopes in place of samples, as a study of their own.
    #[command(override_usage = "friction-bench archive <STUDY|RECORDING>... --to <DIR> [OPTIONS]", after_help = ARCHIVE_STATUS)]
    Archive(archive::ArchiveOptions),
    /// List recordings, one a line, for other programs.
    #[command(after_help = LIST_STATUS)]
    List(List),
    /// Verify that a study is complete and unchanged since it was recorded.
    Verify(Verify),
    /// Exclude a participant, a session or a trial from a study's analysis, with the reason.
    Exclude(Exclude),
    /// Remove a participant from a study permanently.
    Forget(Forget),
    /// Compute the published model: curves as CSV, figures as SVG and PNG.
    Model(published_figures::model::ModelOptions),
    /// Print the JSON Schema of a file, for completion and validation in editors; without a name, list the schemas.
    Schema {
        /// Schema to print.
        #[arg(value_parser = help::schemas::names())]
        name: Option<String>,
    },
    /// Print a completion script for a shell.
    Completions {
        /// Shell that runs the script.
        shell: clap_complete::Shell,
    },
    /// Print the manual page, in the format of man(1), or write the pages of all commands.
    Manual {
        /// Folder for one page per command, such as /usr/local/share/man/man1.
        #[arg(long, value_name = "DIR")]
        to: Option<PathBuf>,
    },
    /// Look up a message of the program: its meaning and the remedy.
    Messages(help::messages::MessagesOptions),
}

/// Faults that are injected into simulated hardware.
#[derive(Debug, Clone, Default, Args)]
pub struct Rehearsal {
    /// Inject a fault into simulated hardware: NAME@TIME, NAME@TIME-UNTIL or NAME@TIME:ARGUMENT, with times in s or ms, such as
    /// estop@12s-14s or xrun@3s:192. Time counts from the start of the sound card, after the quick check; a fault at 0 s is
    /// already present in the quick check. May be repeated; `--fault help` lists the faults.
    #[arg(
        long = "fault",
        value_name = "NAME@TIME",
        value_parser = NamedFault::<RehearsedFault>::new(),
        hide_possible_values = true,
        help_heading = SIMULATION
    )]
    pub faults: Vec<RehearsedFault>,
}

/// `run`
#[derive(Debug, Args)]
pub struct Run {
    /// Participant's pseudonym, such as sub-01.
    #[arg(long, value_name = "ID")]
    pub participant: Option<String>,
    /// Study folder; created if it does not exist.
    #[arg(long, value_name = "DIR", default_value = "study")]
    pub study: PathBuf,
    /// Protocol file, or a built-in protocol: huloux2021, consistency, demo; `friction-bench protocol --template` prints one to
    /// change.
    #[arg(long, value_name = "FILE", default_value = "huloux2021")]
    pub protocol: String,
    /// Operator who holds the participant's signed consent; required with --headless.
    #[arg(long, value_name = "OPERATOR")]
    pub consent_by: Option<String>,
    /// Participant's age in whole years, if the protocol asks for it; n/a if not stated. The dashboard asks for omitted
    /// details.
    #[arg(long, value_name = "YEARS", allow_negative_numbers = true, help_heading = PARTICIPANT)]
    pub age: Option<String>,
    /// Participant's sex, if the protocol asks for it: female, male, other; n/a if not stated.
    #[arg(long, value_name = "SEX", help_heading = PARTICIPANT)]
    pub sex: Option<String>,
    /// Participant's writing hand, if the protocol asks for it: right, left, ambidextrous; n/a if not stated.
    #[arg(long, value_name = "HAND", help_heading = PARTICIPANT)]
    pub handedness: Option<String>,
    /// Ambient pressure in this session, read from a barometer at the bench and not reduced to sea level, hPa, 500 to 1100;
    /// recorded, and used in every estimate [default: room.pressure_hpa of the configuration; without it 1013.25 is assumed].
    #[arg(long, value_name = "HPA", allow_negative_numbers = true)]
    pub pressure_hpa: Option<f64>,
    /// Resume the participant's interrupted session.
    #[arg(long, conflicts_with = "new_session", help_heading = RESUMING)]
    pub resume: bool,
    /// Resume with a protocol that has been edited since; the log and each recording say so.
    #[arg(long, requires = "resume", help_heading = RESUMING)]
    pub accept_edited_protocol: bool,
    /// Resume and repeat every accepted trial with a lost recording [default: only the last trial].
    #[arg(long, requires = "resume", help_heading = RESUMING)]
    pub repeat_lost: bool,
    /// Start another session of a participant who already has one.
    #[arg(long, help_heading = RESUMING)]
    pub new_session: bool,
    /// Run all the same with a setting that is hardly ever meant; asked on a terminal, refused otherwise.
    #[arg(long, value_name = "CONCERN", value_enum, value_delimiter = ',')]
    pub accept: Vec<ConcernKind>,
    /// Run without a valid calibration; every file and screen says so.
    #[arg(long, conflicts_with = "calibration")]
    pub uncalibrated: bool,
    /// Print progress instead of showing the dashboard; verdicts follow the protocol's rules.
    #[arg(long)]
    pub headless: bool,
    /// Create files with the umask's permissions [default: readable by you only].
    #[arg(long)]
    pub shared: bool,
    /// Terminal for the participant's screen, such as /dev/tty2.
    #[arg(long, value_name = "TTY", help_heading = PARTICIPANT)]
    pub participant_display: Option<PathBuf>,
    /// Show the participant's window, opened with `friction-bench participant`, over SOCKET [default: the usual socket].
    #[arg(long, value_name = "SOCKET", num_args = 0..=1, help_heading = PARTICIPANT)]
    pub participant_window: Option<Option<PathBuf>>,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: HardwareOptions,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub rehearsal: Rehearsal,
    /// Pace of simulated hardware.
    #[arg(long, value_enum, default_value_t = Speed::Real, requires = "mock", help_heading = SIMULATION)]
    pub speed: Speed,
    /// Existing folder for the simulated truth, for tests; never read by the bench.
    #[arg(long, value_name = "DIR", requires = "mock", hide = true)]
    pub mock_truth: Option<PathBuf>,
}

/// `monitor`
#[derive(Debug, Args)]
pub struct Monitor {
    /// Drive the plate at this mean voltage with the published modulation, after the quick check [default: no drive, no
    /// check].
    #[arg(long, value_name = "VOLTS", allow_negative_numbers = true)]
    pub drive_v: Option<f64>,
    /// Participant at the plate; driving time counts against their hourly limit [default: against everyone's].
    #[arg(long, value_name = "ID", requires = "study", requires = "drive_v")]
    pub participant: Option<String>,
    /// Study of the participant.
    #[arg(long, value_name = "DIR", requires = "participant")]
    pub study: Option<PathBuf>,
    /// Declare the plate clear: driving time counts against no person's hourly limit.
    #[arg(long, requires = "drive_v", conflicts_with = "participant")]
    pub clear_plate: bool,
    /// Run without a valid calibration; the screen says so.
    #[arg(long, conflicts_with = "calibration")]
    pub uncalibrated: bool,
    /// Print one line a second instead of showing the dashboard.
    #[arg(long)]
    pub headless: bool,
    /// Stop after this many seconds of audio.
    #[arg(long, value_name = "SECONDS", value_parser = published_figures::model::positive, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: HardwareOptions,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub rehearsal: Rehearsal,
    /// Pace of simulated hardware.
    #[arg(long, value_enum, default_value_t = Speed::Real, requires = "mock", help_heading = SIMULATION)]
    pub speed: Speed,
}

/// `calibrate`
#[derive(Debug, Subcommand)]
pub enum Calibrate {
    /// Check the volts at the actuators against an independent meter.
    Output(CalibrateOutput),
    /// Compare the inputs: gain, delay, noise, crosstalk, clipping and response at the carrier.
    Channels(CalibrateChannels),
    /// Calibrate the pickup's sensitivity against known amplitudes.
    Pickup(CalibratePickup),
    /// Measure the plate's resonance, damping and force factor with nothing on the plate, or take them from a sweep measured
    /// elsewhere.
    Plate(CalibratePlate),
    /// Calibrate the force sensor's zero, sensitivity and crosstalk with known masses; the plate is not driven.
    Force(CalibrateForce),
}

/// Options of every calibration.
#[derive(Debug, Clone, Args)]
pub struct Measure {
    /// Name of the operator, stored in the calibration file.
    #[arg(long, value_name = "NAME")]
    pub operator: String,
    /// Create a new calibration file with the umask's permissions [default: readable by you only, because it names the
    /// operator].
    #[arg(long)]
    pub shared: bool,
    /// Print the result as JSON; implies --headless.
    #[arg(long)]
    pub json: bool,
    /// Run without prompts: take known values from options and print progress on standard error. Implied without a terminal.
    #[arg(long)]
    pub headless: bool,
    /// Put the result in force although a constant changed by more than its errors; asked on a terminal.
    #[arg(long)]
    pub replace: bool,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: HardwareOptions,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub rehearsal: Rehearsal,
    /// Pace of simulated hardware.
    #[arg(long, value_enum, default_value_t = Speed::Real, requires = "mock", help_heading = SIMULATION)]
    pub speed: Speed,
}

impl Measure {
    /// Returns whether the operator is guided on the dashboard: on a terminal, in real time, unless options say otherwise.
    #[must_use]
    pub fn attended(&self) -> bool {
        let terminal = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
        terminal && !self.headless && !self.json && self.speed == Speed::Real
    }
}

/// `calibrate pickup`
#[derive(Debug, Args)]
pub struct CalibratePickup {
    /// Drive levels, V peak, lowest first [default: a series up to the limits].
    #[arg(long, value_name = "VOLTS", value_delimiter = ',')]
    pub levels_v: Vec<f64>,
    /// Known peak amplitude at each level, µm.
    #[arg(long, value_name = "MICROMETRES", value_delimiter = ',', conflicts_with_all = ["known_csv", "instrument"], requires = "levels_v")]
    pub known_um: Vec<f64>,
    /// CSV file of levels and known peak amplitudes, with the columns drive_v, known_um and optionally known_at_hz.
    #[arg(long, value_name = "FILE", conflicts_with = "instrument")]
    pub known_csv: Option<PathBuf>,
    /// Frequency at which the known amplitudes are valid, Hz; the plate's resonance must be there now.
    #[arg(long, value_name = "HZ", value_parser = published_figures::model::positive, allow_negative_numbers = true, conflicts_with = "instrument")]
    pub known_at_hz: Option<f64>,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub reference: ReferenceOptions,
    /// Serial port of an instrument that sends its amplitude, one number per line.
    #[arg(long, value_name = "PORT")]
    pub instrument: Option<PathBuf>,
    /// Unit of the instrument's lines, as in nm, "um rms" or "um pp"; a line in another unit is refused.
    #[arg(long, value_name = "UNIT", default_value = "um")]
    pub instrument_unit: LineUnit,
    /// Baud rate of the instrument.
    #[arg(long, value_name = "BAUD", default_value_t = 115_200)]
    pub instrument_baud: u32,
    /// Relative standard uncertainty of the known amplitudes, from the instrument's own calibration.
    #[arg(
        long,
        value_name = "FRACTION",
        default_value_t = 1e-3,
        allow_negative_numbers = true
    )]
    pub known_accuracy: f64,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
}

/// `calibrate channels`
#[derive(Debug, Args)]
pub struct CalibrateChannels {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
}

/// `calibrate output`
#[derive(Debug, Args)]
pub struct CalibrateOutput {
    /// Name of the meter, stored in the calibration file: make, model, serial number.
    #[arg(long, value_name = "NAME")]
    pub meter: String,
    /// Quantity of a sine that the meter reads.
    #[arg(long, value_enum)]
    pub reads: Reads,
    /// Relative standard uncertainty of the meter at the frequency of the tone.
    #[arg(
        long,
        value_name = "FRACTION",
        default_value_t = 0.01,
        allow_negative_numbers = true
    )]
    pub meter_accuracy: f64,
    /// Highest frequency at which the meter has this accuracy; some hundred Hz for a hand-held multimeter [default: the
    /// carrier].
    #[arg(long, value_name = "HZ", value_parser = published_figures::model::positive, allow_negative_numbers = true)]
    pub meter_up_to_hz: Option<f64>,
    /// Drive levels, V peak, lowest first, at least three [default: five up to 20 V].
    #[arg(long, value_name = "VOLTS", value_delimiter = ',')]
    pub levels_v: Vec<f64>,
    /// Readings of the meter at each level, in the unit of --reads.
    #[arg(
        long,
        value_name = "VOLTS",
        value_delimiter = ',',
        conflicts_with = "instrument",
        requires = "levels_v"
    )]
    pub known_v: Vec<f64>,
    /// CSV file of levels and readings, with the columns commanded_v,reading_v, as this calibration writes it.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["levels_v", "known_v", "instrument"])]
    pub known_csv: Option<PathBuf>,
    /// Serial port of a meter that sends its reading in V, one number per line.
    #[arg(long, value_name = "PORT")]
    pub instrument: Option<PathBuf>,
    /// Baud rate of the meter.
    #[arg(long, value_name = "BAUD", default_value_t = 115_200)]
    pub instrument_baud: u32,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
}

/// Quantity of a sine that a meter reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Reads {
    /// Root mean square, as shown by a multimeter.
    Rms,
    /// Peak, from zero.
    Peak,
    /// Peak to peak, as shown by an oscilloscope.
    PeakToPeak,
}

impl From<Reads> for config::MeterReads {
    fn from(reads: Reads) -> Self {
        match reads {
            Reads::Rms => Self::Rms,
            Reads::Peak => Self::Peak,
            Reads::PeakToPeak => Self::PeakToPeak,
        }
    }
}

/// `calibrate plate`
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("places").args(["along", "across"]))]
pub struct CalibratePlate {
    /// Drive level of the tones, V peak; lowered where the limits require it.
    #[arg(
        long,
        value_name = "VOLTS",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    pub drive_v: f64,
    /// Measure the response again with a finger resting on the plate, at 6 V or less; it is stored and plotted with the bare
    /// plate's response, and never used as a constant.
    #[arg(long, conflicts_with_all = ["along", "across"])]
    pub finger: bool,
    /// Then measure the amplitude at this many places along the plate, 3 to 50, with a vibrometer that you move; type in its
    /// readings, or read them with --instrument.
    #[arg(long, value_name = "PLACES")]
    pub along: Option<u32>,
    /// Then measure the amplitude at this many places across the plate, 6 to 50, with a vibrometer that you move, and fit the
    /// wavelength there, by which the finger's width is taken into account; needs plate.width_m in bench.toml.
    #[arg(long, value_name = "PLACES", conflicts_with = "along")]
    pub across: Option<u32>,
    /// Serial port of the vibrometer that sends its amplitude, one number per line.
    #[arg(long, value_name = "PORT", requires = "places")]
    pub instrument: Option<PathBuf>,
    /// Unit of the vibrometer's lines, as in nm, "um rms" or "um pp"; a line in another unit is refused.
    #[arg(long, value_name = "UNIT", default_value = "um")]
    pub instrument_unit: LineUnit,
    /// Baud rate of the vibrometer.
    #[arg(long, value_name = "BAUD", default_value_t = 115_200)]
    pub instrument_baud: u32,
    /// Search for the resonance around this frequency, Hz [default: the last known resonance].
    #[arg(long, value_name = "HZ", value_parser = published_figures::model::positive, allow_negative_numbers = true)]
    pub about_hz: Option<f64>,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub sweep: SweepOptions,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
}

/// `calibrate force`
#[derive(Debug, Args)]
pub struct CalibrateForce {
    /// Known masses to put on the plate one after another, g; the dashboard asks for them if omitted.
    #[arg(long, value_name = "GRAMS", value_delimiter = ',', conflicts_with_all = ["masses_csv", "tare"])]
    pub normal_g: Vec<f64>,
    /// Known masses to hang over the pulley one after another, g; they pull towards increasing position.
    #[arg(long, value_name = "GRAMS", value_delimiter = ',', conflicts_with_all = ["masses_csv", "tare"])]
    pub lateral_g: Vec<f64>,
    /// CSV file of known masses, with the columns axis,mass_g or axis,mass_g,sigma_g, as this calibration writes it; an axis is
    /// normal or lateral.
    #[arg(long, value_name = "FILE", conflicts_with = "tare")]
    pub masses_csv: Option<PathBuf>,
    /// Relative standard uncertainty common to all masses, from the balance or the class of the set.
    #[arg(long, value_name = "FRACTION", default_value_t = 5e-4)]
    pub mass_accuracy: f64,
    /// Relative standard uncertainty of the pull over the pulley, from friction and thread; assumes a ball bearing.
    #[arg(long, value_name = "FRACTION", default_value_t = 5e-3)]
    pub pulley_accuracy: f64,
    /// Local acceleration of gravity, m/s² [default: calibration.gravity_m_per_s2].
    #[arg(long, value_name = "M_PER_S2")]
    pub gravity: Option<f64>,
    /// Measure only the zero again, in a few seconds, and keep the sensitivity.
    #[arg(long)]
    pub tare: bool,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
}

/// `drill`
#[derive(Debug, Args)]
pub struct Drill {
    /// Name of the operator, stored with the times.
    #[arg(long, value_name = "NAME")]
    pub operator: String,
    /// Faults to rehearse, in random order; `--only help` lists them [default: all that this bench can rehearse].
    #[arg(
        long,
        value_name = "FAULTS",
        value_delimiter = ',',
        value_parser = NamedFault::<FaultKind>::new(),
        hide_possible_values = true
    )]
    pub only: Vec<FaultKind>,
    /// Folder for drill records, one subfolder each.
    #[arg(long, value_name = "DIR", default_value = "drills")]
    pub out: PathBuf,
    /// Run without a valid calibration; the screen says so.
    #[arg(long, conflicts_with = "calibration")]
    pub uncalibrated: bool,
    /// Run unattended: a script acts as operator, and lines are printed; only with --mock.
    #[arg(long, requires = "mock")]
    pub headless: bool,
    /// Create files with the umask's permissions [default: readable by you only].
    #[arg(long)]
    pub shared: bool,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: HardwareOptions,
    /// Pace of simulated hardware; max only with --headless.
    #[arg(long, value_enum, default_value_t = Speed::Real, requires = "mock", help_heading = SIMULATION)]
    pub speed: Speed,
}

/// `check`
#[derive(Debug, Args)]
pub struct Check {
    /// First test the e-stop: ask for a press and a release, and record the test.
    #[arg(long)]
    pub press_estop: bool,
    /// Run only the two-second check made before every session, without the disk and the terminal.
    #[arg(long)]
    pub quick: bool,
    /// Protocol of the session that must fit on the plate and on the disk.
    #[arg(long, value_name = "FILE", default_value = "huloux2021")]
    pub protocol: String,
    /// Study folder of that session.
    #[arg(long, value_name = "DIR", default_value = "study")]
    pub study: PathBuf,
    /// Print the result as JSON.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: HardwareOptions,
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub rehearsal: Rehearsal,
}

/// `devices`
#[derive(Debug, Args)]
pub struct Devices {
    /// List the simulated hardware.
    #[arg(long)]
    pub mock: bool,
    /// Print as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `exclude`
#[derive(Debug, Args)]
pub struct Exclude {
    /// Participant's pseudonym, such as sub-07.
    #[arg(value_name = "ID")]
    pub participant: String,
    /// Session [default: all].
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..))]
    pub session: Option<u32>,
    /// Trial with all its attempts: its number, or practice-1 for practice [default: all].
    #[arg(long, value_name = "TRIAL")]
    pub trial: Option<SessionTrial>,
    /// Reason, printed with every result.
    #[arg(long, value_name = "REASON")]
    pub because: String,
    /// Name of the person who decided it.
    #[arg(long, value_name = "NAME")]
    pub by: String,
    /// Folder of the study.
    #[arg(long, value_name = "DIR", default_value = "study")]
    pub study: PathBuf,
}

/// `verify`
#[derive(Debug, Args)]
pub struct Verify {
    /// Folder of a study, a participant or a session.
    #[arg(value_name = "STUDY")]
    pub study: PathBuf,
    /// Write the findings as JSON; `-` for standard output, instead of the table.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// `forget`
#[derive(Debug, Args)]
#[command(override_usage = "friction-bench forget <ID> [--study DIR] [--confirm ID]")]
pub struct Forget {
    /// Participant's pseudonym, such as sub-07.
    #[arg(value_name = "ID")]
    pub participant: PathBuf,
    /// Participant's pseudonym in the earlier form `forget DIR ID`.
    #[arg(hide = true, conflicts_with = "study")]
    pub second: Option<PathBuf>,
    /// Folder of the study.
    #[arg(long, value_name = "DIR", default_value = "study")]
    pub study: PathBuf,
    /// Skip both prompts by repeating the participant's pseudonym; required without a terminal.
    #[arg(long, value_name = "ID")]
    pub confirm: Option<String>,
}

impl Forget {
    /// Returns the study's folder and the participant.
    #[must_use]
    pub fn target(&self) -> (&Path, &Path) {
        match &self.second {
            Some(participant) => (&self.participant, participant),
            None => (&self.study, &self.participant),
        }
    }
}
