//! Consequences of a finding, and its name in the reason why a stretch has no estimate.

use crate::implausible::Implausible;
use crate::units::force_factor;

/// Smallest and largest ratio beyond which no friction has a meaning.
const ANY_FRICTION: [f64; 2] = [0.02, 20.0];
/// Amplitude of a hum beyond which no estimate has a meaning, N: some 7 % of a finger's force.
const GREATEST_HUM_N: f64 = 0.04;
/// Factor of a force beyond which no estimate has a meaning.
const GREATEST_FORCE_FACTOR: f64 = 2.0;

impl Implausible {
    /// Returns whether the plate's impedance cannot be used until it is corrected.
    #[must_use]
    pub fn spoils_plate(&self) -> bool {
        matches!(
            self,
            Self::ChannelsExchanged { .. }
                | Self::ScaleFactor { .. }
                | Self::Scale { .. }
                | Self::FingerOnPlate { .. }
                | Self::FingerUnloaded { .. }
        )
    }

    /// Returns whether it is a flaw of forces of any body, to which the ranges of a finger do not apply.
    #[must_use]
    pub fn is_of_any_body(&self) -> bool {
        matches!(
            self,
            Self::Constant { .. }
                | Self::Clipped { .. }
                | Self::Sign { .. }
                | Self::Wrapped { .. }
                | Self::Repeated { .. }
                | Self::Hum { .. }
                | Self::Coupled { .. }
        )
    }

    /// Returns the name of the flaw, for the reason why a stretch has no estimate.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Size { .. } => "normal force in another unit",
            Self::Light { .. } => "normal force below that of a touch",
            Self::SmallForces { .. } => "small normal force",
            Self::ForcesUnplaced { .. } => "times of the forces",
            Self::LargeAmplitude { .. } => "amplitude of no plate",
            Self::OffCentre { .. } => "slides beside the plate's centre",
            Self::OtherSpeed { .. } => "slides at another speed",
            Self::Amplitude { .. } => "amplitude that lifts no finger",
            Self::Stray { .. } => "stray readings",
            Self::RoundedTimes { .. } => "rounded times",
            Self::Gap { .. } => "missing rows",
            Self::Wrapped { .. } => "force beyond the range of its integers",
            Self::Repeated { .. } => "readings that come twice",
            Self::Hum { .. } => "hum of the force sensor",
            Self::Smoothed { .. } => "forces low-passed",
            Self::Crosstalk { .. } => "crosstalk of the force sensor",
            Self::Sign { .. } => "normal force upside down",
            Self::Constant { .. } => "dead channel of the force sensor",
            Self::Held { .. } => "force that keeps one value",
            Self::Interpolated { .. } => "gap that was filled in",
            Self::PositionsLate { .. } => "positions late or early",
            Self::PositionHeld { .. } => "position that keeps one value",
            Self::PositionJumps { .. } => "position that jumps",
            Self::LateralAlone { .. } => "normal and lateral force exchanged",
            Self::Coupled { .. } => "drive in the force channel",
            Self::ModulationJumps { .. } => "samples missing or doubled",
            Self::LateralLag { .. } => "lateral force late or early",
            Self::FrictionDiffers { .. } => "friction that differs within the recording",
            Self::FrictionLag { .. } => "friction behind the amplitude",
            Self::FrictionUnlike { .. } => "friction unlike that of the impedance",
            Self::Clipped { .. } => "force beyond the sensor's range",
            Self::Friction { .. } => "scale of the forces",
            Self::Carrier { .. } => "carrier far from the resonance",
            Self::SmallShare { .. } => "level of a channel",
            Self::Pressure { .. } => "ambient pressure",
            Self::Untared { .. } => "normal force untared",
            Self::FingerUnloaded { .. } => "finger in the unloaded intervals",
            Self::Exchanged { .. } | Self::ExchangedByStrokes { .. } => {
                "normal and lateral force exchanged"
            }
            Self::Alike => "normal and lateral force alike",
            Self::LateralSign => "lateral force upside down",
            Self::LateralUnsigned => "lateral force without its sign",
            Self::ForcesLate { .. } => "forces late or early",
            Self::ForcesUnclear { .. } => "forces late or early by one of two delays",
            Self::StrokesZero { .. } => "lateral force untared",
            Self::ForcesClock { .. } => "rate of the forces",
            Self::PositionUnit { .. } => "position in another unit",
            Self::Backwards => "position backwards",
            Self::PositionStill => "dead position",
            Self::StimulusUpsideDown { .. } => "stimulus upside down or shifted",
            Self::ChannelsExchanged { .. } => "drive and pickup exchanged",
            Self::ScaleFactor { .. } | Self::Scale { .. } => "scale of drive or pickup",
            Self::OtherModulation { .. } => "modulation not that of the data",
            Self::FingerOnPlate { .. } => "finger in the unloaded intervals",
            Self::PickupQuantity { .. } => "quantity of the pickup",
            Self::Compression { .. } => "compressed drive or pickup",
            Self::ContactArea { .. } => "scale of the normal force",
            Self::DriveJumps { .. } => "samples missing or doubled",
            Self::LevelJumps { .. } => "level of drive or pickup that jumps",
            Self::DeadChannel { .. } => "dead channel",
            Self::OtherCarrier { .. } => "carrier not that of the data",
        }
    }

    /// Returns whether the friction is smaller than that of a finger on a plate that is at rest at times.
    #[must_use]
    pub fn is_low_friction(&self) -> bool {
        matches!(self, Self::Friction { ratio } if *ratio < 1.0)
    }

    /// Returns whether the estimates cannot be used until it is corrected.
    #[must_use]
    pub fn spoils_estimates(&self) -> bool {
        match self {
            Self::Friction { ratio } => !(ANY_FRICTION[0]..=ANY_FRICTION[1]).contains(ratio),
            Self::ContactArea { area_m2 } => {
                let factor = force_factor(*area_m2);
                factor.max(factor.recip()) > GREATEST_FORCE_FACTOR
            }
            Self::DriveJumps { is_timed, .. } | Self::ModulationJumps { is_timed, .. } => !is_timed,
            Self::Hum { amplitude_n, .. } => *amplitude_n > GREATEST_HUM_N,
            Self::Size { .. }
            | Self::RoundedTimes { .. }
            | Self::Sign { .. }
            | Self::Constant { .. }
            | Self::Clipped { .. }
            | Self::Untared { .. }
            | Self::FingerUnloaded { .. }
            | Self::Exchanged { .. }
            | Self::ExchangedByStrokes { .. }
            | Self::Alike
            | Self::PositionUnit { .. }
            | Self::Backwards
            | Self::PositionStill
            | Self::PositionsLate { .. }
            | Self::LateralLag { .. }
            | Self::LateralAlone { .. }
            | Self::Coupled { .. }
            | Self::Repeated { .. }
            | Self::Wrapped { .. }
            | Self::ChannelsExchanged { .. }
            | Self::ScaleFactor { .. }
            | Self::Scale { .. }
            | Self::ForcesUnclear { .. }
            | Self::LevelJumps { .. }
            | Self::FingerOnPlate { .. } => true,
            Self::Carrier { .. }
            | Self::Stray { .. }
            | Self::Held { .. }
            | Self::Interpolated { .. }
            | Self::PositionHeld { .. }
            | Self::PositionJumps { .. }
            | Self::FrictionDiffers { .. }
            | Self::FrictionLag { .. }
            | Self::FrictionUnlike { .. }
            | Self::Gap { .. }
            | Self::Smoothed { .. }
            | Self::Crosstalk { .. }
            | Self::Compression { .. }
            | Self::StimulusUpsideDown { .. }
            | Self::Light { .. }
            | Self::SmallForces { .. }
            | Self::ForcesUnplaced { .. }
            | Self::LargeAmplitude { .. }
            | Self::OffCentre { .. }
            | Self::OtherSpeed { .. }
            | Self::Amplitude { .. }
            | Self::SmallShare { .. }
            | Self::Pressure { .. }
            | Self::LateralSign
            | Self::LateralUnsigned
            | Self::ForcesLate { .. }
            | Self::ForcesClock { .. }
            | Self::StrokesZero { .. }
            | Self::PickupQuantity { .. }
            | Self::OtherModulation { .. }
            | Self::DeadChannel { .. }
            | Self::OtherCarrier { .. } => false,
        }
    }
}
