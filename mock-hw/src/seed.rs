//! One seed, many independent random streams.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Who draws; each has its own stream, so that one does not shift another's numbers.
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
}

pub(crate) fn stream(seed: u64, stream: Stream) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream as u64);
    rng
}
