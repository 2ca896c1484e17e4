//! An input xrun swallows frames: the bench finds how many, and time stays true (FAULTS.md, row 6).
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use friction_bench::assembly::Bench;
use friction_bench::config::Config;
use friction_bench::gpio::{Lines, input, output};
use friction_bench::safety::SafetyState;
use mock_hw::apparatus::{Apparatus, ApparatusConfig};
use mock_hw::clock::Pace;
use mock_hw::host::Direction;
use mock_hw::scenario::Scenario;
use signalgen::Waveform;

struct Rig {
    apparatus: Apparatus,
    bench: Bench,
    frames: Vec<impedance::ZmFrame>,
    account: friction_bench::pipeline::Account,
}

impl Rig {
    fn driven() -> Self {
        let config = Config::parse(include_str!("../mock-bench.toml"), "mock-bench.toml").unwrap();
        let mut apparatus =
            Apparatus::new(ApparatusConfig::new(Scenario::default(), 1, Pace::Stepped)).unwrap();
        let pins = apparatus.pins().unwrap();
        let lines = Lines {
            estop: Some(input("e-stop", pins.estop)),
            enable: Some(output("enable", pins.amplifier_enable)),
            heartbeat: Some(output("heartbeat", pins.heartbeat)),
            ..Lines::default()
        };
        let port = Some(apparatus.force_port().to_owned());
        let mut bench = Bench::open(&config, 35_000.0, &apparatus.host(), lines, port).unwrap();
        let tone = friction_bench::drive::settings(&config)
            .unwrap()
            .admit(Waveform::Tone {
                carrier_hz: 35_000.0,
                amplitude_v: 10.0,
            })
            .unwrap();
        bench.drive.start(tone);
        bench.streams.play().unwrap();
        Self {
            apparatus,
            bench,
            frames: Vec::new(),
            account: Default::default(),
        }
    }

    fn pass(&mut self, seconds: f64) {
        let until_ns = self.apparatus.now_ns() + (seconds * 1e9) as u64;
        while self.apparatus.now_ns() < until_ns {
            self.apparatus.step().unwrap();
            let now_ns = self.apparatus.now_ns();
            let Bench { before, after, .. } = &mut self.bench;
            for task in before.iter_mut().chain(after) {
                task.poll(now_ns).unwrap();
            }
            let safety = self.bench.shared.safety.get().unwrap_or_default();
            assert!(!matches!(safety, SafetyState::Tripped { .. }), "{safety:?}");
            self.bench.drive.poll(&safety);
            for batch in self.bench.batches.try_iter() {
                self.frames.extend(batch.frames);
                self.account = batch.account;
            }
        }
    }
}

#[test]
fn the_frames_that_an_xrun_swallows_are_counted_exactly_and_time_stays_true() {
    let mut rig = Rig::driven();
    rig.pass(0.5);
    let mut lost = 0;
    for frames in [1, 191, 192, 1000, 4807] {
        rig.apparatus.faults().xrun(Direction::Input, frames);
        rig.pass(0.1);
        lost += frames;
        assert_eq!(
            rig.account.lost_frames, lost,
            "after an xrun of {frames} frames"
        );
    }
    assert_eq!(rig.account.input_xruns, 5);

    // The phase of the drive is that of a stream without a loss: no slip of a sample (65.6°).
    let phase = |from_s: f64, to_s: f64| {
        let inside = rig
            .frames
            .iter()
            .filter(|f| (from_s..to_s).contains(&f.time_s) && f.mask.is_clear());
        inside
            .map(|frame| frame.drive_v)
            .sum::<num_complex::Complex64>()
            .arg()
    };
    let (before, after) = (phase(0.4, 0.5), phase(0.98, 1.0));
    assert!(
        (before - after).abs() < 1e-3,
        "{before} rad before, {after} rad after"
    );
    let newest = rig.frames.last().unwrap().time_s;
    let now_s = rig.apparatus.now_ns() as f64 * 1e-9;
    assert!(
        (now_s - newest).abs() < 0.01,
        "audio at {newest} s, apparatus at {now_s} s"
    );
}

#[test]
fn an_xrun_without_a_loss_leaves_no_gap() {
    let mut rig = Rig::driven();
    rig.pass(0.5);
    rig.apparatus.faults().xrun(Direction::Input, 0);
    rig.pass(0.1);
    assert_eq!((rig.account.input_xruns, rig.account.lost_frames), (1, 0));
}
