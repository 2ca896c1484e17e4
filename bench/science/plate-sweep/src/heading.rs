//! Headings of a sweep's columns.

use crate::sweep_unit::SweepUnit;
use crate::swept_quantity::SweptQuantity::{self, Admittance, Displacement, Impedance, Velocity};

/// Part of a complex response, or its frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColumnRole {
    Frequency,
    Real,
    Imaginary,
    Magnitude,
    Phase,
}

/// Heading of a column: its name and its unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Heading {
    /// The whole text.
    pub(crate) text: String,
    /// Name without the unit.
    pub(crate) name: String,
    pub(crate) unit: Option<SweepUnit>,
}

/// Names of columns, in lower case without signs, with their role and quantity.
const NAMES: &[(&[&str], ColumnRole, Option<SweptQuantity>)] = &[
    (
        &[
            "f",
            "freq",
            "frequency",
            "frequencies",
            "frequenz",
            "fréquence",
            "frequence",
            "hz",
            "sweepfrequency",
            "freqhz",
            "frq",
        ],
        ColumnRole::Frequency,
        None,
    ),
    (
        &[
            "g",
            "gp",
            "gm",
            "conductance",
            "rey",
            "realy",
            "yre",
            "yreal",
            "realadmittance",
            "admittancereal",
            "leitwert",
        ],
        ColumnRole::Real,
        Some(Admittance),
    ),
    (
        &[
            "b",
            "bp",
            "bm",
            "susceptance",
            "imy",
            "imagy",
            "yim",
            "yimag",
            "imaginaryadmittance",
            "admittanceimag",
            "admittanceimaginary",
        ],
        ColumnRole::Imaginary,
        Some(Admittance),
    ),
    (
        &[
            "r",
            "rs",
            "resistance",
            "rez",
            "realz",
            "zre",
            "zreal",
            "z′",
            "impedancereal",
            "realimpedance",
        ],
        ColumnRole::Real,
        Some(Impedance),
    ),
    (
        &[
            "x",
            "xs",
            "reactance",
            "imz",
            "imagz",
            "zim",
            "zimag",
            "z″",
            "impedanceimag",
            "impedanceimaginary",
            "imaginaryimpedance",
        ],
        ColumnRole::Imaginary,
        Some(Impedance),
    ),
    (
        &["re", "real", "realpart", "realteil", "inphase"],
        ColumnRole::Real,
        None,
    ),
    (
        &[
            "im",
            "imag",
            "imaginary",
            "imaginarypart",
            "imaginärteil",
            "quadrature",
        ],
        ColumnRole::Imaginary,
        None,
    ),
    (
        &[
            "rex",
            "realx",
            "xre",
            "xreal",
            "displacementre",
            "displacementreal",
            "redisplacement",
            "realdisplacement",
        ],
        ColumnRole::Real,
        Some(Displacement),
    ),
    (
        &[
            "imx",
            "imagx",
            "xim",
            "ximag",
            "displacementim",
            "displacementimag",
            "imdisplacement",
            "imagdisplacement",
        ],
        ColumnRole::Imaginary,
        Some(Displacement),
    ),
    (
        &[
            "rev",
            "realv",
            "vre",
            "vreal",
            "velocityre",
            "velocityreal",
            "revelocity",
            "realvelocity",
        ],
        ColumnRole::Real,
        Some(Velocity),
    ),
    (
        &[
            "imv",
            "imagv",
            "vim",
            "vimag",
            "velocityim",
            "velocityimag",
            "imvelocity",
            "imagvelocity",
        ],
        ColumnRole::Imaginary,
        Some(Velocity),
    ),
    (
        &[
            "mag",
            "magnitude",
            "abs",
            "amplitude",
            "modulus",
            "gain",
            "level",
            "betrag",
            "response",
        ],
        ColumnRole::Magnitude,
        None,
    ),
    (
        &[
            "y",
            "admittance",
            "absy",
            "ymag",
            "magy",
            "yabs",
            "admittancemagnitude",
            "magnitudeofadmittance",
        ],
        ColumnRole::Magnitude,
        Some(Admittance),
    ),
    (
        &[
            "z",
            "impedance",
            "absz",
            "zmag",
            "magz",
            "zabs",
            "impedancemagnitude",
            "magnitudeofimpedance",
            "impedanz",
        ],
        ColumnRole::Magnitude,
        Some(Impedance),
    ),
    (
        &[
            "displacement",
            "absx",
            "xmag",
            "xabs",
            "displacementmagnitude",
            "displacementamplitude",
            "xpervolt",
            "displacementpervolt",
        ],
        ColumnRole::Magnitude,
        Some(Displacement),
    ),
    (
        &[
            "velocity",
            "v",
            "absv",
            "vmag",
            "vabs",
            "velocitymagnitude",
            "velocityamplitude",
            "velocitypervolt",
        ],
        ColumnRole::Magnitude,
        Some(Velocity),
    ),
    (
        &[
            "phase",
            "theta",
            "θ",
            "phi",
            "φ",
            "ϕ",
            "arg",
            "angle",
            "phaseangle",
            "deg",
            "degrees",
            "rad",
            "ph",
            "phasez",
            "phasey",
            "thetaz",
            "thetay",
            "θz",
            "θy",
            "argz",
            "argy",
            "zphase",
            "yphase",
            "ztheta",
            "ytheta",
            "phaseofimpedance",
            "phaseofadmittance",
            "impedancephase",
            "admittancephase",
            "displacementphase",
            "velocityphase",
            "xphase",
            "vphase",
        ],
        ColumnRole::Phase,
        None,
    ),
];

impl Heading {
    /// Reads a heading, as in `f (Hz)`, `Frequency [kHz]`, `G / mS`, `freq_khz`, `Theta, deg` or `Phase in °`.
    pub(crate) fn parse(text: &str) -> Self {
        let text = text.trim();
        let (name, unit) = split(text).map_or((text, None), |(name, unit)| (name, Some(unit)));
        Self {
            text: text.to_owned(),
            name: name
                .trim_end_matches(['/', ',', '_', ' ', '-'])
                .trim()
                .to_owned(),
            unit,
        }
    }

    /// Returns the role, by the unit or by the name.
    pub(crate) fn role(&self) -> Option<ColumnRole> {
        match self.unit {
            Some(SweepUnit::Frequency(_)) => return Some(ColumnRole::Frequency),
            Some(SweepUnit::Angle(_)) => return Some(ColumnRole::Phase),
            Some(SweepUnit::Decibels(_)) => return Some(ColumnRole::Magnitude),
            Some(SweepUnit::Response(..)) | None => {}
        }
        self.known().map(|(role, _)| role)
    }

    /// Returns the quantity, by the unit or by the name.
    pub(crate) fn quantity(&self) -> Option<SweptQuantity> {
        match self.unit {
            Some(SweepUnit::Response(quantity, _) | SweepUnit::Decibels(Some((quantity, _)))) => {
                Some(quantity)
            }
            _ => self.known().and_then(|(_, quantity)| quantity),
        }
    }

    fn known(&self) -> Option<(ColumnRole, Option<SweptQuantity>)> {
        let name = key(&self.name);
        let mut rows = NAMES.iter();
        let row = rows.find(|(names, _, _)| names.contains(&name.as_str()))?;
        Some((row.1, row.2))
    }
}

/// Returns a name in lower case without signs, by which names are compared.
pub(crate) fn key(name: &str) -> String {
    let name = name.replace("''", "″").replace('\'', "′").to_lowercase();
    let is_kept = |c: &char| c.is_alphanumeric() || matches!(c, '′' | '″');
    name.chars().filter(is_kept).collect()
}

/// Splits a heading into its name and its unit; `None` if it states no unit.
fn split(text: &str) -> Option<(&str, SweepUnit)> {
    // `G (S)` is no gigasiemens.
    let is_one_word = !text.contains(|c: char| c.is_whitespace() || matches!(c, '(' | '['));
    if let Some(unit) = SweepUnit::parse(text).filter(|_| is_one_word) {
        return Some((text, unit));
    }
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        let inner = text.strip_suffix(close);
        // The outermost pair, as in `v ((mm/s)/V)`, and then the innermost one, as in `Re(Y) (S)`.
        let outer = inner.and_then(|inner| inner.split_once(open));
        let last = inner.and_then(|inner| inner.rsplit_once(open));
        for (name, unit) in [outer, last].into_iter().flatten() {
            if let Some(unit) = SweepUnit::parse(unit) {
                return Some((name, unit));
            }
        }
    }
    let tails = [
        text.rsplit_once(" in "),
        text.rsplit_once(','),
        text.split_once('/'),
        text.rsplit_once(' '),
        text.rsplit_once('_'),
        text.rsplit_once('-'),
    ];
    let mut split = tails.into_iter().flatten();
    split.find_map(|(name, unit)| Some((name, SweepUnit::parse(unit)?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_name_role_and_quantity() {
        use ColumnRole::{Frequency, Imaginary, Magnitude, Phase, Real};
        for (text, name, role, quantity) in [
            ("f (Hz)", "f", Frequency, None),
            ("Frequency [kHz]", "Frequency", Frequency, None),
            ("freq_khz", "freq", Frequency, None),
            ("f/MHz", "f", Frequency, None),
            ("Hz", "Hz", Frequency, None),
            ("G (S)", "G", Real, Some(Admittance)),
            ("B, mS", "B", Imaginary, Some(Admittance)),
            ("Re(Y) (S)", "Re(Y)", Real, Some(Admittance)),
            ("Im{Z}", "Im{Z}", Imaginary, Some(Impedance)),
            ("Z''", "Z''", Imaginary, Some(Impedance)),
            ("|Z| in kOhm", "|Z|", Magnitude, Some(Impedance)),
            ("Impedance (Ω)", "Impedance", Magnitude, Some(Impedance)),
            ("Theta-deg", "Theta", Phase, None),
            ("phase (°)", "phase", Phase, None),
            ("Mag [dB re 1 m/V]", "Mag", Magnitude, Some(Displacement)),
            ("real (nm/V)", "real", Real, Some(Displacement)),
            ("imag ((mm/s)/V)", "imag", Imaginary, Some(Velocity)),
        ] {
            let heading = Heading::parse(text);
            assert_eq!(heading.name, name, "{text}");
            assert_eq!(heading.role(), Some(role), "{text}");
            assert_eq!(heading.quantity(), quantity, "{text}");
        }
        for text in ["time", "marker", "1", "", "Q"] {
            assert_eq!(Heading::parse(text).role(), None, "{text}");
        }
    }
}
