//! The serial line: reads bytes and returns samples on the host's clock.

use config::{Correction, ForceProtocol};
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use impedance::clock_alignment::LowerEnvelope;
use safety::Nonsense;

use super::force_sample::{Decoder, ForceSample, LineFaults};
use super::frames::FrameDecoder;
use super::nonsense::NonsenseWatch;
use super::text_lines::LineDecoder;

/// A force sample on the host's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedForce {
    /// Sample with corrected forces.
    pub sample: ForceSample,
    /// Normal and lateral force as the sensor sent them, N.
    pub raw_n: [f64; 2],
    /// Time of sampling on the host's clock, s.
    pub host_s: f64,
}

/// A source of bytes that never blocks.
pub trait ForcePort: Send {
    /// Appends the bytes that have arrived.
    ///
    /// # Errors
    /// When the port has disappeared.
    fn read_waiting(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()>;
}

struct SerialPort {
    port: Box<dyn serialport::SerialPort>,
    buffer: Box<[u8]>,
}

impl ForcePort for SerialPort {
    fn read_waiting(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()> {
        while self.port.bytes_to_read()? > 0 {
            match self.port.read(&mut self.buffer) {
                Ok(0) => return Err(ErrorKind::BrokenPipe.into()),
                Ok(read) => bytes.extend_from_slice(&self.buffer[..read]),
                Err(error)
                    if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) =>
                {
                    return Ok(());
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// Opens a serial port for listening.
///
/// # Errors
/// When the port is missing, busy or forbidden.
pub fn open_port(path: &Path, baud: u32) -> anyhow::Result<Box<dyn ForcePort>> {
    let port = serialport::new(path.to_string_lossy(), baud)
        .timeout(Duration::from_millis(1))
        .open()
        .with_context(|| {
            format!(
                "cannot open the force sensor's port {}: is it plugged in, free, and may you use it? `friction-bench devices` lists the ports",
                path.display()
            )
        })?;
    Ok(Box::new(SerialPort {
        port,
        buffer: vec![0; 4096].into(),
    }))
}

/// A force sensor as a source of samples on the host's clock.
pub struct ForceLink {
    port: Box<dyn ForcePort>,
    decoder: Box<dyn Decoder>,
    clock: LowerEnvelope,
    latency_s: f64,
    correction: Correction,
    /// Reading from which on an axis is saturated, N.
    range_n: f64,
    bytes: Vec<u8>,
    samples: Vec<ForceSample>,
    nonsense: NonsenseWatch,
}

impl ForceLink {
    /// Makes a link on `port`; `latency_s` is the shortest time from sampling to arrival, s.
    pub fn new(
        port: Box<dyn ForcePort>,
        protocol: ForceProtocol,
        latency_s: f64,
        correction: Correction,
    ) -> Self {
        Self {
            port,
            decoder: decoder(protocol),
            clock: LowerEnvelope::default(),
            latency_s,
            correction,
            range_n: f64::INFINITY,
            bytes: Vec::new(),
            samples: Vec::new(),
            nonsense: NonsenseWatch::default(),
        }
    }

    /// Takes an axis that reads `range_n` or more, in N and either way, for saturated.
    #[must_use]
    pub fn with_range(mut self, range_n: f64) -> Self {
        self.range_n = range_n;
        self
    }

    /// Reads the port and passes each new sample to `take`; `now_s` is the host's clock, s.
    ///
    /// # Errors
    /// When the port has disappeared.
    pub fn poll(
        &mut self,
        now_s: impl Fn() -> f64,
        mut take: impl FnMut(TimedForce),
    ) -> std::io::Result<()> {
        self.bytes.clear();
        self.port.read_waiting(&mut self.bytes)?;
        // Read only now: bytes may have arrived after the caller read the clock, and no arrival may be stated early.
        let arrival_s = now_s();
        self.samples.clear();
        self.decoder.decode(&self.bytes, &mut self.samples);
        // The last sample of a burst has waited least: it alone shows the delay.
        if let Some(last) = self.samples.last() {
            // The decoder lets only advancing times pass.
            let _ = self.clock.observe(seconds(last.device_us), arrival_s);
        }
        for &sample in &self.samples {
            if let Some(host_s) = self.clock.to_host_s(seconds(sample.device_us)) {
                let raw_n = [sample.normal_n, sample.lateral_n];
                let [normal_n, lateral_n] = self.correction.forces_n(raw_n);
                take(TimedForce {
                    sample: ForceSample {
                        normal_n,
                        lateral_n,
                        normal_saturated: sample.normal_saturated || raw_n[0].abs() >= self.range_n,
                        lateral_saturated: sample.lateral_saturated
                            || raw_n[1].abs() >= self.range_n,
                        ..sample
                    },
                    raw_n,
                    host_s: host_s - self.latency_s,
                });
            }
        }
        Ok(())
    }

    /// Returns what the port has sent instead of readings, up to the last poll, which was at `now_ns`.
    pub fn nonsense(&mut self, now_ns: u64) -> Nonsense {
        let (bytes, readings) = (self.bytes.len() as u64, self.samples.len() as u64);
        self.nonsense.take(now_ns, bytes, readings)
    }

    /// Returns the faults of the line so far.
    pub fn faults(&self) -> LineFaults {
        self.decoder.faults()
    }

    /// Returns the drift of the host's clock against the sensor's, ppm; `None` until it is known.
    pub fn drift_ppm(&self) -> Option<f64> {
        self.clock.settled().then(|| self.clock.drift_ppm())
    }
}

fn seconds(device_us: u64) -> f64 {
    device_us as f64 * 1e-6
}

/// Returns a decoder of `protocol` in its initial state.
pub fn decoder(protocol: ForceProtocol) -> Box<dyn Decoder> {
    match protocol {
        ForceProtocol::Frames => Box::new(FrameDecoder::default()),
        ForceProtocol::Lines => Box::new(LineDecoder::default()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A port on which some text has arrived.
    struct Arrived(&'static [u8]);

    impl ForcePort for Arrived {
        fn read_waiting(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()> {
            bytes.extend_from_slice(std::mem::take(&mut self.0));
            Ok(())
        }
    }

    /// Fault 23.
    #[test]
    fn an_axis_at_the_end_of_its_stated_range_is_saturated_either_way() {
        let lines = b"0,0,0\n1000,9990,0\n2000,10000,0\n3000,-10200,100\n4000,500,-10000\n";
        let read = |range_n: Option<f64>| {
            let port = Box::new(Arrived(lines));
            let link = ForceLink::new(port, ForceProtocol::Lines, 0.0, Correction::default());
            let mut link = match range_n {
                Some(range_n) => link.with_range(range_n),
                None => link,
            };
            let mut saturated = Vec::new();
            let take = |force: TimedForce| {
                let ForceSample {
                    normal_saturated,
                    lateral_saturated,
                    ..
                } = force.sample;
                saturated.push((normal_saturated, lateral_saturated));
            };
            link.poll(|| 1.0, take).unwrap();
            saturated
        };
        let expected = [(false, false), (true, false), (true, false), (false, true)];
        assert_eq!(read(Some(10.0)), expected);
        assert_eq!(read(None), [(false, false); 4]);
    }
}
