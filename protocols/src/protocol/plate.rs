//! Check that a protocol's slider stays on a plate.

use super::definition::Protocol;

/// An end of the slider's travel that is off the plate.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OffPlateError {
    /// The left end is off the plate.
    #[error(
        "exploration.from_m = {from_m} m is not on the plate, which reaches from 0 to \
         plate.length_m = {plate_length_m} m"
    )]
    From {
        /// Left end of the slider's travel, m.
        from_m: f64,
        /// Length of the plate, m.
        plate_length_m: f64,
    },
    /// The right end is off the plate.
    #[error(
        "exploration.to_m = {to_m} m is not on the plate, which reaches from 0 to \
         plate.length_m = {plate_length_m} m"
    )]
    To {
        /// Right end of the slider's travel, m.
        to_m: f64,
        /// Length of the plate, m.
        plate_length_m: f64,
    },
}

impl OffPlateError {
    /// Returns the dotted path of the key that places the slider off the plate.
    pub fn key(&self) -> &'static str {
        match self {
            Self::From { .. } => "exploration.from_m",
            Self::To { .. } => "exploration.to_m",
        }
    }
}

impl Protocol {
    /// Requires both ends of the slider's travel to lie on a plate that extends from 0 to `plate_length_m`.
    ///
    /// # Errors
    /// [`OffPlateError`] for the first end that is off the plate, or if `plate_length_m` is NaN.
    ///
    /// ```
    /// use protocols::{OffPlateError, Protocol, built_in};
    ///
    /// let text = built_in("huloux2021").expect("a built-in protocol").replace("to_m = 0.095", "to_m = 0.95");
    /// let protocol = Protocol::parse(&text, "long.toml")?;
    /// assert_eq!(
    ///     protocol.require_on_plate(0.105),
    ///     Err(OffPlateError::To { to_m: 0.95, plate_length_m: 0.105 })
    /// );
    /// # Ok::<(), protocols::ProtocolError>(())
    /// ```
    pub fn require_on_plate(&self, plate_length_m: f64) -> Result<(), OffPlateError> {
        let on_plate = |position_m: f64| (0.0..=plate_length_m).contains(&position_m);
        let (from_m, to_m) = (self.exploration.from_m, self.exploration.to_m);
        if !on_plate(from_m) {
            return Err(OffPlateError::From {
                from_m,
                plate_length_m,
            });
        }
        if !on_plate(to_m) {
            return Err(OffPlateError::To {
                to_m,
                plate_length_m,
            });
        }
        Ok(())
    }
}
