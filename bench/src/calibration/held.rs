//! The calibration in force: read, compared with the bench, and put in the place of what `bench.toml` assumes.

use std::path::Path;

use anyhow::{Context, bail};
use jiff::{SignedDuration, Timestamp};

use super::file::{Calibration, Provenance};
use super::identity::Identity;
use crate::config::Config;

/// A calibration file that was read whole and is complete.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// What was measured.
    pub calibration: Calibration,
    /// Hash of its content.
    pub hash: String,
    /// For screens and files, such as `2026-05-04, A. Tester`.
    pub label: String,
    text: String,
}

/// A date this far ahead is no clock's inaccuracy.
const AHEAD: SignedDuration = SignedDuration::from_hours(24);

impl Held {
    /// The calibration that holds by these options, with its constants put into `config`; `None` runs uncalibrated, which on
    /// real hardware only the operator can decide. A simulated bench has a calibration only where one is named.
    ///
    /// # Errors
    /// As [`Held::read`].
    pub fn choose(
        options: &crate::cli::Hardware,
        uncalibrated: bool,
        config: &mut Config,
    ) -> anyhow::Result<Option<Self>> {
        let none_named = options.mock.is_some() && options.calibration.is_none();
        if uncalibrated || none_named {
            return Ok(None);
        }
        let held = Self::read(&super::command::path(options), config)?;
        held.apply(config);
        Ok(Some(held))
    }

    /// Reads the calibration at `path` and checks that it is whole for the bench of `config`.
    ///
    /// # Errors
    /// When there is none, it was edited, a measurement is missing, or one is none that a sound bench can have.
    pub fn read(path: &Path, config: &Config) -> anyhow::Result<Self> {
        let (calibration, hash) = Calibration::read(path)?;
        for (missing, command) in [
            (calibration.pickup.is_none(), "pickup"),
            (calibration.plate.is_none(), "plate"),
            (
                config.force.is_some() && calibration.force.is_none(),
                "force",
            ),
        ] {
            if missing {
                bail!(
                    "{} is not complete: run `friction-bench calibrate {command}`",
                    path.display()
                );
            }
        }
        if let Some(force) = &calibration.force {
            force
                .correction()
                .require_plausible(config.safety.max_forces_n())
                .with_context(|| {
                    format!(
                        "{} cannot be used: run `friction-bench calibrate force`",
                        path.display()
                    )
                })?;
        }
        let plate = calibration.plate.as_ref().context("no plate")?;
        let label = format!(
            "{}, {}",
            plate.measured.date.strftime("%Y-%m-%d"),
            plate.measured.operator
        );
        Ok(Self {
            text: calibration.to_text()?,
            calibration,
            hash,
            label,
        })
    }

    /// Compares the calibration with an opened bench, before anything is driven.
    ///
    /// # Errors
    /// As [`Held::require`].
    pub fn require_opened(
        &self,
        config: &Config,
        streams: &signalgen::audio::Streams,
        clock: &dyn tasks::Clock,
    ) -> anyhow::Result<()> {
        self.require(
            &Identity::opened(config, streams),
            clock.utc(),
            config.calibration.max_age_days,
        )
    }

    /// For a recording's `[hardware]`.
    #[must_use]
    pub fn recorded(&self) -> crate::recording::manifest::Calibration {
        crate::recording::manifest::Calibration {
            label: self.label.clone(),
            hash: self.hash.clone(),
            force: self.calibration.force.as_ref().map(|force| {
                let signed =
                    |of: &Provenance| format!("{}, {}", of.date.strftime("%Y-%m-%d"), of.operator);
                format!("{}; tare {}", signed(&force.measured), signed(&force.tared))
            }),
        }
    }

    /// The file's text, for the session's folder.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Puts the measured constants into `config`: sensitivity and phase of the pickup, resonance and
    /// force factor, matrix and tare of the force sensor, clipping levels.
    pub fn apply(&self, config: &mut Config) {
        apply(&self.calibration, config);
    }

    /// Compares the opened bench and the date with the calibration.
    ///
    /// # Errors
    /// Names what differs, or how old it is, and what to do.
    pub fn require(
        &self,
        present: &Identity,
        now: Timestamp,
        max_age_days: f64,
    ) -> anyhow::Result<()> {
        const OVERRIDE: &str = "the calibration does not hold; --uncalibrated runs without it";
        self.calibration
            .identity
            .require(present)
            .context(OVERRIDE)?;
        let Some(oldest) = self.calibration.oldest() else {
            bail!("the calibration has no date");
        };
        let age = now.duration_since(oldest);
        let days = age.as_secs_f64() / 86_400.0;
        if days > max_age_days {
            return Err(anyhow::anyhow!(
                "the calibration is {days:.0} days old, more than calibration.max_age_days = {max_age_days}: calibrate again"
            )
            .context(OVERRIDE));
        }
        if age < -AHEAD {
            return Err(anyhow::anyhow!(
                "the calibration is dated {oldest}, in the future: set the computer's clock, or calibrate again"
            )
            .context(OVERRIDE));
        }
        Ok(())
    }
}

/// A sample this near to the measured clipping level is cut off.
const CLIPPED: f64 = 0.999;

/// Puts what has been measured so far into `config`.
pub fn apply(calibration: &Calibration, config: &mut Config) {
    if let Some(pickup) = &calibration.pickup {
        config.channels.pickup.metres_per_unit = pickup.metres_per_unit.value;
    }
    if let Some(plate) = &calibration.plate {
        config.channels.pickup.phase_rad = plate.pickup_phase_rad.value;
        config.plate.resonance_hz = plate.resonance_hz.value;
        config.plate.force_factor_n_per_v = plate.force_factor_n_per_v.value;
    }
    if let (Some(measured), Some(force)) = (&calibration.force, &mut config.force) {
        force.set_correction(measured.correction());
    }
    if let Some(channels) = &calibration.channels {
        let clip_units = |index: u16| {
            let clips_at = channels.input(index)?.clips_at.as_ref()?;
            Some((CLIPPED * clips_at.value).min(1.0))
        };
        let of = &mut config.channels;
        if let Some(clip_units) = clip_units(of.drive.index) {
            of.drive.clip_units = clip_units;
        }
        if let Some(clip_units) = clip_units(of.pickup.index) {
            of.pickup.clip_units = clip_units;
        }
    }
}
