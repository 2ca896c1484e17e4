//! The force sensor's device with its serial line, shared by the simulation and the fault panel.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::apparatus_error::ApparatusError;
use crate::serial::{DeviceStart, ForceDevice, ForceFault, SerialLine};
use mock_world::plant::SensorSample;
use mock_world::scenario::ForceSensorTable;

/// The force sensor's device and its serial line.
#[derive(Clone)]
pub(super) struct ForceSide(Arc<Mutex<(ForceDevice, SerialLine)>>);

impl ForceSide {
    /// Powers the device up. On a `synchronous` line every byte sent is readable before the simulation goes on.
    pub(super) fn open(
        sensor: &ForceSensorTable,
        start: DeviceStart,
        synchronous: bool,
    ) -> Result<Self, ApparatusError> {
        let device = ForceDevice::new(sensor, start);
        let line = SerialLine::open(synchronous).map_err(ApparatusError::Serial)?;
        Ok(Self(Arc::new(Mutex::new((device, line)))))
    }

    /// Takes in the samples of a period that ended at true time `now_s`, and sends a burst when one is due.
    pub(super) fn send(&self, samples: &[SensorSample], now_s: f64) -> Result<(), ApparatusError> {
        let (device, line) = &mut *self.lock();
        for sample in samples {
            device.sample(sample);
        }
        if let Some(burst) = device.burst(now_s) {
            line.send(burst, now_s).map_err(ApparatusError::Serial)?;
            device.sent();
        }
        Ok(())
    }

    /// Returns the serial port to be opened by path; `None` where the operating system has no pseudo-terminals.
    pub(super) fn path(&self) -> Option<PathBuf> {
        self.lock().1.path().map(Path::to_owned)
    }

    /// Bytes lost because nobody took them in time.
    pub(super) fn dropped_bytes(&self) -> u64 {
        self.lock().1.dropped_bytes()
    }

    /// Lets the device show a fault.
    pub(super) fn inject(&self, fault: ForceFault) {
        self.lock().0.inject(fault);
    }

    /// Disconnects the serial line for good.
    pub(super) fn unplug(&self) {
        self.lock().1.unplug();
    }

    fn lock(&self) -> MutexGuard<'_, (ForceDevice, SerialLine)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
