//! Checks in words, for a terminal and the report.

use super::{Comparison, Condition, Difference, LawCheck, Setting};

/// Symbol and unit of each quantity, in order.
const SYMBOLS: [(&str, Unit); 5] = [
    ("σ_t", Unit::Percent),
    ("S", Unit::Percent),
    ("τ", Unit::Percent),
    (
        "Re Z_t",
        Unit::Plain {
            factor: 1.0,
            name: "N·s/m",
        },
    ),
    (
        "Im Z_t/ω",
        Unit::Plain {
            factor: 1e6,
            name: "mg",
        },
    ),
];

/// Unit of a printed difference.
#[derive(Debug, Clone, Copy)]
enum Unit {
    /// Percentage, of a difference of logarithms.
    Percent,
    /// Unit with a factor from that of the difference.
    Plain { factor: f64, name: &'static str },
}

impl Unit {
    /// Returns a difference with its standard error in this unit, the latter with two digits.
    fn text(self, value: f64, std: f64) -> String {
        let (value, std, name) = match self {
            Self::Percent => (100.0 * value.exp_m1(), 100.0 * value.exp() * std, "%"),
            Self::Plain { factor, name } => (factor * value, factor * std, name),
        };
        let decimals = (1.0 - std.log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:+.decimals$} ± {std:.decimals$} {name}").replace('-', "−")
    }
}

impl LawCheck {
    /// Returns a heading, and a line for each comparison.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "law check of {}, {} trials under {} conditions{}: {}",
            self.participant,
            self.n_trials,
            self.conditions.len(),
            match self.n_left_out {
                0 => String::new(),
                n => format!(", {n} left out"),
            },
            self.verdict()
        )];
        lines.extend(self.comparisons.iter().map(|comparison| {
            let words: Vec<String> = comparison
                .words()
                .into_iter()
                .map(|(symbol, words)| format!("{symbol} {words}"))
                .collect();
            format!("  {}: {}", comparison.title(), words.join(", "))
        }));
        lines
    }

    /// Returns the result of all comparisons in a sentence without its stop.
    #[must_use]
    pub fn verdict(&self) -> String {
        let comparisons = self.comparisons.iter();
        let differences = comparisons.flat_map(|comparison| comparison.differences.as_array());
        let differences: Vec<&Difference> = differences.flatten().collect();
        let n_different = differences
            .iter()
            .filter(|difference| !difference.agrees)
            .count();
        match (differences.len(), n_different) {
            (0, _) if self.comparisons.is_empty() => {
                "not compared, because the conditions differ in several settings at once".to_owned()
            }
            (0, _) => "not compared, because each condition needs two trials".to_owned(),
            (_, 0) => "the estimates agree".to_owned(),
            (n, different) => format!("{different} of {n} differences exceed their errors"),
        }
    }
}

impl Comparison {
    /// Returns the two values of the setting, `drive 12.0 and 24.0 V`.
    #[must_use]
    pub fn title(&self) -> String {
        let (lower, upper) = (self.lower, self.upper);
        match self.setting {
            Setting::DriveV => format!("drive {lower:.1} and {upper:.1} V"),
            Setting::ModulationHz => format!("modulation {lower:.1} and {upper:.1} Hz"),
            Setting::CarrierHz => format!("carrier {lower:.0} and {upper:.0} Hz"),
        }
    }

    /// Returns symbol and result of each quantity: `agrees (+0.4 ± 0.8 %)`, or `differs by +12.0 ± 1.5 % (p = 0.003)`.
    #[must_use]
    pub fn words(&self) -> [(&'static str, String); 5] {
        let differences = self.differences.as_array();
        std::array::from_fn(|quantity| {
            let (symbol, unit) = SYMBOLS[quantity];
            let words = differences[quantity].map(|difference| difference.words(unit));
            let words = words.unwrap_or_else(|| "not compared: too few trials".to_owned());
            (symbol, words)
        })
    }
}

impl Difference {
    fn words(&self, unit: Unit) -> String {
        let size = unit.text(self.value, self.std);
        match (self.agrees, self.p_adjusted) {
            (true, _) => format!("agrees ({size})"),
            (false, p) if p < 1e-3 => format!("differs by {size} (p < 0.001)"),
            (false, p) => format!("differs by {size} (p = {p:.3})"),
        }
    }
}

impl Condition {
    /// Returns the settings, `12.0 V, 3.0 Hz, carrier 35000 Hz`.
    #[must_use]
    pub fn words(&self) -> String {
        format!(
            "{:.1} V, {:.1} Hz, carrier {:.0} Hz",
            self.drive_v, self.modulation_hz, self.carrier_hz
        )
    }
}
