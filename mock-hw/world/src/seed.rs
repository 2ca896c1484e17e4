//! Independent random streams of one seed.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Users of random numbers; each has a stream, so that the draws of one do not shift those of another.
///
/// The numbers of the streams are part of every seeded result: new ones go to the end.
#[derive(Debug, Clone, Copy)]
pub enum Stream {
    /// When callbacks come.
    Jitter = 1,
    /// The skin of a person.
    Fingertip,
    /// How the skin changes over a session.
    Moisture,
    /// Noise of the converter.
    ConverterNoise,
    /// Noise of the force sensor.
    ForceNoise,
    /// What the person does.
    Person,
    /// Where the counters of the force sensor begin.
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
    /// The contact of a person's skin.
    Pad,
    /// What holds for one session of the bench.
    Session,
    /// Noise of a force sensor's gauges.
    Gauges,
    /// Noise of a vibrometer on an input of the sound card.
    Reference,
}

/// Returns the generator of one stream of `seed`.
#[must_use]
pub fn stream(seed: u64, stream: Stream) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream as u64);
    rng
}
