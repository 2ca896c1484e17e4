//! Statistics as a table for a terminal, a spreadsheet, a page or a manuscript.

use comfy_table::presets::NOTHING;
use comfy_table::{ContentArrangement, Table};
use statistics::with_error;

use crate::cluster_test::Clustered;
use crate::statistic::{Level, MethodStatistic, Statistic};
use crate::table::{StatisticRow, Statistics};
use analysis::estimate::Method;

/// Form of the table of statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableFormat {
    /// Text in columns, wrapped to the width of the terminal if it is given.
    Text {
        /// Width of the terminal, columns.
        columns: Option<u16>,
    },
    /// One row for each statistic, method and level, with every number in a separate column.
    Csv,
    /// Markdown.
    Markdown,
    /// LaTeX, for `booktabs`.
    Latex,
}

const HEADER: [&str; COLUMNS] = ["statistic", "published", "paper", "dynamic", "trial"];
const COLUMNS: usize = 5;
/// End of the meaning of a length.
const LENGTH: &str = ", m";
/// Fewest pairs of a correlation or slope.
pub const FEWEST: usize = 3;
/// Meaning of the numbers of the table on a terminal.
const LEGEND: [&str; 2] = [
    "a ± b: mean and standard deviation of the n values, not an interval of the mean; of a slope, b is its standard error",
    "p: pairs taken as independent; clustered p: participants taken as the unit",
];

impl Statistics {
    /// Returns the table of the statistics with the published values.
    pub fn to_table(&self, format: TableFormat) -> String {
        match format {
            TableFormat::Text { columns } => self.to_text(columns),
            TableFormat::Csv => self.to_csv(),
            TableFormat::Markdown => self.to_markdown(),
            TableFormat::Latex => self.to_latex(),
        }
    }

    /// Returns the lines of the table, with further levels after the published one.
    fn lines(&self) -> Vec<[String; COLUMNS]> {
        let mut lines = Vec::new();
        for row in &self.rows {
            let (meaning, published) = row.in_practical_units();
            let text = |statistic: &Statistic| row.printed(statistic).to_text();
            lines.push([
                meaning,
                published,
                text(&row.paper.main),
                text(&row.dynamic.main),
                text(&row.trial.main),
            ]);
            let others = row.dynamic.also.iter().zip(&row.trial.also);
            for (paper, (dynamic, trial)) in row.paper.also.iter().zip(others) {
                lines.push([
                    format!("  over {}", paper.over.name()),
                    String::new(),
                    text(paper),
                    text(dynamic),
                    text(trial),
                ]);
            }
        }
        lines
    }

    fn to_text(&self, columns: Option<u16>) -> String {
        let mut table = Table::new();
        table
            .load_style(NOTHING)
            .set_content_arrangement(ContentArrangement::Dynamic);
        if let Some(columns) = columns {
            table.set_width(columns);
        }
        table.set_header(HEADER);
        for line in self.lines() {
            // The indentation marks lines that belong to the row above; the table would remove it.
            table.add_row(line.map(|cell| greek(&cell).replacen("  ", "\u{a0}\u{a0}", 1)));
        }
        let lines = table.lines().map(|line| line.trim_end().to_owned() + "\n");
        lines.collect::<String>() + &wrapped(LEGEND, columns)
    }

    fn to_csv(&self) -> String {
        let mut rows = csv::Writer::from_writer(Vec::new());
        let header = "statistic,meaning,published,method,over,value,std,n,p,p_clustered,people";
        // Writing to memory does not fail.
        let _ = rows.write_record(header.split(','));
        for row in &self.rows {
            for method in Method::ALL {
                for statistic in row.statistic(method).statistics() {
                    let _ = rows.write_record(statistic.record(row, method));
                }
            }
        }
        let bytes = rows.into_inner().unwrap_or_default();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    fn to_markdown(&self) -> String {
        let line = |cells: [String; COLUMNS]| {
            let cells = cells.map(|cell| greek(cell.trim()).replace('|', "\\|"));
            format!("| {} |\n", cells.join(" | "))
        };
        let mut text = line(HEADER.map(str::to_owned));
        text.push_str(&line(HEADER.map(|_| "---".to_owned())));
        text.extend(self.lines().into_iter().map(line));
        text
    }

    fn to_latex(&self) -> String {
        let line = |cells: [String; COLUMNS]| {
            let cells = cells.map(|cell| match cell.strip_prefix("  ") {
                Some(indented) => format!("\\quad {}", latex(indented)),
                None => latex(&cell),
            });
            format!("{} \\\\\n", cells.join(" & "))
        };
        let mut text = "\\begin{tabular}{lllll}\n\\toprule\n".to_owned();
        text.push_str(&line(HEADER.map(str::to_owned)));
        text.push_str("\\midrule\n");
        text.extend(self.lines().into_iter().map(line));
        text.push_str("\\bottomrule\n\\end{tabular}\n");
        text
    }
}

impl StatisticRow {
    /// Returns meaning and published value for people: a length is in µm.
    #[must_use]
    pub fn in_practical_units(&self) -> (String, String) {
        let (meaning, published) = (self.meaning, self.published);
        match meaning.strip_suffix(LENGTH) {
            Some(quantity) => {
                let published = published.strip_prefix('(').unwrap_or(published);
                (format!("{quantity}, µm"), published.replace(")e-6", ""))
            }
            None => (meaning.to_owned(), published.to_owned()),
        }
    }

    /// Returns one of its statistics for people: a length in µm, and no slope of two points, which are always on a line.
    #[must_use]
    pub fn printed(&self, statistic: &Statistic) -> Statistic {
        let factor = if self.meaning.ends_with(LENGTH) {
            1e6
        } else {
            1.0
        };
        let is_slope = self.name.starts_with("slope_");
        let value = statistic
            .value
            .filter(|_| !is_slope || statistic.n >= FEWEST);
        Statistic {
            value: value.map(|value| value * factor),
            std: statistic.std.map(|std| std * factor),
            ..*statistic
        }
    }

    /// Returns the statistic by a method.
    pub fn statistic(&self, method: Method) -> &MethodStatistic {
        match method {
            Method::Paper => &self.paper,
            Method::Dynamic => &self.dynamic,
            Method::Trial => &self.trial,
        }
    }
}

impl MethodStatistic {
    /// Returns the statistics at all levels, the published one first.
    pub fn statistics(&self) -> impl Iterator<Item = &Statistic> {
        std::iter::once(&self.main).chain(&self.also)
    }
}

impl Statistic {
    fn record(&self, row: &StatisticRow, method: Method) -> [String; 11] {
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        [
            row.name.to_owned(),
            row.meaning.to_owned(),
            row.published.to_owned(),
            method.name().to_owned(),
            Level::name(self.over).to_owned(),
            number(self.value),
            number(self.std),
            self.n.to_string(),
            number(self.p),
            number(self.clustered.and_then(|test| test.p)),
            self.clustered
                .map_or_else(String::new, |test| test.people.to_string()),
        ]
    }

    fn to_text(self) -> String {
        // Metres need an exponent, but the rounding error of a zero does not.
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
                format!(", too few people ({people})")
            }
            Some(Clustered { p: Some(p), people }) => {
                format!(", clustered {} of {people} people", p_value(p))
            }
        };
        let over = self.over.name();
        let over = over
            .strip_suffix('s')
            .filter(|_| self.n == 1)
            .unwrap_or(over);
        let n = format!("n={} {over}", self.n);
        match (self.value, self.std, self.p) {
            (None, ..) if self.n < FEWEST => format!("too few ({n})"),
            (None, ..) => format!("- ({n})"),
            (Some(value), Some(std), _) => format!("{} ({n})", with_error(value, std, 2)),
            (Some(value), None, Some(p)) => {
                format!("{} ({}, {n}{people})", number(value), p_value(p))
            }
            (Some(value), None, None) => format!("{} ({n})", number(value)),
        }
    }
}

/// Returns an empty table without lines between its cells, at most as wide as the terminal if that is given.
#[must_use]
pub fn plain_table(columns: Option<u16>) -> Table {
    let mut table = Table::new();
    table
        .load_style(NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic);
    if let Some(columns) = columns {
        table.set_width(columns);
    }
    table
}

/// Returns the lines, broken between words where they are wider than the terminal.
pub fn wrapped<T: Into<String>>(
    lines: impl IntoIterator<Item = T>,
    columns: Option<u16>,
) -> String {
    let mut table = plain_table(columns);
    for line in lines {
        table.add_row([line.into()]);
    }
    let lines = table.lines();
    lines.map(|line| line.trim().to_owned() + "\n").collect()
}

/// Words of the table, with the letters that screens and figures show.
const LETTERS: [(&str, &str); 4] = [("sigma_t", "σ_t"), ("mu0", "μ0"), ("mu", "μ"), ("um", "µm")];

/// Returns the text with Greek letters in place of whole words.
#[must_use]
pub fn greek(text: &str) -> String {
    let is_part = |character: char| character.is_alphanumeric() || character == '_';
    let mut output = String::new();
    for piece in text.split_inclusive(|character| !is_part(character)) {
        let word = piece.trim_end_matches(|character| !is_part(character));
        let letter = LETTERS.iter().find(|(plain, _)| *plain == word);
        output += letter.map_or(word, |(_, letter)| letter);
        output += &piece[word.len()..];
    }
    output
}

/// Symbols of the table's words in LaTeX, each before its own prefixes.
const SYMBOLS: [(&str, &str); 21] = [
    ("|Z_m⁰ - Z_p|", r"$|Z_m^0 - Z_p|$"),
    ("|Im Z_m|", r"$|\operatorname{Im} Z_m|$"),
    ("Re Z_m", r"$\operatorname{Re} Z_m$"),
    ("|Z_m|", r"$|Z_m|$"),
    ("|Z_t|", r"$|Z_t|$"),
    ("Re Z_t", r"$\operatorname{Re} Z_t$"),
    ("Im Z_t", r"$\operatorname{Im} Z_t$"),
    ("Z_t", r"$Z_t$"),
    ("1 - k_c/k_c0", r"$1 - k_c/k_c^0$"),
    ("k_c", r"$k_c$"),
    ("sigma_t", r"$\sigma_t$"),
    ("mu0", r"$\mu_0$"),
    ("mu", r"$\mu$"),
    (" um ", r"~\textmu m "),
    (" µm", r"~\textmu m"),
    ("R²", r"$R^2$"),
    ("±", r"$\pm$"),
    ("<", "$<$"),
    ("&", r"\&"),
    ("%", r"\%"),
    ("_", r"\_"),
];

/// Returns the text for LaTeX, with symbols in place of whole words.
fn latex(text: &str) -> String {
    let mut output = String::new();
    let mut rest = text;
    while let Some(character) = rest.chars().next() {
        let is_word_character =
            |neighbour: Option<char>| neighbour.is_some_and(char::is_alphanumeric);
        let entry = SYMBOLS.iter().find(|(plain, _)| {
            let is_word = plain.chars().all(char::is_alphanumeric) && plain.is_ascii();
            let previous = output.chars().next_back();
            rest.strip_prefix(plain).is_some_and(|tail| {
                !is_word || !is_word_character(previous) && !is_word_character(tail.chars().next())
            })
        });
        let (length, symbol) = entry.map_or_else(
            || (character.len_utf8(), character.to_string()),
            |(plain, symbol)| (plain.len(), (*symbol).to_owned()),
        );
        output.push_str(&symbol);
        rest = &rest[length..];
    }
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statistics() -> Statistics {
        let statistic = |value| {
            MethodStatistic::single(Statistic {
                value: Some(value),
                p: Some(0.25),
                clustered: Some(Clustered {
                    p: Some(0.4),
                    people: 7,
                }),
                n: 70,
                ..Statistic::empty(Level::Trials)
            })
        };
        Statistics {
            rows: vec![StatisticRow {
                name: "spearman",
                meaning: "Spearman of |Im Z_m|, mu0 and mu, \"all\"",
                published: "< 0.10",
                paper: statistic(0.5),
                dynamic: statistic(-0.125),
                trial: statistic(0.25),
            }],
        }
    }

    #[test]
    fn each_form_holds_the_published_value_every_method_n_and_both_p_values() {
        let table = |format| statistics().to_table(format);
        let cells = [
            "0.50 (p=0.250, n=70 trials, clustered p=0.400 of 7 people)",
            "-0.12 (p=0.250, n=70 trials, clustered p=0.400 of 7 people)",
            "0.25 (p=0.250, n=70 trials, clustered p=0.400 of 7 people)",
        ];
        let text = table(TableFormat::Text { columns: None });
        assert_eq!(text.lines().count(), 2 + LEGEND.len());
        assert!(text.contains("μ0 and μ, "), "{text}");
        assert!(cells.iter().all(|cell| text.contains(cell)), "{text}");
        assert_eq!(
            table(TableFormat::Markdown),
            format!(
                "| statistic | published | paper | dynamic | trial |\n| --- | --- | --- | --- | --- |\n\
                 | Spearman of \\|Im Z_m\\|, μ0 and μ, \"all\" | < 0.10 | {} | {} | {} |\n",
                cells[0], cells[1], cells[2]
            )
        );
        let latex = table(TableFormat::Latex);
        let row = r#"Spearman of $|\operatorname{Im} Z_m|$, $\mu_0$ and $\mu$, "all" & $<$ 0.10 & 0.50 (p=0.250,"#;
        assert!(latex.contains(row), "{latex}");
        let csv = table(TableFormat::Csv);
        let mut reader = csv::Reader::from_reader(csv.as_bytes());
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(&rows[1][1], "Spearman of |Im Z_m|, mu0 and mu, \"all\"");
        let numbers: Vec<&str> = (3..11).map(|column| &rows[1][column]).collect();
        let expected = ["dynamic", "trials", "-0.125", "", "70", "0.25", "0.4", "7"];
        assert_eq!(numbers, expected);
    }

    #[test]
    fn on_a_terminal_no_line_is_longer_than_it_is_wide_and_no_word_is_lost() {
        for columns in [60, 80, 120, 200] {
            let text = statistics().to_table(TableFormat::Text {
                columns: Some(columns),
            });
            let longest = text.lines().map(|line| line.chars().count()).max();
            assert!(longest <= Some(columns.into()), "{columns}:\n{text}");
            let count = |word: &str| text.matches(word).count();
            assert_eq!(count("p=0.250"), 3, "{columns}:\n{text}");
            assert_eq!(count("Spearman") + count("-0.12"), 2, "{columns}:\n{text}");
        }
    }

    #[test]
    fn a_length_is_printed_in_micrometres_with_its_published_value() {
        let mut statistics = statistics();
        let row = &mut statistics.rows[0];
        (row.meaning, row.published) = ("sigma_t, m", "(1.7 ± 0.4)e-6");
        row.paper = MethodStatistic::single(Statistic {
            value: Some(1.6e-6),
            std: Some(0.3e-6),
            n: 9,
            ..Statistic::empty(Level::Instances)
        });
        row.trial = MethodStatistic::single(Statistic {
            n: 2,
            ..Statistic::empty(Level::Participants)
        });
        let text = statistics.to_table(TableFormat::Text { columns: None });
        for cell in [
            "σ_t, µm",
            "1.7 ± 0.4 ",
            "1.60 ± 0.30 (n=9 instances)",
            "too few (n=2 participants)",
        ] {
            assert!(text.contains(cell), "{cell}: {text}");
        }
    }

    #[test]
    fn symbols_stand_for_whole_words_alone() {
        assert_eq!(latex("the mutual mu_x"), r"the mutual $\mu$\_x");
        assert_eq!(
            latex("5 um and sigma_t, m"),
            r"5~\textmu m and $\sigma_t$, m"
        );
    }
}
