//! 24-bit samples in cpal's types.

use crate::sample::{ConverterSample, I24};

impl ConverterSample for cpal::I24 {
    const ZERO: Self = <Self as cpal::Sample>::EQUILIBRIUM;

    fn from_unit(value: f32) -> Self {
        Self::new_unchecked(I24::from_unit(value).container())
    }

    fn to_unit(self) -> f32 {
        I24::from_container(self.inner()).to_unit()
    }
}
