//! Apparatus as outboard equipment of another audio server.
//!
//! The server sets the pace, the person receives no percepts, and there is no GPIO: the amplifier is always on, and the finger
//! follows a timetable that starts each time the drive comes on.

use std::path::PathBuf;

use super::apparatus_error::ApparatusError;
use super::force_side::ForceSide;
use crate::serial::DeviceStart;
use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::scenario::Scenario;

/// Generator output, full scale 1, above which it counts as drive.
const DRIVEN: f32 = 1e-3;
/// Silence after which the drive counts as off, s.
const SILENCE_S: f64 = 0.5;
/// Time in which the normal force rises to its full value, s.
const LANDING_S: f64 = 0.1;

/// Motion of the finger from each start of the drive until it goes off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timetable {
    /// Time from the beginning of the drive to the landing of the finger, s.
    pub touch_after_s: f64,
    /// Time from landing to the beginning of the slide, s.
    pub slide_after_s: f64,
    /// Position at which the finger lands, m along the plate.
    pub from_m: f64,
    /// Position at which the finger turns back, m along the plate.
    pub to_m: f64,
    /// Speed of the slide in both directions, m/s.
    pub speed_m_per_s: f64,
    /// Normal force of the finger, N.
    pub normal_n: f64,
}

impl Default for Timetable {
    /// Returns the published exploration, preceded by 1.5 s without the finger.
    fn default() -> Self {
        Self {
            touch_after_s: 1.5,
            slide_after_s: 0.5,
            from_m: 0.010,
            to_m: 0.095,
            speed_m_per_s: 0.050,
            normal_n: 0.65,
        }
    }
}

impl Timetable {
    /// Returns the finger's state `driven_s` after the drive came on.
    fn finger(&self, driven_s: f64) -> FingerState {
        let on_plate_s = driven_s - self.touch_after_s;
        if on_plate_s <= 0.0 {
            return FingerState {
                position_m: self.from_m,
                ..FingerState::default()
            };
        }
        let length_m = self.to_m - self.from_m;
        let travelled_m = self.speed_m_per_s * (on_plate_s - self.slide_after_s).max(0.0);
        let lap_m = travelled_m % (2.0 * length_m.abs());
        let (distance_m, way) = if lap_m <= length_m.abs() {
            (lap_m, 1.0)
        } else {
            (2.0 * length_m.abs() - lap_m, -1.0)
        };
        let is_sliding = on_plate_s > self.slide_after_s;
        FingerState {
            position_m: self.from_m + distance_m * length_m.signum(),
            velocity_m_per_s: if is_sliding {
                way * self.speed_m_per_s * length_m.signum()
            } else {
                0.0
            },
            normal_n: self.normal_n * (on_plate_s / LANDING_S).min(1.0),
            touching: true,
        }
    }
}

/// An apparatus connected between the output and the input of an audio server.
pub struct Outboard {
    plant: Plant,
    force: ForceSide,
    timetable: Timetable,
    interval_s: f64,
    frame: u64,
    /// First and last frame of the present period of drive.
    driven: Option<(u64, u64)>,
}

impl Outboard {
    /// Builds an apparatus at the audio server's rate, with the serial line of its force sensor.
    ///
    /// # Errors
    /// [`ApparatusError::Serial`] if the system provides no pseudo-terminal, [`ApparatusError::NoLines`] for a field box.
    pub fn new(
        scenario: &Scenario,
        seed: u64,
        rate_hz: u32,
        timetable: Timetable,
    ) -> Result<Self, ApparatusError> {
        let start = DeviceStart::draw(seed);
        let clock_rate = 1.0 + 1e-6 * scenario.converter.clock_ppm;
        Ok(Self {
            plant: Plant::new(scenario, seed, f64::from(rate_hz)),
            force: ForceSide::open(&scenario.force_sensor, start, false, None)?,
            timetable,
            interval_s: 1.0 / (f64::from(rate_hz) * clock_rate),
            frame: 0,
            driven: None,
        })
    }

    /// Returns the number of input channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.plant.channels()
    }

    /// Returns the path of the force sensor's serial port.
    ///
    /// # Errors
    /// [`ApparatusError::NoSerialPort`] if the operating system has no pseudo-terminals.
    pub fn force_port(&self) -> Result<PathBuf, ApparatusError> {
        self.force.path().ok_or(ApparatusError::NoSerialPort {
            device: "force sensor",
        })
    }

    /// Whether the finger is on the plate.
    #[must_use]
    pub fn is_touched(&self) -> bool {
        self.finger().touching
    }

    /// Simulates one period: generator samples in, interleaved inputs out. Neither allocates nor blocks.
    ///
    /// # Errors
    /// [`ApparatusError::Serial`] if the serial line has failed.
    ///
    /// # Panics
    /// If `inputs` is not `drive.len() · channels()` long.
    pub fn process(&mut self, drive: &[f32], inputs: &mut [f32]) -> Result<(), ApparatusError> {
        self.listen(drive);
        self.frame += drive.len() as u64;
        let finger = self.finger();
        self.plant.step(drive, true, &finger, inputs);
        self.force
            .send(self.plant.forces(), self.frame as f64 * self.interval_s)
    }

    fn listen(&mut self, drive: &[f32]) {
        if drive.iter().any(|sample| sample.abs() > DRIVEN) {
            let start_frame = self
                .driven
                .map_or(self.frame, |(start_frame, _)| start_frame);
            self.driven = Some((start_frame, self.frame));
        } else if self
            .driven
            .is_some_and(|(_, last)| (self.frame - last) as f64 * self.interval_s > SILENCE_S)
        {
            self.driven = None;
        }
    }

    fn finger(&self) -> FingerState {
        let driven_s = self.driven.map_or(0.0, |(start_frame, _)| {
            (self.frame - start_frame) as f64 * self.interval_s
        });
        self.timetable.finger(driven_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_finger_lands_slides_and_turns_round() {
        let timetable = Timetable::default();
        let finger_at = |driven_s| timetable.finger(driven_s);
        assert!(!finger_at(1.4).touching);
        assert!((finger_at(1.55).normal_n - 0.325).abs() < 1e-9, "landing");
        assert_eq!(
            (finger_at(1.9).velocity_m_per_s, finger_at(1.9).position_m),
            (0.0, 0.010)
        );
        let way_out = finger_at(2.0 + 1.0);
        assert!((way_out.position_m - 0.060).abs() < 1e-9 && way_out.velocity_m_per_s > 0.0);
        let way_back = finger_at(2.0 + 1.7 + 1.0);
        assert!((way_back.position_m - 0.045).abs() < 1e-9 && way_back.velocity_m_per_s < 0.0);
    }
}
