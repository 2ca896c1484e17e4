//! The published statistics in columns of text.

use crate::clustered::Clustered;
use crate::published::{Statistic, Statistics};

impl Statistics {
    /// Returns the statistics beside the published values, in columns.
    pub fn to_text(&self) -> String {
        let mut lines = vec![["statistic", "published", "paper", "dynamic"].map(str::to_owned)];
        for row in &self.rows {
            lines.push([
                row.meaning.to_owned(),
                row.published.to_owned(),
                row.paper.main.to_text(),
                row.dynamic.main.to_text(),
            ]);
            for (paper, dynamic) in row.paper.also.iter().zip(&row.dynamic.also) {
                lines.push([
                    format!("  over {}", paper.over.name()),
                    String::new(),
                    paper.to_text(),
                    dynamic.to_text(),
                ]);
            }
        }
        let widths: [usize; 4] = std::array::from_fn(|column| {
            let cells = lines.iter().map(|line| line[column].chars().count());
            cells.max().unwrap_or(0)
        });
        let mut text = String::new();
        for line in &lines {
            let cells = line
                .iter()
                .zip(widths)
                .map(|(cell, width)| format!("{cell:width$}"));
            text.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
            text.push('\n');
        }
        text
    }
}

impl Statistic {
    fn to_text(self) -> String {
        // Metres need an exponent, what rounding leaves of a zero does not.
        let number = |value: f64| match value.abs() {
            size if size < 1e-12 => "0.00".to_owned(),
            size if size < 1e-3 => format!("{value:.2e}"),
            _ => format!("{value:.2}"),
        };
        let p_value = |p: f64| {
            if p < 1e-3 {
                "p<0.001".to_owned()
            } else {
                format!("p={p:.3}")
            }
        };
        let people = match self.clustered {
            None => String::new(),
            Some(Clustered { p: None, people }) => {
                format!(", clustered: too few people ({people})")
            }
            Some(Clustered { p: Some(p), people }) => {
                format!(", clustered {} of {people} people", p_value(p))
            }
        };
        let n = format!("n={} {}", self.n, self.over.name());
        match (self.value, self.std, self.p) {
            (None, ..) => format!("- ({n})"),
            (Some(value), Some(std), _) => format!("{} ± {} ({n})", number(value), number(std)),
            (Some(value), None, Some(p)) => {
                format!("{} ({}, {n}{people})", number(value), p_value(p))
            }
            (Some(value), None, None) => format!("{} ({n})", number(value)),
        }
    }
}
