//! Stops the drive when no thread monitors it any longer.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

#[derive(Debug, Default)]
struct AttendanceCounters {
    times: AtomicU64,
    limit_frames: AtomicU64,
}

/// Reports to the output callback that the drive is monitored; lock-free. Once reports are required, a plate driven without
/// them is stopped as by [`crate::KillSwitch::kill`]: this covers a monitor that hangs, starves or has ended although nothing
/// else has failed.
#[derive(Clone, Debug, Default)]
pub struct Attendance(Arc<AttendanceCounters>);

impl Attendance {
    /// Requires at least one report per `limit_frames` rendered frames from now on.
    pub fn require(&self, limit_frames: u64) {
        self.show();
        let limit_frames = limit_frames.max(1);
        self.0.limit_frames.store(limit_frames, Ordering::Release);
    }

    /// Reports that the drive is monitored now.
    pub fn show(&self) {
        self.0.times.fetch_add(1, Ordering::AcqRel);
    }
}

/// The output callback's view of an [`Attendance`].
#[derive(Debug)]
pub(crate) struct AttendanceCheck {
    attendance: Attendance,
    times_seen: u64,
    /// Frames rendered since the latest report.
    missed_frames: u64,
}

impl AttendanceCheck {
    pub(crate) fn new(attendance: Attendance) -> Self {
        Self {
            attendance,
            times_seen: 0,
            missed_frames: 0,
        }
    }

    /// Counts `frames` that are about to be rendered; returns whether a required report is overdue.
    pub(crate) fn is_missed(&mut self, frames: usize) -> bool {
        let latest = &self.attendance.0;
        let times = latest.times.load(Ordering::Acquire);
        if times != self.times_seen {
            self.times_seen = times;
            self.missed_frames = 0;
        }
        self.missed_frames = self.missed_frames.saturating_add(frames as u64);
        let limit_frames = latest.limit_frames.load(Ordering::Acquire);
        limit_frames > 0 && self.missed_frames > limit_frames
    }
}

#[cfg(test)]
mod tests {
    use crate::drive_handle::DriveHandle;
    use crate::drive_program::{DriveConfig, DriveSettings, Waveform};
    use crate::generator::{DriveCommand, DrivePhase, Generator};
    use crate::renderer::DriveRenderer;
    use crate::stream_health::StreamHealth;

    const BLOCK: usize = 192;

    fn drive_pair() -> (DriveRenderer, DriveHandle) {
        let settings = DriveSettings::new(DriveConfig {
            sample_rate_hz: 192_000,
            volts_per_unit: 100.0,
            limit_v: 80.0,
            ramp_s: 0.005,
        })
        .unwrap();
        let (mut renderer, mut drive) =
            DriveRenderer::connect(Generator::new(settings), 1, 0, StreamHealth::new()).unwrap();
        let tone = settings.admit(Waveform::Tone {
            carrier_hz: 35_000.0,
            amplitude_v: 40.0,
        });
        drive.send(DriveCommand::Start(tone.unwrap())).unwrap();
        for _ in 0..10 {
            renderer.render(&mut [0.0_f32; BLOCK]);
        }
        (renderer, drive)
    }

    /// Renders a block, and returns the drive's phase.
    fn phase(renderer: &mut DriveRenderer, drive: &DriveHandle) -> DrivePhase {
        renderer.render(&mut [0.0_f32; BLOCK]);
        drive.state().phase
    }

    #[test]
    fn a_drive_without_required_attendance_continues() {
        let (mut renderer, drive) = drive_pair();
        for _ in 0..1000 {
            assert_eq!(phase(&mut renderer, &drive), DrivePhase::Steady);
        }
    }

    /// Hazard 15.
    #[test]
    fn a_drive_that_is_not_watched_any_more_stops_and_stays_silent() {
        let (mut renderer, mut drive) = drive_pair();
        let attendance = drive.attendance();
        attendance.require(10 * BLOCK as u64);
        for block in 0..100 {
            if block % 9 == 0 {
                attendance.show();
            }
            assert_eq!(phase(&mut renderer, &drive), DrivePhase::Steady, "{block}");
        }
        attendance.show();
        let blocks = (0..100).take_while(|_| phase(&mut renderer, &drive) == DrivePhase::Steady);
        assert_eq!(blocks.count(), 10);
        assert_eq!(drive.kill_switch().kills(), 1);
        for _ in 0..50 {
            phase(&mut renderer, &drive);
        }
        assert_eq!(phase(&mut renderer, &drive), DrivePhase::EmergencyStopped);
        assert_eq!(
            drive.kill_switch().kills(),
            1,
            "a silent drive need not be watched"
        );
        // A late report starts nothing; a re-arming decided before the stop does not undo it.
        attendance.show();
        drive.rearm_after(0).unwrap();
        assert_eq!(phase(&mut renderer, &drive), DrivePhase::EmergencyStopped);
    }
}
