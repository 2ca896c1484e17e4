//! Numbers of two parts: a complex impedance, and an estimate with its standard deviation.

/// A complex mechanical impedance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ComplexImpedance {
    /// Real part, N·s/m.
    pub re_n_s_per_m: f64,
    /// Imaginary part, N·s/m.
    pub im_n_s_per_m: f64,
}

/// An estimate with its standard deviation, in the unit of the field's name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ValueAndStd {
    /// Estimated value.
    pub value: f64,
    /// Standard deviation of the value.
    pub std: f64,
}
