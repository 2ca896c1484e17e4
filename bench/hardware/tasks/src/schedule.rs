//! Runs the bench's tasks, each on a separate thread or all in turn on one thread.
//!
//! Tasks share nothing but queues and snapshots. On one thread they keep step with an apparatus that advances its own
//! clock.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Context;

use crate::Clock;

/// One independent activity of the bench.
pub trait Task: Send {
    /// Returns the name of the task's thread, which its errors carry.
    fn name(&self) -> &'static str;
    /// Returns how long the task may sleep between polls when it has its own thread.
    fn period(&self) -> Duration;
    /// Prepares the task's own thread, on it, before the first poll. Not called when tasks share a thread.
    fn begin(&mut self) {}
    /// Does the work that is due at `now_ns` and returns; never waits for another task.
    ///
    /// # Errors
    /// A failure that must end the whole schedule.
    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()>;
    /// Does the work that must not wait for a stalled disk: called right after the task's last poll, independently of
    /// the other tasks.
    fn stop(&mut self) {}
    /// Completes the task's work, after all tasks have stopped.
    ///
    /// # Errors
    /// The remaining work has failed; the other tasks finish nevertheless.
    fn finish(&mut self) -> anyhow::Result<()> {
        Ok(())
    }
}

/// Apparatus with time that passes only in ticks.
pub trait Pacer: Send {
    /// Lets one tick of the apparatus pass; on return, all data of the tick can be read.
    ///
    /// # Errors
    /// The apparatus failed; the schedule ends.
    fn tick(&mut self) -> anyhow::Result<()>;
}

impl<F: FnMut() -> anyhow::Result<()> + Send> Pacer for F {
    fn tick(&mut self) -> anyhow::Result<()> {
        self()
    }
}

/// Way of running tasks.
pub enum Schedule {
    /// Each task on its own thread, on the computer's clock.
    Threads,
    /// All tasks on the calling thread, in the order given, one round per tick: deterministic.
    Lockstep(Box<dyn Pacer>),
}

/// A task panicked; the panic hook has run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Panicked;

impl std::fmt::Display for Panicked {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("panicked")
    }
}

impl std::error::Error for Panicked {}

/// Flag that any thread may raise to end a schedule, and that keeps the first failure.
///
/// ```
/// let stop = tasks::StopFlag::default();
/// let elsewhere = stop.clone();
/// elsewhere.fail("disk full".to_owned());
/// elsewhere.fail("queue overflowed".to_owned());
/// assert!(stop.is_raised());
/// assert_eq!(stop.failure(), Some("disk full"));
/// ```
#[derive(Clone, Default)]
pub struct StopFlag {
    raised: Arc<AtomicBool>,
    failure: Arc<OnceLock<String>>,
    busy: Arc<Mutex<Vec<&'static str>>>,
}

impl StopFlag {
    /// Asks the schedule to end.
    pub fn raise(&self) {
        self.raised.store(true, Ordering::Release);
    }

    /// Asks the schedule to end because something failed.
    pub fn fail(&self, why: String) {
        // Later failures are consequences of the first.
        let _ = self.failure.set(why);
        self.raise();
    }

    /// Returns whether the schedule has been asked to end.
    pub fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Acquire)
    }

    /// Returns the first failure; `None` if nothing failed.
    pub fn failure(&self) -> Option<&str> {
        self.failure.get().map(String::as_str)
    }

    /// Returns the names of the tasks that have not finished, in the order in which they began.
    pub fn busy(&self) -> Vec<&'static str> {
        self.tasks().clone()
    }

    fn tasks(&self) -> MutexGuard<'_, Vec<&'static str>> {
        self.busy.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the flag alone, for signal handlers.
    pub fn shared(&self) -> Arc<AtomicBool> {
        self.raised.clone()
    }
}

impl Schedule {
    /// Runs `tasks` until `stop` is raised or one of them fails; then each stops independently, and then they finish in
    /// order, including tasks that panicked. All tasks are kept until all have finished.
    ///
    /// # Errors
    /// The first error of any task, named by its task; a panic in a task counts as one.
    pub fn run(
        self,
        tasks: Vec<Box<dyn Task>>,
        clock: &Arc<dyn Clock>,
        stop: &StopFlag,
    ) -> anyhow::Result<()> {
        match self {
            Self::Threads => run_threads(tasks, clock, stop),
            Self::Lockstep(mut pacer) => run_lockstep(tasks, pacer.as_mut(), clock.as_ref(), stop),
        }
    }
}

fn run_lockstep(
    mut tasks: Vec<Box<dyn Task>>,
    pacer: &mut dyn Pacer,
    clock: &dyn Clock,
    stop: &StopFlag,
) -> anyhow::Result<()> {
    let mut result = Ok(());
    'run: while !stop.is_raised() {
        if let Err(error) = pacer.tick() {
            result = Err(error.context("the apparatus"));
            break;
        }
        let now_ns = clock.now_ns();
        for task in &mut tasks {
            if let Err(error) = caught(|| task.poll(now_ns)) {
                result = Err(error.context(task.name()));
                break 'run;
            }
        }
    }
    match &result {
        Ok(()) => stop.raise(),
        Err(error) => stop.fail(bounded_files::cause_line(error.as_ref())),
    }
    for task in &mut tasks {
        let stopped = caught(|| {
            task.stop();
            Ok(())
        });
        result = result.and(stopped.context(task.name()));
    }
    for task in &mut tasks {
        result = result.and(caught(|| task.finish()).context(task.name()));
    }
    result
}

/// Finishes `task`, which `stop` counts as busy until then.
fn finish(task: &mut dyn Task, stop: &StopFlag) -> anyhow::Result<()> {
    let finished = caught(|| task.finish()).context(task.name());
    stop.tasks().retain(|busy| *busy != task.name());
    finished
}

/// Does a part of a task's work; a panic becomes an error, after the panic hook has run, so that no task keeps another
/// one from finishing.
fn caught(work: impl FnOnce() -> anyhow::Result<()>) -> anyhow::Result<()> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| Err(Panicked.into()))
}

fn run_threads(
    tasks: Vec<Box<dyn Task>>,
    clock: &Arc<dyn Clock>,
    stop: &StopFlag,
) -> anyhow::Result<()> {
    let (mut threads, mut result) = (Vec::new(), Ok(()));
    for task in tasks {
        match spawn(task, clock.clone(), stop.clone()) {
            Ok(thread) => threads.push(thread),
            Err(error) => {
                stop.fail(bounded_files::cause_line(error.as_ref()));
                result = Err(error);
                break;
            }
        }
    }
    // Every task first stops polling, then each finishes in the order given: producers before the recorder.
    let mut finished = Vec::new();
    for (name, thread) in threads {
        match thread.join() {
            Ok((task, outcome)) => {
                result = result.and(outcome);
                finished.push(task);
            }
            Err(_) => result = result.and(Err(Panicked).context(name)),
        }
    }
    // All tasks are kept until all have finished: the screen closes with the last task that supplies its data.
    for task in &mut finished {
        result = result.and(finish(task.as_mut(), stop));
    }
    result
}

type Ended = (Box<dyn Task>, anyhow::Result<()>);

fn spawn(
    mut task: Box<dyn Task>,
    clock: Arc<dyn Clock>,
    stop: StopFlag,
) -> anyhow::Result<(&'static str, JoinHandle<Ended>)> {
    let name = task.name();
    stop.tasks().push(name);
    let thread = std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(move || {
            let _raise_on_unwind = RaiseOnDrop(stop.clone());
            let mut outcome = caught(|| {
                task.begin();
                while !stop.is_raised() {
                    task.poll(clock.now_ns())?;
                    std::thread::sleep(task.period());
                }
                Ok(())
            });
            if let Err(error) = &outcome {
                stop.fail(format!(
                    "{name}: {}",
                    bounded_files::cause_line(error.as_ref())
                ));
            }
            outcome = outcome.and(caught(|| {
                task.stop();
                Ok(())
            }));
            (task, outcome.context(name))
        })
        .with_context(|| format!("cannot start the thread {name}"))?;
    Ok((name, thread))
}

/// Guard that raises its flag when it is dropped, also on a panic.
pub struct RaiseOnDrop(pub StopFlag);

impl Drop for RaiseOnDrop {
    fn drop(&mut self) {
        self.0.raise();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SystemClock;

    struct Counter {
        polls: u32,
        stop_at: u32,
        stop: StopFlag,
        log: Arc<Mutex<Vec<&'static str>>>,
        name: &'static str,
    }

    impl Task for Counter {
        fn name(&self) -> &'static str {
            self.name
        }
        fn period(&self) -> Duration {
            Duration::from_micros(100)
        }
        fn poll(&mut self, _now_ns: u64) -> anyhow::Result<()> {
            self.polls += 1;
            if self.polls == self.stop_at {
                self.stop.raise();
            }
            anyhow::ensure!(self.polls < 1000, "never stopped");
            Ok(())
        }
        fn finish(&mut self) -> anyhow::Result<()> {
            self.log.lock().unwrap().push(self.name);
            Ok(())
        }
    }

    struct Nothing;
    impl Pacer for Nothing {
        fn tick(&mut self) -> anyhow::Result<()> {
            Ok(())
        }
    }

    fn schedules() -> [Schedule; 2] {
        [Schedule::Threads, Schedule::Lockstep(Box::new(Nothing))]
    }

    #[test]
    fn every_task_finishes_in_order_under_both_schedules() {
        for schedule in schedules() {
            let (stop, log) = (StopFlag::default(), Arc::default());
            let task = |name, stop_at| -> Box<dyn Task> {
                Box::new(Counter {
                    polls: 0,
                    stop_at,
                    stop: stop.clone(),
                    log: Arc::clone(&log),
                    name,
                })
            };
            let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
            schedule
                .run(vec![task("first", 10), task("second", 2000)], &clock, &stop)
                .unwrap();
            assert_eq!(*log.lock().unwrap(), ["first", "second"]);
        }
    }

    #[test]
    fn the_error_of_a_task_ends_the_others_and_carries_its_name() {
        for schedule in schedules() {
            let (stop, log) = (StopFlag::default(), Arc::default());
            let task = |name| -> Box<dyn Task> {
                Box::new(Counter {
                    polls: 0,
                    stop_at: 0,
                    stop: stop.clone(),
                    log: Arc::clone(&log),
                    name,
                })
            };
            let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
            let error = schedule.run(vec![task("only")], &clock, &stop).unwrap_err();
            assert_eq!(format!("{error:#}"), "only: never stopped");
            assert_eq!(stop.failure(), Some("only: never stopped"));
        }
    }

    /// Task that logs when it stops and when it finishes, and calls the test's closure in each poll.
    struct LoggingTask<F: FnMut() + Send> {
        name: &'static str,
        polled: F,
        log: Arc<Mutex<Vec<String>>>,
    }

    impl<F: FnMut() + Send> Task for LoggingTask<F> {
        fn name(&self) -> &'static str {
            self.name
        }
        fn period(&self) -> Duration {
            Duration::from_micros(100)
        }
        fn poll(&mut self, _now_ns: u64) -> anyhow::Result<()> {
            (self.polled)();
            Ok(())
        }
        fn stop(&mut self) {
            self.log
                .lock()
                .unwrap()
                .push(format!("{} stops", self.name));
        }
        fn finish(&mut self) -> anyhow::Result<()> {
            self.log
                .lock()
                .unwrap()
                .push(format!("{} finishes", self.name));
            Ok(())
        }
    }

    /// Fault 27.
    #[test]
    fn a_task_stops_while_another_hangs_on_a_disk() {
        let (stop, log) = (StopFlag::default(), Arc::<Mutex<Vec<String>>>::default());
        let watch = LoggingTask {
            name: "watch",
            polled: || (),
            log: log.clone(),
        };
        let (task_stop, task_log) = (stop.clone(), log.clone());
        let disk = LoggingTask {
            name: "disk",
            polled: move || {
                task_stop.raise();
                let start = std::time::Instant::now();
                while task_log.lock().unwrap().is_empty() {
                    assert!(start.elapsed() < Duration::from_secs(60), "the watch waits");
                    std::thread::sleep(Duration::from_millis(1));
                }
            },
            log: log.clone(),
        };
        let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
        Schedule::Threads
            .run(vec![Box::new(watch), Box::new(disk)], &clock, &stop)
            .unwrap();
        let expected = [
            "watch stops",
            "disk stops",
            "watch finishes",
            "disk finishes",
        ];
        assert_eq!(*log.lock().unwrap(), expected);
    }

    /// Fault 30.
    #[test]
    fn a_task_that_panics_ends_the_others_and_all_finish() {
        for schedule in schedules() {
            let (stop, log) = (StopFlag::default(), Arc::default());
            let sound = LoggingTask {
                name: "sound",
                polled: || (),
                log: Arc::clone(&log),
            };
            let broken = LoggingTask {
                name: "broken",
                polled: || panic!("on purpose"),
                log: Arc::clone(&log),
            };
            let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
            let error = schedule
                .run(vec![Box::new(sound), Box::new(broken)], &clock, &stop)
                .unwrap_err();
            assert_eq!(format!("{error:#}"), "broken: panicked");
            assert_eq!(stop.failure(), Some("broken: panicked"));
            assert_eq!(
                log.lock().unwrap()[2..],
                ["sound finishes", "broken finishes"]
            );
        }
    }
}
