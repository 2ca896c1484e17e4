//! Health of the bench's tasks and devices.

use devices::DeviceReadings;
use recording::pipeline::Account;
use safety::LostDevice;
use tui::event::{LineStates, LostDevices, SystemHealth};

use crate::bench_page::processor::ProcessorMeter;

/// Time between two reports of health, ns.
const PERIOD_NS: u64 = 500_000_000;

/// Reads the health of the bench, and the rates since the last reading.
#[derive(Debug, Default)]
pub struct HealthMeter {
    processor: ProcessorMeter,
    due_ns: u64,
    /// Time, frames and samples of the force sensor at the last reading.
    last: Option<(u64, u64, u64)>,
    /// Devices lost at the last reading.
    lost: LostDevices,
}

impl HealthMeter {
    /// Returns the health twice a second, and as soon as a device is lost; the caller fills in recorder and disk if it records.
    pub fn read(
        &mut self,
        now_ns: u64,
        account: &Account,
        gauges: &DeviceReadings,
        rate_hz: u32,
    ) -> Option<SystemHealth> {
        let includes = |device| gauges.losses.includes(device);
        let lost = LostDevices {
            force_sensor: includes(LostDevice::ForceSensor),
            encoder: includes(LostDevice::Encoder),
            sound_card: includes(LostDevice::SoundCard),
        };
        let is_early = now_ns < self.due_ns;
        if is_early && lost == self.lost {
            return None;
        }
        self.lost = lost;
        self.due_ns = now_ns + PERIOD_NS;
        let field = gauges.field.get().unwrap_or_default();
        let faults = field.force;
        let lines = gauges.lines.get().unwrap_or_default();
        let reading = (now_ns, account.frames, field.force_samples);
        // Rates over less than the period would be chance.
        let last = if is_early {
            None
        } else {
            self.last.replace(reading)
        };
        let per_second = |count: u64, since_ns: u64| {
            count as f64 / (now_ns.saturating_sub(since_ns).max(1) as f64 * 1e-9)
        };
        let ago_s = |at_ns: u64| now_ns.saturating_sub(at_ns) as f64 * 1e-9;
        Some(SystemHealth {
            xruns_in: account.input_xruns,
            xruns_out: account.output_xruns,
            ring_fill: gauges.ring_fill.get().unwrap_or_default(),
            clock_drift_ppm: gauges.force_clock_ppm(),
            clock_residual_s: gauges.force_residual_s(),
            clock_off: gauges.clock_off(),
            frames: account.frames,
            lost_frames: account.lost_frames,
            force_rate_hz: last
                .filter(|_| field.force_samples > 0)
                .map(|(at_ns, _, samples)| per_second(field.force_samples - samples, at_ns)),
            speed: last.map_or(1.0, |(at_ns, frames, _)| {
                per_second(account.frames - frames, at_ns) / f64::from(rate_hz)
            }),
            force_faults: faults.corrupt
                + faults.lost
                + faults.repeated
                + faults.reordered
                + faults.failed
                + faults.restarted,
            encoder_skipped: field.encoder_skipped,
            cores: self.processor.cores(now_ns as f64 * 1e-9),
            lost,
            lines: LineStates {
                estop_open: lines.estop_open,
                heartbeat_beats: lines.beats,
                button_pressed: field.button_pressed,
                button_presses: field.button_presses,
                estop_open_ago_s: lines.estop_open_ns.map(ago_s),
                button_press_ago_s: field.button_press_ns.map(ago_s),
            },
            ..SystemHealth::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use devices::FieldHealth;
    use safety::LineLevels;
    use tui::event::BenchLine;

    #[test]
    fn a_lost_device_is_reported_at_once_and_once() {
        let gauges = DeviceReadings::default();
        let mut meter = HealthMeter::default();
        let mut lost = |now_ns| {
            let health = meter.read(now_ns, &Account::default(), &gauges, 192_000);
            health.map(|health| health.lost.force_sensor)
        };
        assert_eq!(lost(0), Some(false));
        gauges.losses.report(LostDevice::ForceSensor);
        assert_eq!(lost(1_000_000), Some(true));
        assert_eq!(lost(2_000_000), None);
    }

    #[test]
    fn a_press_between_two_looks_is_shown_with_its_age() {
        let gauges = DeviceReadings::default();
        let mut meter = HealthMeter::default();
        let mut look = |now_ns| {
            let health = meter.read(now_ns, &Account::default(), &gauges, 192_000);
            health.map(|health| health.lines)
        };
        assert!(look(0).is_some());
        gauges.field.set(FieldHealth {
            button_pressed: Some(false),
            button_presses: 1,
            button_press_ns: Some(100_000_000),
            ..FieldHealth::default()
        });
        gauges.lines.set(LineLevels {
            estop_open: Some(false),
            estop_open_ns: Some(200_000_000),
            ..LineLevels::default()
        });
        assert!(look(499_000_000).is_none(), "twice a second");
        let lines = look(2_200_000_000).unwrap();
        assert_eq!(lines.button_press_ago_s, Some(2.1));
        let words = |line| lines.describe(line).unwrap().0;
        assert_eq!(words(BenchLine::Button), "not pressed; pressed 2 s ago");
        assert_eq!(words(BenchLine::Estop), "closed; open 2 s ago");
    }
}
