//! Device of the force sensor with its line or network connection, and an optional field box; shared by the simulation and the
//! fault panel.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::apparatus_error::ApparatusError;
use crate::field_box::{FieldBox, UnloadedBox};
use crate::network::NetFt;
use crate::pins::PinBoard;
use crate::serial::{DeviceStart, ForceDevice, ForceFault, SerialLine};
use mock_world::plant::SensorSample;
use mock_world::scenario::{FIRST_GAUGE, ForceInterface, ForceSensorTable, GAUGES};

/// Device of the force sensor, and its connection.
enum Device {
    Serial(ForceDevice, SerialLine),
    Netft(NetFt),
    /// On inputs of the sound card.
    Gauges(GaugeFaults),
    /// On the field box, with the encoder and the lines.
    FieldBox(FieldBox),
}

/// Faults of the cable from the gauges' amplifier to the sound card.
#[derive(Debug, Clone, Copy, Default)]
struct GaugeFaults {
    /// The inputs are muted: their values are constant.
    silent: bool,
    /// A gauge is at the end of its range.
    saturated: bool,
    /// The cable is unplugged, and the open inputs drift to the end of their range.
    unplugged: bool,
    /// Number of coming frames that are NaN.
    corrupt_frames: u32,
}

impl GaugeFaults {
    fn inject(&mut self, fault: ForceFault) {
        match fault {
            ForceFault::Silent(silent) => self.silent = silent,
            ForceFault::Saturated(saturated) => self.saturated = saturated,
            ForceFault::Corrupt(frames) => self.corrupt_frames += frames,
            // There are no frames to drop, repeat or reorder, and no other device on a wire.
            ForceFault::Drop(_)
            | ForceFault::Repeat(_)
            | ForceFault::Reorder(_)
            | ForceFault::Status(_)
            | ForceFault::OtherDevice(_)
            | ForceFault::Restart => {}
        }
    }

    fn lay(&mut self, inputs: &mut [f32], channels: usize) {
        for frame in inputs.chunks_exact_mut(channels) {
            let Some(gauges) = frame.get_mut(FIRST_GAUGE..FIRST_GAUGE + GAUGES) else {
                return;
            };
            if self.saturated {
                gauges[2] = -1.0;
            }
            if self.unplugged {
                gauges.fill(1.0);
            }
            if self.silent {
                gauges.fill(0.0);
            }
            if self.corrupt_frames > 0 {
                self.corrupt_frames -= 1;
                gauges[0] = f32::NAN;
            }
        }
    }
}

/// Device of the force sensor, and a field box without forces.
struct Devices {
    sensor: Device,
    field_box: Option<UnloadedBox>,
}

/// Shared devices of the force sensor.
#[derive(Clone)]
pub(super) struct ForceSide(Arc<Mutex<Devices>>);

impl ForceSide {
    /// Powers the device up. On a `synchronous` line every byte sent is readable before the simulation continues. A field box
    /// drives the lines of `board`.
    pub(super) fn open(
        sensor: &ForceSensorTable,
        start: DeviceStart,
        synchronous: bool,
        board: Option<&Arc<PinBoard>>,
    ) -> Result<Self, ApparatusError> {
        let device = match sensor.interface {
            ForceInterface::Serial => {
                let line = SerialLine::open(synchronous).map_err(ApparatusError::Serial)?;
                Device::Serial(ForceDevice::new(sensor, start), line)
            }
            ForceInterface::FieldBox => {
                let board = Arc::clone(board.ok_or(ApparatusError::NoLines)?);
                let field_box = FieldBox::open(sensor, start, synchronous, board);
                Device::FieldBox(field_box.map_err(ApparatusError::Serial)?)
            }
            ForceInterface::Gauges => Device::Gauges(GaugeFaults::default()),
            // The loopback delivers a datagram before the call that sends it returns.
            ForceInterface::Netft => {
                Device::Netft(NetFt::open(sensor, start.clock_us).map_err(ApparatusError::Network)?)
            }
        };
        let field_box = match board.filter(|_| sensor.box_beside) {
            Some(board) => Some(
                UnloadedBox::open(start, synchronous, Arc::clone(board))
                    .map_err(ApparatusError::Serial)?,
            ),
            None => None,
        };
        let devices = Devices {
            sensor: device,
            field_box,
        };
        Ok(Self(Arc::new(Mutex::new(devices))))
    }

    /// Takes the samples of a period that ended at true time `now_s`, and sends the data that are due.
    pub(super) fn send(&self, samples: &[SensorSample], now_s: f64) -> Result<(), ApparatusError> {
        let devices = &mut *self.lock();
        if let Some(field_box) = &mut devices.field_box {
            field_box.send(now_s).map_err(ApparatusError::Serial)?;
        }
        match &mut devices.sensor {
            Device::Serial(device, line) => {
                for sample in samples {
                    device.sample(sample);
                }
                if let Some(burst) = device.burst(now_s) {
                    line.send(burst, now_s).map_err(ApparatusError::Serial)?;
                    device.clear_outbox();
                }
            }
            Device::Gauges(_) => {}
            Device::FieldBox(device) => {
                device
                    .send(samples, now_s)
                    .map_err(ApparatusError::Serial)?;
            }
            Device::Netft(device) => {
                device.answer().map_err(ApparatusError::Network)?;
                for sample in samples {
                    device.sample(sample).map_err(ApparatusError::Network)?;
                }
            }
        }
        Ok(())
    }

    /// Runs the amplifier guard of a field box at `now_ns`.
    pub(super) fn guard(&self, now_ns: u64) -> Result<(), ApparatusError> {
        let devices = &mut *self.lock();
        if let Some(field_box) = &mut devices.field_box {
            field_box.guard(now_ns).map_err(ApparatusError::Serial)?;
        }
        match &mut devices.sensor {
            Device::FieldBox(device) => device.guard(now_ns).map_err(ApparatusError::Serial),
            Device::Serial(..) | Device::Gauges(_) | Device::Netft(_) => Ok(()),
        }
    }

    /// Applies the faults of gauges to the frames that the sound card is about to read.
    pub(super) fn lay(&self, inputs: &mut [f32], channels: usize) {
        if let Device::Gauges(faults) = &mut self.lock().sensor {
            faults.lay(inputs, channels);
        }
    }

    /// Returns whether the sensor is connected to the sound card, without a separate device.
    pub(super) fn is_on_card(&self) -> bool {
        matches!(self.lock().sensor, Device::Gauges(_))
    }

    /// Returns the path of the serial port; `None` if the sensor has no such port, or the operating system has no
    /// pseudo-terminals.
    pub(super) fn path(&self) -> Option<PathBuf> {
        match &self.lock().sensor {
            Device::Serial(_, line) => line.path().map(Path::to_owned),
            Device::FieldBox(device) => device.path().map(Path::to_owned),
            Device::Netft(_) | Device::Gauges(_) => None,
        }
    }

    /// Returns the serial port of the field box, with or without forces.
    pub(super) fn box_path(&self) -> Option<PathBuf> {
        let devices = self.lock();
        let path = match (&devices.sensor, &devices.field_box) {
            (Device::FieldBox(device), _) => device.path(),
            (_, Some(field_box)) => field_box.path(),
            (_, None) => None,
        };
        path.map(Path::to_owned)
    }

    /// Returns the network address of the sensor.
    pub(super) fn address(&self) -> Option<SocketAddr> {
        match &self.lock().sensor {
            Device::Serial(..) | Device::Gauges(_) | Device::FieldBox(_) => None,
            Device::Netft(device) => Some(device.address()),
        }
    }

    /// Makes the device show a fault.
    pub(super) fn inject(&self, fault: ForceFault) {
        match &mut self.lock().sensor {
            Device::Serial(device, _) => device.inject(fault),
            Device::Netft(device) => device.inject(fault),
            Device::FieldBox(device) => device.inject(fault),
            Device::Gauges(faults) => faults.inject(fault),
        }
    }

    /// Disconnects the sensor permanently.
    pub(super) fn unplug(&self) {
        match &mut self.lock().sensor {
            Device::Serial(_, line) => line.unplug(),
            Device::Netft(device) => device.unplug(),
            Device::FieldBox(device) => device.unplug(),
            Device::Gauges(faults) => faults.unplugged = true,
        }
    }

    fn lock(&self) -> MutexGuard<'_, Devices> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
