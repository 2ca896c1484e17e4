//! Simulated box: takes samples and commands, sends reports and drives the lines.

use std::io;
use std::path::Path;
use std::sync::Arc;

use field_box_logic::{Guard, LineRequest, StopCause};

use super::codec::{Ear, Reading, Request, put_identity, put_report};
use crate::fault_count::take_one;
use crate::pins::PinBoard;
use crate::serial::{DeviceStart, ForceFault, SerialLine};
use mock_world::plant::SensorSample;
use mock_world::scenario::ForceSensorTable;

/// Force at the end of the converter's range, N.
const FULL_SCALE_N: f64 = 20.0;
const FULL_SCALE: f64 = 8_388_608.0;
const FIRMWARE: [u8; 3] = [0, 1, 0];
const SERIAL: [u8; 8] = *b"\x51\x3D\x00simul";
/// Text sent by another device in place of a report.
const OTHER_TEXT: &[u8] = b"ATZ\r\nOK, and more of it\r\n\0";

/// Faults not yet shown.
#[derive(Debug, Default)]
struct Faults {
    drop: u32,
    corrupt: u32,
    repeat: u32,
    converter_silent: bool,
    saturated: bool,
    other_device: bool,
}

/// The box with its serial line and its lines to the apparatus.
#[derive(Debug)]
pub(crate) struct FieldBox {
    line: SerialLine,
    board: Arc<PinBoard>,
    guard: Guard,
    ear: Ear,
    report_hz: u16,
    start_us: u32,
    number: u16,
    last_word: u16,
    /// Whether a bench has sent a message yet.
    has_bench: bool,
    burst_period_s: f64,
    next_burst_s: f64,
    range_n: f64,
    faults: Faults,
    received: Vec<u8>,
    frame: Vec<u8>,
    outbox: Vec<u8>,
}

impl FieldBox {
    /// Powers the box up.
    pub(crate) fn open(
        sensor: &ForceSensorTable,
        start: DeviceStart,
        synchronous: bool,
        board: Arc<PinBoard>,
    ) -> io::Result<Self> {
        Ok(Self {
            line: SerialLine::open(synchronous)?,
            board,
            guard: Guard::default(),
            ear: Ear::default(),
            report_hz: sensor.rate_hz as u16,
            start_us: start.clock_us,
            number: start.sequence,
            last_word: 0,
            has_bench: false,
            burst_period_s: sensor.burst_period_s,
            next_burst_s: sensor.burst_period_s,
            range_n: sensor.range_n,
            faults: Faults::default(),
            received: Vec::new(),
            frame: Vec::new(),
            outbox: Vec::new(),
        })
    }

    /// Returns the path of the port for the bench.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.line.path()
    }

    /// Pulls the cable to the bench permanently; the box continues to run.
    pub(crate) fn unplug(&mut self) {
        self.line.unplug();
    }

    /// Makes the box show a fault.
    pub(crate) fn inject(&mut self, fault: ForceFault) {
        let faults = &mut self.faults;
        match fault {
            ForceFault::Drop(reports) => faults.drop += reports,
            ForceFault::Corrupt(reports) => faults.corrupt += reports,
            ForceFault::Repeat(reports) => faults.repeat += reports,
            ForceFault::Silent(silent) => faults.converter_silent = silent,
            ForceFault::Saturated(saturated) => faults.saturated = saturated,
            ForceFault::OtherDevice(is_other) => faults.other_device = is_other,
            // A serial line keeps its order, and the converter has no status word; the box restarts only at power-up.
            ForceFault::Reorder(_) | ForceFault::Status(_) | ForceFault::Restart => {}
        }
    }

    /// Takes the commands of the bench, checks the amplifier's timeout, and drives its lines, at `now_ns`.
    pub(crate) fn guard(&mut self, now_ns: u64) -> io::Result<()> {
        self.received.clear();
        self.line.receive(&mut self.received)?;
        let (now_us, closed) = (now_ns / 1_000, self.board.estop_healthy());
        for &byte in &self.received {
            let request = self.ear.hear(byte).filter(|_| !self.faults.other_device);
            self.has_bench |= request.is_some();
            match request {
                Some(Request::Identity) => {
                    put_identity(FIRMWARE, SERIAL, self.report_hz, &mut self.outbox);
                }
                Some(Request::Lines {
                    number,
                    enable,
                    heartbeat,
                }) => {
                    self.last_word = number;
                    self.guard
                        .hear(now_us, LineRequest { enable, heartbeat }, closed);
                }
                None => {}
            }
        }
        self.guard.look(now_us, closed);
        let outputs = self.guard.outputs();
        self.board
            .set_lines(outputs.enable, outputs.heartbeat, now_ns);
        Ok(())
    }

    /// Takes the samples of a period that ended at true time `now_s`, and sends the data that are due.
    pub(crate) fn send(&mut self, samples: &[SensorSample], now_s: f64) -> io::Result<()> {
        for sample in samples {
            self.report(sample);
        }
        if now_s < self.next_burst_s {
            return Ok(());
        }
        while self.next_burst_s <= now_s {
            self.next_burst_s += self.burst_period_s;
        }
        if !self.outbox.is_empty() {
            self.line.send(&self.outbox, now_s)?;
            self.outbox.clear();
        }
        Ok(())
    }

    fn report(&mut self, sample: &SensorSample) {
        let elapsed_us = (1e6 * sample.device_time_s).round() as u64;
        let number = self.number;
        self.number = self.number.wrapping_add(1);
        if take_one(&mut self.faults.drop) {
            return;
        }
        if self.faults.other_device {
            self.outbox.extend_from_slice(OTHER_TEXT);
            return;
        }
        let normal_n = if self.faults.saturated {
            self.range_n
        } else {
            sample.normal_n
        };
        let outputs = self.guard.outputs();
        let levels = [
            self.board.estop_healthy(),
            self.board.button(),
            // The person holds the switch only once a bench is connected.
            self.has_bench && self.board.dead_man(),
            outputs.enable,
            outputs.heartbeat,
            sample.normal_saturated || self.faults.saturated,
            sample.lateral_saturated,
            self.faults.converter_silent,
        ];
        let bits = levels.iter().enumerate();
        let reading = Reading {
            number,
            device_us: self.start_us.wrapping_add(elapsed_us as u32),
            counts: [normal_n, sample.lateral_n].map(counts),
            position: self.board.encoder_count() as i32,
            levels: bits.fold(0, |bits, (place, &high)| bits | u8::from(high) << place),
            stop: match self.guard.stop() {
                None => 0,
                Some(StopCause::BenchSilent) => 1,
                Some(StopCause::Estop) => 2,
                Some(StopCause::NotReleased) => 3,
            },
            last_word: self.last_word,
        };
        self.frame.clear();
        put_report(&reading, &mut self.frame);
        if take_one(&mut self.faults.corrupt) {
            let middle = self.frame.len() / 2;
            self.frame[middle] ^= 0x40;
        }
        self.outbox.extend_from_slice(&self.frame);
        if take_one(&mut self.faults.repeat) {
            self.outbox.extend_from_slice(&self.frame);
        }
    }
}

fn counts(force_n: f64) -> i32 {
    let counts = (force_n / FULL_SCALE_N * FULL_SCALE).round();
    counts.clamp(-FULL_SCALE, FULL_SCALE - 1.0) as i32
}
