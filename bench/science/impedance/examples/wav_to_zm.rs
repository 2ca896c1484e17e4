//! Mechanical impedance from a WAV file: CSV of time, Z_m and |Z_m| on standard output.
//!
//! ```text
//! cargo run --release -p impedance --example wav_to_zm -- recording.wav \
//!     --pickup-scale 2e-6 --mass 0.008 --force-factor 0.13 > zm.csv
//! ```
//!
//! Envelopes are peak values with exp(+iωt). Z_m is the one corrected for envelope dynamics; frames without an
//! impedance (lost or clipped samples, an envelope null) have empty cells.
#![expect(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "a program reads files and arguments; the library beside it does not"
)]

use std::fmt;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::process::ExitCode;

use impedance::{
    ChannelScales, Demodulator, Filter, FilterSettings, InputChannel, PlateConstants, Zm, ZmFrame,
};

const USAGE: &str = "\
usage: wav_to_zm FILE.wav --pickup-scale M --mass KG --force-factor N/V [OPTIONS]

  --pickup-scale M    plate displacement at a full-scale sample, m
  --mass KG           modal mass of the plate, kg
  --force-factor N/V  force of the actuators per volt, N/V

  --carrier HZ        carrier frequency, Hz [35000]
  --resonance HZ      resonance of the plate, Hz [the carrier]
  --drive-scale V     actuator voltage at a full-scale sample, V [1]
  --pickup-phase RAD  phase to add to the pickup, rad [0]
  --drive N           channel of the drive voltage, from 0 [0]
  --pickup N          channel of the pickup, from 0 [1]
  --rate HZ           envelope frames per second; must divide the sample rate [2000]";

/// Arguments of the command line.
struct Arguments {
    file: String,
    carrier_hz: f64,
    plate: PlateConstants,
    scales: ChannelScales,
    drive: usize,
    pickup: usize,
    rate_hz: u32,
}

/// Errors of the command line.
#[derive(Debug)]
enum UsageError {
    Unknown(String),
    Missing(&'static str),
    NoValue(String),
    NotANumber { option: String, value: String },
}

impl std::error::Error for UsageError {}

impl fmt::Display for UsageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(argument) => write!(f, "unexpected argument {argument:?}"),
            Self::Missing(name) => write!(f, "{name} is missing"),
            Self::NoValue(option) => write!(f, "{option} needs a value"),
            Self::NotANumber { option, value } => write!(f, "{option} {value:?} is not a number"),
        }?;
        write!(f, "\n\n{USAGE}")
    }
}

impl Arguments {
    fn parse(arguments: impl Iterator<Item = String>) -> Result<Self, UsageError> {
        let (mut file, mut carrier_hz, mut resonance_hz) = (None, 35_000.0, None);
        let (mut mass, mut force_factor, mut pickup_scale) = (None, None, None);
        let (mut drive_scale, mut pickup_phase_rad) = (1.0, 0.0);
        let (mut drive, mut pickup, mut rate_hz) = (0, 1, impedance::OUTPUT_RATE_HZ);
        let mut arguments = arguments;
        while let Some(option) = arguments.next() {
            if !option.starts_with("--") && file.is_none() {
                file = Some(option);
                continue;
            }
            match option.as_str() {
                "--carrier" => carrier_hz = value(&option, arguments.next())?,
                "--resonance" => resonance_hz = Some(value(&option, arguments.next())?),
                "--mass" => mass = Some(value(&option, arguments.next())?),
                "--force-factor" => force_factor = Some(value(&option, arguments.next())?),
                "--drive-scale" => drive_scale = value(&option, arguments.next())?,
                "--pickup-scale" => pickup_scale = Some(value(&option, arguments.next())?),
                "--pickup-phase" => pickup_phase_rad = value(&option, arguments.next())?,
                "--drive" => drive = value(&option, arguments.next())?,
                "--pickup" => pickup = value(&option, arguments.next())?,
                "--rate" => rate_hz = value(&option, arguments.next())?,
                _ => return Err(UsageError::Unknown(option)),
            }
        }
        Ok(Self {
            file: file.ok_or(UsageError::Missing("FILE.wav"))?,
            carrier_hz,
            plate: PlateConstants {
                resonance_hz: resonance_hz.unwrap_or(carrier_hz),
                modal_mass_kg: mass.ok_or(UsageError::Missing("--mass"))?,
                force_factor_n_per_v: force_factor.ok_or(UsageError::Missing("--force-factor"))?,
            },
            scales: ChannelScales {
                drive_volts_per_unit: drive_scale,
                pickup_metres_per_unit: pickup_scale
                    .ok_or(UsageError::Missing("--pickup-scale"))?,
                pickup_phase_rad,
            },
            drive,
            pickup,
            rate_hz,
        })
    }
}

fn value<T: std::str::FromStr>(option: &str, value: Option<String>) -> Result<T, UsageError> {
    let value = value.ok_or_else(|| UsageError::NoValue(option.to_owned()))?;
    value.parse().map_err(|_| UsageError::NotANumber {
        option: option.to_owned(),
        value,
    })
}

/// Returns all samples, interleaved, with full scale at 1.
fn samples(reader: &mut hound::WavReader<impl io::Read>) -> Result<Vec<f32>, hound::Error> {
    let format = reader.spec();
    match format.sample_format {
        hound::SampleFormat::Float => reader.samples::<f32>().collect(),
        hound::SampleFormat::Int => {
            let full_scale = 2f64.powi(i32::from(format.bits_per_sample) - 1);
            let scaled = |sample: i32| (f64::from(sample) / full_scale) as f32;
            reader.samples::<i32>().map(|s| s.map(scaled)).collect()
        }
    }
}

fn write(writer: &mut impl Write, frames: &[ZmFrame]) -> io::Result<()> {
    writeln!(
        writer,
        "time_s,re_z_m_n_s_per_m,im_z_m_n_s_per_m,abs_z_m_n_s_per_m"
    )?;
    for frame in frames {
        let z_m = frame.corrected_n_s_per_m;
        if frame.mask.is_clear() {
            writeln!(
                writer,
                "{},{},{},{}",
                frame.time_s,
                z_m.re,
                z_m.im,
                z_m.norm()
            )?;
        } else {
            writeln!(writer, "{},,,", frame.time_s)?;
        }
    }
    writer.flush()
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = Arguments::parse(std::env::args().skip(1))?;
    let mut reader = hound::WavReader::open(&arguments.file)
        .map_err(|error| format!("{}: {error}", arguments.file))?;
    let format = reader.spec();
    let interleaved =
        samples(&mut reader).map_err(|error| format!("{}: {error}", arguments.file))?;

    let filter = Filter::new(FilterSettings {
        sample_rate_hz: format.sample_rate,
        carrier_hz: arguments.carrier_hz,
        output_rate_hz: arguments.rate_hz,
    })?;
    let zm = Zm::new(arguments.plate, arguments.scales, &filter)?;
    // The samples of a float file may exceed 1 without clipping.
    let clip_level = match format.sample_format {
        hound::SampleFormat::Float => f32::INFINITY,
        hound::SampleFormat::Int => 0.999,
    };
    let input = |channel| InputChannel {
        channel,
        clip_level,
    };
    let mut demodulator = Demodulator::drive_and_pickup(
        filter,
        usize::from(format.channels),
        input(arguments.drive),
        input(arguments.pickup),
    )?;
    let mut frames = Vec::new();
    demodulator.push(&interleaved, |frame| frames.push(zm.read(frame)))?;

    match write(&mut BufWriter::new(io::stdout().lock()), &frames) {
        // A reader such as `head` may close the pipe early.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Standard error may be closed as well.
            let _ = writeln!(io::stderr(), "wav_to_zm: {error}");
            ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
        }
    }
}
