//! Groups as lines of a terminal, and their legend.

use analysis::method::Method;
use published_statistics::{plain_table, wrapped};

use crate::description::Description;
use crate::groups::{Group, Level, Unit};
use crate::mean::Mean;
use crate::quantity::Quantity;
use crate::strokes::{StrokeGroup, StrokeQuantity};

/// Text for an unknown value.
const UNKNOWN: &str = "–";
/// Number of columns from which each mean has its interval next to it.
const WIDE: u16 = 120;

impl Description {
    /// Returns the groups as tables, wrapped to the width of the terminal if it is given, each with its legend: those of instances, then
    /// those of explorations without one. Empty without both.
    #[must_use]
    pub fn to_text(&self, columns: Option<u16>) -> String {
        self.instances_text(columns) + &self.strokes_text(columns)
    }

    fn instances_text(&self, columns: Option<u16>) -> String {
        if self.groups.iter().all(|group| group.n_instances == 0) {
            return String::new();
        }
        let is_narrow = columns.is_some_and(|columns| columns < WIDE);
        let headings = Quantity::ALL.map(Quantity::heading);
        let rows = self.groups.iter().map(|group| match is_narrow {
            true => row(group.label(), group.short_cells(), group.n().to_string()),
            false => row(group.label(), group.cells(), group.over_text()),
        });
        let title = "mean (95 % interval)";
        table_text((title, &headings), rows, columns) + &wrapped(self.legend(), columns)
    }

    fn strokes_text(&self, columns: Option<u16>) -> String {
        if self.strokes.is_empty() {
            return String::new();
        }
        let is_narrow = columns.is_some_and(|columns| columns < WIDE);
        let headings = StrokeQuantity::ALL.map(StrokeQuantity::heading);
        let rows = self.strokes.iter().map(|group| match is_narrow {
            true => row(
                group.label(),
                group.short_stroke_cells(),
                group.n().to_string(),
            ),
            false => row(group.label(), group.stroke_cells(), group.over_text()),
        });
        let title = match is_narrow {
            true => "explorations: mean",
            false => "explorations: mean (95 % interval)",
        };
        table_text((title, &headings), rows, columns) + &wrapped(Self::strokes_legend(), columns)
    }

    /// Returns the meaning of the columns of explorations, in lines.
    #[must_use]
    pub fn strokes_legend() -> Vec<String> {
        vec![
            "of recordings without an instance. μ: mean of |lateral|/normal where the finger presses; contrast: share by which μ at the \
             greatest stimulus is below that at the least one"
                .to_owned(),
            "interval: 95 % by Student's t over a trial's explorations, a participant's trials, or the participants; one alone has none"
                .to_owned(),
        ]
    }

    /// Returns the meaning of the table's columns and intervals, in lines.
    #[must_use]
    pub fn legend(&self) -> Vec<String> {
        let gap = match self.gap_method {
            Method::Trial => "by trial, where its fit can be used and its model holds",
            method => {
                debug_assert_eq!(method, Method::Dynamic);
                "by dynamic"
            }
        };
        vec![
            "at rest, at crest: measured friction in the first and last 5 ms of an instance, where the amplitude is least and \
             greatest; fall: their difference relative to rest"
                .to_owned(),
            format!(
                "gap (estimated {gap}) and amplitude (peak, under the finger) at the crest; force: mean of the instance"
            ),
            "interval: 95 % by Student's t over a trial's instances, a participant's trials, or the participants; one alone has none"
                .to_owned(),
        ]
    }
}

fn row(name: String, cells: impl IntoIterator<Item = String>, over: String) -> Vec<String> {
    std::iter::once(name).chain(cells).chain([over]).collect()
}

fn table_text(
    (title, headings): (&str, &[&str]),
    rows: impl Iterator<Item = Vec<String>>,
    columns: Option<u16>,
) -> String {
    let mut table = plain_table(columns);
    let is_narrow = columns.is_some_and(|columns| columns < WIDE);
    let over = if is_narrow { "n" } else { "over" };
    let headings = headings.iter().map(|heading| (*heading).to_owned());
    table.set_header(row(title.to_owned(), headings, over.to_owned()));
    for row in rows {
        table.add_row(row);
    }
    let lines = table.lines().map(|line| line.trim_end().to_owned() + "\n");
    lines.collect()
}

impl<const N: usize> Group<N> {
    /// Returns the group's name, indented under its participant.
    #[must_use]
    pub fn label(&self) -> String {
        let condition = || match self.condition.as_deref() {
            None | Some("") => "condition not stated".to_owned(),
            Some(condition) => format!("condition {condition}"),
        };
        match self.level {
            Level::Study => "all".to_owned(),
            Level::Condition => condition(),
            Level::Participant => self.participant.clone().unwrap_or_default(),
            // The table would remove plain blanks.
            Level::ParticipantInCondition => format!("\u{a0}\u{a0}{}", condition()),
            Level::Trial => {
                let name = self.trial.as_ref().map(|key| key.name());
                format!("\u{a0}\u{a0}{}", name.unwrap_or_default())
            }
        }
    }

    /// Returns the number of units in words, with the number of instances where the units are others.
    #[must_use]
    pub fn over_text(&self) -> String {
        let units = self.over.count(self.n());
        match self.over {
            Unit::Instances | Unit::Explorations => units,
            Unit::Trials | Unit::Participants => {
                format!("{units}, {}", self.of.count(self.n_instances))
            }
        }
    }
}

impl StrokeGroup {
    /// Returns the means with their intervals, in the units of [`StrokeQuantity::heading`].
    #[must_use]
    pub fn stroke_cells(&self) -> [String; StrokeQuantity::ALL.len()] {
        let mut means = self.means.iter();
        StrokeQuantity::ALL.map(|quantity| {
            let mean = means.next();
            mean.map_or_else(String::new, |mean| cell(mean, quantity.format()))
        })
    }
}

impl StrokeGroup {
    /// Returns the means, with the interval of the friction alone.
    fn short_stroke_cells(&self) -> [String; StrokeQuantity::ALL.len()] {
        let mut short = self.clone();
        short
            .means
            .iter_mut()
            .skip(1)
            .for_each(|mean| mean.interval95 = None);
        short.stroke_cells()
    }
}

impl Group {
    /// Returns the means with their intervals, in the units of [`Quantity::heading`].
    #[must_use]
    pub fn cells(&self) -> [String; Quantity::ALL.len()] {
        Quantity::ALL.map(|quantity| quantity.cell(self.mean(quantity)))
    }
}

impl Group {
    /// Returns the means, with the interval of the fall alone.
    fn short_cells(&self) -> [String; Quantity::ALL.len()] {
        Quantity::ALL.map(|quantity| {
            let mean = *self.mean(quantity);
            let interval95 = mean.interval95.filter(|_| quantity == Quantity::Fall);
            quantity.cell(&Mean { interval95, ..mean })
        })
    }
}

impl Quantity {
    /// Returns a mean with its interval, such as `92.9 (89.7 to 96.1)`.
    #[must_use]
    pub fn cell(self, mean: &Mean) -> String {
        cell(mean, (self.factor(), self.decimals()))
    }
}

/// Returns a mean with its interval in a unit with a number of decimals.
fn cell(mean: &Mean, (factor, decimals): (f64, usize)) -> String {
    let number = |value: f64| format!("{:.decimals$}", value * factor).replace('-', "−");
    match (mean.value.is_finite(), mean.interval95) {
        (false, _) => UNKNOWN.to_owned(),
        (true, None) => number(mean.value),
        (true, Some([low, high])) => {
            format!(
                "{} ({} to {})",
                number(mean.value),
                number(low),
                number(high)
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_in_the_units_of_people_and_a_single_value_has_no_interval() {
        let mean = Mean {
            value: 0.929,
            interval95: Some([0.897, 0.961]),
            n: 5,
        };
        assert_eq!(Quantity::Fall.cell(&mean), "92.9 (89.7 to 96.1)");
        let alone = Mean {
            value: 3.214e-6,
            interval95: None,
            n: 1,
        };
        assert_eq!(Quantity::Gap.cell(&alone), "3.21");
        assert_eq!(Quantity::Gap.cell(&Mean::new([])), "–");
    }
}
