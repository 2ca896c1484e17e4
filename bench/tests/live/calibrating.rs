//! System health shown during a calibration, and the results of an unattended one that is stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use calibration_rig::EndedEarly;
use calibration_rig::operator::{
    CalibrationProgress, LiveReading, Operator, OperatorInput, PointRead, Request,
};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use calibration_rig::rig::{self, Outcome};
use config::Effective;
use devices::driving_time;
use mock_world::scenario::Scenario;
use safety::{input, output};
use signalgen::{ToneList, Waveform};
use sources::Lines;
use tasks::Schedule;
use tui::event::SystemHealth;

use crate::rig::{Level, apparatus, config, hardware};

/// Plays one tone after the other, each giving one point.
#[derive(Default)]
struct Tones {
    points: Vec<PointRead>,
}

impl Procedure for Tones {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        if matches!(outcome, StepOutcome::Captured(_)) {
            self.points.push(PointRead {
                place: "5.00 V".to_owned(),
                value: "0.3 µm".to_owned(),
                ..PointRead::default()
            });
        }
        if self.points.len() == 3 {
            return Ok(NextStep::Done);
        }
        Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
            tones: ToneList::new(&[35_000.0])?,
            dwell_s: 0.6,
            amplitude_v: 5.0,
        })))
    }

    fn progress(&self) -> CalibrationProgress {
        CalibrationProgress {
            points: self.points.clone(),
            ..CalibrationProgress::default()
        }
    }
}

/// Stores the system health shown, and presses the e-stop after the first point if `presses` is set.
#[derive(Clone, Default)]
struct IdleOperator {
    health_log: Arc<Mutex<Vec<SystemHealth>>>,
    closed: Arc<AtomicBool>,
    presses: bool,
    points: usize,
}

impl Operator for IdleOperator {
    fn ask(&mut self, _: Option<&Request>) {}
    fn progress(&mut self, progress: &CalibrationProgress) {
        self.points = progress.points.len();
    }
    fn show(&mut self, reading: &LiveReading) {
        if self.presses && self.points == 1 && reading.sounds {
            self.closed.store(false, Ordering::Relaxed);
        }
    }
    fn health(&mut self, health: &SystemHealth) {
        self.health_log.lock().unwrap().push(*health);
    }
    fn next_input(&mut self) -> anyhow::Result<Option<OperatorInput>> {
        Ok(None)
    }
    fn broken_off(&mut self, _: &str, _: Option<&str>) -> bool {
        false
    }
    fn failed(&mut self, _: &str) -> bool {
        false
    }
    fn close(&mut self) {}
}

fn calibrate(operator: &IdleOperator) -> anyhow::Result<Outcome<Tones>> {
    let mut apparatus = apparatus(Scenario::default());
    let pins = apparatus.pins().unwrap();
    operator.closed.store(true, Ordering::Relaxed);
    let lines = Lines {
        estop: Some(Box::new(Level(operator.closed.clone()))),
        enable: Some(output("enable", pins.amplifier_enable)),
        heartbeat: Some(output("heartbeat", pins.heartbeat)),
        button: Some(input("button", pins.button)),
        ..Lines::default()
    };
    let mut hardware = hardware(&apparatus, lines);
    let bench = Effective::uncalibrated(config(&[]));
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("calibration.toml");
    let ledger = driving_time::clear_plate_account(&file, bench.config(), &hardware).unwrap();
    hardware.schedule = Schedule::Lockstep(Box::new(move || Ok(apparatus.step()?)));
    let attend = |_: &_| Ok((Box::new(operator.clone()) as Box<dyn Operator>, None));
    let tones = Tones::default();
    rig::run(&bench, hardware, ledger, None, None, attend, tones)
}

#[test]
fn a_calibration_shows_rates_losses_and_lines_as_a_session_does() {
    let operator = IdleOperator::default();
    let outcome = calibrate(&operator).unwrap();
    assert_eq!(outcome.procedure.points.len(), 3);
    let health_log = operator.health_log.lock().unwrap();
    assert!(
        (4..=8).contains(&health_log.len()),
        "{} in 2 s",
        health_log.len()
    );
    let last = health_log[health_log.len() - 1];
    assert!((last.speed - 1.0).abs() < 0.05, "{last:?}");
    assert!(last.force_rate_hz.unwrap() > 100.0, "{last:?}");
    assert_eq!((last.lost_frames, last.xruns_in), (0, 0));
    assert!(last.frames > 300_000, "{last:?}");
    assert_eq!(last.lines.estop_open, Some(false));
    assert_eq!(last.lines.button_pressed, Some(false));
    let beats = |health: &SystemHealth| health.lines.heartbeat_beats == Some(true);
    assert!(health_log.iter().any(beats), "while it is armed");
}

#[test]
fn a_calibration_that_is_stopped_with_nobody_there_ends_with_its_points() {
    let operator = IdleOperator {
        presses: true,
        ..IdleOperator::default()
    };
    let Err(error) = calibrate(&operator) else {
        panic!("it goes on under a pressed e-stop");
    };
    let early = error.downcast_ref::<EndedEarly>().unwrap();
    assert!(early.to_string().contains("e-stop pressed"), "{early}");
    let table = early.table().unwrap();
    assert_eq!(table, "at,value,residual\n5.00 V,0.3 µm,\n");
}
