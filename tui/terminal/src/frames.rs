//! Output of frames to the terminal: each whole, synchronized (DEC mode 2026, ignored by terminals without it), in one
//! write, by a thread that may wait for a blocked terminal.

use std::io::{self, Write};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

const BEGIN: &[u8] = b"\x1b[?2026h";
const END: &[u8] = b"\x1b[?2026l";

/// Buffers a frame until it is flushed, then hands it to the writing thread.
#[derive(Debug)]
pub struct FrameWriter {
    frame: Vec<u8>,
    to: Sender<Vec<u8>>,
    frames: Frames,
}

/// Status of the frames handed over.
#[derive(Clone, Debug, Default)]
pub struct Frames(Arc<Underway>);

#[derive(Debug, Default)]
struct Underway {
    state: Mutex<State>,
    change: Condvar,
}

#[derive(Debug, Default)]
struct State {
    unwritten: usize,
    error: Option<io::Error>,
}

impl FrameWriter {
    /// Starts the thread that writes to `to`. It ends after the writer is dropped and all frames are written.
    ///
    /// # Errors
    /// An error if the system cannot start a thread.
    pub fn start(to: impl Write + Send + 'static) -> io::Result<Self> {
        let (sender, receiver) = mpsc::channel();
        let frames = Frames::default();
        let queue = frames.clone();
        std::thread::Builder::new()
            .name("frames".to_owned())
            .spawn(move || queue.write(to, &receiver))?;
        Ok(Self {
            frame: Vec::with_capacity(1 << 16),
            to: sender,
            frames,
        })
    }

    /// Returns the status of the frames handed over.
    #[must_use]
    pub fn frames(&self) -> Frames {
        self.frames.clone()
    }
}

impl Frames {
    /// Whether all frames are written. Another frame before that would only add to the delay.
    #[must_use]
    pub fn are_written(&self) -> bool {
        self.0.lock().unwritten == 0
    }

    /// Waits until all frames are written, at most for `limit`. Returns whether they are.
    pub(crate) fn wait(&self, limit: Duration) -> bool {
        let (state, _) = self
            .0
            .change
            .wait_timeout_while(self.0.lock(), limit, |state| state.unwritten > 0)
            .unwrap_or_else(PoisonError::into_inner);
        state.unwritten == 0
    }

    fn write(&self, mut to: impl Write, receiver: &Receiver<Vec<u8>>) {
        for frame in receiver {
            let result = to.write_all(&frame).and_then(|()| to.flush());
            let mut state = self.0.lock();
            state.unwritten -= 1;
            if let Err(error) = result {
                state.error.get_or_insert(error);
            }
            self.0.change.notify_all();
        }
    }
}

impl Underway {
    fn lock(&self) -> MutexGuard<'_, State> {
        // No panic can leave the state half-changed, so a poisoned one is valid.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for FrameWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.frame.is_empty() {
            self.frame.extend_from_slice(BEGIN);
        }
        self.frame.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    /// Hands the frame over.
    ///
    /// # Errors
    /// The terminal's error for an earlier frame.
    fn flush(&mut self) -> io::Result<()> {
        let mut state = self.frames.0.lock();
        if let Some(error) = state.error.take() {
            return Err(error);
        }
        if self.frame.is_empty() {
            return Ok(());
        }
        self.frame.extend_from_slice(END);
        state.unwritten += 1;
        drop(state);
        let buffer = Vec::with_capacity(self.frame.capacity());
        let frame = std::mem::replace(&mut self.frame, buffer);
        self.to
            .send(frame)
            .map_err(|_| io::Error::from(io::ErrorKind::BrokenPipe))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(20);

    #[derive(Clone, Default)]
    struct Written(Arc<Mutex<Vec<Vec<u8>>>>);

    impl Write for Written {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().push(bytes.to_vec());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    struct StandsStill(Receiver<()>);

    impl Write for StandsStill {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let broken_pipe = |_| io::Error::from(io::ErrorKind::BrokenPipe);
            self.0.recv().map_err(broken_pipe)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_frame_is_one_synchronized_write() {
        let sink = Written::default();
        let mut writer = FrameWriter::start(sink.clone()).unwrap();
        writer.write_all(b"one").unwrap();
        writer.write_all(b" two").unwrap();
        writer.flush().unwrap();
        writer.flush().unwrap();
        assert!(writer.frames().wait(LONG));
        let frames = sink.0.lock().unwrap();
        assert_eq!(*frames, [b"\x1b[?2026hone two\x1b[?2026l".to_vec()]);
    }

    #[test]
    fn a_blocked_terminal_never_blocks_the_writer() {
        let (resume, terminal) = mpsc::channel();
        let mut writer = FrameWriter::start(StandsStill(terminal)).unwrap();
        for _ in 0..2 {
            writer.write_all(b"frame").unwrap();
            writer.flush().unwrap();
        }
        let frames = writer.frames();
        assert!(!frames.are_written());
        assert!(!frames.wait(Duration::from_millis(1)));
        resume.send(()).unwrap();
        resume.send(()).unwrap();
        assert!(frames.wait(LONG));
        assert!(frames.are_written());
    }

    #[test]
    fn the_next_frame_reports_a_failed_terminal() {
        let (resume, terminal) = mpsc::channel();
        drop(resume);
        let mut writer = FrameWriter::start(StandsStill(terminal)).unwrap();
        writer.write_all(b"frame").unwrap();
        writer.flush().unwrap();
        assert!(writer.frames().wait(LONG));
        let error = writer.flush().unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
    }
}
