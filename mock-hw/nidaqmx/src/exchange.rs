//! Exchange between apparatus and tasks in a period: first the output samples, then the input samples.

use std::slice;
use std::time::{Duration, Instant};

use mock_hw::rack::GONE;

use crate::status::{OVERWRITTEN, RAN_DRY};
use crate::twin::{CHANGED, Kind, lock};

/// Full scale of the simulated converters, V.
pub(crate) const FULL_SCALE_V: f64 = 10.0;
/// Timeout of a stepped apparatus that waits for its program; a program that hangs does not block it forever.
const LONGEST_WAIT: Duration = Duration::from_secs(20);

/// Plays one period of the first output.
pub(crate) extern "C" fn play(samples: *mut f32, len: usize) {
    // SAFETY: the apparatus lends a buffer of that length.
    let samples = unsafe { slice::from_raw_parts_mut(samples, len) };
    let mut twin = lock();
    twin.inputs_ran = twin.streaming_task(Kind::Input).is_some();
    let inputs_ran = twin.inputs_ran;
    let mut held_v = twin.held_v;
    let mut played_frames = 0;
    if let Some(task) = twin.streaming_task(Kind::Output)
        && (task.trigger.is_none() || inputs_ran)
    {
        let channels = task.channels.len();
        for sample in &mut *samples {
            if task.buffer_v.len() < channels {
                task.stopped_by = Some(RAN_DRY);
                break;
            }
            let mut frame = task.buffer_v.drain(..channels);
            held_v = frame.next().unwrap_or(0.0);
            *sample = (held_v / FULL_SCALE_V) as f32;
            played_frames += 1;
        }
    }
    for sample in &mut samples[played_frames..] {
        *sample = (held_v / FULL_SCALE_V) as f32;
    }
    (twin.held_v, twin.played_frames) = (held_v, played_frames);
    CHANGED.notify_all();
}

/// Records one period of the inputs.
pub(crate) extern "C" fn record(samples: *const f32, len: usize) {
    // SAFETY: the apparatus lends a buffer of that length.
    let samples = unsafe { slice::from_raw_parts(samples, len) };
    let mut twin = lock();
    let (inputs_ran, played_frames) = (twin.inputs_ran, twin.played_frames);
    let Some((width, is_stepped)) = twin
        .board
        .as_ref()
        .map(|board| (board.inputs as usize, board.stepped != 0))
    else {
        return;
    };
    if let Some(task) = twin.streaming_task(Kind::Input).filter(|_| inputs_ran) {
        let has_own_clock = task
            .clock
            .as_ref()
            .is_some_and(|clock| clock.source.is_empty());
        let frame_count = if has_own_clock {
            usize::MAX
        } else {
            played_frames
        };
        for frame in samples.chunks_exact(width).take(frame_count) {
            if task.buffer_v.len() >= task.buffer_frames * task.channels.len() {
                task.stopped_by = Some(OVERWRITTEN);
                break;
            }
            for channel in &task.channels {
                let value = frame.get(channel.number as usize).copied().unwrap_or(0.0);
                let volts = FULL_SCALE_V * f64::from(value);
                task.buffer_v
                    .push_back(volts.clamp(-channel.range_v, channel.range_v));
            }
        }
    }
    CHANGED.notify_all();
    // A stepped apparatus waits until the program has read all samples and asks for more.
    let began = Instant::now();
    while is_stepped && began.elapsed() < LONGEST_WAIT {
        let has_backlog = twin.streaming_task(Kind::Input).is_some_and(|task| {
            task.read_request
                .is_none_or(|request| task.buffer_v.len() >= request)
        });
        if !has_backlog || twin.is_gone {
            return;
        }
        twin = twin.wait(Duration::from_millis(100));
    }
}

/// Handles a fault of the outputs or of the inputs.
pub(crate) extern "C" fn fail(output: u32, kind: u32) {
    let mut twin = lock();
    if kind == GONE {
        twin.is_gone = true;
    } else {
        let (kind, code) = if output != 0 {
            (Kind::Output, RAN_DRY)
        } else {
            (Kind::Input, OVERWRITTEN)
        };
        if let Some(task) = twin.streaming_task(kind) {
            task.stopped_by = Some(code);
        }
    }
    CHANGED.notify_all();
}
