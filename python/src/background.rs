//! Long computations: on a thread of their own, while the thread of the interpreter reports progress and obeys Ctrl-C.

use std::ops::ControlFlow;
use std::panic;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, unbounded};
use pyo3::prelude::*;

/// Time after which a pending Ctrl-C is obeyed.
const PATIENCE: Duration = Duration::from_millis(50);

/// Steps of a computation, which ask whether to go on.
pub(crate) struct Steps {
    is_broken_off: Arc<AtomicBool>,
    sender: Sender<()>,
}

impl Steps {
    /// Reports a step that is done.
    pub(crate) fn report(&self) -> ControlFlow<()> {
        // Without a listener the computation is broken off.
        let _ = self.sender.send(());
        if self.is_broken_off.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

/// Runs `work` of `total` steps without the interpreter's lock. `progress` is called with the number of steps done, and the total;
/// its exception ends the work and is raised, as is that of Ctrl-C: steps that are under way end later, unseen.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    total: usize,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Steps) -> T + Send + 'static,
) -> PyResult<T> {
    let is_broken_off = Arc::new(AtomicBool::new(false));
    let (sender, steps) = unbounded();
    let tracker = Steps {
        is_broken_off: Arc::clone(&is_broken_off),
        sender,
    };
    let worker = thread::spawn(move || work(&tracker));
    if let Err(error) = follow(py, &steps, total, progress) {
        is_broken_off.store(true, Ordering::Relaxed);
        return Err(error);
    }
    match py.detach(|| worker.join()) {
        Ok(value) => Ok(value),
        Err(payload) => panic::resume_unwind(payload),
    }
}

/// Runs `work` on borrowed data without the interpreter's lock. An exception of `progress`, which is called at its end, or of Ctrl-C
/// sets the flag that `work` receives; it is raised once `work` has returned.
pub(crate) fn run_borrowed<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        let (sender, steps) = unbounded();
        let flag = &stop;
        let worker = scope.spawn(move || {
            let value = work(flag);
            // Without a listener the work is broken off.
            let _ = sender.send(());
            value
        });
        let followed = follow(py, &steps, 1, progress);
        if followed.is_err() {
            stop.store(true, Ordering::Relaxed);
        }
        let value = py.detach(|| worker.join());
        followed?;
        match value {
            Ok(value) => Ok(value),
            Err(payload) => panic::resume_unwind(payload),
        }
    })
}

/// Follows the steps until the work is done.
fn follow(
    py: Python<'_>,
    steps: &Receiver<()>,
    total: usize,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    let mut done = 0;
    loop {
        let step = py.detach(|| steps.recv_timeout(PATIENCE));
        py.check_signals()?;
        match step {
            Ok(()) => {
                done += 1;
                if let Some(progress) = progress {
                    progress.call1((done, total))?;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}
