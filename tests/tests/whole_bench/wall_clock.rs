//! A computer whose wall clock is set while a session runs: dates are labels, and nothing else hangs on them (FAULTS.md, row 39).
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bench_tests::program::protocol;
use bench_tests::session::SessionFolder;
use config::{Config, Effective};
use devices::loudspeaker::Tone;
use devices::{Hardware, Lines};
use friction_bench::apparatus::{Apparatus as Bench, Watcher};
use friction_bench::cli;
use friction_bench::run::{Plan, run};
use jiff::{SignedDuration, Timestamp};
use mock_hw::apparatus::{Apparatus, ApparatusClock, ApparatusConfig, Senses};
use mock_hw::person::{Cue, Instruction, Percept};
use mock_hw::scenario::Scenario;
use mock_hw::world_clock::Pace;
use safety::{input, output};
use serde_json::Value;
use tasks::{Clock, Pacer, Schedule, later};

/// An apparatus's clock whose date is set by an hour back and forth.
struct SetClock {
    clock: ApparatusClock,
    /// From when on, s, and by how much it is wrong, h.
    set: &'static [(f64, i64)],
}

impl Clock for SetClock {
    fn now_ns(&self) -> u64 {
        self.clock.now_ns()
    }

    fn utc(&self) -> Timestamp {
        let date: Timestamp = "2026-01-01T09:00:00Z".parse().unwrap();
        let now_s = self.now_ns() as f64 * 1e-9;
        let set = self.set.iter().rev().find(|(from_s, _)| now_s >= *from_s);
        let wrong = SignedDuration::from_hours(set.map_or(0, |(_, hours)| *hours));
        later(date, self.now_ns()).checked_add(wrong).unwrap()
    }
}

struct Stepper(Apparatus);

impl Pacer for Stepper {
    fn tick(&mut self) -> anyhow::Result<()> {
        Ok(self.0.step()?)
    }
}

/// Shows the simulated person what a session of one exploration, without a button, shows.
fn participant(senses: Senses) -> Watcher {
    Box::new(move |view, _, tone| {
        let instruction = match view.instruction {
            tui::Instruction::LiftFinger => Instruction::LiftFinger,
            tui::Instruction::PlaceFinger => Instruction::PlaceFinger,
            tui::Instruction::GetReady => Instruction::GetReady,
            tui::Instruction::FollowSlider => Instruction::FollowSlider,
            tui::Instruction::Feedback => Instruction::Feedback,
            _ => Instruction::Wait,
        };
        senses.show(Percept {
            instruction,
            slider_m: view.slider_m,
            countdown: view.countdown,
            mean_force_n: view.mean_force_n,
            force_band_n: view.force_band_n,
            cue: tone.map(|tone| match tone {
                Tone::Start => Cue::Start,
                Tone::End => Cue::End,
            }),
        });
    })
}

fn apparatus(set: &'static [(f64, i64)]) -> Bench {
    let config = ApparatusConfig::new(Scenario::default(), 1, Pace::Stepped);
    let mut apparatus = Apparatus::new(config).unwrap();
    let pins = apparatus.pins().unwrap();
    let clock = SetClock {
        clock: apparatus.clock(),
        set,
    };
    let watchers = vec![participant(apparatus.senses())];
    let hardware = Hardware {
        host: apparatus.host(),
        lines: Lines {
            encoder: Some([
                input("encoder A", pins.encoder_a),
                input("encoder B", pins.encoder_b),
            ]),
            estop: Some(input("e-stop", pins.estop)),
            button: None,
            enable: Some(output("enable", pins.amplifier_enable)),
            heartbeat: Some(output("heartbeat", pins.heartbeat)),
        },
        force_port: Some(apparatus.force_port().unwrap().to_owned()),
        clock: Arc::new(clock),
        guard: Box::new(()),
        simulated: true,
        pace: safety::Pace::Simulated,
        schedule: Schedule::Lockstep(Box::new(Stepper(apparatus))),
    };
    Bench {
        hardware,
        watchers,
        hands: None,
        vibrometer_port: None,
        voltmeter_port: None,
        estop_hand: None,
    }
}

/// Holds a session and returns its folder.
fn session(study: &Path, set: &'static [(f64, i64)]) -> PathBuf {
    let config =
        Config::parse(include_str!("../../../bench/mock-bench.toml"), "bench.toml").unwrap();
    let options = cli::Run {
        hardware: cli::Hardware {
            config: None,
            mock: Some("nominal".to_owned()),
            seed: None,
            print_config: false,
            calibration: None,
        },
        study: study.to_owned(),
        participant: Some("sub-01".to_owned()),
        protocol: protocol("one-exploration.toml").display().to_string(),
        consent_by: Some("A. Tester".to_owned()),
        resume: false,
        new_session: false,
        uncalibrated: true,
        headless: true,
        speed: cli::Speed::Max,
        mock_truth: None,
        shared: false,
        participant_display: None,
    };
    let plan = Plan::new(Effective::uncalibrated(config), &options).unwrap();
    let report = run(plan, apparatus(set), std::io::sink()).unwrap();
    assert!(report.completed, "{:?}", report.reason);
    SessionFolder::read(study, "sub-01").unwrap().path
}

/// Every file of a session by its path, and the log apart: its documents without their dates, and the dates.
type Left = (BTreeMap<PathBuf, Vec<u8>>, Vec<Value>, Vec<Timestamp>);

fn left(session: &Path) -> Left {
    let (mut files, mut folders) = (BTreeMap::new(), vec![session.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(session).unwrap().to_owned();
                files.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    let log = files.remove(Path::new("events.jsonl")).unwrap();
    let lines = String::from_utf8(log).unwrap();
    let mut dates = Vec::new();
    let documents = lines.lines().map(|line| {
        let mut document: Value = serde_json::from_str(line).unwrap();
        if let Some(date) = document.as_object_mut().unwrap().remove("time") {
            dates.push(date.as_str().unwrap().parse().unwrap());
        }
        document
    });
    (files, documents.collect(), dates)
}

/// Fault 39.
#[test]
fn a_wall_clock_that_is_set_during_a_session_changes_nothing_but_the_dates() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, set| left(&session(&folder.path().join(name), set));
    let (files, documents, dates) = of("steady", &[]);
    let (set_files, set_documents, set_dates) = of("set", &[(1.5, 1), (3.0, -1)]);

    // An hour ahead and then an hour behind was in force, and dates that somebody wrote tell.
    let wrong = |hours: i64| {
        let pairs = dates.iter().zip(&set_dates);
        pairs
            .filter(|(date, set)| date.duration_until(**set) == SignedDuration::from_hours(hours))
            .count()
    };
    let counts = [0, 1, -1].map(wrong);
    assert!(
        counts.iter().all(|&count| count > 0),
        "{counts:?}: {dates:?}"
    );
    assert_eq!(counts.iter().sum::<usize>(), dates.len());

    assert_eq!(documents, set_documents);
    let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&files), names(&set_files));
    assert!(files.len() > 5, "{:?}", names(&files));
    for (name, bytes) in &files {
        assert!(*bytes == set_files[name], "{} differs", name.display());
    }
}
