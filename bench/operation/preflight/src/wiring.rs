//! Check that the lines required by a bench are wired. Every bench requires all lines not named in `[safety] waived`.

use config::{Config, EncoderSource, HardwareStop, Safety};
use devices::NotWired;
use safety::{StopLine, StopTimes};

use crate::Table;
use crate::measure::Measured;
use crate::table::RowVerdict;

pub(super) fn judge(table: &mut Table, config: &Config, measured: &Measured) {
    if let Some(encoder) = &config.encoder {
        let is_read = measured.positions > 0;
        let finding = match encoder.source {
            _ if is_read => "read",
            EncoderSource::Gpio => {
                "no lines: name encoder_a and encoder_b in [gpio]; a bench without an encoder has no [encoder] in bench.toml"
            }
            EncoderSource::Nidaqmx => {
                "no counts from the card, encoder.source in bench.toml: look at nidaqmx.counter"
            }
            EncoderSource::FieldBox => {
                "no counts from the field box, encoder.source in bench.toml: look at field_box.port"
            }
        };
        table.row("encoder", is_read, finding);
    }
    judge_wired(table, config, measured);
    judge_dead_man(table, config, measured.dead_man_wired);
    judge_stops(table, config, measured);
}

/// Judges which hardware stops are wired.
pub(super) fn judge_wired(table: &mut Table, config: &Config, measured: &Measured) {
    for (name, line, wired) in [
        ("e-stop", HardwareStop::Estop, measured.estop_wired),
        (
            "heartbeat",
            HardwareStop::Heartbeat,
            measured.heartbeat_wired,
        ),
    ] {
        let (verdict, finding) = line_in_words(&config.safety, line, wired);
        table.verdict_row(name, verdict, finding);
    }
}

/// Judges the dead-man switch of a bench that uses one; its opening and closing are tested before each trial.
fn judge_dead_man(table: &mut Table, config: &Config, wired: bool) {
    let safety = &config.safety;
    if safety.dead_man.is_none() {
        return;
    }
    let finding = if wired {
        format!(
            "in use: released for {} s it stops the drive, and each drive wants a release and a press before it",
            safety.dead_man_release_s
        )
    } else {
        "not wired: name dead_man in [gpio]; safety.dead_man asks for it".to_owned()
    };
    table.row("dead-man", wired, finding);
}

/// Judges the exercise of the hardware stops.
pub(super) fn judge_stops(table: &mut Table, config: &Config, measured: &Measured) {
    for (line, wired) in [
        (StopLine::Heartbeat, measured.heartbeat_wired),
        (StopLine::Enable, measured.enable_wired),
    ] {
        let times = measured.stops.iter().find(|times| times.line == line);
        match times {
            Some(times) => judge_stop(table, &config.safety, times, shown_s(&measured.stops)),
            None if wired => table.row(row_name(line), false, "could not be exercised"),
            None => {}
        }
    }
}

/// Longest time from the last edge of the heartbeat until the amplifier is off, s (FAULTS.md, row 7).
const ONE_SHOT_S: f64 = 0.1;
/// Longest delay of the read-back in showing an amplifier that is off, s: the loop, the demodulation, and a buffer.
const SHOWN_S: f64 = 0.05;
/// Time between two checks of the read-back, s.
const LOOK_S: f64 = 0.01;

/// Returns the delay of the read-back in showing an amplifier that is off, s: as measured with the enable line, if it is wired.
fn shown_s(stops: &[StopTimes]) -> f64 {
    let enable = stops.iter().find(|times| times.line == StopLine::Enable);
    let off_s = enable.and_then(|times| times.off_s);
    off_s.map_or(SHOWN_S, |off_s| (off_s + LOOK_S).min(SHOWN_S))
}

fn row_name(line: StopLine) -> &'static str {
    match line {
        StopLine::Heartbeat => "stop: heartbeat",
        StopLine::Enable => "stop: enable",
    }
}

/// Judges a hardware stop that was exercised with the faint tone.
fn judge_stop(table: &mut Table, safety: &Safety, times: &StopTimes, shown_s: f64) {
    let (line, most_s, remedy) = match times.line {
        StopLine::Heartbeat => (
            "the heartbeat",
            ONE_SHOT_S + shown_s,
            "wire it to a retriggerable one-shot of at most 100 ms that gates the amplifier",
        ),
        StopLine::Enable => (
            "the enable line",
            SHOWN_S,
            "wire it to the amplifier's enable input or relay",
        ),
    };
    let (passed, finding) = match (times.off_s, times.back_s) {
        (None, _) => (
            false,
            format!("the amplifier stays on without {line}: {remedy}"),
        ),
        (Some(off_s), _) if off_s > most_s => (
            false,
            format!(
                "the amplifier is off only {:.0} ms after {line} stopped, more than {:.0} ms: {remedy}",
                1e3 * off_s,
                1e3 * most_s
            ),
        ),
        (Some(_), None) => (
            false,
            format!("the amplifier does not come back with {line}: {remedy}"),
        ),
        (Some(off_s), Some(back_s)) => (
            true,
            format!(
                "off {:.0} ms after {line} stopped, back after {:.0} ms",
                1e3 * off_s,
                1e3 * back_s
            ),
        ),
    };
    let waiver = match times.line {
        StopLine::Heartbeat => safety.waiver_of(HardwareStop::Heartbeat),
        StopLine::Enable => None,
    };
    let verdict = match (passed, waiver) {
        (true, _) => RowVerdict::Passed,
        (false, Some(_)) => RowVerdict::Waived,
        (false, None) => RowVerdict::Failed,
    };
    table.verdict_row(row_name(times.line), verdict, finding);
}

fn line_in_words(safety: &Safety, line: HardwareStop, wired: bool) -> (RowVerdict, String) {
    match (safety.waiver_of(line), wired) {
        (None, true) => (RowVerdict::Passed, "wired".to_owned()),
        (None, false) => (RowVerdict::Failed, NotWired { line }.to_string()),
        (Some(name), false) => (RowVerdict::Waived, format!("waived by {name}; not wired")),
        (Some(name), true) => (
            RowVerdict::Waived,
            format!("waived by {name}, although it is wired and watched: take it out of `waived`"),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(safety: &str, estop_wired: bool, heartbeat_wired: bool) -> Table {
        let text = config::rigs::MOCK_BENCH.replace("[safety]\n", &format!("[safety]\n{safety}\n"));
        let config = Config::parse(&text, "test").unwrap();
        let measured = Measured {
            positions: 1,
            estop_wired,
            heartbeat_wired,
            stops: Vec::from_iter(heartbeat_wired.then_some(StopTimes {
                line: StopLine::Heartbeat,
                off_s: Some(0.09),
                back_s: Some(0.01),
            })),
            ..Measured::default()
        };
        let mut table = Table::default();
        judge(&mut table, &config, &measured);
        table
    }

    fn verdicts(table: &Table) -> Vec<RowVerdict> {
        let lines = table
            .rows
            .iter()
            .filter(|row| !row.name.starts_with("stop"));
        lines.map(|row| row.verdict).collect()
    }

    /// Returns the verdict on a heartbeat or enable line with these times, under additional keys of `[safety]`.
    fn stop(safety: &str, line: StopLine, off_s: Option<f64>, back_s: Option<f64>) -> RowVerdict {
        let text = config::rigs::MOCK_BENCH.replace("[safety]\n", &format!("[safety]\n{safety}\n"));
        let config = Config::parse(&text, "test").unwrap();
        let mut table = Table::default();
        judge_stop(
            &mut table,
            &config.safety,
            &StopTimes {
                line,
                off_s,
                back_s,
            },
            0.013,
        );
        table.rows[0].verdict
    }

    #[test]
    fn a_stop_must_stop_in_time_and_let_go() {
        use RowVerdict::{Failed, Passed, Waived};
        let heartbeat = |off_s, back_s| stop("", StopLine::Heartbeat, off_s, back_s);
        assert_eq!(heartbeat(Some(0.104), Some(0.003)), Passed);
        assert_eq!(heartbeat(Some(0.12), Some(0.003)), Failed);
        assert_eq!(heartbeat(None, Some(0.0)), Failed);
        assert_eq!(heartbeat(Some(0.1), None), Failed);
        let enable = |off_s| stop("", StopLine::Enable, off_s, Some(0.003));
        assert_eq!(enable(Some(0.02)), Passed);
        assert_eq!(enable(Some(0.06)), Failed);
        let waived = "waived = [\"heartbeat\"]\nwaived_by = \"A. Tester\"";
        assert_eq!(stop(waived, StopLine::Heartbeat, None, None), Waived);
        assert_eq!(stop(waived, StopLine::Enable, None, None), Failed);
    }

    /// Hazard 15.
    #[test]
    fn a_dead_man_switch_that_is_asked_for_must_be_wired() {
        let text =
            config::rigs::MOCK_BENCH.replace("[safety]\n", "[safety]\ndead_man = \"button\"\n");
        for (text, wired, expected) in [
            (text.as_str(), true, vec![RowVerdict::Passed]),
            (&text, false, vec![RowVerdict::Failed]),
            (config::rigs::MOCK_BENCH, false, vec![]),
        ] {
            let config = Config::parse(text, "test").unwrap();
            let mut table = Table::default();
            judge_dead_man(&mut table, &config, wired);
            let verdicts: Vec<RowVerdict> = table.rows.iter().map(|row| row.verdict).collect();
            assert_eq!(verdicts, expected);
        }
    }

    #[test]
    fn a_wired_line_that_was_not_exercised_fails() {
        let mut table = Table::default();
        let config = Config::parse(config::rigs::MOCK_BENCH, "test").unwrap();
        let measured = Measured {
            heartbeat_wired: true,
            estop_wired: true,
            enable_wired: true,
            ..Measured::default()
        };
        judge_stops(&mut table, &config, &measured);
        let failed = table.rows.iter().filter(|row| !row.passed);
        assert_eq!(failed.count(), 2);
    }

    /// Hazards 15, 16.
    #[test]
    fn a_bench_without_a_hardware_stop_fails() {
        use RowVerdict::{Failed, Passed};
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
        use RowVerdict::{Failed, Passed, Waived};
        let estop = "waived = [\"estop\"]\nwaived_by = \"A. Tester\"";
        let verdict_table = table(estop, false, false);
        assert_eq!(verdicts(&verdict_table), [Passed, Waived, Failed]);
        assert!(verdict_table.rows[1].found.contains("waived by A. Tester"));
        assert!(!verdict_table.passed());
        let two_waivers = "waived = [\"estop\", \"heartbeat\"]\nwaived_by = \"A. Tester\"";
        let verdict_table = table(two_waivers, false, false);
        assert_eq!(verdicts(&verdict_table), [Passed, Waived, Waived]);
        assert!(verdict_table.passed());
    }

    #[test]
    fn waiving_a_wired_line_is_allowed_and_reported() {
        let estop = "waived = [\"estop\"]\nwaived_by = \"A. Tester\"";
        let verdict_table = table(estop, true, true);
        assert!(verdict_table.passed());
        assert_eq!(verdict_table.rows[1].verdict, RowVerdict::Waived);
        assert!(verdict_table.rows[1].found.contains("although it is wired"));
    }
}
