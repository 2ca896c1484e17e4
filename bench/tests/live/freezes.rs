//! The program is frozen while the plate is driven: the one-shot at the amplifier takes the enable off, regardless of how
//! the sound card treats its last buffer (FAULTS.md, row 7).

use mock_hw::apparatus::{Apparatus, ApparatusConfig};
use mock_hw::host::ConverterDirection;
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use safety::SafetyState;

use crate::campaign;
use crate::rig::{Rig, amplitudes, config, rest_s};
use crate::safe::quantiles_ms;

const FROZEN_S: f64 = 0.5;
/// Time limit for the one-shot, from the FAULTS.md row.
const ENABLE_S: f64 = 0.1;
/// The simulated plate rings down to a hundredth in 4.6 time constants of 2 m/b, with 8 g and 7.01 N·s/m; the truth has
/// one sample per millisecond.
const RING_DOWN_S: f64 = 0.012;

/// A freeze of the program, in true time, s.
struct Freeze {
    at_s: f64,
    card_plays_on: bool,
}

/// Fault 7.
/// Hazard 15.
#[test]
fn a_program_frozen_at_random_moments_leaves_the_plate_at_rest_within_a_tenth_of_a_second() {
    let count = campaign::repeats("FRICTION_BENCH_FREEZES", 6);
    let folder = tempfile::tempdir().unwrap();
    let apparatus = Apparatus::new(ApparatusConfig {
        truth_path: Some(folder.path().to_owned()),
        ..ApparatusConfig::new(Scenario::default(), 1, WorldPace::Stepped)
    });
    let config = config(&[("silence_s = 0.25", "silence_s = 0.05")]);
    let mut rig = Rig::with_apparatus(apparatus.unwrap(), config, None);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut freezes = Vec::new();
    let halt = |rig: &Rig, halted| {
        for side in [ConverterDirection::Input, ConverterDirection::Output] {
            rig.apparatus.faults().halt_audio(side, halted);
        }
    };
    for number in 0..count {
        rig.drive();
        rig.pass(rng.random_range(0.25..0.5));
        assert!(rig.bench.drive.sounds());
        // Alternates between a card that repeats its buffer and one that stops with the program.
        let card_plays_on = number % 2 == 0;
        freezes.push(Freeze {
            at_s: rig.apparatus.now_ns() as f64 * 1e-9,
            card_plays_on,
        });
        halt(&rig, !card_plays_on);
        rig.freeze(FROZEN_S);
        halt(&rig, false);

        for _ in 0..600 {
            rig.tick();
        }
        let state = rig.tick();
        assert!(matches!(state, SafetyState::Tripped { .. }), "{state:?}");
        assert!(!rig.bench.drive.sounds(), "drives by itself");
        rig.bench.drive.rearm();
        rig.pass(0.1);
    }

    let Rig { apparatus, .. } = rig;
    apparatus.finish().unwrap();
    let truth = amplitudes(folder.path());
    let to_rest = freezes.iter().map(|freeze| {
        let rest_s = rest_s(&truth, freeze.at_s, FROZEN_S);
        assert!(rest_s < ENABLE_S + RING_DOWN_S, "moves for {rest_s} s");
        assert!(
            rest_s > 0.02 || !freeze.card_plays_on,
            "the card that plays on was not what the one-shot stopped: {rest_s} s"
        );
        rest_s
    });
    let to_rest = to_rest.collect();
    let text = format!(
        "median / 99 % / worst: plate at rest {}",
        quantiles_ms(to_rest)
    );
    campaign::report("stop: program frozen", count, &text);
}
