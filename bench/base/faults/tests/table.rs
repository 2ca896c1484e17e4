//! Tests that the documentation's table of faults is current.

use faults::{FaultKind, Remedy, Required, Within};

const DOCS: &str = include_str!("../../../../docs/rehearsal.md");

fn line(fault: FaultKind) -> String {
    let row = fault.row();
    let amount = row.amount.map_or(String::new(), |amount| {
        format!(
            "; {}: {} to {} {}, by default {}",
            amount.name, amount.low, amount.high, amount.unit, amount.default
        )
    });
    let number = row.row.map_or("–".to_owned(), |row| row.to_string());
    let required = match row.required {
        Required::Stop(Within::Seconds(seconds)) => format!("stops, {:.0} ms", 1e3 * seconds),
        Required::Stop(Within::SilenceAnd(seconds)) => {
            format!("stops, silence + {:.0} ms", 1e3 * seconds)
        }
        Required::Flag => "flags".to_owned(),
        Required::Refuse => "refuses".to_owned(),
        Required::GoOn => "takes it for one press".to_owned(),
    };
    let remedy = match row.remedy {
        _ if !fault.is_drilled() => "",
        Remedy::Rearm(_) => "re-arm, resume",
        Remedy::Repeat => "repeat the trial",
        Remedy::Restart(_) => "end the program, resume the session",
    };
    let by_hand = if row.real.is_some() { "yes" } else { "" };
    format!(
        "| `{}` | {}{amount} | {number} | {required} | {remedy} | {by_hand} |",
        fault.form(),
        row.words
    )
}

#[test]
fn the_documentation_has_the_table_as_it_is() {
    let head = "| fault | effect | row | the bench | the operator | by hand |\n| --- | --- | --- | --- | --- | --- |";
    let lines: Vec<_> = FaultKind::ALL.iter().map(|fault| line(*fault)).collect();
    let table = format!("{head}\n{}\n", lines.join("\n"));
    assert!(
        DOCS.contains(&table),
        "docs/rehearsal.md must have this table:\n{table}"
    );
}
