//! Line output that does not block on a stalled reader.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, SyncSender, TrySendError};
use std::thread::{self, JoinHandle};

use anyhow::Context;

/// Capacity of the queue of lines; further lines are dropped.
const WAITING_LINES: usize = 1 << 16;

/// Output that never makes its writer wait for the reader: a separate thread writes the lines, since a pipe may be full and a
/// terminal stopped. Dropping it waits until all lines are written.
///
/// ```
/// use std::io::Write;
///
/// let (reader, writer) = std::io::pipe()?;
/// let mut lines = operator_ui::console::LineQueue::start(writer)?;
/// writeln!(lines, "trial 1 of 12")?;
/// drop(lines);
/// assert_eq!(std::io::read_to_string(reader)?, "trial 1 of 12\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LineQueue {
    line: Vec<u8>,
    /// `None` only during drop.
    queue: Option<SyncSender<Vec<u8>>>,
    unread: Arc<AtomicBool>,
    writer: Option<JoinHandle<()>>,
}

impl LineQueue {
    /// Starts the thread that writes to `out`.
    ///
    /// # Errors
    /// If the system refuses a thread.
    pub fn start(mut out: impl Write + Send + 'static) -> anyhow::Result<Self> {
        let (queue, lines) = mpsc::sync_channel::<Vec<u8>>(WAITING_LINES);
        let unread = Arc::new(AtomicBool::new(false));
        let closed = Arc::clone(&unread);
        let writer = thread::Builder::new()
            .name("lines".to_owned())
            .spawn(move || {
                for line in lines {
                    if out.write_all(&line).and_then(|()| out.flush()).is_err() {
                        closed.store(true, Ordering::Release);
                        return;
                    }
                }
            })
            .context("cannot start the thread that writes lines")?;
        Ok(Self {
            line: Vec::new(),
            queue: Some(queue),
            unread,
            writer: Some(writer),
        })
    }

    fn hand_over(&mut self) -> io::Result<()> {
        if self.line.is_empty() {
            return Ok(());
        }
        let line = std::mem::take(&mut self.line);
        let broken_pipe = || Err(io::Error::from(io::ErrorKind::BrokenPipe));
        match self.queue.as_ref().map(|queue| queue.try_send(line)) {
            None | Some(Err(TrySendError::Disconnected(_))) => broken_pipe(),
            // The line is dropped: the reader has not read for hours.
            Some(Ok(()) | Err(TrySendError::Full(_))) if self.unread.load(Ordering::Acquire) => {
                broken_pipe()
            }
            Some(Ok(()) | Err(TrySendError::Full(_))) => Ok(()),
        }
    }
}

impl Write for LineQueue {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.line.extend_from_slice(bytes);
        if self.line.ends_with(b"\n") {
            self.hand_over()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.hand_over()
    }
}

impl Drop for LineQueue {
    fn drop(&mut self) {
        let _ = self.hand_over();
        self.queue = None;
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::Receiver;

    use super::*;

    /// A reader that takes a line only when the test allows it.
    struct StandsStill(Receiver<()>);

    impl Write for StandsStill {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            match self.0.recv() {
                Ok(()) => Ok(bytes.len()),
                Err(_) => Err(io::Error::from(io::ErrorKind::BrokenPipe)),
            }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// Fault 49.
    #[test]
    fn a_reader_who_stands_still_keeps_no_writer_waiting() {
        let (goes_on, reader) = mpsc::channel();
        let mut lines = LineQueue::start(StandsStill(reader)).unwrap();
        for _ in 0..2 * WAITING_LINES {
            writeln!(lines, "not read").unwrap();
        }
        drop(goes_on);
        let failure = std::iter::repeat_with(|| {
            thread::yield_now();
            writeln!(lines, "to nobody")
        })
        .find_map(Result::err);
        assert_eq!(
            failure.map(|error| error.kind()),
            Some(io::ErrorKind::BrokenPipe)
        );
    }
}
