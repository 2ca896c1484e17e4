//! Course of a drill: one exercise after another, each on a newly opened bench, with a record of the times.

use std::path::Path;
use std::time::{Duration, Instant};

use config::{Config, Effective};
use devices::drive_control::settings;
use devices::{Bench, EndedByPanic, Hardware, require_armable, require_watched};
use faults::FaultKind;
use jiff::Timestamp;
use operator_ui::console::{Front, safety_event};
use safety::{DriveStop, Pace, SafetyState, Trip};
use signalgen::{Program, Waveform};
use tasks::{Clock, StopFlag, SystemClock};
use tui::event::{LogLevel, PhaseKind, PhaseView};
use tui::{Action, Event};

use crate::draw::{NotDrilledError, PlannedFault, draw};
use crate::drill_task::{DrillTask, ExerciseState};
use crate::exercise::{Exercise, Sight};
use crate::page::Page;
use crate::panels::Panels;
use crate::record::{DrillFolder, DrillRecord};
use crate::signs::Signs;
use crate::{FaultHand, TONE_V};

/// Mean voltage that drives a simulated bench, V, and its modulation (Huloux 2021, section IV).
const MEAN_V: f64 = 20.0;
const MODULATION_HZ: f64 = 6.0;
const MODULATION_INDEX: f64 = 0.95;
/// Time between two polls while no bench is open.
const IDLE_PERIOD: Duration = Duration::from_millis(20);

/// A bench used for a drill.
pub struct WatchedHardware {
    /// Hardware of the bench.
    pub hardware: Hardware,
    /// Injects faults; `None` if the operator is asked to cause them.
    pub hand: Option<FaultHand>,
}

/// A planned drill, checked to be possible.
pub struct Course {
    bench: Effective,
    selection: Vec<FaultKind>,
    simulated: bool,
    seed: Option<u64>,
    operator: String,
    unattended: bool,
    program: Program,
}

impl Course {
    /// Plans a drill of the faults `only`, or of all faults possible on this bench if it is empty; their order is drawn from
    /// `seed`, or from the time of day.
    ///
    /// # Errors
    /// If a fault cannot be drilled, or the drive is not admitted.
    pub fn new(
        bench: Effective,
        selection: &[FaultKind],
        simulated: bool,
        pace: Pace,
        seed: Option<u64>,
        operator: &str,
        unattended: bool,
    ) -> anyhow::Result<Self> {
        let config = bench.config();
        require_armable(config, pace)?;
        let plan: Result<Vec<PlannedFault>, NotDrilledError> =
            draw(selection, config, simulated, 0);
        if plan?.is_empty() {
            anyhow::bail!(
                "this bench can be drilled with nothing: it has neither e-stop nor force sensor"
            );
        }
        let waveform = waveform(config, simulated);
        if simulated {
            require_watched(&bench, &waveform, pace, SystemClock::start().utc())?;
        }
        let program = settings(config)?.admit(waveform)?;
        Ok(Self {
            selection: selection.to_vec(),
            simulated,
            seed,
            operator: operator.to_owned(),
            unattended,
            program,
            bench,
        })
    }

    /// Runs the drill and saves its record after each exercise, in a new folder in `parent`. `over` ends the drill; `drive`
    /// stops the bench that is open.
    ///
    /// # Errors
    /// If the bench cannot be opened or the record cannot be written.
    pub fn run(
        &self,
        parent: &Path,
        mut front: Box<dyn Front>,
        (quit, drive): (&StopFlag, &DriveStop),
        mut open: impl FnMut() -> anyhow::Result<WatchedHardware>,
    ) -> anyhow::Result<(DrillRecord, DrillFolder)> {
        let first = open()?;
        let began = first.hardware.clock.utc();
        let seed = self.seed.unwrap_or_else(|| day_seed(began));
        let plan = draw(&self.selection, self.bench.config(), self.simulated, seed)?;
        let mut record = DrillRecord::new(began, &self.operator, self.simulated, seed, plan.len());
        record.unattended = self.unattended;
        let folder = DrillFolder::create(parent, began)?;
        folder.write(&record)?;
        let (config, file) = (self.bench.config(), self.bench.file());
        let facts = operator_ui::bench_page::facts(config, file, &first.hardware);
        front.show(Event::Bench(facts));

        let mut page = Page::new(plan.len());
        let (mut open_bench, mut is_abandoned) = (Some(first), false);
        for (number, planned) in (1..).zip(&plan) {
            page.turn();
            let silence_s = self.bench.config().safety.silence_s;
            let mut state = ExerciseState {
                front,
                page,
                exercise: Exercise::new(
                    planned.fault,
                    !self.simulated,
                    planned.settle_s,
                    silence_s,
                ),
                has_left: false,
                now_s: 0.0,
            };
            state.show();
            let watched = match open_bench.take() {
                Some(watched) => Some(watched),
                None => self.reopen(&mut state, quit, &mut open)?,
            };
            if let Some(watched) = watched {
                state =
                    self.run_exercise(state, watched, (quit, drive), (number, record.planned))?;
            }
            record.add(&state.exercise);
            folder.write(&record)?;
            let ExerciseState {
                front: last_front,
                page: last_page,
                has_left,
                ..
            } = state;
            (front, page) = (last_front, last_page);
            let exercise = &record.exercises[record.exercises.len() - 1];
            page.add(exercise);
            front.show(Event::Log {
                level: LogLevel::Info,
                text: exercise.log_line(),
            });
            is_abandoned = has_left || quit.is_raised();
            if is_abandoned {
                break;
            }
        }
        front.show(Event::Drill(page.last()));
        if !is_abandoned {
            conclude(front.as_mut(), &record, quit);
        }
        front.show(Event::Close);
        Ok((record, folder))
    }

    /// Reopens the bench; on real hardware the operator is asked to undo the effects of the last exercise first. Returns `None`
    /// if the operator leaves.
    fn reopen(
        &self,
        state: &mut ExerciseState,
        quit: &StopFlag,
        open: &mut impl FnMut() -> anyhow::Result<WatchedHardware>,
    ) -> anyhow::Result<Option<WatchedHardware>> {
        loop {
            let error = match open() {
                Ok(watched) => return Ok(Some(watched)),
                Err(error) if self.simulated => return Err(error),
                Err(error) => error,
            };
            let words = format!(
                "{}. Put it right, then space.",
                bounded_files::cause_line(error.as_ref())
            );
            if let Some(view) = state.page.with_words(words) {
                state.front.show(Event::Drill(view));
            }
            loop {
                if quit.is_raised() {
                    state.has_left = true;
                    return Ok(None);
                }
                match state.front.action() {
                    Some(Action::Ready) => break,
                    Some(Action::Quit | Action::Interrupt) => {
                        state.has_left = true;
                        return Ok(None);
                    }
                    _ => idle(state.front.as_mut(), &SafetyState::Disarmed),
                }
            }
        }
    }

    /// Runs one exercise on an opened bench.
    fn run_exercise(
        &self,
        state: ExerciseState,
        watched: WatchedHardware,
        (quit, drive): (&StopFlag, &DriveStop),
        (number, numbers): (u32, usize),
    ) -> anyhow::Result<ExerciseState> {
        let mut hardware = watched.hardware;
        // No exercise needs sliding or the button, and a removed GPIO chip must not end the task that reads them.
        (hardware.lines.encoder, hardware.lines.button) = (None, None);
        let bench = Bench::open(
            &self.bench,
            self.bench.config().plate.resonance_hz,
            hardware,
        )?;
        bench.require_calibration_holds(&self.bench)?;
        drive.follow(bench.life.drive_stop());
        let (sender, receiver) = crossbeam_channel::bounded(1);
        let task = DrillTask {
            batches: bench.batches,
            drive: bench.drive,
            signals: bench.signals,
            gauges: bench.gauges,
            stop: bench.life.stop().clone(),
            quit: quit.clone(),
            program: self.program,
            hand: watched.hand,
            panels: Panels::new(self.bench.config().audio.rate_hz),
            state: Some(state),
            sender,
            signs: Signs::default(),
            safety: None,
            phase: None,
            screen_due_ns: 0,
            number,
            numbers: numbers as u32,
        };
        let mut tasks = bench.first_tasks;
        tasks.push(Box::new(task));
        tasks.extend(bench.last_tasks);
        let result = bench.life.run(tasks, || Ok(()));
        let result = match result {
            // Not a fault of the exercise: the drill must not continue on such a bench.
            Err(error) if error.is::<EndedByPanic>() => return Err(error),
            result => result,
        };
        let Ok(mut state) = receiver.try_recv() else {
            result?;
            anyhow::bail!("the exercise ended without its operator");
        };
        if let Err(error) = result {
            state
                .exercise
                .bench_ended(&bounded_files::cause_line(error.as_ref()));
            finish_without_bench(&mut state, quit);
        } else if state.exercise.outcome().is_none() {
            state.has_left = true;
        }
        Ok(state)
    }
}

/// Returns a seed from the time of day.
fn day_seed(time: Timestamp) -> u64 {
    time.as_nanosecond().unsigned_abs() as u64 & (i64::MAX as u64)
}

/// Returns the drive of a drill: on simulated hardware the published one, reduced to the limits; on real hardware a faint tone.
fn waveform(config: &Config, simulated: bool) -> Waveform {
    let carrier_hz = config.plate.resonance_hz;
    let limit_v = config.limits.drive_v;
    if simulated {
        Waveform::Modulated {
            carrier_hz,
            mean_amplitude_v: MEAN_V.min(limit_v / (1.0 + MODULATION_INDEX)),
            modulation_hz: MODULATION_HZ,
            modulation_index: MODULATION_INDEX,
            start_phase_rad: 0.0,
        }
    } else {
        Waveform::Tone {
            carrier_hz,
            amplitude_v: TONE_V.min(limit_v),
        }
    }
}

/// Continues the exercise with the operator alone after the bench has ended.
fn finish_without_bench(state: &mut ExerciseState, quit: &StopFlag) {
    let (began, from_s) = (Instant::now(), state.now_s);
    let safety = SafetyState::Tripped {
        trip: Trip::AudioLost,
    };
    while state.exercise.outcome().is_none() && !state.has_left {
        state.now_s = from_s + began.elapsed().as_secs_f64();
        let sight = Sight {
            now_s: state.now_s,
            safety: &safety,
            sounds: false,
            flag: None,
        };
        // No bench is left to obey the order.
        let _ = state.exercise.poll(sight);
        state.show();
        if let Some(action) = state.front.action() {
            let _ = state.act(action);
        }
        state.has_left |= quit.is_raised() || state.front.is_unread();
        idle(state.front.as_mut(), &safety);
    }
}

/// Waits until the next poll while no bench is open; the screen keeps the last state.
fn idle(front: &mut dyn Front, safety: &SafetyState) {
    front.show(safety_event(safety, false, None));
    std::thread::sleep(IDLE_PERIOD);
}

/// Shows the summary until the operator has read it.
fn conclude(front: &mut dyn Front, record: &DrillRecord, quit: &StopFlag) {
    front.show(Event::Phase(PhaseView::new(PhaseKind::Finished)));
    front.show(Event::Finished {
        summary: record.lines(),
    });
    while !quit.is_raised() && !front.is_unread() {
        if let Some(Action::Quit | Action::Interrupt) = front.action() {
            break;
        }
        idle(front, &SafetyState::Disarmed);
    }
}
