//! Setup of a calibration of the pickup.

use anyhow::{Context, bail};
use config::Config;
use metrology::plate_fit::CHANNEL_MATCH;

use calibration_rig::known::Known;

/// Setup of a calibration of the pickup.
#[derive(Debug, Clone)]
pub struct PickupSetup {
    /// Frequency about which the resonance is sought, Hz.
    pub about_hz: f64,
    /// Requested levels, V peak; the default ladder when empty.
    pub levels_v: Vec<f64>,
    /// Source of the known amplitudes.
    pub known: Known,
    /// Relative standard uncertainty of the known amplitudes from the instrument's own calibration.
    pub accuracy: f64,
    /// Match of the channels, relative and rad.
    pub channel_match: f64,
    /// Sensitivity of the pickup in force, measured earlier, metres per sample unit.
    pub(super) sensitivity_in_force: Option<f64>,
    /// Frequency of each known amplitude, Hz; empty if the amplitudes are measured while the plate moves.
    pub(super) known_at_hz: Vec<f64>,
    pub(super) config: Config,
}

impl PickupSetup {
    /// Checks and collects the setup on the bench of `config`; `calibration` is the present one.
    ///
    /// # Errors
    /// If the numbers of levels and amplitudes differ, or a value is out of its range.
    pub fn new(
        config: &Config,
        calibration: &config::CalibrationFile,
        levels_v: Vec<f64>,
        known: Known,
        known_at_hz: Option<f64>,
        accuracy: f64,
    ) -> anyhow::Result<Self> {
        let levels_v = match &known {
            Known::Table(rows) if levels_v.is_empty() => {
                rows.iter().map(|row| row.drive_v).collect()
            }
            Known::Table(_) => bail!("the table has its own levels: leave --levels-v out"),
            _ => levels_v,
        };
        let amplitudes: Vec<f64> = match &known {
            Known::Values(values) => values.clone(),
            Known::Table(rows) => rows.iter().map(|row| row.known_m).collect(),
            Known::Instrument | Known::Typed | Known::Reference(_) => Vec::new(),
        };
        let stated_hz = |row_hz: Option<f64>| {
            row_hz.or(known_at_hz).context(
                "missing frequency of the known amplitudes: give --known-at-hz HZ, or a column known_at_hz in the \
                 table; off its resonance a plate moves less",
            )
        };
        let known_at_hz: Vec<f64> = match &known {
            Known::Values(values) => values
                .iter()
                .map(|_| stated_hz(None))
                .collect::<Result<_, _>>()?,
            Known::Table(rows) => rows
                .iter()
                .map(|row| stated_hz(row.at_hz))
                .collect::<Result<_, _>>()?,
            Known::Instrument | Known::Typed | Known::Reference(_) => Vec::new(),
        };
        let listed = matches!(known, Known::Values(_) | Known::Table(_));
        if listed && amplitudes.len() != levels_v.len() {
            bail!(
                "{} levels (--levels-v) but {} known amplitudes: one for each is needed",
                levels_v.len(),
                amplitudes.len()
            );
        }
        let most_m = config.calibration.max_amplitude_m;
        for amplitude_m in amplitudes {
            if !(amplitude_m > 0.0 && amplitude_m <= most_m) {
                bail!(
                    "a known amplitude of {:.3} µm is outside 0 to calibration.max_amplitude_m = {:.3} µm",
                    amplitude_m * 1e6,
                    most_m * 1e6
                );
            }
        }
        for level_v in &levels_v {
            if !(*level_v > 0.0 && *level_v <= config.limits.drive_v) {
                bail!(
                    "--levels-v: {level_v} V is outside 0 to limits.drive_v = {} V",
                    config.limits.drive_v
                );
            }
        }
        if !(0.0..0.5).contains(&accuracy) {
            bail!("--known-accuracy = {accuracy} is outside 0 to 0.5");
        }
        let about_hz = calibration
            .plate
            .as_ref()
            .map_or(config.plate.resonance_hz, |plate| plate.resonance_hz.value);
        Ok(Self {
            about_hz,
            levels_v,
            known,
            accuracy,
            channel_match: calibration.channel_match().unwrap_or(CHANNEL_MATCH),
            sensitivity_in_force: calibration
                .pickup
                .as_ref()
                .map(|pickup| pickup.metres_per_unit.value),
            known_at_hz,
            config: config.clone(),
        })
    }
}

/// Largest distance of the tone from the frequency of the known amplitudes, in half-bandwidths f₀/(2Q) of the plate; within it,
/// the plate's amplitude changes by less than 0.5 %.
const MOST_BESIDE: f64 = 0.1;

impl PickupSetup {
    /// Requires that the known amplitudes hold at the tone of `carrier_hz` on a plate of this quality factor; returns the
    /// largest relative difference of the plate's amplitude at their frequencies.
    ///
    /// # Errors
    /// If an amplitude was measured at another frequency.
    pub(super) fn require_known_at(&self, carrier_hz: f64, quality: f64) -> anyhow::Result<f64> {
        let half_width_hz = carrier_hz / (2.0 * quality);
        let mut largest: f64 = 0.0;
        for known_hz in &self.known_at_hz {
            let distance = (known_hz - carrier_hz).abs() / half_width_hz;
            if distance.is_nan() || distance > MOST_BESIDE {
                bail!(
                    "the amplitudes are known at {known_hz:.1} Hz (--known-at-hz), and the plate's resonance is at \
                     {carrier_hz:.1} Hz: {:.1} Hz apart, and {:.1} Hz change the plate's motion by half a per cent (a \
                     tenth of the half-bandwidth at Q = {quality:.0}); measure them again at the resonance, or let an \
                     instrument read while the plate is driven (--reference-channel, --instrument)",
                    (known_hz - carrier_hz).abs(),
                    MOST_BESIDE * half_width_hz
                );
            }
            largest = largest.max(distance);
        }
        Ok(1.0 - (1.0 + largest * largest).sqrt().recip())
    }
}
