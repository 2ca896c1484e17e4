//! Scan with faint tones below the safety watch's floor: it detects silent, swapped, saturated and unpatched inputs, and
//! resampling sound layers, before any louder tone is played.

use anyhow::Context;
use metrology::signal_path::{self, COMES_BACK, PathFault, ToneAnswer};
use metrology::spectrum::{Peak, Spectrum};
use metrology::tone_clipping::Peaks;

use calibration_rig::capture::{Capture, Dwell};

use super::channels_setup::{ChannelsSetup, LOOK_STEP_HZ, SETTLE_S};
use super::fault::ChannelsFault;

/// Resolution of the scan's spectra, Hz.
const LOOK_RESOLUTION_HZ: f64 = 20.0;
/// Share of the loudest input's level below which an input is silent: no gain is set that low.
const SILENT: f64 = 0.01;
/// Variation over the tones about the carrier, dB, above which an input reads a plate instead of the patched signal.
const UNEVEN_DB: f64 = 3.0;

/// Returns the amplitudes of the scan's tones about the carrier for each input, sample units.
fn near_levels(setup: &ChannelsSetup, capture: &Capture) -> anyhow::Result<Vec<[f64; 3]>> {
    let [low, middle, high] = capture
        .dwells
        .last_chunk::<3>()
        .context("the look's tones were not played")?;
    (0..setup.inputs())
        .map(|input| {
            let level = |dwell| anyhow::Ok(capture.tone(dwell, input, SETTLE_S)?.value.norm());
            Ok([level(low)?, level(middle)?, level(high)?])
        })
        .collect()
}

/// Judges the path of the drive on `input`, where the drive is expected.
fn require_path(setup: &ChannelsSetup, capture: &Capture, input: u16) -> anyhow::Result<()> {
    let expected = setup.expected(setup.faint_v());
    let answers: Vec<ToneAnswer> = capture
        .dwells
        .iter()
        .map(|dwell| {
            let window = capture.settled(dwell, SETTLE_S);
            let spectrum = Spectrum::read(
                &capture.samples[window.start * capture.channels..window.end * capture.channels],
                capture.channels,
                usize::from(input),
                capture.rate_hz,
                LOOK_RESOLUTION_HZ,
            )?;
            let peaks = spectrum.peaks().into_iter().map(|peak| Peak {
                amplitude: peak.amplitude / expected,
                ..peak
            });
            Ok(ToneAnswer {
                played_hz: dwell.carrier_hz,
                share: capture.tone(dwell, input, SETTLE_S)?.value.norm() / expected,
                peaks: peaks.collect(),
            })
        })
        .collect::<anyhow::Result<_>>()?;
    signal_path::judge(
        &answers,
        setup.carrier_hz,
        1.5 * LOOK_STEP_HZ,
        capture.rate_hz,
        LOOK_RESOLUTION_HZ,
    )
    .map_err(|fault| ChannelsFault::from(fault).into())
}

/// Rejects inputs that are saturated at the faint level.
fn require_headroom(setup: &ChannelsSetup, capture: &Capture) -> anyhow::Result<()> {
    let drive_v = setup.faint_v();
    for input in 0..setup.inputs() {
        let peaks: Vec<Peaks> = capture
            .dwells
            .iter()
            .rev()
            .take(setup.near().len())
            .filter_map(|dwell| peaks(capture, dwell, input))
            .collect();
        let cut_off = |peaks: &Peaks| peaks.cut_off() && peaks.level > setup.expected(drive_v);
        if let Some(first) = peaks.first()
            && peaks.iter().all(cut_off)
        {
            return Err(ChannelsFault::Saturated {
                input,
                level: first.level,
                drive_v,
            }
            .into());
        }
    }
    Ok(())
}

/// Rejects saturated, silent and unpatched inputs and broken paths; returns each input's amplitude at the carrier, sample
/// units.
pub(super) fn faint_amplitudes(
    setup: &ChannelsSetup,
    capture: &Capture,
) -> anyhow::Result<Vec<f64>> {
    if capture.dwells.is_empty() {
        return Err(ChannelsFault::from(PathFault::Silent { share: 0.0 }).into());
    }
    require_headroom(setup, capture)?;
    let levels = near_levels(setup, capture)?;
    let faint: Vec<f64> = levels.iter().map(|levels| levels[1]).collect();
    let drive = usize::from(setup.drive());
    let (loudest, most) = loudest(&faint);
    let audible = most > COMES_BACK * setup.expected(setup.faint_v());
    // If only the drive's input is silent, its cable is out, and the path need not be judged.
    if !audible || faint[drive] >= SILENT * most {
        require_path(setup, capture, setup.drive())?;
    }
    for (input, level) in (0..).zip(&faint) {
        let share = level / most;
        if share < SILENT {
            return Err(ChannelsFault::Silent {
                input,
                loudest,
                share,
            }
            .into());
        }
    }
    for (input, near) in (0..).zip(&levels) {
        let shares = std::array::from_fn::<f64, 3, _>(|i| near[i] / levels[drive][i]);
        let spread = shares.iter().copied().fold(0.0, f64::max)
            / shares.iter().copied().fold(f64::INFINITY, f64::min);
        let spread_db = 20.0 * spread.log10();
        if spread_db > UNEVEN_DB {
            return Err(ChannelsFault::NotPatched { input, spread_db }.into());
        }
    }
    Ok(faint)
}

/// Rejects a drive on another input, and cables that should be disconnected; `faint` holds the amplitudes with all cables
/// connected.
pub(super) fn require_alone(
    setup: &ChannelsSetup,
    faint: &[f64],
    capture: &Capture,
) -> anyhow::Result<()> {
    if capture.dwells.is_empty() {
        return Err(ChannelsFault::from(PathFault::Silent { share: 0.0 }).into());
    }
    let levels = near_levels(setup, capture)?;
    let has_tone = |input: u16| {
        let input = usize::from(input);
        levels[input][1] > COMES_BACK * faint[input]
    };
    let expected = setup.drive();
    let other_inputs = || (0..setup.inputs()).filter(|&input| input != expected);
    if !has_tone(expected) {
        return Err(match other_inputs().find(|&input| has_tone(input)) {
            Some(found) => ChannelsFault::Swapped { expected, found },
            None => ChannelsFault::Silent {
                input: expected,
                loudest: expected,
                share: levels[usize::from(expected)][1] / faint[usize::from(expected)],
            },
        }
        .into());
    }
    match other_inputs().find(|&input| has_tone(input)) {
        Some(input) => Err(ChannelsFault::StillConnected { input }.into()),
        None => Ok(()),
    }
}

/// Returns the peaks of `input` during `dwell`; `None` if samples are not finite or too few.
pub(super) fn peaks(capture: &Capture, dwell: &Dwell, input: u16) -> Option<Peaks> {
    let window = capture.settled(dwell, SETTLE_S);
    Peaks::read(
        &capture.samples[window.start * capture.channels..window.end * capture.channels],
        capture.channels,
        usize::from(input),
    )
}

/// Returns the loudest input and its level.
fn loudest(levels: &[f64]) -> (u16, f64) {
    (0..)
        .zip(levels.iter().copied())
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0))
}
