//! Errors of NI's library, and their meaning for a bench.

/// Meaning of an error of the library for a bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DaqFault {
    /// The input buffer overran: samples were not read in time.
    Overrun,
    /// The output underran: samples were not written in time.
    Underrun,
    /// Fewer samples than requested came in time.
    TimedOut,
    /// The device was removed, or was never present.
    Gone,
    /// The device has no such terminal, line or counter.
    NoTerminal,
    /// The device cannot route the clock or the trigger in this way.
    Route,
    /// The rate is over the limit of the device.
    Rate,
    /// Another program holds the device or a part of it.
    Reserved,
    /// Anything else.
    Other,
}

/// A call of the library that failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{function} failed with NI-DAQmx error {code}: {text}")]
pub struct DaqError {
    /// Name of the function.
    pub function: &'static str,
    /// Its status, negative.
    pub code: i32,
    /// Message of the library.
    pub text: String,
}

impl DaqError {
    /// Returns the meaning of the error. The numbers are those of NI's `DAQmxErrors`, by the names in the comments.
    #[must_use]
    pub fn fault(&self) -> DaqFault {
        match self.code {
            // SamplesNoLongerAvailable, AcqStoppedToPreventInputBufferOverwrite, InputFIFOOverflow, InputFIFOOverflow2,
            // ADCOverrun.
            -200_279 | -200_222 | -200_010 | -200_361 | -200_019 => DaqFault::Overrun,
            // GenStoppedToPreventRegenOfOldSamples, OutputFIFOUnderflow2, DACUnderflow, OutputFIFOUnderflow.
            -200_290 | -200_621 | -200_018 | -200_016 => DaqFault::Underrun,
            // SamplesNotYetAvailable.
            -200_284 => DaqFault::TimedOut,
            // InvalidDeviceID, DevAbsentOrUnavailable, DevCannotBeAccessed, DevAbsentOrUnavailable_Routing.
            -200_220 | -200_324 | -201_003 | -89_130 => DaqFault::Gone,
            // PhysicalChanDoesNotExist.
            -200_170 => DaqFault::NoTerminal,
            // Routing: from InvalidRoutingSourceTerminalName to NoCommonTrigLineForRoute.
            -89_139..=-89_120 => DaqFault::Route,
            // SampRateTooHigh, SampleRateNumChansConvertPeriodCombo, InvalidAttributeValue.
            -200_332 | -200_081 | -200_077 => DaqFault::Rate,
            // PALResourceReserved, DigLinesReservedOrUnavailable.
            -50_103 | -200_587 => DaqFault::Reserved,
            _ => DaqFault::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_codes_match_nis_header() {
        for (code, fault) in [
            (-200_279, DaqFault::Overrun),
            (-200_290, DaqFault::Underrun),
            (-200_284, DaqFault::TimedOut),
            (-201_003, DaqFault::Gone),
            (-89_130, DaqFault::Gone),
            (-200_170, DaqFault::NoTerminal),
            (-89_136, DaqFault::Route),
            (-200_332, DaqFault::Rate),
            (-50_103, DaqFault::Reserved),
            (-1, DaqFault::Other),
        ] {
            let error = DaqError {
                function: "DAQmxReadAnalogF64",
                code,
                text: String::new(),
            };
            assert_eq!(error.fault(), fault, "{code}");
        }
    }
}
