//! IQ demodulation, mechanical impedance and plate identification.
