//! Long computations: on threads that stay for later ones, while the thread of the interpreter reports progress and obeys Ctrl-C.

use std::mem;
use std::ops::ControlFlow;
use std::panic::{self, AssertUnwindSafe};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, unbounded};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::FrictionBenchError;

/// Time after which a pending Ctrl-C is obeyed.
const PATIENCE: Duration = Duration::from_millis(50);

/// Threads of the computations, and the process to which they belong.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

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

/// Returns the threads of this process. A process that forks leaves all threads behind but the one that forked, as
/// `multiprocessing` does on Linux by default up to Python 3.13: work given to the parent's threads would never end.
fn pool() -> PyResult<Arc<ThreadPool>> {
    let process = process::id();
    let mut current = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((owner, pool)) = &*current
        && *owner == process
    {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new().build().map_err(|error| {
        FrictionBenchError::new_err(format!(
            "no threads could be started for the computation ({error}): end other programs of yours, and try again"
        ))
    })?;
    let pool = Arc::new(pool);
    // The end of a parent's pool would notify threads that are not here.
    mem::forget(current.replace((process, Arc::clone(&pool))));
    Ok(pool)
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
    let outcome = Outcome::default();
    let worker_outcome = outcome.clone();
    pool()?.spawn(move || {
        worker_outcome.set(|| work(&tracker));
        // The last step has been seen once the outcome is there.
        drop(tracker);
    });
    if let Err(error) = follow(py, &steps, total, progress) {
        is_broken_off.store(true, Ordering::Relaxed);
        return Err(error);
    }
    Ok(outcome.value())
}

/// Runs `work` on borrowed data without the interpreter's lock. An exception of `progress`, which is called at its end, or of Ctrl-C
/// sets the flag that `work` receives; it is raised once `work` has returned.
pub(crate) fn run_borrowed<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let stop = AtomicBool::new(false);
    let outcome = Outcome::default();
    let (sender, steps) = unbounded();
    let (flag, worker_outcome) = (&stop, outcome.clone());
    let pool = pool()?;
    let followed = pool.in_place_scope(|scope| {
        scope.spawn(move |_| {
            worker_outcome.set(|| work(flag));
            // Without a listener the work is broken off.
            let _ = sender.send(());
        });
        let followed = follow(py, &steps, 1, progress);
        if followed.is_err() {
            stop.store(true, Ordering::Relaxed);
            // The scope waits for the work, which must not keep the interpreter.
            py.detach(|| while steps.recv().is_ok() {});
        }
        followed
    });
    followed?;
    Ok(outcome.value())
}

/// Value of a computation, or its panic.
struct Outcome<T>(Arc<Mutex<Option<thread::Result<T>>>>);

impl<T> Default for Outcome<T> {
    fn default() -> Self {
        Self(Arc::new(Mutex::new(None)))
    }
}

impl<T> Clone for Outcome<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> Outcome<T> {
    fn set(&self, work: impl FnOnce() -> T) {
        let outcome = panic::catch_unwind(AssertUnwindSafe(work));
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(outcome);
    }

    /// Returns the value of a computation that has ended, and goes on with its panic.
    fn value(&self) -> T {
        let outcome = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        match outcome {
            Some(Ok(value)) => value,
            Some(Err(payload)) => panic::resume_unwind(payload),
            None => unreachable!("the computation has ended"),
        }
    }
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
