//! Independent random streams of a seed.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Users of random numbers; each has a separate stream, so that its draws do not shift those of another.
///
/// The stream numbers affect every seeded result: append new ones at the end.
#[derive(Debug, Clone, Copy)]
pub enum RandomStream {
    /// Constants of a scenario's jitter.
    Jitter = 1,
    /// Skin of a person.
    Fingertip,
    /// Change of the skin during a session.
    Moisture,
    /// Noise of the converter.
    ConverterNoise,
    /// Noise of the force sensor.
    ForceNoise,
    /// Behaviour of the person.
    Person,
    /// Initial counters of the force sensor.
    ForceCounters,
    /// Errors of the vibrometer.
    Vibrometer,
    /// Slow drift of the force sensor.
    ForceWander,
    /// Errors of the known masses.
    Masses,
    /// Delays of the sound layer, drawn at each opening.
    SoundLayer,
    /// Errors of the voltmeter.
    Voltmeter,
    /// Contact of a person's skin.
    Pad,
    /// Constants of one session of the bench.
    Session,
    /// Noise of a force sensor's gauges.
    Gauges,
    /// Noise of a vibrometer on an input of the sound card.
    Reference,
}

/// Returns the generator of one stream of `seed`.
#[must_use]
pub fn stream(seed: u64, stream: RandomStream) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream as u64);
    rng
}
