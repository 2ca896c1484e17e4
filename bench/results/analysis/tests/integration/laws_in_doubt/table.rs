//! Table of a method's outcomes and errors for each cause.

use std::fmt;

use analysis::method::Method;
use statistics::quantile;

use crate::verdict::{Coverage, Outcome, Quantity, Verdict, median};

/// Verdicts of one method on the worlds of one cause.
pub struct Row<'a> {
    cause: &'static str,
    method: Method,
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

/// Least share of intervals within the laws that cover the truth where the laws are as published.
const LEAST_COVERAGE: f64 = 0.92;
/// Largest share of worlds of the published laws with a sign of misfit.
const MOST_FLAGGED: f64 = 0.05;

impl<'a> Row<'a> {
    /// Gathers the verdicts of a method on a cause's worlds.
    pub fn new(cause: &'static str, method: Method, verdicts: Vec<&'a Verdict>) -> Self {
        Self {
            cause,
            method,
            verdicts,
        }
    }

    /// Cause of the worlds.
    pub fn cause(&self) -> &'static str {
        self.cause
    }

    /// Method of the estimates.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Returns the worlds in which the estimate is wrong in silence.
    pub fn wrong_in_silence(&self) -> impl Iterator<Item = &'a Verdict> {
        let verdicts = self.verdicts.iter().copied();
        verdicts.filter(|verdict| matches!(verdict.outcome, Outcome::WrongInSilence(_)))
    }

    /// Returns the worlds without a flag in which a quantity has an error beyond its limit.
    pub fn wrong_in(&self, quantity: Quantity) -> impl Iterator<Item = &Verdict> {
        self.unflagged()
            .filter(move |verdict| !verdict.is_right_in(quantity))
    }

    /// Asserts that intervals within the laws cover the truth, and that few worlds are flagged, as it must be where the laws are as
    /// published.
    pub fn assert_within_laws(&self) {
        for (name, quantity) in QUANTITIES {
            let share = self.coverage(quantity, |coverage| coverage.within_laws);
            let is_covered = share >= LEAST_COVERAGE || quantity == Quantity::RmsMu;
            assert!(is_covered, "{name}: {share} in the intervals within laws");
        }
        let flagged = self.count(|outcome| matches!(outcome, Outcome::Flagged(_))) as f64;
        let share = flagged / self.verdicts.len() as f64;
        assert!(share <= MOST_FLAGGED, "{share} flagged");
    }

    fn count(&self, is: IsOutcome) -> usize {
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

    /// Returns the median width of the stated intervals of unflagged worlds over that within the laws; NaN without any.
    fn widening(&self, quantity: Quantity) -> f64 {
        let comparisons = self.unflagged().flat_map(|verdict| &verdict.comparisons);
        let coverages = comparisons
            .filter(|comparison| comparison.quantity == quantity)
            .flat_map(|comparison| &comparison.coverage);
        median(coverages.filter_map(|coverage| coverage.widening))
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
                    "median width of interval95 over interval95_within_laws",
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
            self.method.name().to_owned(),
            self.verdicts.len().to_string(),
        ];
        columns.extend(OUTCOMES.map(|(_, is)| self.count(is).to_string()));
        for ((_, quantity), coverages) in QUANTITIES.iter().zip(self.coverages()) {
            let mut values = [self.errors(*quantity), coverages].concat();
            values.push(self.widening(*quantity));
            columns.extend(values.iter().map(|value| format!("{value:.4}")));
        }
        columns.join("\t")
    }
}

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:26} {:8}", self.cause, self.method.name())?;
        for (name, is) in OUTCOMES {
            write!(f, " {} {name},", self.count(is))?;
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
