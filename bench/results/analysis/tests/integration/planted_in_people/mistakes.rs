//! Mistakes of recordings made elsewhere, each with the words that name it.

use std::f32::consts::{FRAC_1_SQRT_2, SQRT_2};
use std::f64::consts::{FRAC_PI_2, TAU};

use recording::manifest::{Carrier, Direction, RecordedIntervalKind};
use recording::{ForceRow, PositionRow};

use super::columns::Columns;

/// A mistake, and the words of which its name has one.
pub struct Mistake {
    pub name: String,
    pub words: &'static [&'static str],
    pub plant: Box<dyn Fn(&mut Columns) + Send + Sync>,
}

fn mistake(
    name: impl Into<String>,
    words: &'static [&'static str],
    plant: impl Fn(&mut Columns) + Send + Sync + 'static,
) -> Mistake {
    Mistake {
        name: name.into(),
        words,
        plant: Box::new(plant),
    }
}

fn of_forces(
    name: impl Into<String>,
    words: &'static [&'static str],
    change: impl Fn(&mut ForceRow) + Send + Sync + 'static,
) -> Mistake {
    mistake(name, words, move |columns| {
        columns.forces.iter_mut().for_each(&change);
    })
}

fn of_positions(
    name: impl Into<String>,
    words: &'static [&'static str],
    change: impl Fn(&mut PositionRow) + Send + Sync + 'static,
) -> Mistake {
    mistake(name, words, move |columns| {
        columns.positions.iter_mut().for_each(&change);
    })
}

fn scale(samples: &mut [f32], factor: f32) {
    samples.iter_mut().for_each(|sample| *sample *= factor);
}

/// Words of a scale that is off, of the force sensor's zero, of the clock of the forces, and of sizes of forces.
const SCALE: &[&str] = &["as if its modal mass were"];
const BOTH_SCALES: &[&str] = &[
    "a finger pad's is",
    "too little to lift",
    "times as far as a plate does",
    "self-sensed normal force is",
];
const ZERO: &[&str] = &["the force sensor read", "untared"];
const LATE: &[&str] = &["the forces come"];
const CLOCK: &[&str] = &["the forces come", "its times are on a clock"];
const JUMP: &[&str] = &[
    "the drive's phase jumps",
    "the forces come",
    "its times are on a clock",
];
const SIZE: &[&str] = &[
    "any finger's",
    "with which a finger touches",
    "little for a finger",
    "a finger pad's is",
    "friction is",
    "times normal_n",
];
const PHASE: &[&str] = &["as with phase_rad", "its phase is that of"];
const CARRIER: &[&str] = &["the carrier", "sample rate"];
const PLACE: &[&str] = &["position.csv"];

/// Returns all mistakes.
pub fn all() -> Vec<Mistake> {
    let groups = [of_sensors(), frames(), signals(), descriptions()];
    groups.into_iter().flatten().collect()
}

/// Returns those that need neither drive nor pickup.
pub fn of_sensors() -> Vec<Mistake> {
    let groups = [forces(), clocks(), files(), positions(), intervals()];
    groups.into_iter().flatten().collect()
}

fn forces() -> Vec<Mistake> {
    let mut all = Vec::new();
    for tare_n in [0.1, -0.1, 0.3] {
        let name = |axis: &str| format!("{axis} untared by {tare_n} N");
        all.push(of_forces(name("lateral"), ZERO, move |row| {
            row.lateral_n += tare_n
        }));
        all.push(of_forces(name("normal"), ZERO, move |row| {
            row.normal_n += tare_n
        }));
    }
    all.push(of_forces(
        "normal upside down",
        &["multiply it by -1"],
        |row| row.normal_n *= -1.0,
    ));
    all.push(of_forces(
        "lateral upside down",
        &["multiply it by -1"],
        |row| row.lateral_n *= -1.0,
    ));
    all.push(of_forces(
        "normal and lateral exchanged",
        &["the columns are exchanged"],
        |row| {
            std::mem::swap(&mut row.normal_n, &mut row.lateral_n);
        },
    ));
    // A volt of the sensor is 0.31 or 3.2 N.
    let units = [
        ("millinewtons", 1e3),
        ("grams", 101.97),
        ("kilograms", 0.101_97),
        ("pounds", 0.224_81),
        ("ounces", 3.597),
        ("volts", 3.2),
        ("volts of a stiff sensor", 0.31),
    ];
    for (unit, factor) in units {
        all.push(of_forces(format!("forces in {unit}"), SIZE, move |row| {
            row.normal_n *= factor;
            row.lateral_n *= factor;
        }));
    }
    for (unit, factor) in [("millinewtons", 1e3), ("grams", 101.97)] {
        all.push(of_forces(format!("normal in {unit}"), SIZE, move |row| {
            row.normal_n *= factor
        }));
        all.push(of_forces(format!("lateral in {unit}"), SIZE, move |row| {
            row.lateral_n *= factor
        }));
    }
    all.push(of_forces("normal dead", &["in each of"], |row| {
        row.normal_n = 0.25
    }));
    all.push(of_forces("lateral dead", &["in each of"], |row| {
        row.lateral_n = 0.0
    }));
    all.push(of_forces(
        "lateral rectified",
        &["lateral_n has one sign"],
        |row| row.lateral_n = row.lateral_n.abs(),
    ));
    all.push(mistake(
        "a gap filled in",
        &["is straight from"],
        |columns| {
            let from_s = middle_s(columns);
            let place = |time_s: f64| columns.forces.partition_point(|row| row.time_s < time_s);
            let (first, last) = (place(from_s), place(from_s + 0.3));
            let (from, to) = (columns.forces[first], columns.forces[last]);
            for (index, row) in columns.forces[first..last].iter_mut().enumerate() {
                let share = index as f64 / (last - first) as f64;
                row.normal_n = from.normal_n + share * (to.normal_n - from.normal_n);
                row.lateral_n = from.lateral_n + share * (to.lateral_n - from.lateral_n);
            }
        },
    ));
    all.push(mistake("forces delta-encoded", &["force.csv"], |columns| {
        let rows = columns.forces.clone();
        for (row, before) in columns.forces.iter_mut().skip(1).zip(&rows) {
            row.normal_n -= before.normal_n;
            row.lateral_n -= before.lateral_n;
        }
    }));
    all
}

fn clocks() -> Vec<Mistake> {
    let mut all = Vec::new();
    for late_s in [0.05, -0.05, 0.17, -0.17, 0.5, 0.005, -0.005] {
        let name = format!("forces late by {:.0} ms", late_s * 1e3);
        all.push(of_forces(name, LATE, move |row| row.time_s += late_s));
    }
    for rate in [1.01, 0.99, 1.001, 0.999] {
        let name = format!("clock of the forces times {rate}");
        all.push(of_forces(name, CLOCK, move |row| row.time_s *= rate));
    }
    for (unit, factor) in [("ms for s", 1e3), ("µs for s", 1e6), ("s for ms", 1e-3)] {
        let name = format!("times of forces: {unit}");
        all.push(of_forces(name, &["force.csv"], move |row| {
            row.time_s *= factor
        }));
        let name = format!("times of positions: {unit}");
        all.push(of_positions(name, PLACE, move |row| row.time_s *= factor));
    }
    // One reading of a hundred is missing, and the times are those of a constant rate.
    all.push(mistake("one force of a hundred lost", CLOCK, |columns| {
        let times: Vec<f64> = columns.forces.iter().map(|row| row.time_s).collect();
        let mut index = 0;
        columns.forces.retain(|_| {
            index += 1;
            index % 100 != 50
        });
        let rows = columns.forces.iter_mut().zip(times);
        rows.for_each(|(row, time_s)| row.time_s = time_s);
    }));
    all
}

fn files() -> Vec<Mistake> {
    vec![
        mistake("forces end early", &["force.csv"], |columns| {
            columns.forces.truncate(columns.forces.len() * 6 / 10);
        }),
        mistake("forces end in zeros", &["force.csv"], |columns| {
            let start = columns.forces.len() * 6 / 10;
            for row in &mut columns.forces[start..] {
                (row.normal_n, row.lateral_n) = (0.0, 0.0);
            }
        }),
        mistake("forces stay", &["stay at"], |columns| {
            let start = columns.forces.len() * 6 / 10;
            let frozen_row = columns.forces[start];
            for row in &mut columns.forces[start..] {
                (row.normal_n, row.lateral_n) = (frozen_row.normal_n, frozen_row.lateral_n);
            }
        }),
        mistake(
            "one lateral reading of -999",
            &["lateral_n jumps"],
            |columns| {
                let middle = columns.forces.len() / 2;
                columns.forces[middle].lateral_n = -999.0;
            },
        ),
        mistake("lost readings as 9.9e37", &["normal_n jumps"], |columns| {
            let rows = columns.forces.iter_mut().step_by(100);
            rows.for_each(|row| row.normal_n = 9.9e37);
        }),
        mistake("lost packets as zeros", &["normal_n jumps"], |columns| {
            let rows = columns.forces.iter_mut().step_by(10);
            rows.for_each(|row| (row.normal_n, row.lateral_n) = (0.0, 0.0));
        }),
        mistake("positions end early", PLACE, |columns| {
            columns.positions.truncate(columns.positions.len() * 4 / 10);
        }),
    ]
}

fn positions() -> Vec<Mistake> {
    let mut all = Vec::new();
    let units = [
        ("millimetres", 1e3),
        ("centimetres", 1e2),
        ("inches", 39.37),
        ("micrometres", 1e6),
        ("kilometres", 1e-3),
        ("half steps", 0.5),
        ("quarters of lines", 4.0),
    ];
    for (unit, factor) in units {
        all.push(of_positions(
            format!("position in {unit}"),
            PLACE,
            move |row| {
                row.position_m *= factor;
            },
        ));
    }
    all.push(of_positions("position backwards", PLACE, |row| {
        row.position_m *= -1.0
    }));
    all.push(of_positions("position mirrored", PLACE, |row| {
        row.position_m = 0.105 - row.position_m
    }));
    all.push(of_positions(
        "position of a counter that overflows",
        PLACE,
        |row| {
            row.position_m = row.position_m.rem_euclid(0.02);
        },
    ));
    all.push(of_positions("position dead", PLACE, |row| {
        row.position_m = 0.05
    }));
    all.push(of_positions("position of another origin", PLACE, |row| {
        row.position_m += 0.2
    }));
    all
}

/// Frames of the signals that are lost.
fn frames() -> Vec<Mistake> {
    let mut all = Vec::new();
    for share in [0.3, 0.62] {
        let name = format!("a block of samples lost after {:.0} %", 100.0 * share);
        all.push(mistake(name, JUMP, move |columns| {
            let frames = columns.drive.len() as f64;
            let (start, end) = (
                (share * frames) as usize,
                ((share + 0.01) * frames) as usize,
            );
            columns.drive.drain(start..end);
            columns.pickup.drain(start..end);
        }));
    }
    all.push(mistake("samples lost in blocks", JUMP, |columns| {
        for samples in [&mut columns.drive, &mut columns.pickup] {
            let mut index = 0;
            samples.retain(|_| {
                index += 1;
                (index / 1000) % 100 != 50
            });
        }
    }));
    all.push(mistake(
        "signals end early",
        &["the recording ends at"],
        |columns| {
            let frames = columns.drive.len() * 6 / 10;
            columns.drive.truncate(frames);
            columns.pickup.truncate(frames);
        },
    ));
    all
}

/// Returns the middle of the first exploration, s.
fn middle_s(columns: &Columns) -> f64 {
    let mut intervals = columns.manifest.intervals.iter();
    let is_exploration =
        |kind: &RecordedIntervalKind| matches!(kind, RecordedIntervalKind::Exploration(_));
    let exploration = intervals.find(|interval| is_exploration(&interval.kind));
    exploration.map_or(0.0, |interval| 0.5 * (interval.start_s + interval.end_s))
}

fn signals() -> Vec<Mistake> {
    let mut all = Vec::new();
    for factor in [0.5f32, 2.0, 0.0] {
        let from_then_on =
            move |columns: &Columns| (middle_s(columns) * f64::from(columns.rate_hz)) as usize;
        all.push(mistake(
            format!("pickup times {factor} from the middle of a slide on"),
            &["level jumps"],
            move |columns| {
                let start = from_then_on(columns);
                scale(&mut columns.pickup[start..], factor);
            },
        ));
        all.push(mistake(
            format!("drive times {factor} from the middle of a slide on"),
            &["level jumps"],
            move |columns| {
                let start = from_then_on(columns);
                scale(&mut columns.drive[start..], factor);
            },
        ));
    }
    let factors = [
        ("1/20", 0.05),
        ("1/10", 0.1),
        ("10", 10.0),
        ("20", 20.0),
        ("√2", SQRT_2),
        ("1/√2", FRAC_1_SQRT_2),
        ("2", 2.0),
        ("1/2", 0.5),
        ("2√2", 2.0 * SQRT_2),
        ("1/(2√2)", 0.5 * FRAC_1_SQRT_2),
        ("1000", 1e3),
        ("1/256", 1.0 / 256.0),
    ];
    for (name, factor) in factors {
        all.push(mistake(
            format!("drive times {name}"),
            SCALE,
            move |columns| {
                scale(&mut columns.drive, factor);
            },
        ));
        all.push(mistake(
            format!("pickup times {name}"),
            SCALE,
            move |columns| {
                scale(&mut columns.pickup, factor);
            },
        ));
    }
    for (name, factor) in [("1/256", 1.0 / 256.0), ("1/20", 0.05), ("20", 20.0)] {
        all.push(mistake(
            format!("both channels times {name}"),
            BOTH_SCALES,
            move |columns| {
                scale(&mut columns.drive, factor);
                scale(&mut columns.pickup, factor);
            },
        ));
    }
    all.push(mistake(
        "drive and pickup exchanged",
        &[
            "drive and pickup are exchanged",
            "as if its modal mass were",
        ],
        |columns| {
            std::mem::swap(&mut columns.drive, &mut columns.pickup);
        },
    ));
    all.push(mistake("pickup inverted", PHASE, |columns| {
        scale(&mut columns.pickup, -1.0)
    }));
    all.push(mistake(
        "velocity for displacement",
        &["that of a velocity", "as if its modal mass were"],
        |columns| {
            let turn = 1.0 / (TAU * carrier_hz(columns)) as f32 * columns.rate_hz as f32 / 2.0;
            let samples = columns.pickup.clone();
            let (before, after) = (samples.iter(), samples.iter().skip(2));
            for (sample, (before, after)) in
                columns.pickup.iter_mut().skip(1).zip(before.zip(after))
            {
                *sample = (after - before) * turn;
            }
        },
    ));
    for share in [0.5, 0.9] {
        let clip = move |samples: &mut Vec<f32>| {
            let peak = samples
                .iter()
                .fold(0.0f32, |peak, sample| peak.max(sample.abs()));
            samples
                .iter_mut()
                .for_each(|sample| *sample = sample.clamp(-share * peak, share * peak));
        };
        all.push(mistake(
            format!("pickup clipped at {share}"),
            &["pickup clipped"],
            move |columns| {
                clip(&mut columns.pickup);
            },
        ));
        all.push(mistake(
            format!("drive clipped at {share}"),
            &["drive clipped"],
            move |columns| {
                clip(&mut columns.drive);
            },
        ));
    }
    all.push(mistake("pickup dead", &["a dead channel"], |columns| {
        columns.pickup.fill(0.25)
    }));
    all.push(mistake("drive dead", &["a dead channel"], |columns| {
        columns.drive.fill(0.0)
    }));
    all.push(mistake(
        "pickup a copy of the drive",
        &["as if its modal mass were", "as with phase_rad"],
        |columns| {
            columns.pickup.clone_from(&columns.drive);
        },
    ));
    for (name, late_s) in [("late", 3e-3), ("early", -3e-3)] {
        let words = &["late", "exchanged", "impedance"];
        all.push(mistake(
            format!("pickup {name} by 3 ms"),
            words,
            move |columns| {
                let frames = (late_s * f64::from(columns.rate_hz)) as isize;
                let length = columns.pickup.len() as isize;
                columns
                    .pickup
                    .rotate_right(frames.rem_euclid(length) as usize);
            },
        ));
    }
    all
}

fn descriptions() -> Vec<Mistake> {
    let mut all = Vec::new();
    for turn_rad in [0.3, FRAC_PI_2, -FRAC_PI_2] {
        all.push(mistake(
            format!("phase of the pickup off by {turn_rad:.1}"),
            PHASE,
            move |columns| {
                columns.signals().channels.pickup.phase_rad += turn_rad;
            },
        ));
    }
    all.push(mistake(
        "phase of the pickup conjugated",
        PHASE,
        |columns| {
            columns.signals().channels.pickup.phase_rad *= -1.0;
        },
    ));
    for off_hz in [50.0, 500.0, -5000.0] {
        all.push(mistake(
            format!("carrier off by {off_hz} Hz"),
            CARRIER,
            move |columns| {
                columns.signals().carrier = Carrier::Steady(carrier_hz(columns) + off_hz);
            },
        ));
    }
    for factor in [0.5, 0.96, 2.0, 1.001] {
        all.push(mistake(
            format!("sample rate times {factor}"),
            CARRIER,
            move |columns| {
                columns.rate_hz = (f64::from(columns.rate_hz) * factor).round() as u32;
            },
        ));
    }
    for factor in [5.0 / 6.0, 2.0] {
        all.push(mistake(
            format!("modulation times {factor:.2}"),
            &["modulation_hz"],
            move |columns| {
                columns.signals().modulation.frequency_hz *= factor;
            },
        ));
    }
    all.push(mistake("modal mass in grams", SCALE, |columns| {
        columns.signals().plate.modal_mass_kg *= 1e3;
    }));
    all.push(mistake("force factor twice", SCALE, |columns| {
        columns.signals().plate.force_factor_n_per_v *= 2.0;
    }));
    all.push(mistake("centre in millimetres", PLACE, |columns| {
        columns.signals().plate.centre_m *= 1e3;
    }));
    all
}

fn intervals() -> Vec<Mistake> {
    let mut all = Vec::new();
    all.push(mistake("left and right exchanged", PLACE, |columns| {
        for interval in &mut columns.manifest.intervals {
            if let RecordedIntervalKind::Exploration(direction) = &mut interval.kind {
                *direction = match direction {
                    Direction::LeftToRight => Direction::RightToLeft,
                    Direction::RightToLeft => Direction::LeftToRight,
                };
            }
        }
    }));
    all.push(mistake(
        "finger in the unloaded intervals",
        &["a finger was on", "finger on the plate"],
        |columns| {
            let (start_s, end_s) = columns.exploration_s();
            let middle_s = 0.5 * (start_s + end_s);
            for interval in &mut columns.manifest.intervals {
                if interval.kind == RecordedIntervalKind::Unloaded {
                    (interval.start_s, interval.end_s) = (middle_s - 0.4, middle_s + 0.4);
                }
            }
        },
    ));
    all
}

fn carrier_hz(columns: &mut Columns) -> f64 {
    match columns.signals().carrier {
        Carrier::Steady(carrier_hz) => carrier_hz,
        Carrier::Follows => panic!("a carrier that moves"),
    }
}
