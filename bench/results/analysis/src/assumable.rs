//! Assumed numbers that can be changed, and their allowed values.

/// Allowed values of a number: in words, and as a rule.
#[derive(Clone, Copy)]
pub(crate) struct AllowedValues {
    pub(crate) words: &'static str,
    pub(crate) rule: fn(f64) -> bool,
}

pub(crate) const POSITIVE: AllowedValues = AllowedValues {
    words: "finite numbers above 0",
    rule: |value| value.is_finite() && value > 0.0,
};
pub(crate) const AREA: AllowedValues = AllowedValues {
    words: "areas from 1e-6 to 1e-2 m² (314 mm² are 3.14e-4)",
    rule: |value| (1e-6..=1e-2).contains(&value),
};
pub(crate) const PRESSURE: AllowedValues = AllowedValues {
    words: "pressures from 3e4 to 1.2e5 Pa (1013 hPa are 101300)",
    rule: |value| (3e4..=1.2e5).contains(&value),
};
pub(crate) const FINITE: AllowedValues = AllowedValues {
    words: "finite numbers",
    rule: f64::is_finite,
};
pub(crate) const NOT_NEGATIVE: AllowedValues = AllowedValues {
    words: "finite numbers from 0",
    rule: |value| value.is_finite() && value >= 0.0,
};
pub(crate) const POISSON: AllowedValues = AllowedValues {
    words: "above -1, at most 0.5",
    rule: |value| value > -1.0 && value <= 0.5,
};
pub(crate) const FRACTION: AllowedValues = AllowedValues {
    words: "above 0, at most 1",
    rule: |value| value > 0.0 && value <= 1.0,
};

/// An assumed number that can be changed.
pub(crate) struct Number<'a> {
    pub(crate) name: String,
    pub(crate) allowed: AllowedValues,
    pub(crate) value: &'a mut f64,
}
