//! Independent random streams of one seed.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Users of random numbers; each has a stream, so that the draws of one do not shift those of another.
///
/// The numbers of the streams are part of every seeded result: new ones go to the end.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Stream {
    Jitter = 1,
    Fingertip,
    Moisture,
    ConverterNoise,
    ForceNoise,
    Person,
    ForceCounters,
    Vibrometer,
    ForceWander,
    Masses,
    SoundLayer,
    Voltmeter,
}

/// Returns the generator of one stream of `seed`.
pub(crate) fn stream(seed: u64, stream: Stream) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream as u64);
    rng
}
