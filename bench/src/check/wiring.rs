//! Whether the lines that a bench needs are wired. What `[safety] waived` does not name is required, of every bench.

use config::{Config, HardwareStop, Safety};

use super::Table;
use super::measure::Measured;
use super::table::Verdict;

pub(super) fn judge(table: &mut Table, config: &Config, measured: &Measured) {
    if config.encoder.is_some() {
        let read = measured.positions > 0;
        let found = if read {
            "read"
        } else {
            "no lines: name encoder_a and encoder_b in [gpio]; a bench without an encoder has no [encoder] in bench.toml"
        };
        table.row("encoder", read, found);
    }
    for (name, line, wired) in [
        ("e-stop", HardwareStop::Estop, measured.estop_wired),
        (
            "heartbeat",
            HardwareStop::Heartbeat,
            measured.heartbeat_wired,
        ),
    ] {
        let (verdict, found) = line_in_words(&config.safety, line, wired);
        table.judged(name, verdict, found);
    }
}

fn line_in_words(safety: &Safety, line: HardwareStop, wired: bool) -> (Verdict, String) {
    match (safety.waiver_of(line), wired) {
        (None, true) => (Verdict::Passed, "wired".to_owned()),
        (None, false) => (
            Verdict::Failed,
            format!(
                "not wired: name {line} in [gpio]; without it the drive has no hardware stop, and only \
                 `waived = [\"{line}\"]` with `waived_by` in [safety] lets the bench run"
            ),
        ),
        (Some(name), false) => (Verdict::Waived, format!("waived by {name}; not wired")),
        (Some(name), true) => (
            Verdict::Waived,
            format!("waived by {name}, although it is wired and watched: take it out of `waived`"),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(safety: &str, estop_wired: bool, heartbeat_wired: bool) -> Table {
        let text = include_str!("../../mock-bench.toml")
            .replace("[safety]\n", &format!("[safety]\n{safety}\n"));
        let config = Config::parse(&text, "test").unwrap();
        let measured = Measured {
            positions: 1,
            estop_wired,
            heartbeat_wired,
            ..Measured::default()
        };
        let mut table = Table::default();
        judge(&mut table, &config, &measured);
        table
    }

    fn verdicts(table: &Table) -> Vec<Verdict> {
        table.rows.iter().map(|row| row.verdict).collect()
    }

    #[test]
    fn a_bench_without_a_hardware_stop_fails() {
        use Verdict::{Failed, Passed};
        for (estop, heartbeat, expected) in [
            (true, true, [Passed, Passed, Passed]),
            (false, true, [Passed, Failed, Passed]),
            (true, false, [Passed, Passed, Failed]),
        ] {
            assert_eq!(verdicts(&table("", estop, heartbeat)), expected);
        }
    }

    #[test]
    fn a_waiver_covers_the_line_that_it_names_and_no_other() {
        use Verdict::{Failed, Passed, Waived};
        let estop = "waived = [\"estop\"]\nwaived_by = \"A. Tester\"";
        let judged = table(estop, false, false);
        assert_eq!(verdicts(&judged), [Passed, Waived, Failed]);
        assert!(judged.rows[1].found.contains("waived by A. Tester"));
        assert!(!judged.passed());
        let both = "waived = [\"estop\", \"heartbeat\"]\nwaived_by = \"A. Tester\"";
        let judged = table(both, false, false);
        assert_eq!(verdicts(&judged), [Passed, Waived, Waived]);
        assert!(judged.passed());
    }

    #[test]
    fn waiving_a_wired_line_is_allowed_and_reported() {
        let estop = "waived = [\"estop\"]\nwaived_by = \"A. Tester\"";
        let judged = table(estop, true, true);
        assert!(judged.passed());
        assert_eq!(judged.rows[1].verdict, Verdict::Waived);
        assert!(judged.rows[1].found.contains("although it is wired"));
    }
}
