//! Causes for which the laws of a world are others, and the worlds drawn for each.

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use reference_worlds::independent::random_world;
use reference_worlds::truth::{World, parameter};

/// Wavelength across the plate of Huloux 2021, m.
const WAVELENGTH_ACROSS_M: f64 = 22e-3;
/// Resonance of the plate, Hz.
const RESONANCE_HZ: f64 = 35e3;
/// Longest fingertip contact relative to its width.
const LONGEST_ASPECT: f64 = 1.5;

/// A cause with the parameters that it sets.
#[derive(Debug, Clone, Copy)]
pub struct Cause {
    /// Name, by which a run selects it.
    pub name: &'static str,
    draw: fn(&mut Draw, &World) -> World,
}

/// Causes, in the order of the table.
pub static CAUSES: [Cause; 16] = [
    Cause {
        name: "force-zero",
        draw: |draw, _| {
            vec![
                ("normal_zero_n", draw.sign() * draw.linear(5e-3, 48e-3)),
                ("lateral_zero_n", draw.uniform(-30e-3, 30e-3)),
            ]
        },
    },
    Cause {
        name: "force-zero-drifts",
        draw: |draw, _| {
            vec![
                ("after_s", 1.0),
                ("normal_zero_n", draw.uniform(-45e-3, 45e-3)),
                (
                    "normal_zero_n_per_s",
                    draw.sign() * draw.logarithmic(8e-5, 3e-3),
                ),
                ("lateral_zero_n_per_s", draw.uniform(-1e-3, 1e-3)),
            ]
        },
    },
    Cause {
        name: "wide-finger",
        draw: |draw, _| {
            vec![
                ("wavelength_across_m", WAVELENGTH_ACROSS_M),
                ("finger_width_m", draw.linear(3e-3, 13e-3)),
                ("finger_is_strip", draw.coin()),
            ]
        },
    },
    Cause {
        name: "fingertip",
        draw: |draw, _| fingertip(draw),
    },
    Cause {
        name: "fingertip-known-wavelength",
        draw: |draw, _| {
            let mut world = fingertip(draw);
            let error = draw.uniform(-0.015, 0.015);
            world.push(("stated_wavelength_m", WAVELENGTH_ACROSS_M * (1.0 + error)));
            world
        },
    },
    Cause {
        name: "trapped-air",
        draw: |draw, _| vec![("trapped_air", draw.logarithmic(1e-3, 0.3))],
    },
    Cause {
        name: "film-loss",
        draw: |draw, finger| {
            let loss_factor = parameter(finger, "loss_factor").unwrap_or(0.3);
            let is_less = draw.coin() > 0.0;
            let difference = if is_less { -loss_factor } else { 0.3 };
            vec![("film_loss", difference * draw.linear(0.1, 1.0))]
        },
    },
    Cause {
        name: "cycle-average",
        draw: |draw, _| {
            vec![
                ("cycle_average", draw.linear(0.05, 1.0)),
                ("cycle_harmonic", draw.coin()),
            ]
        },
    },
    Cause {
        name: "relative-motion",
        draw: |draw, _| vec![("relative_motion", draw.logarithmic(0.01, 1.0))],
    },
    Cause {
        name: "plate-softens",
        draw: |draw, _| {
            vec![(
                "softening_ppm_per_um2",
                draw.sign() * draw.logarithmic(0.1, 10.0),
            )]
        },
    },
    Cause {
        name: "pressure",
        draw: |draw, _| vec![("ambient_pa", draw.linear(70e3, 105e3))],
    },
    Cause {
        name: "pressure-known",
        draw: |draw, _| {
            vec![
                ("ambient_pa", draw.linear(70e3, 105e3)),
                ("states_pressure", 1.0),
            ]
        },
    },
    Cause {
        name: "crosstalk-to-lateral",
        draw: |draw, _| vec![("normal_to_lateral", draw.sign() * draw.linear(2e-3, 5e-2))],
    },
    Cause {
        name: "crosstalk-to-normal",
        draw: |draw, _| vec![("lateral_to_normal", draw.sign() * draw.linear(2e-3, 5e-2))],
    },
    Cause {
        name: "forces-late",
        draw: |draw, _| {
            vec![
                ("forces_late_s", draw.linear(0.2e-3, 5e-3)),
                ("normal_lag_s", draw.uniform(0.0, 2e-3)),
            ]
        },
    },
    Cause {
        name: "second-mode",
        draw: |draw, _| {
            let resonance_hz = RESONANCE_HZ + draw.sign() * draw.logarithmic(800.0, 6000.0);
            let mass_kg = draw.uniform(8e-3, 30e-3);
            let quality = draw.uniform(150.0, 350.0);
            let damping = std::f64::consts::TAU * resonance_hz * mass_kg / quality;
            vec![
                ("second_mode_hz", resonance_hz),
                ("second_mode_kg", mass_kg),
                ("second_mode_damping", damping),
                ("second_mode_at_drive", draw.uniform(-1.0, 1.0)),
                ("second_mode_at_pickup", draw.uniform(-1.0, 1.0)),
                ("second_mode_at_finger", draw.uniform(-1.0, 1.0)),
            ]
        },
    },
];

/// Name of the worlds with two to four causes at once.
pub const SEVERAL: &str = "several";
/// Name of the worlds of the published laws.
pub const PUBLISHED: &str = "published";

/// A finger as wide as its area and shape make it, near the antinode of the mode across the plate.
fn fingertip(draw: &mut Draw) -> World {
    let area_m2 = draw.linear(50e-6, 160e-6);
    let aspect = draw.uniform(1.1, LONGEST_ASPECT);
    // An ellipse of width w and length aspect · w has the area π/4 · aspect · w².
    let width_m = (4.0 * area_m2 / (std::f64::consts::PI * aspect)).sqrt();
    vec![
        ("contact_area_m2", area_m2),
        ("wavelength_across_m", WAVELENGTH_ACROSS_M),
        ("finger_width_m", width_m),
        ("finger_offset_m", draw.uniform(-1e-3, 1e-3)),
    ]
}

/// Values of one world of a cause: the main one at its place among those of all worlds, the others at random.
struct Draw {
    /// Place of the main value in its range, 0 to 1.
    place: f64,
    is_even: bool,
    rng: ChaCha8Rng,
}

impl Draw {
    fn linear(&self, low: f64, high: f64) -> f64 {
        low + self.place * (high - low)
    }

    fn logarithmic(&self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.place)
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.rng.random_range(low..high)
    }

    /// Either sign by turns.
    fn sign(&self) -> f64 {
        if self.is_even { 1.0 } else { -1.0 }
    }

    /// 0 or 1 at random.
    fn coin(&mut self) -> f64 {
        f64::from(u8::from(self.rng.random_bool(0.5)))
    }
}

/// World with its name.
#[derive(Debug, Clone)]
pub struct NamedWorld {
    /// Cause.
    pub cause: &'static str,
    /// Values that the cause sets.
    pub changed: World,
    /// All parameters.
    pub world: World,
}

impl NamedWorld {
    fn new(cause: &'static str, finger: World, changed: World) -> Self {
        let world = [finger, changed.clone()].concat();
        Self {
            cause,
            changed,
            world,
        }
    }
}

/// Returns `count` worlds of a cause: half of them with the finger that `dynamic` assumes, half with drawn fingers, plates and
/// sensors.
pub fn worlds_of(cause: &Cause, count: u64) -> Vec<NamedWorld> {
    let bytes = cause.name.bytes();
    let hash = bytes.fold(0_u64, |hash, byte| hash * 31 % 1_000_003 + u64::from(byte));
    let world = |number: u64| {
        let seed = 1000 * hash + number;
        let mut draw = Draw {
            place: (number as f64 + 0.5) / count as f64,
            is_even: (number / 2).is_multiple_of(2),
            rng: ChaCha8Rng::seed_from_u64(seed),
        };
        let finger = if number.is_multiple_of(2) {
            vec![("seed", seed as f64), ("mu0", 0.8)]
        } else {
            random_world(seed)
        };
        let changed = (cause.draw)(&mut draw, &finger);
        NamedWorld::new(cause.name, finger, changed)
    };
    (0..count).map(world).collect()
}

/// Returns `count` worlds with two to four causes at once and drawn fingers.
pub fn worlds_of_several(count: u64) -> Vec<NamedWorld> {
    let world = |number: u64| {
        let seed = 40_000 + number;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let finger = random_world(seed);
        let causes = rng.random_range(2..=4);
        let chosen: Vec<&Cause> = CAUSES.sample(&mut rng, causes).collect();
        let changed = chosen.into_iter().flat_map(|cause| {
            let mut draw = Draw {
                place: rng.random_range(0.0..1.0),
                is_even: rng.random_bool(0.5),
                rng: ChaCha8Rng::seed_from_u64(rng.random()),
            };
            (cause.draw)(&mut draw, &finger)
        });
        let changed = changed.collect();
        NamedWorld::new(SEVERAL, finger.clone(), changed)
    };
    (0..count).map(world).collect()
}

/// Returns `count` worlds of the published laws with drawn fingers.
pub fn published_worlds(count: u64) -> Vec<NamedWorld> {
    let world = |number| NamedWorld::new(PUBLISHED, random_world(number), World::new());
    (1..=count).map(world).collect()
}
