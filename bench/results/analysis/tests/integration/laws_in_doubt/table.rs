//! Table of a method's outcomes and errors for each cause.

use std::fmt;

use statistics::quantile;

use crate::verdict::{Coverage, Outcome, Quantity, Verdict};

/// Verdicts of one method on the worlds of one cause.
pub struct Row<'a> {
    cause: &'static str,
    method: &'static str,
    verdicts: Vec<&'a Verdict>,
}

type IsOutcome = fn(&Outcome) -> bool;

/// Kinds of outcome, with the names of their columns.
const OUTCOMES: [(&str, IsOutcome); 5] = [
    ("right", |outcome| *outcome == Outcome::Right),
    ("covered", |outcome| *outcome == Outcome::Covered),
    ("flagged", |outcome| matches!(outcome, Outcome::Flagged(_))),
    ("refused", |outcome| *outcome == Outcome::Refused),
    ("silent", |outcome| {
        matches!(outcome, Outcome::WrongInSilence(_))
    }),
];
/// Quantities, with the names of their columns.
const QUANTITIES: [(&str, Quantity); 5] = [
    ("sigma_t", Quantity::SigmaT),
    ("Z_t", Quantity::ZT),
    ("S", Quantity::Area),
    ("mu0", Quantity::Mu0),
    ("RMS of mu", Quantity::RmsMu),
];

impl<'a> Row<'a> {
    /// Gathers the verdicts of a method on a cause's worlds.
    pub fn new(cause: &'static str, method: &'static str, verdicts: Vec<&'a Verdict>) -> Self {
        Self {
            cause,
            method,
            verdicts,
        }
    }

    /// Number of verdicts of the outcome `name`.
    pub fn count(&self, name: &str) -> usize {
        let is = OUTCOMES.iter().find(|outcome| outcome.0 == name);
        let is = is.map_or_else(
            || panic!("no outcome is called {name}"),
            |outcome| outcome.1,
        );
        self.verdicts.iter().filter(|v| is(&v.outcome)).count()
    }

    /// Verdicts without a flag, in which the stated values and intervals count.
    fn unflagged(&self) -> impl Iterator<Item = &Verdict> {
        let verdicts = self.verdicts.iter().copied();
        verdicts.filter(|verdict| !matches!(verdict.outcome, Outcome::Flagged(_)))
    }

    /// Returns the median and the 90 % quantile of |error| over the unflagged worlds.
    pub fn errors(&self, quantity: Quantity) -> [f64; 2] {
        let errors = self
            .unflagged()
            .filter_map(|verdict| verdict.error(quantity));
        let mut errors: Vec<f64> = errors.map(f64::abs).collect();
        errors.sort_by(f64::total_cmp);
        [0.5, 0.9].map(|share| quantile(&errors, share).unwrap_or(f64::NAN))
    }

    /// Returns the share of intervals of unflagged worlds that include the truth; NaN without any.
    pub fn coverage(
        &self,
        quantity: Quantity,
        is_covered: impl Fn(&Coverage) -> Option<bool>,
    ) -> f64 {
        let covered: Vec<bool> = self
            .unflagged()
            .flat_map(|verdict| &verdict.comparisons)
            .filter(|comparison| comparison.quantity == quantity)
            .flat_map(|comparison| &comparison.coverage)
            .filter_map(is_covered)
            .collect();
        covered.iter().filter(|is| **is).count() as f64 / covered.len() as f64
    }

    fn coverages(&self) -> [[f64; 2]; QUANTITIES.len()] {
        QUANTITIES.map(|(_, quantity)| {
            [
                self.coverage(quantity, |coverage| Some(coverage.total)),
                self.coverage(quantity, |coverage| coverage.within_laws),
            ]
        })
    }

    /// Returns the names of the columns of [`tsv`](Self::tsv).
    pub fn tsv_header() -> String {
        let mut columns = vec!["cause".to_owned(), "method".to_owned(), "worlds".to_owned()];
        columns.extend(OUTCOMES.map(|(name, _)| name.to_owned()));
        for (name, _) in QUANTITIES {
            columns.extend(
                [
                    "median error",
                    "90 % error",
                    "share in interval95",
                    "share in interval95_within_laws",
                ]
                .map(|column| format!("{name}: {column}")),
            );
        }
        columns.join("\t")
    }

    /// Returns the row with tabs between its columns.
    pub fn tsv(&self) -> String {
        let mut columns = vec![
            self.cause.to_owned(),
            self.method.to_owned(),
            self.verdicts.len().to_string(),
        ];
        columns.extend(OUTCOMES.map(|(name, _)| self.count(name).to_string()));
        for ((_, quantity), coverages) in QUANTITIES.iter().zip(self.coverages()) {
            let values = [self.errors(*quantity), coverages].concat();
            columns.extend(values.iter().map(|value| format!("{value:.4}")));
        }
        columns.join("\t")
    }
}

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:26} {:8}", self.cause, self.method)?;
        for (name, _) in OUTCOMES {
            write!(f, " {} {name},", self.count(name))?;
        }
        for ((name, quantity), [total, within_laws]) in QUANTITIES.iter().zip(self.coverages()) {
            let [median, most] = self.errors(*quantity);
            write!(f, " {name} {median:.4} {most:.4} ({:.0} %", 100.0 * total)?;
            if within_laws.is_finite() {
                write!(f, ", {:.0} % within", 100.0 * within_laws)?;
            }
            write!(f, ")")?;
        }
        Ok(())
    }
}
