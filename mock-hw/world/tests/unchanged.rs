//! The scenarios that were there before the unkind ones stay the worlds that they were.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

use std::f64::consts::TAU;

use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::scenario::built_in;

const RATE_HZ: f64 = 192e3;
const PERIOD: usize = 384;

/// Root mean squares of drive read-back, pickup, normal and lateral reading, gap in µm, and the sum of |sample| · (1 + n mod
/// 7) over all inputs, which hears any change of a random stream.
fn fingerprint(name: &str, seed: u64) -> [f64; 6] {
    let mut plant = Plant::new(&built_in(name).unwrap(), seed, RATE_HZ);
    let (mut drive, mut inputs) = ([0.0f32; PERIOD], vec![0.0f32; PERIOD * plant.channels()]);
    let mut squares = [(0.0, 0u32); 5];
    let mut add = |index: usize, value: f64| {
        let (sum, n): &mut (f64, u32) = &mut squares[index];
        *sum += value * value;
        *n += 1;
    };
    let mut heard = 0.0;
    for period in 0..150 {
        let t_s = f64::from(period) * PERIOD as f64 / RATE_HZ;
        for (i, sample) in drive.iter_mut().enumerate() {
            let t = t_s + i as f64 / RATE_HZ;
            let envelope = 0.4 * (1.0 + 0.95 * (TAU * 6.0 * t).sin());
            *sample = (envelope * (TAU * 35e3 * t).sin()) as f32;
        }
        let touching = (0.05..0.25).contains(&t_s);
        let finger = FingerState {
            position_m: 0.03 + 0.05 * t_s,
            velocity_m_per_s: 0.05,
            normal_n: if touching {
                0.65 + 0.1 * (TAU * 9.0 * t_s).sin()
            } else {
                0.0
            },
            touching,
        };
        plant.step(&drive, true, &finger, &mut inputs);
        for frame in inputs.chunks(plant.channels()) {
            add(0, f64::from(frame[0]));
            add(1, f64::from(frame[1]));
        }
        for (n, sample) in inputs.iter().enumerate() {
            heard += f64::from(sample.abs()) * (1 + n % 7) as f64;
        }
        for reading in plant.forces() {
            add(2, reading.normal_n);
            add(3, reading.lateral_n);
        }
        for truth in plant.truth().iter().filter(|truth| truth.gap_m.is_finite()) {
            add(4, 1e6 * truth.gap_m);
        }
    }
    let [a, b, c, d, e] = squares.map(|(sum, n)| (sum / f64::from(n)).sqrt());
    [a, b, c, d, e, heard]
}

/// Name, seed and fingerprint, taken before there were unkind worlds.
const BEFORE: [(&str, u64, [f64; 6]); 8] = [
    (
        "nominal",
        1,
        [
            0.3500945073501093,
            0.3496404425668713,
            0.525532585723241,
            0.21582587782044468,
            22.45222221669874,
            183803.15446281433,
        ],
    ),
    (
        "steady",
        1,
        [
            0.35009448691587824,
            0.34964279327755465,
            0.5255083941237918,
            0.21652649152495496,
            22.450959357164585,
            183789.06958511937,
        ],
    ),
    (
        "noisy",
        1,
        [
            0.35009515069330965,
            0.3493519937299328,
            0.5256158537684267,
            0.2573759724845751,
            23.113460622501666,
            183800.20700073242,
        ],
    ),
    (
        "population",
        1,
        [
            0.3500945073501093,
            0.3494610160293301,
            0.525532585723241,
            0.25688976774525674,
            23.127541475701676,
            183893.11609721184,
        ],
    ),
    (
        "participant-late",
        1,
        [
            0.3500945073501093,
            0.3494610160293301,
            0.525532585723241,
            0.25688976774525674,
            23.127541475701676,
            183893.11609721184,
        ],
    ),
    (
        "bench-unknown",
        1,
        [
            0.3500945073501093,
            0.23172033674938847,
            0.4838693281645917,
            0.2535479830696059,
            18.309613618801382,
            163255.79002308846,
        ],
    ),
    (
        "arduino",
        1,
        [
            0.3500945073501093,
            0.3494610160293301,
            0.5259376412314986,
            0.25672903907553435,
            23.127541475701676,
            183893.11609721184,
        ],
    ),
    (
        "population",
        7,
        [
            0.35009443827592807,
            0.34935802382607994,
            0.5255608849379456,
            0.1890696048108957,
            22.183136128921326,
            183503.87722563744,
        ],
    ),
];

#[test]
fn no_effect_of_an_unkind_world_reaches_the_older_scenarios() {
    for (name, seed, before) in BEFORE {
        let now = fingerprint(name, seed);
        for (now, before) in now.iter().zip(before) {
            // what another machine's library rounds otherwise; the tables' defaults change nothing at all on the same one
            assert!(
                (now / before - 1.0).abs() < 1e-9,
                "{name}, seed {seed}: {now} was {before}"
            );
        }
    }
}
