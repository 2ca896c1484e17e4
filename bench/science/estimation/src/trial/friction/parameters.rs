//! Parameters of friction that the instances of a trial share, and their places in vectors.

use std::ops::Index;

use nalgebra::Vector2;

/// Number of parameters shared by a trial.
pub(crate) const FRICTION_PARAMETERS: usize = 2;

/// Parameter of friction that the instances of a trial share, in the order of vectors and matrices.
#[derive(Debug, Clone, Copy)]
pub(crate) enum FrictionParameter {
    /// φ.
    Floor,
    /// Lag of the lateral force, ms.
    LagMs,
}

impl Index<FrictionParameter> for Vector2<f64> {
    type Output = f64;

    fn index(&self, parameter: FrictionParameter) -> &f64 {
        &self[parameter as usize]
    }
}
