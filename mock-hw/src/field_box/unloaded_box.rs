//! A box without forces on its converter, for a bench with a force sensor on another interface.

use std::io;
use std::path::Path;
use std::sync::Arc;

use mock_world::plant::SensorSample;
use mock_world::scenario::ForceSensorTable;

use super::device::FieldBox;
use crate::pins::PinBoard;
use crate::serial::DeviceStart;

const RATE_HZ: f64 = 1000.0;

/// Encoder, lines and guard of a box.
#[derive(Debug)]
pub(crate) struct UnloadedBox {
    field_box: FieldBox,
    /// Rate of its clock relative to true time.
    clock_rate: f64,
    conversions: u64,
}

impl UnloadedBox {
    /// Powers the box up.
    pub(crate) fn open(
        start: DeviceStart,
        synchronous: bool,
        board: Arc<PinBoard>,
    ) -> io::Result<Self> {
        let converter = ForceSensorTable {
            rate_hz: RATE_HZ,
            burst_period_s: 1.0 / RATE_HZ,
            ..ForceSensorTable::default()
        };
        Ok(Self {
            clock_rate: 1.0 + 1e-6 * converter.clock_ppm,
            field_box: FieldBox::open(&converter, start, synchronous, board)?,
            conversions: 0,
        })
    }

    /// Returns the path of the port for the bench.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.field_box.path()
    }

    /// Checks the amplifier's timeout.
    pub(crate) fn guard(&mut self, now_ns: u64) -> io::Result<()> {
        self.field_box.guard(now_ns)
    }

    /// Sends the data that are due at true time `now_s`.
    pub(crate) fn send(&mut self, now_s: f64) -> io::Result<()> {
        let mut samples = Vec::new();
        while (self.conversions as f64) <= now_s * self.clock_rate * RATE_HZ {
            let device_time_s = self.conversions as f64 / RATE_HZ;
            samples.push(SensorSample {
                time_s: device_time_s / self.clock_rate,
                device_time_s,
                normal_n: 0.0,
                lateral_n: 0.0,
                normal_saturated: false,
                lateral_saturated: false,
            });
            self.conversions += 1;
        }
        self.field_box.send(&samples, now_s)
    }
}
