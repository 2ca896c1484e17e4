//! A field box, shared by all its sources and outputs.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use config::{BoxForce as BoxForceTable, Config, Correction};
use tasks::Clock;

use super::box_force::BoxForce;
use super::box_lines;
use super::box_position::BoxPosition;
use super::link::{Link, serial_number};
use super::loss::FieldBoxGone;
use crate::correct::Corrector;
use crate::force_source::ForceSource;
use crate::lines::Lines;
use crate::position::PositionSource;

/// A field box. Clones refer to the same box.
#[derive(Clone)]
pub struct FieldBoxDevice(Arc<Link>);

impl FieldBoxDevice {
    /// Opens the box that `config` names, at `port` instead of the configured one if given; `None` if no source uses a box.
    ///
    /// # Errors
    /// If its port is missing, busy or forbidden.
    pub fn open(
        config: &Config,
        port: Option<&Path>,
        clock: Arc<dyn Clock>,
    ) -> anyhow::Result<Option<Self>> {
        let Some(table) = config.used_field_box() else {
            return Ok(None);
        };
        let port = port.unwrap_or(&table.port);
        let link = Link::open(table, port, config.safety.silence_s, clock)?;
        Ok(Some(Self(Arc::new(link))))
    }

    /// Waits until the box has identified itself and sent a report.
    ///
    /// # Errors
    /// [`FieldBoxGone`] if it does not do so within seconds, or cannot be used.
    pub fn require_known(&self) -> Result<(), FieldBoxGone> {
        while self.0.report()?.is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }

    /// Returns a description of the box; `None` until it has identified itself.
    #[must_use]
    pub fn in_words(&self) -> Option<String> {
        let identity = self.0.identity()?;
        let [major, minor, patch] = identity.firmware;
        Some(format!(
            "{}, firmware {major}.{minor}.{patch}, {} Hz",
            serial_number(identity),
            identity.report_hz
        ))
    }

    /// Returns the force source of its converter.
    #[must_use]
    pub fn force(
        &self,
        table: &BoxForceTable,
        latency_s: f64,
        correction: Correction,
        range_n: Option<f64>,
    ) -> Box<dyn ForceSource> {
        self.0.keep_forces();
        let corrector = Corrector::new(correction, range_n);
        Box::new(BoxForce::new(self.0.clone(), table, latency_s, corrector))
    }

    /// Returns the position source of its encoder.
    #[must_use]
    pub fn encoder(&self) -> Box<dyn PositionSource> {
        self.0.keep_positions();
        Box::new(BoxPosition::new(self.0.clone()))
    }

    /// Returns its lines.
    #[must_use]
    pub fn lines(&self) -> Lines {
        box_lines::lines(&self.0)
    }
}
