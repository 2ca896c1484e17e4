//! Forces from inputs of the card: on its clock to the sample, despite losses; known within their intervals; and under
//! any fault of the inputs, the drive is silent in time and the recording remains readable (FAULTS.md, row 46).

use calibration::masses::{Accuracy, ForceProcedure, ForceSetup, Mass, from_g};
use calibration_rig::capture::Capture;
use calibration_rig::judged::{Calibrates, Part};
use calibration_rig::operator::{Answer, ForceAxis, GRAVITY_M_PER_S2, Request};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::{Config, Gauges, MeasuredForce, Quantity, Sensor};
use mock_hw::host::ConverterDirection;
use mock_hw::serial::ForceFault;
use mock_world::plant::{LoadedAxis, MAKERS_MATRIX};
use mock_world::scenario::{Scenario, built_in};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{ForceRow, RecordingReader};
use safety::{SafetyState, Trip};
use signalgen::InputTap;
use sources::ForceSource;
use sources::channels::GaugeForce;

use crate::rig::{RATE_HZ, Rig, config};

fn scenario() -> Scenario {
    built_in("gauges").unwrap()
}

/// Returns a bench with gauges on its inputs that may be silent for this long; its samples are floats and can be NaN.
fn bench(silence_s: &str) -> Config {
    let channels = format!(
        "source = \"channels\"\nchannels = {{ inputs = [3, 4, 5, 6, 7, 8], volts_per_unit = [10.0], newtons_per_v = \
         {MAKERS_MATRIX:?} }}"
    );
    config(&[
        ("sample_format = \"i32\"", "sample_format = \"f32\""),
        ("input_channels = 4", "input_channels = 9"),
        ("silence_s = 0.25", &format!("silence_s = {silence_s}")),
        ("port = \"/dev/ttyUSB0\"", &channels),
        // The latency of the gauges' amplifier.
        ("latency_s = 0.0", "latency_s = 2.0e-4"),
    ])
}

/// Makes both kinds of force sensor free of noise.
fn quiet(mut scenario: Scenario) -> Scenario {
    scenario.force_sensor.noise_n = 0.0;
    scenario.force_sensor.clock_ppm = 0.0;
    scenario.force_sensor.gauges.noise_v = 1e-9;
    scenario.converter.noise_units_per_sqrt_hz = 1e-12;
    scenario
}

/// Returns the readings for a mass that is placed after 2.2 s, following an input xrun that swallows frames.
fn placed_mass_rig(scenario: Scenario, config: Config) -> Rig {
    let mut rig = Rig::new(quiet(scenario), config, None);
    rig.drive();
    rig.pass(2.0);
    rig.apparatus
        .faults()
        .xrun(ConverterDirection::Input, 1_037);
    rig.pass(0.2);
    rig.apparatus.masses().place(LoadedAxis::Normal, 0.1);
    rig.pass(1.0);
    rig
}

/// Returns the value and the slope of `rows` at a time within them.
fn force_at(rows: &[ForceRow], time_s: f64) -> [f64; 2] {
    let next = rows.partition_point(|row| row.time_s < time_s);
    let [a, b] = [&rows[next - 1], &rows[next]];
    let share = (time_s - a.time_s) / (b.time_s - a.time_s);
    [
        a.normal_n + share * (b.normal_n - a.normal_n),
        (b.normal_n - a.normal_n) / (b.time_s - a.time_s),
    ]
}

#[test]
fn forces_stay_at_the_sample_at_which_they_acted_after_lost_input() {
    let rig = placed_mass_rig(scenario(), bench("0.25"));
    assert_eq!(rig.account.lost_frames, 1_037, "{:?}", rig.warnings);
    let gauges = &rig.record.force;
    // The same bench with a sensor that counts true time and loses no sample.
    let reference = placed_mass_rig(Scenario::default(), config(&[]));
    let rows = reference.record.force.iter().enumerate();
    let truth: Vec<ForceRow> = rows
        .map(|(k, row)| ForceRow {
            time_s: k as f64 * 1e-4,
            ..*row
        })
        .collect();
    let moving = gauges
        .iter()
        .filter(|row| (2.21..3.1).contains(&row.time_s));
    let (mut product, mut square, mut count) = (0.0, 0.0, 0);
    for row in moving {
        let [expected_n, slope] = force_at(&truth, row.time_s);
        product += (row.normal_n - expected_n) * slope;
        square += slope * slope;
        count += 1;
    }
    let late_s = -product / square;
    println!("late by {:.2} µs, of {count} rows", 1e6 * late_s);
    assert!(count > 3000);
    assert!(late_s.abs() < 1.0 / f64::from(RATE_HZ), "{late_s} s");
    let times = gauges
        .windows(2)
        .map(|pair| pair[1].time_s - pair[0].time_s);
    let longest_s = times.fold(0.0, f64::max);
    assert!(
        longest_s < 2.6e-4 + 1037.0 / f64::from(RATE_HZ),
        "{longest_s} s"
    );
}

/// A fault, a check of the bench's report on it, and the time limit, s.
type Case = (&'static str, fn(&Rig), fn(&Trip) -> bool, f64);

fn at_its_end(trip: &Trip) -> bool {
    matches!(
        trip,
        Trip::ForceSaturated
            | Trip::ForceLimit { .. }
            | Trip::LateralForceLimit { .. }
            | Trip::RawForceLimit { .. }
    )
}

const CASES: [Case; 9] = [
    (
        "a gauge at its end",
        |rig| rig.apparatus.faults().force(ForceFault::Saturated(true)),
        at_its_end,
        0.01,
    ),
    (
        "cable out: the open inputs drift to their end",
        |rig| rig.apparatus.faults().unplug_force(),
        at_its_end,
        0.01,
    ),
    (
        "inputs muted",
        |rig| rig.apparatus.faults().force(ForceFault::Silent(true)),
        |trip| matches!(trip, Trip::ForceNonsense { .. } | Trip::ForceSilent),
        0.12,
    ),
    (
        "samples that are no numbers",
        |rig| rig.apparatus.faults().force(ForceFault::Corrupt(1_000_000)),
        |trip| matches!(trip, Trip::ForceNonsense { .. } | Trip::ForceSilent),
        0.06,
    ),
    (
        "the card's input halted",
        |rig| {
            rig.apparatus
                .faults()
                .halt_audio(ConverterDirection::Input, true)
        },
        |trip| {
            matches!(
                trip,
                Trip::AudioSilent | Trip::ReadbackMissing | Trip::ForceSilent
            )
        },
        0.06,
    ),
    (
        "4 N on the plate",
        |rig| rig.apparatus.masses().place(LoadedAxis::Normal, 0.4),
        |trip| matches!(trip, Trip::ForceLimit { .. }),
        0.1,
    ),
    (
        "4 N back along the plate",
        |rig| rig.apparatus.masses().place(LoadedAxis::Lateral, -0.4),
        |trip| matches!(trip, Trip::LateralForceLimit { .. }),
        0.1,
    ),
    (
        "a gauge at its end, and frames that are swallowed",
        |rig| {
            rig.apparatus.faults().force(ForceFault::Saturated(true));
            rig.apparatus.faults().xrun(ConverterDirection::Input, 500);
        },
        at_its_end,
        0.01,
    ),
    (
        "inputs muted, and the e-stop pressed",
        |rig| {
            rig.apparatus.faults().force(ForceFault::Silent(true));
            rig.apparatus.faults().press_estop(true);
        },
        |trip| *trip == Trip::EmergencyStop,
        0.01,
    ),
];

/// Fault 46.
/// Hazard 20.
#[test]
fn whatever_the_gauges_inputs_do_the_drive_is_silent_in_time_and_what_was_recorded_is_kept() {
    for (name, inject, is_expected, within_s) in CASES {
        let mut rig = Rig::new(scenario(), bench("0.05"), None);
        rig.drive();
        rig.pass(0.4);
        let before = rig.bench.gauges.field.get().unwrap().force;
        assert_eq!(before, sources::LineFaults::default());
        let folder = rig.begin("kept");
        rig.pass(0.2);
        inject(&rig);
        rig.stops(name, is_expected, within_s, 0.2);
        rig.end();
        let reader = RecordingReader::open(&folder).unwrap();
        let kept_s = reader.frames() as f64 / f64::from(RATE_HZ);
        assert!(kept_s > 0.19, "{name}: {kept_s} s kept");
        let rows = reader.force().unwrap().count();
        assert!(rows > 700, "{name}: {rows} rows");
    }
}

/// Fault 46.
#[test]
fn a_sample_that_is_no_number_is_flagged_and_costs_the_forces_about_it() {
    let config = bench("0.25");
    let mut rig = Rig::new(scenario(), config, None);
    rig.pass(0.5);
    let rows = rig.record.force.len();
    rig.apparatus.faults().force(ForceFault::Corrupt(1));
    rig.pass(0.5);
    let faults = rig.bench.gauges.field.get().unwrap().force;
    assert_eq!(faults.corrupt, 1);
    let new_rows = rig.record.force.len() - rows;
    assert_eq!(new_rows as u64 + faults.lost, 2000, "{faults:?}");
    assert!((15..30).contains(&faults.lost), "{faults:?}");
    rig.pass(1.0);
    let words = rig.warnings.join("; ");
    assert!(words.contains("force frames corrupt: 1"), "{words}");
}

/// Fault 46.
#[test]
fn muted_inputs_arm_nothing_for_longer_than_a_second() {
    let mut rig = Rig::new(scenario(), bench("0.05"), None);
    rig.apparatus.faults().force(ForceFault::Silent(true));
    rig.drive();
    let trip = loop {
        if let SafetyState::Tripped { trip } = rig.tick() {
            break trip;
        }
        assert!(rig.apparatus.now_ns() < 1_050_000_000, "driven on");
    };
    assert!(matches!(trip, Trip::ForceNonsense { .. }), "{trip}");
}

/// Rate of the card in the calibrations, Hz: a low one, to save work.
const CARD_HZ: f64 = 24_000.0;

/// An unknown sensor with six gauges, as manufactured and mounted.
struct Unknown {
    /// Readings, normal and lateral, per newton of normal and of lateral force.
    response: [[f64; 2]; 2],
    /// Volts of the gauges per newton that each axis would read.
    gauges: [[f64; 2]; 6],
    offset_v: [f64; 6],
    drift_v_per_s: [f64; 6],
    noise_v: f64,
    rng: ChaCha8Rng,
}

impl Unknown {
    fn draw(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut uniform =
            |middle: f64, half_width: f64| middle + half_width * (2.0 * rng.random::<f64>() - 1.0);
        let response = [
            [uniform(1.0, 0.2), uniform(0.0, 0.05)],
            [uniform(0.0, 0.05), uniform(1.0, 0.2)],
        ];
        let gauges = std::array::from_fn(|_| [uniform(0.0, 0.6), uniform(0.0, 0.6)]);
        let offset_v = std::array::from_fn(|_| uniform(0.0, 0.1));
        let drift_v_per_s = std::array::from_fn(|_| uniform(0.0, 2e-5));
        Self {
            response,
            gauges,
            offset_v,
            drift_v_per_s,
            noise_v: uniform(2e-3, 1e-3),
            rng,
        }
    }

    /// Returns the maker's matrix: the pseudo-inverse of the gauges' volts.
    fn maker_matrix(&self) -> Vec<Vec<f64>> {
        let sum = |a: usize, b: usize| self.gauges.iter().map(|g| g[a] * g[b]).sum::<f64>();
        let (nn, nl, ll) = (sum(0, 0), sum(0, 1), sum(1, 1));
        let det = nn * ll - nl * nl;
        let row = |a: f64, b: f64| {
            let weight = |g: &[f64; 2]| (a * g[0] + b * g[1]) / det;
            self.gauges.iter().map(weight).collect()
        };
        vec![row(ll, -nl), row(-nl, nn)]
    }

    /// Returns interleaved samples of a second from `from_s` on, under a load.
    fn second(&mut self, load_n: [f64; 2], from_s: f64) -> Vec<f32> {
        let read = self
            .response
            .map(|row| row[0] * load_n[0] + row[1] * load_n[1]);
        let mut samples = Vec::with_capacity(6 * CARD_HZ as usize);
        for frame in 0..CARD_HZ as usize {
            let at_s = from_s + frame as f64 / CARD_HZ;
            for (gauge, volts) in self.gauges.iter().enumerate() {
                let noise: f64 = StandardNormal.sample(&mut self.rng);
                let volts = volts[0] * read[0]
                    + volts[1] * read[1]
                    + self.offset_v[gauge]
                    + self.drift_v_per_s[gauge] * at_s
                    + self.noise_v * noise;
                samples.push((volts / 10.0) as f32);
            }
        }
        samples
    }
}

/// Runs `calibrate force` for a sensor on inputs of the card.
fn calibrated(sensor: &mut Unknown) -> (MeasuredForce, Vec<String>) {
    let mut config = bench("0.25");
    let gauges = Gauges {
        inputs: vec![3, 4, 5, 6, 7, 8],
        newtons_per_v: sensor.maker_matrix(),
        volts_per_unit: vec![10.0],
        ..Gauges::default()
    };
    config.force.as_mut().unwrap().sensor = Sensor::Channels(gauges.clone());
    let (mut feed, tap) = InputTap::with_feed(6, 2 * CARD_HZ as usize);
    let no_correction = config::Correction::default();
    let mut source = GaugeForce::new(tap, &gauges, CARD_HZ, 0.0, no_correction, None);
    let masses: Vec<Mass> = [
        from_g(ForceAxis::Normal, &[20.0, 50.0, 100.0, 200.0]),
        from_g(ForceAxis::Lateral, &[20.0, 50.0, 100.0]),
    ]
    .concat();
    let exact = Accuracy {
        masses: 0.0,
        pulley: 0.0,
    };
    let setup = ForceSetup::new(&config, masses, exact, Some(GRAVITY_M_PER_S2)).unwrap();
    let mut procedure = ForceProcedure::new(setup, false);
    let (mut load_n, mut now_s) = ([0.0; 2], 0.0);
    let mut read = |load_n: [f64; 2], now_s: &mut f64| {
        let first = (*now_s * CARD_HZ).round() as u64;
        feed.feed(first, &sensor.second(load_n, *now_s));
        let mut capture = Capture {
            samples: vec![0.0; CARD_HZ as usize],
            channels: 1,
            rate_hz: CARD_HZ,
            from_s: *now_s,
            ..Capture::default()
        };
        *now_s += 1.0;
        source
            .poll(&|| 0.0, &mut |force| {
                capture.normal_n.push(force.normal_n);
                capture.lateral_n.push(force.lateral_n);
            })
            .unwrap();
        capture
    };
    let mut outcome = StepOutcome::Began;
    loop {
        outcome = match procedure.next(outcome).unwrap() {
            NextStep::Listen(_) => StepOutcome::Captured(read(load_n, &mut now_s)),
            NextStep::Ask(request) => {
                match request {
                    Request::Load { axis, mass_kg } => {
                        load_n[axis.index()] = mass_kg * GRAVITY_M_PER_S2;
                    }
                    _ => load_n = [0.0; 2],
                }
                StepOutcome::Answered(Answer::Ready, read(load_n, &mut now_s))
            }
            NextStep::Done => break,
            step => panic!("{step:?}"),
        };
    }
    let judgement = procedure
        .judge(jiff::Timestamp::UNIX_EPOCH, "A. Tester")
        .unwrap();
    match judgement.part {
        Part::Force { force, .. } => (*force, judgement.faults),
        part => panic!("{part:?}"),
    }
}

#[test]
fn eight_unknown_sensors_are_known_within_their_intervals() {
    const SEEDS: u64 = 8;
    let misses = |seed: u64| -> [(f64, f64); 4] {
        let mut sensor = Unknown::draw(seed);
        let (force, faults) = calibrated(&mut sensor);
        assert_eq!(faults, Vec::<String>::new(), "seed {seed}");
        let [[a, b], [c, d]] = sensor.response;
        let det = a * d - b * c;
        let miss =
            |quantity: &Quantity, truth: f64| (quantity.value - truth, quantity.half_width_95());
        [
            miss(&force.normal_per_normal, d / det),
            miss(&force.normal_per_lateral, -b / det),
            miss(&force.lateral_per_normal, -c / det),
            miss(&force.lateral_per_lateral, a / det),
        ]
    };
    let spawn_half = |first_seed: u64| {
        std::thread::spawn(move || {
            (first_seed..=SEEDS)
                .step_by(2)
                .map(misses)
                .collect::<Vec<_>>()
        })
    };
    let halves = [spawn_half(1), spawn_half(2)];
    let all: Vec<_> = halves
        .into_iter()
        .flat_map(|thread| thread.join().unwrap())
        .collect();
    assert_eq!(all.len() as u64, SEEDS);
    for entry in 0..4 {
        let hits = all
            .iter()
            .filter(|misses| misses[entry].0.abs() <= misses[entry].1)
            .count();
        let worst = all
            .iter()
            .map(|misses| misses[entry].0.abs())
            .fold(0.0, f64::max);
        println!("entry {entry}: worst {worst:.1e}, interval holds the truth {hits}/{SEEDS}");
        assert!(hits as u64 >= SEEDS - 1, "entry {entry}: {hits} of {SEEDS}");
        assert!(worst < 2e-3, "entry {entry}: {worst:e}");
    }
}

#[test]
fn a_sensor_without_frames_can_lose_none_in_a_rehearsal() {
    let config = bench("0.25");
    let possible = |fault: &str| {
        let fault = fault.parse().unwrap();
        drill::rehearsed::require_possible(&[fault], &config, true).is_ok()
    };
    assert!(possible("force-silent@1s") && possible("press@1s"));
    assert!(!possible("force-dropped@1s") && !possible("force-corrupted@1s"));
}
