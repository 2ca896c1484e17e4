//! Drive signal of the plate and the sound card's two directions.
