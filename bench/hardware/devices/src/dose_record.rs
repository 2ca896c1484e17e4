//! Record of driving times: a table of spans, each with the run of the computer in which it was driven.
//!
//! Within one run of the computer its own clock counts, which cannot be set. Across a restart the wall clock is trusted
//! only if it says that more than a day has passed: a wall clock that is hours wrong, or set by hours, frees no driving
//! time. A span of another computer, or of one that the record does not name, may be younger than this run: it is
//! placed as late as the start of this run, the wall clock and the order of the record allow.

use jiff::{SignedDuration, Timestamp};

use crate::boot::Boot;

const HEADER: &str = "boot\tup_s\tdriven_s\tdate\tmachine\n";
/// Header of a bench's record, which also states the person at the plate for each span.
const BENCH_HEADER: &str = "boot\tup_s\tdriven_s\tdate\twhose\tmachine\n";
/// Headers of both in earlier versions, which did not name the computer.
const OLDER_HEADER: &str = "boot\tup_s\tdriven_s\tdate\n";
const OLDER_BENCH_HEADER: &str = "boot\tup_s\tdriven_s\tdate\twhose\n";
/// Word for a run or a computer without an identifier.
const UNNAMED: &str = "-";
/// Age above which the wall clock is trusted across a restart, s.
pub const BELIEVED_S: f64 = 86_400.0;
/// Age above which a span of this run is dropped from the record, s.
const KEPT_S: f64 = 7_200.0;
/// Longest span, s: a week.
const LONGEST_S: f64 = 604_800.0;

/// Person at the driven plate, as far as a bench can tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AccountOwner {
    /// No person: calibrations require a clear plate.
    Nobody,
    /// Unknown person: no participant was named.
    Unnamed,
    /// Named participant, with an account of their own that counts the span.
    Named,
}

impl AccountOwner {
    const ALL: [(Self, &'static str); 3] = [
        (Self::Nobody, "nobody"),
        (Self::Unnamed, "unnamed"),
        (Self::Named, "named"),
    ];

    /// Returns whether a span of `other` on the bench's record counts for a drive of `self`, in addition to the drive's
    /// own account: an unnamed person may be any person, including a named participant.
    #[must_use]
    pub fn counts(self, other: Self) -> bool {
        match self {
            Self::Nobody => other != Self::Named,
            Self::Unnamed => true,
            Self::Named => other == Self::Unnamed,
        }
    }

    fn word(self) -> &'static str {
        let (_, word) = Self::ALL[self as usize];
        word
    }

    fn from_word(word: &str) -> Option<Self> {
        let entry = Self::ALL.iter().find(|(_, known)| *known == word);
        entry.map(|(owner, _)| *owner)
    }
}

/// A span of driving.
#[derive(Debug, Clone, PartialEq)]
pub struct Driven {
    /// Identifier of the computer's run; `None` if the system gives none.
    pub boot: Option<String>,
    /// Start of the drive, in seconds of that run.
    pub up_s: f64,
    /// Length of the drive, s.
    pub driven_s: f64,
    /// Start of the drive by the wall clock.
    pub date: Timestamp,
    /// Person at the plate; unnamed if the record does not say.
    pub owner: AccountOwner,
    /// Identifier of the computer; `None` if the record does not name it, or the computer has no identifier.
    pub machine: Option<String>,
}

/// Columns of a record after the first four.
#[derive(Debug, Clone, Copy)]
struct Columns {
    owner: bool,
    machine: bool,
}

impl Columns {
    fn from_header(header: &str) -> Option<Self> {
        let (owner, machine) = match header {
            HEADER => (false, true),
            BENCH_HEADER => (true, true),
            OLDER_HEADER => (false, false),
            OLDER_BENCH_HEADER => (true, false),
            _ => return None,
        };
        Some(Self { owner, machine })
    }
}

/// A line of a record that cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("line {line} is damaged")]
pub struct DamagedLine {
    /// Number of the line, from 1.
    pub line: usize,
}

/// Reads a record.
///
/// # Errors
/// The first line that cannot be read: the driving time is then unknown.
pub fn parse(text: &str) -> Result<Vec<Driven>, DamagedLine> {
    let mut lines = text.split_inclusive('\n').enumerate();
    let columns = lines
        .next()
        .and_then(|(_, header)| Columns::from_header(header));
    let Some(columns) = columns else {
        return Err(DamagedLine { line: 1 });
    };
    lines
        .map(|(i, line)| row(line, columns).ok_or(DamagedLine { line: i + 1 }))
        .collect()
}

/// Returns the identifier of a run or a computer in a record: `Some(None)` for the word that stands for no identifier,
/// `None` for an invalid word.
pub fn id_named(word: &str) -> Option<Option<String>> {
    let is_name_char = |c: char| c.is_ascii_hexdigit() || c == '-';
    let is_name = !word.is_empty() && word.len() <= 64 && word.chars().all(is_name_char);
    is_name.then(|| (word != UNNAMED).then(|| word.to_owned()))
}

/// Returns the word for the identifier of a run or a computer, which [`id_named`] reads.
pub fn id_word(id: Option<&str>) -> &str {
    id.unwrap_or(UNNAMED)
}

fn row(line: &str, columns: Columns) -> Option<Driven> {
    let line = line.strip_suffix('\n')?;
    let mut fields = line.split('\t');
    let boot = id_named(fields.next()?)?;
    let number = |text: &str| {
        text.parse()
            .ok()
            .filter(|n: &f64| n.is_finite() && *n >= 0.0)
    };
    let up_s = number(fields.next()?)?;
    let driven_s = number(fields.next()?)?;
    let date = fields.next()?.parse().ok()?;
    let owner = if columns.owner {
        AccountOwner::from_word(fields.next()?)?
    } else {
        AccountOwner::Unnamed
    };
    let machine = if columns.machine {
        id_named(fields.next()?)?
    } else {
        None
    };
    (fields.next().is_none() && driven_s <= LONGEST_S).then_some(Driven {
        boot,
        up_s,
        driven_s,
        date,
        owner,
        machine,
    })
}

/// Returns the text of a participant's record.
#[must_use]
pub fn to_text(spans: &[Driven]) -> String {
    let rows = spans
        .iter()
        .map(|span| format!("{}\t{}\n", four_columns(span), machine_word(span)));
    std::iter::once(HEADER.to_owned()).chain(rows).collect()
}

/// Returns the text of a bench's record.
#[must_use]
pub fn to_bench_text(spans: &[Driven]) -> String {
    let rows = spans.iter().map(|span| {
        let (owner, machine) = (span.owner.word(), machine_word(span));
        format!("{}\t{owner}\t{machine}\n", four_columns(span))
    });
    std::iter::once(BENCH_HEADER.to_owned())
        .chain(rows)
        .collect()
}

fn machine_word(span: &Driven) -> &str {
    id_word(span.machine.as_deref())
}

fn four_columns(span: &Driven) -> String {
    let boot = id_word(span.boot.as_deref());
    format!(
        "{boot}\t{:.3}\t{:.3}\t{}",
        span.up_s, span.driven_s, span.date
    )
}

/// Returns the spans that may still lie within the last hour, as start and end in seconds of the present run of the
/// computer. Spans of an earlier run of this computer are placed as late as possible before the start of the present
/// run, spans of another computer as late as possible before `now`; spans do not overlap and keep their order.
#[must_use]
pub fn on_this_run(spans: &[Driven], boot: &Boot, now: Timestamp) -> Vec<(f64, f64)> {
    let mut places = Vec::new();
    // Start of the next later span, and the other run that is being placed: its name and its shift.
    let mut until_s = boot.up_s;
    let mut run: Option<(&str, f64)> = None;
    for (i, span) in spans.iter().enumerate().rev() {
        let wall_s = age_s(span, now);
        let wall_end_s = boot.up_s - wall_s.max(0.0);
        let (start_s, end_s) = (span.up_s, span.up_s + span.driven_s);
        let end_s = match (&span.boot, &boot.id) {
            (Some(span_boot), Some(this_boot)) if span_boot == this_boot => {
                places.push((start_s, end_s));
                until_s = until_s.min(start_s);
                continue;
            }
            (Some(_), Some(_)) if wall_s > BELIEVED_S => continue,
            (Some(span_boot), Some(_)) => {
                let shift_s = match run {
                    Some((name, shift_s)) if name == span_boot => shift_s,
                    _ if span.machine.is_some() && span.machine == boot.machine => {
                        until_s.min(0.0) - end_s
                    }
                    _ => {
                        let after_s = end_of_this_run(&spans[..i], boot) + span.driven_s;
                        wall_end_s.max(after_s).max(0.0).min(until_s) - end_s
                    }
                };
                run = Some((span_boot, shift_s));
                until_s.min(end_s + shift_s)
            }
            _ => until_s.min(wall_end_s),
        };
        until_s = end_s - span.driven_s;
        places.push((until_s, end_s));
    }
    places
}

/// Returns the end of the last span of the present run, s; minus infinity without one.
fn end_of_this_run(spans: &[Driven], boot: &Boot) -> f64 {
    let last = spans.iter().rev().find(|span| span.boot == boot.id);
    last.map_or(f64::NEG_INFINITY, |span| span.up_s + span.driven_s)
}

/// Returns the time since the end of a span by the wall clock, s.
fn age_s(span: &Driven, now: Timestamp) -> f64 {
    let since: SignedDuration = now.duration_since(span.date);
    since.as_secs_f64() - span.driven_s
}

/// Returns the spans that a record still needs.
pub fn recent_spans(spans: &[Driven], boot: &Boot, now: Timestamp) -> Vec<Driven> {
    let is_needed = |span: &&Driven| {
        let in_this_run = span.boot.is_some() && span.boot == boot.id;
        if in_this_run {
            boot.up_s - span.up_s - span.driven_s < KEPT_S
        } else {
            age_s(span, now) <= BELIEVED_S
        }
    };
    spans.iter().filter(is_needed).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn timestamp(text: &str) -> Timestamp {
        text.parse().unwrap()
    }

    fn span_of(boot: &str, up_s: f64, driven_s: f64, date: &str) -> Driven {
        Driven {
            boot: Some(boot.to_owned()),
            up_s,
            driven_s,
            date: timestamp(date),
            owner: AccountOwner::Unnamed,
            machine: Some("1".to_owned()),
        }
    }

    fn run(id: &str, up_s: f64) -> Boot {
        Boot {
            id: Some(id.to_owned()),
            up_s,
            machine: Some("1".to_owned()),
        }
    }

    fn driven_by(machine: Option<&str>, span: Driven) -> Driven {
        Driven {
            machine: machine.map(str::to_owned),
            ..span
        }
    }

    const NOON: &str = "2026-05-04T12:00:00Z";

    /// Fault 39.
    #[test]
    fn on_the_same_run_the_wall_clock_is_not_asked() {
        let spans = [span_of("a", 1000.0, 60.0, NOON)];
        for now in [
            "2026-05-04T12:10:00Z",
            "2027-01-01T00:00:00Z",
            "1999-01-01T00:00:00Z",
        ] {
            let placed = on_this_run(&spans, &run("a", 1700.0), timestamp(now));
            assert_eq!(placed, [(1000.0, 1060.0)], "{now}");
            assert_eq!(
                recent_spans(&spans, &run("a", 1700.0), timestamp(now)),
                spans
            );
        }
    }

    /// Fault 39.
    #[test]
    fn over_a_restart_hours_of_the_wall_clock_free_nothing_and_days_do() {
        let spans = [
            span_of("a", 1000.0, 60.0, "2026-05-04T11:00:00Z"),
            span_of("a", 2000.0, 40.0, "2026-05-04T11:16:40Z"),
        ];
        for now in [
            "2026-05-04T11:20:00Z",
            "2026-05-05T11:00:00Z",
            "2025-01-01T00:00:00Z",
        ] {
            let placed = on_this_run(&spans, &run("b", 30.0), timestamp(now));
            assert_eq!(placed, [(-40.0, 0.0), (-1040.0, -980.0)], "{now}");
        }
        let a_week_later = timestamp("2026-05-11T12:00:00Z");
        assert!(on_this_run(&spans, &run("b", 30.0), a_week_later).is_empty());
        assert!(recent_spans(&spans, &run("b", 30.0), a_week_later).is_empty());
    }

    #[test]
    fn several_runs_lie_one_before_the_other() {
        let spans = [
            span_of("a", 10.0, 60.0, NOON),
            span_of("b", 5.0, 20.0, NOON),
        ];
        let placed = on_this_run(&spans, &run("c", 3.0), timestamp(NOON));
        assert_eq!(placed, [(-20.0, 0.0), (-80.0, -20.0)]);
    }

    #[test]
    fn a_computer_that_tells_no_runs_apart_goes_by_the_wall_clock() {
        let spans = [Driven {
            boot: None,
            ..span_of("a", 0.0, 60.0, "2026-05-04T11:50:00Z")
        }];
        let anonymous = Boot {
            id: None,
            up_s: 0.0,
            machine: None,
        };
        let placed = on_this_run(&spans, &anonymous, timestamp(NOON));
        assert_eq!(placed, [(-600.0, -540.0)]);
        // A span dated in the future may have ended just now.
        let early = on_this_run(&spans, &anonymous, timestamp("2026-05-04T11:00:00Z"));
        assert_eq!(early, [(-60.0, 0.0)]);
    }

    /// After ten minutes of driving on one computer, the participant moves to another that has been on for five hours.
    ///
    /// Faults 42, 51.
    /// Hazard 5.
    #[test]
    fn what_was_driven_on_another_computer_counts() {
        let now = timestamp("2026-05-04T12:11:00Z");
        let five_hours = run("b", 18_000.0);
        for machine in [Some("2"), None] {
            let spans = [driven_by(machine, span_of("a", 500.0, 600.0, NOON))];
            let placed = on_this_run(&spans, &five_hours, now);
            assert_eq!(placed, [(17_340.0, 17_940.0)], "{machine:?}");
            // A slow wall clock cannot date the span: it may have ended just now.
            let placed = on_this_run(&spans, &five_hours, timestamp("2026-05-04T08:00:00Z"));
            assert_eq!(placed, [(17_400.0, 18_000.0)], "{machine:?}");
            // A fast wall clock does not make the span older than the start of this run.
            let placed = on_this_run(&spans, &five_hours, timestamp("2026-05-05T11:00:00Z"));
            assert_eq!(placed, [(-600.0, 0.0)], "{machine:?}");
            assert_eq!(recent_spans(&spans, &five_hours, now), spans);
        }
        let local = [span_of("a", 500.0, 600.0, NOON)];
        assert_eq!(on_this_run(&local, &five_hours, now), [(-600.0, 0.0)]);
    }

    /// Fault 42.
    #[test]
    fn spans_of_several_computers_keep_their_order_and_share_no_time() {
        let remote =
            |boot: &str, up_s, driven_s| driven_by(Some("2"), span_of(boot, up_s, driven_s, NOON));
        let (boot, late) = (run("b", 9_000.0), timestamp("2026-05-04T20:00:00Z"));
        // A span on another computer after one of this run is placed after it, regardless of the wall clock.
        let spans = [span_of("b", 8_000.0, 100.0, NOON), remote("a", 1.0, 50.0)];
        let placed = on_this_run(&spans, &boot, late);
        assert_eq!(placed, [(8_100.0, 8_150.0), (8_000.0, 8_100.0)]);
        let spans = [remote("a", 1.0, 50.0), span_of("b", 8_000.0, 100.0, NOON)];
        let placed = on_this_run(&spans, &boot, timestamp(NOON));
        assert_eq!(placed, [(8_000.0, 8_100.0), (7_950.0, 8_000.0)]);
        // Two runs with impossible dates; within a run its own clock counts.
        let spans = [
            remote("a", 1.0, 50.0),
            remote("c", 7.0, 20.0),
            remote("c", 100.0, 30.0),
        ];
        let placed = on_this_run(&spans, &boot, timestamp("2026-05-04T11:00:00Z"));
        assert_eq!(
            placed,
            [(8_970.0, 9_000.0), (8_877.0, 8_897.0), (8_827.0, 8_877.0)]
        );
        // An earlier run of this computer lies before all of that, and before this run.
        let spans = [span_of("d", 5.0, 60.0, NOON), remote("a", 1.0, 50.0)];
        let placed = on_this_run(&spans, &boot, timestamp(NOON));
        assert_eq!(placed, [(8_950.0, 9_000.0), (-60.0, 0.0)]);
    }

    #[test]
    fn a_damaged_line_is_named() {
        let text_read = to_text(&[span_of("a", 1.0, 2.0, NOON)]);
        assert_eq!(parse(&text_read).unwrap().len(), 1);
        for (text, line) in [
            (String::new(), 1),
            ("boot\n".to_owned(), 1),
            (text_read.trim_end().to_owned(), 2),
            (format!("{text_read}a\t1\t2\n"), 3),
            (format!("{text_read}a\t1\t-2\t{NOON}\t1\n"), 3),
            (format!("{text_read}a\t1\tNaN\t{NOON}\t1\n"), 3),
            (format!("{text_read}a\t1\t1e300\t{NOON}\t1\n"), 3),
            (format!("{text_read}a b\t1\t1\t{NOON}\t1\n"), 3),
            (format!("{text_read}a\t1\t1\tyesterday\t1\n"), 3),
            (format!("{text_read}a\t1\t1\t{NOON}\n"), 3),
            (format!("{text_read}a\t1\t1\t{NOON}\tmy machine\n"), 3),
            (format!("{text_read}\n{text_read}"), 3),
        ] {
            assert_eq!(parse(&text), Err(DamagedLine { line }), "{text:?}");
        }
    }

    #[test]
    fn a_benchs_record_states_the_owner_of_each_span_and_an_older_one_unnamed() {
        let spans = AccountOwner::ALL.map(|(owner, _)| Driven {
            owner,
            ..span_of("a", 1.0, 2.0, NOON)
        });
        let text = to_bench_text(&spans);
        assert_eq!(parse(&text).unwrap(), spans);
        let plain = parse(&to_text(&spans)).unwrap();
        assert!(plain.iter().all(|span| span.owner == AccountOwner::Unnamed));
        let older = text.replace("\tmachine\n", "\n").replace("\t1\n", "\n");
        let unknown = spans.clone().map(|span| driven_by(None, span));
        assert_eq!(parse(&older).unwrap(), unknown);
        let older = older.replace("\twhose", "").replace("\tunnamed", "");
        let older = older
            .lines()
            .take(1)
            .chain(older.lines().filter(|line| line.ends_with('Z')));
        let older: String = older.map(|line| format!("{line}\n")).collect();
        assert_eq!(
            parse(&older).unwrap(),
            [driven_by(None, span_of("a", 1.0, 2.0, NOON))]
        );
        for (from, to) in [
            ("\tnamed", "\tsomebody"),
            ("\tnamed", ""),
            ("\tnamed", "\tnamed\t1"),
        ] {
            let damaged = text.replace(from, to);
            assert_eq!(parse(&damaged), Err(DamagedLine { line: 4 }), "{damaged}");
        }
    }

    proptest! {
        #[test]
        fn a_record_reads_as_it_was_written(
            rows in prop::collection::vec((prop::option::of("[0-9a-f]{1,36}"), prop::option::of("[0-9a-f]{16}"), 0u32..1_000_000, 0u32..100_000, 0i64..2_000_000_000), 0..20),
        ) {
            let spans: Vec<Driven> = rows
                .into_iter()
                .map(|(boot, machine, up, driven, date)| Driven {
                    boot,
                    up_s: f64::from(up) / 8.0,
                    driven_s: f64::from(driven) / 8.0,
                    date: Timestamp::from_second(date).unwrap(),
                    owner: AccountOwner::Unnamed,
                    machine,
                })
                .collect();
            prop_assert_eq!(parse(&to_text(&spans)).unwrap(), spans);
        }

        #[test]
        fn no_text_makes_the_reader_fail_otherwise(text in "(boot\tup_s\tdriven_s\tdate(\tmachine)?\n)?[0-9a-f\t\n.:TZe-]{0,80}") {
            let _ = parse(&text);
        }

        /// A wall clock that is wrong by less than a day does not move the spans of earlier runs: they end as late as
        /// possible before this run.
        /// Fault 39.
        #[test]
        fn within_a_day_the_wall_clock_changes_nothing(wrong_s in -80_000i64..80_000, up_s in 0.0..4000.0) {
            let spans = [span_of("a", 100.0, 50.0, NOON), span_of("b", 20.0, 30.0, "2026-05-04T12:05:00Z")];
            let now = timestamp("2026-05-04T12:10:00Z");
            let wrong_now = now.checked_add(SignedDuration::from_secs(wrong_s)).unwrap();
            let boot = run("c", up_s);
            prop_assert_eq!(on_this_run(&spans, &boot, wrong_now), on_this_run(&spans, &boot, now));
        }
    }
}
