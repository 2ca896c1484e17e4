//! Contact and levitation model of a fingertip on an ultrasonic plate, its inversion and its fits.
mod assumed;
mod contact;
mod error;
pub mod fit;
pub mod harmonic;
mod root;
pub use assumed::AssumedConstants;
pub use contact::*;
pub use error::ModelError;
