//! The command line.

use std::io::IsTerminal;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use contact::AssumedConstants;

/// Test bench controller for ultrasonic friction modulation.
#[derive(Debug, Parser)]
#[command(version, about, arg_required_else_help = true, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a participant's session by a protocol file.
    Run(Run),
    /// Watch the bench without a protocol.
    Monitor(Monitor),
    /// Measure what turns volts into micrometres and newtons, and keep it in a calibration file.
    #[command(subcommand)]
    Calibrate(Calibrate),
    /// Play a recording through the live pipeline.
    Replay(Replay),
    /// Preflight: is everything there and alive?
    Check(Check),
    /// List audio devices with their rates, serial ports and GPIO chips.
    Devices(Devices),
    /// Analyse recordings: stiffness, gap and friction by both methods.
    Analyze(Analyze),
    /// Draw the published model: curves as CSV, figures as SVG and PNG.
    Model(Model),
    /// Print shell completions.
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page.
    Manual,
}

/// Which bench: shared by every command that touches hardware.
#[derive(Debug, Clone, Args)]
pub struct Hardware {
    /// Description of the hardware.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Use simulated hardware; optionally a scenario file.
    #[arg(long, value_name = "SCENARIO", num_args = 0..=1, default_missing_value = "nominal")]
    pub mock: Option<String>,
    /// Seed of the simulated hardware and of every random choice; the protocol's own when absent.
    #[arg(long, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: Option<u64>,
    /// Print the configuration that holds, and stop.
    #[arg(long)]
    pub print_config: bool,
    /// Calibration file; calibration.toml by default, none on simulated hardware.
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
}

/// How fast simulated or recorded time passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Speed {
    /// As on real hardware.
    Real,
    /// As fast as it computes; simulated hardware gives the same files for the same seed.
    Max,
}

/// `run`
#[derive(Debug, Args)]
pub struct Run {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: Hardware,
    /// Study folder; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "study")]
    pub study: PathBuf,
    /// Participant, such as sub-01.
    #[arg(long, value_name = "ID")]
    pub participant: Option<String>,
    /// Protocol file, or the name of a built-in one: huloux2021, demo.
    #[arg(long, value_name = "FILE", default_value = "huloux2021")]
    pub protocol: String,
    /// The operator who holds the participant's signed consent; without it nothing is driven.
    #[arg(long, value_name = "OPERATOR")]
    pub consent_by: Option<String>,
    /// Go on with the participant's interrupted session.
    #[arg(long, conflicts_with = "new_session")]
    pub resume: bool,
    /// Begin another session of a participant who has one.
    #[arg(long)]
    pub new_session: bool,
    /// Run without a calibration that holds; every file and screen says so.
    #[arg(long, conflicts_with = "calibration")]
    pub uncalibrated: bool,
    /// No dashboard: print progress, decide by the protocol's rules.
    #[arg(long)]
    pub headless: bool,
    /// Pace of simulated hardware.
    #[arg(long, value_enum, default_value_t = Speed::Real, requires = "mock")]
    pub speed: Speed,
    /// Existing folder for the simulated truth, for tests; the bench never reads it.
    #[arg(long, value_name = "DIR", requires = "mock", hide = true)]
    pub mock_truth: Option<PathBuf>,
    /// Terminal that shows the participant's screen, such as /dev/tty2.
    #[arg(long, value_name = "TTY")]
    pub participant_display: Option<PathBuf>,
}

/// `monitor`
#[derive(Debug, Args)]
pub struct Monitor {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: Hardware,
    /// Drive the plate at this mean voltage with the published modulation, once the bench has passed `check --quick`; without it the
    /// plate stays silent and nothing is checked.
    #[arg(long, value_name = "VOLTS")]
    pub drive_v: Option<f64>,
    /// Watch without a calibration that holds; the screen says so.
    #[arg(long, conflicts_with = "calibration")]
    pub uncalibrated: bool,
    /// No dashboard: print one line a second.
    #[arg(long)]
    pub headless: bool,
    /// Pace of simulated hardware.
    #[arg(long, value_enum, default_value_t = Speed::Real, requires = "mock")]
    pub speed: Speed,
    /// Stop after this many seconds of audio.
    #[arg(long, value_name = "SECONDS")]
    pub duration_s: Option<f64>,
}

/// `calibrate`
#[derive(Debug, Subcommand)]
pub enum Calibrate {
    /// The pickup's sensitivity, against known amplitudes.
    Pickup(CalibratePickup),
    /// The plate's resonance, damping and force factor, with no finger on it.
    Plate(CalibratePlate),
    /// The force sensor's zero, sensitivity and crosstalk, by known masses on both axes; the plate stays silent.
    Force(CalibrateForce),
    /// The inputs beside each other: gain, delay, noise, crosstalk, clipping, and what the path does to the carrier.
    Channels(CalibrateChannels),
}

/// What every calibration asks.
#[derive(Debug, Clone, Args)]
pub struct Measure {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: Hardware,
    /// Pace of simulated hardware.
    #[arg(long, value_enum, default_value_t = Speed::Real, requires = "mock")]
    pub speed: Speed,
    /// Who measures; kept in the file.
    #[arg(long, value_name = "NAME")]
    pub operator: String,
    /// Print the result as JSON; implies --headless.
    #[arg(long)]
    pub json: bool,
    /// Nobody is asked: flags say what is known, lines on standard error tell the progress. So it is without a terminal.
    #[arg(long)]
    pub headless: bool,
}

impl Measure {
    /// Whether an operator is guided on the dashboard: on a terminal, in real time, unless flags say otherwise.
    #[must_use]
    pub fn attended(&self) -> bool {
        let terminal = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
        terminal && !self.headless && !self.json && self.speed == Speed::Real
    }
}

/// `calibrate pickup`
#[derive(Debug, Args)]
pub struct CalibratePickup {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
    /// Drive levels, V peak, lowest first; a ladder up to the limits when absent.
    #[arg(long, value_name = "VOLTS", value_delimiter = ',')]
    pub levels_v: Vec<f64>,
    /// Known peak amplitude at each level, µm.
    #[arg(long, value_name = "MICROMETRES", value_delimiter = ',', conflicts_with_all = ["known_csv", "instrument"], requires = "levels_v")]
    pub known_um: Vec<f64>,
    /// Table of levels and known peak amplitudes: columns drive_v,known_um.
    #[arg(long, value_name = "FILE", conflicts_with = "instrument")]
    pub known_csv: Option<PathBuf>,
    /// Serial port of an instrument that sends its peak amplitude in µm, one number a line.
    #[arg(long, value_name = "PORT")]
    pub instrument: Option<PathBuf>,
    /// Baud rate of the instrument.
    #[arg(long, value_name = "BAUD", default_value_t = 115_200)]
    pub instrument_baud: u32,
    /// Relative standard uncertainty of the known amplitudes: the instrument's own calibration.
    #[arg(long, value_name = "FRACTION", default_value_t = 1e-3)]
    pub known_accuracy: f64,
}

/// `calibrate channels`
#[derive(Debug, Args)]
pub struct CalibrateChannels {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
}

/// `calibrate plate`
#[derive(Debug, Args)]
pub struct CalibratePlate {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
    /// Drive level of the tones, V peak; lowered where the limits ask for it.
    #[arg(long, value_name = "VOLTS", default_value_t = 20.0)]
    pub drive_v: f64,
    /// Look for the resonance about this frequency, Hz; where it was when absent.
    #[arg(long, value_name = "HZ")]
    pub about_hz: Option<f64>,
}

/// `calibrate force`
#[derive(Debug, Args)]
pub struct CalibrateForce {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub measure: Measure,
    /// Known masses to put on the plate one after the other, g; on the dashboard they are asked for when no mass is given.
    #[arg(long, value_name = "GRAMS", value_delimiter = ',', conflicts_with_all = ["masses_csv", "tare"])]
    pub normal_g: Vec<f64>,
    /// Known masses to hang over the pulley one after the other, g; they must pull towards increasing position.
    #[arg(long, value_name = "GRAMS", value_delimiter = ',', conflicts_with_all = ["masses_csv", "tare"])]
    pub lateral_g: Vec<f64>,
    /// Table of known masses: columns axis,mass_g or axis,mass_g,sigma_g; an axis is normal or lateral.
    #[arg(long, value_name = "FILE", conflicts_with = "tare")]
    pub masses_csv: Option<PathBuf>,
    /// Relative standard uncertainty that all masses have in common: the balance, or the class of the set.
    #[arg(long, value_name = "FRACTION", default_value_t = 5e-4)]
    pub mass_accuracy: f64,
    /// Relative standard uncertainty of the pull behind the pulley: its friction and its thread (an assumption for a ball bearing).
    #[arg(long, value_name = "FRACTION", default_value_t = 5e-3)]
    pub pulley_accuracy: f64,
    /// Local acceleration of gravity, m/s²; calibration.gravity_m_per_s2 of the configuration when absent.
    #[arg(long, value_name = "M_PER_S2")]
    pub gravity: Option<f64>,
    /// Measure the zero anew and keep the matrix: a few seconds, before a session.
    #[arg(long)]
    pub tare: bool,
}

/// `replay`
#[derive(Debug, Args)]
pub struct Replay {
    /// Folder of the recording.
    #[arg(value_name = "RECORDING")]
    pub recording: PathBuf,
    /// How fast.
    #[arg(long, value_enum, default_value_t = Speed::Real)]
    pub speed: Speed,
    /// No dashboard: print a few lines for each exploration, and totals.
    #[arg(long)]
    pub headless: bool,
}

/// `check`
#[derive(Debug, Args)]
pub struct Check {
    #[command(flatten)]
    #[expect(missing_docs, reason = "flattened")]
    pub hardware: Hardware,
    /// Two seconds without the computer, as before every session, instead of ten with all.
    #[arg(long)]
    pub quick: bool,
    /// Protocol whose session must fit on the disk.
    #[arg(long, value_name = "FILE", default_value = "huloux2021")]
    pub protocol: String,
    /// Study folder that it would go to.
    #[arg(long, value_name = "DIR", default_value = "study")]
    pub study: PathBuf,
    /// Print the table as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `devices`
#[derive(Debug, Args)]
pub struct Devices {
    /// List the simulated hardware instead.
    #[arg(long)]
    pub mock: bool,
    /// Print as JSON.
    #[arg(long)]
    pub json: bool,
}

/// `analyze`
#[derive(Debug, Args)]
pub struct Analyze {
    /// Recording folders, or study, participant or session folders: all of their completed trials.
    #[arg(required = true, value_name = "RECORDING|STUDY")]
    pub recordings: Vec<PathBuf>,
    /// Write the results as JSON; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Print the published statistics beside those of these recordings.
    #[arg(long)]
    pub table: bool,
    /// Write tidy tables as Parquet, instances.parquet and samples.parquet.
    #[arg(long, value_name = "DIR")]
    pub tables: Option<PathBuf>,
    /// Draw the published figures as SVG and PNG, with their captions.
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Assume another value, such as `contact_area_m2=314e-6`; the names are those of the results' `settings`.
    #[arg(long, value_name = "NAME=VALUE")]
    pub assume: Vec<String>,
    /// Assume what a TOML file says, `NAME = VALUE` on each line; `--assume` goes before it.
    #[arg(long, value_name = "FILE")]
    pub assume_file: Vec<PathBuf>,
    /// Analyse a study's practice trials too.
    #[arg(long)]
    pub practice: bool,
}

/// `model`
#[derive(Debug, Args)]
pub struct Model {
    /// Folder for the files; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "model")]
    pub out: PathBuf,
    /// Only the curves, no figures.
    #[arg(long)]
    pub csv_only: bool,
    /// What is assumed.
    #[command(flatten)]
    pub assume: ModelAssumptions,
}

/// What the model's curves assume; the defaults are those of the published figures where these say it.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Assumptions")]
pub struct ModelAssumptions {
    /// σ_t, characteristic height of the asperities, m.
    #[arg(long, value_parser = positive, default_value_t = 2e-6)]
    pub sigma_t_m: f64,
    /// S, apparent contact area, m².
    #[arg(long, value_parser = positive, default_value_t = AssumedConstants::FIGURES.contact_area_m2)]
    pub contact_area_m2: f64,
    /// E, Young's modulus of the skin, Pa.
    #[arg(long, value_parser = positive, default_value_t = AssumedConstants::FIGURES.young_modulus_pa)]
    pub young_modulus_pa: f64,
    /// ν, Poisson's ratio of the skin.
    #[arg(long, value_parser = not_negative, default_value_t = AssumedConstants::FIGURES.poisson_ratio)]
    pub poisson_ratio: f64,
    /// q0, wave vector of the coarsest roughness, rad/m.
    #[arg(long, value_parser = positive, default_value_t = AssumedConstants::FIGURES.q0_rad_per_m)]
    pub q0_rad_per_m: f64,
    /// p0, ambient pressure, Pa.
    #[arg(long, value_parser = positive, default_value_t = AssumedConstants::FIGURES.ambient_pressure_pa)]
    pub ambient_pressure_pa: f64,
    /// η, loss factor of the contact.
    #[arg(long, value_parser = not_negative, default_value_t = AssumedConstants::FIGURES.loss_factor)]
    pub loss_factor: f64,
    /// f0, carrier and resonance of the plate, Hz.
    #[arg(long, value_parser = positive, default_value_t = 35e3)]
    pub carrier_hz: f64,
    /// m_p, modal mass of the plate, kg.
    #[arg(long, value_parser = positive, default_value_t = 8e-3)]
    pub plate_mass_kg: f64,
    /// b_p, damping of the plate, N·s/m.
    #[arg(long, value_parser = positive, default_value_t = 7.01)]
    pub plate_damping_n_s_per_m: f64,
    /// m_t, mass of the skin, kg.
    #[arg(long, value_parser = not_negative, default_value_t = 1e-4)]
    pub tissue_mass_kg: f64,
    /// k_t, stiffness of the skin, N/m.
    #[arg(long, value_parser = not_negative, default_value_t = 0.0)]
    pub tissue_stiffness_n_per_m: f64,
    /// b_t, damping of the skin, N·s/m.
    #[arg(long, value_parser = positive, default_value_t = 32.0)]
    pub tissue_damping_n_s_per_m: f64,
    /// μ0, friction without vibration.
    #[arg(long, value_parser = positive, default_value_t = 0.8)]
    pub mu0: f64,
}

fn number(text: &str, allowed: fn(f64) -> bool, limit: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if allowed(value) => Ok(value),
        _ => Err(format!("must be {limit}")),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    number(
        text,
        |value| value.is_finite() && value > 0.0,
        "a finite number above 0",
    )
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(
        text,
        |value| value.is_finite() && value >= 0.0,
        "a finite number from 0",
    )
}
