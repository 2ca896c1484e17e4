//! Output direction: takes commands from a ring and renders the generator in the callback.

use rtrb::Consumer;

use crate::{
    attendance::AttendanceCheck,
    drive_handle::{DriveHandle, KillSwitch, SentCommand},
    generator::{DriveCommand, Generator},
    sample::ConverterSample,
    seqlock::StatePublisher,
    stream_health::{StreamDirection, StreamHealth},
    stream_layout::{LayoutError, nonzero},
};

/// Frames per rendered chunk.
const CHUNK_FRAMES: usize = 256;

/// Body of the output callback: executes the commands of its [`DriveHandle`] and renders the drive into one channel.
#[derive(Debug)]
pub struct DriveRenderer {
    generator: Generator,
    commands: Consumer<SentCommand>,
    kill_switch: KillSwitch,
    kills_obeyed: u64,
    attendance: AttendanceCheck,
    publisher: StatePublisher,
    health: StreamHealth,
    channels: usize,
    drive_channel: usize,
}

impl DriveRenderer {
    /// Connects `generator` to a handle. The drive goes to channel `drive_channel` (from 0) of `channels`; the other channels
    /// are silent.
    ///
    /// # Errors
    /// If there is no channel, or `drive_channel` is out of range.
    pub fn connect(
        generator: Generator,
        channels: usize,
        drive_channel: usize,
        health: StreamHealth,
    ) -> Result<(Self, DriveHandle), LayoutError> {
        nonzero("output.channels", channels)?;
        if drive_channel >= channels {
            return Err(LayoutError::DriveChannel {
                drive_channel,
                channels,
            });
        }
        let (handle, commands, kill_switch, publisher) = DriveHandle::connect();
        let renderer = Self {
            generator,
            commands,
            kill_switch,
            kills_obeyed: 0,
            attendance: AttendanceCheck::new(handle.attendance()),
            publisher,
            health,
            channels,
            drive_channel,
        };
        Ok((renderer, handle))
    }

    /// Executes the waiting commands, renders the interleaved `out` and publishes the state.
    ///
    /// Neither allocates, locks, logs nor panics; asserted by `tests/integration/real_time.rs` and, through cpal,
    /// `tests/integration/duplex`.
    pub fn render<T: ConverterSample>(&mut self, out: &mut [T]) {
        self.health.beat(StreamDirection::Output);
        self.obey();
        self.require_attendance(out.len() / self.channels);
        let mut drive = [0.0_f32; CHUNK_FRAMES];
        for chunk in out.chunks_mut(CHUNK_FRAMES * self.channels) {
            let frames = chunk.len() / self.channels;
            let drive = &mut drive[..frames];
            self.generator.fill(drive);
            chunk.fill(T::ZERO);
            for (frame, &value) in chunk.chunks_exact_mut(self.channels).zip(drive.iter()) {
                frame[self.drive_channel] = T::from_unit(value);
            }
        }
        self.publisher.publish(&self.generator.state());
    }

    fn require_attendance(&mut self, frames: usize) {
        let phase = self.generator.state().phase;
        let is_driven = !phase.is_silent() && !phase.is_latched();
        if self.attendance.is_missed(frames) && is_driven {
            self.kill_switch.kill();
            self.obey_kills();
        }
    }

    fn obey(&mut self) {
        while let Ok(sent) = self.commands.pop() {
            self.obey_kills();
            if sent.command == DriveCommand::Rearm && sent.kills_known != self.kills_obeyed {
                continue;
            }
            self.generator.apply(sent.command);
        }
        self.obey_kills();
        if self.commands.is_abandoned() {
            self.generator.apply(DriveCommand::EmergencyStop);
        }
    }

    fn obey_kills(&mut self) {
        let kills = self.kill_switch.kills();
        if kills != self.kills_obeyed {
            self.kills_obeyed = kills;
            self.generator.apply(DriveCommand::EmergencyStop);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive_program::{DriveConfig, DriveSettings};

    #[test]
    fn layouts_without_the_drives_channel_are_refused() {
        let settings = DriveSettings::new(DriveConfig {
            sample_rate_hz: 192_000,
            volts_per_unit: 100.0,
            limit_v: 80.0,
            ramp_s: 0.05,
        })
        .unwrap();
        let connect = |channels, drive_channel| {
            let generator = Generator::new(settings);
            DriveRenderer::connect(generator, channels, drive_channel, StreamHealth::new())
                .map(|_| ())
        };
        assert_eq!(connect(2, 1), Ok(()));
        assert_eq!(
            connect(2, 2),
            Err(LayoutError::DriveChannel {
                drive_channel: 2,
                channels: 2
            })
        );
        let parameter = "output.channels";
        assert_eq!(connect(0, 0), Err(LayoutError::Zero { parameter }));
    }
}
