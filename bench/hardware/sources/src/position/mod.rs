//! Position along the plate, in encoder counts.

mod line_encoder;
mod position_source;
mod quadrature;

pub use line_encoder::LineEncoder;
pub use position_source::{Counted, POSITION_HZ, PositionSource};
pub use quadrature::Quadrature;
