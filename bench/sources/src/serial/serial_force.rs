//! The serial line as a source of forces.

use config::{Correction, ForceProtocol};
use safety::Nonsense;

use super::decoder::{Decoder, ForceSample};
use super::frames::FrameDecoder;
use super::port::ForcePort;
use super::text_lines::LineDecoder;
use crate::correct::Corrector;
use crate::force_source::{ForceSource, Moment, SourceHealth, TimedForce};
use crate::gone::SourceGone;
use crate::nonsense::NonsenseWatch;
use crate::sensor_clock::SensorClock;

/// A force sensor on a serial line.
pub struct SerialForce {
    port: Box<dyn ForcePort>,
    decoder: Box<dyn Decoder>,
    clock: SensorClock,
    corrector: Corrector,
    bytes: Vec<u8>,
    samples: Vec<ForceSample>,
    nonsense: NonsenseWatch,
}

impl SerialForce {
    /// Makes a source on `port`; `latency_s` is the shortest time from sampling to arrival, s, and an axis that reads
    /// `range_n` or more, in N and either way, counts as saturated.
    pub fn new(
        port: Box<dyn ForcePort>,
        protocol: ForceProtocol,
        latency_s: f64,
        correction: Correction,
        range_n: Option<f64>,
    ) -> Self {
        Self {
            port,
            decoder: decoder(protocol),
            clock: SensorClock::new(latency_s),
            corrector: Corrector::new(correction, range_n),
            bytes: Vec::new(),
            samples: Vec::new(),
            nonsense: NonsenseWatch::default(),
        }
    }
}

impl ForceSource for SerialForce {
    fn poll(
        &mut self,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(TimedForce),
    ) -> Result<(), SourceGone> {
        self.bytes.clear();
        let read = self.port.read_waiting(&mut self.bytes);
        read.map_err(SourceGone::Port)?;
        // Read only now: bytes may have arrived after the caller read the clock, and no arrival may be stated early.
        let arrival_s = now_s();
        self.samples.clear();
        self.decoder.decode(&self.bytes, &mut self.samples);
        // The last sample of a burst has waited least: it alone shows the delay.
        if let Some(last) = self.samples.last() {
            self.clock.arrived(seconds(last.device_us), arrival_s);
        }
        for sample in &self.samples {
            if let Some(host_s) = self.clock.host_s(seconds(sample.device_us)) {
                take(self.corrector.force(
                    Moment::Host(host_s),
                    [sample.normal_n, sample.lateral_n],
                    [sample.normal_saturated, sample.lateral_saturated],
                ));
            }
        }
        Ok(())
    }

    fn health(&self) -> SourceHealth {
        SourceHealth {
            faults: self.decoder.faults(),
            drift_ppm: self.clock.drift_ppm(),
        }
    }

    fn nonsense(&mut self, now_ns: u64) -> Nonsense {
        let (bytes, readings) = (self.bytes.len() as u64, self.samples.len() as u64);
        self.nonsense.take(now_ns, bytes, readings)
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
