//! Record of the plate's temperature: one line, with the run of the computer in which it was written.
//!
//! A plate cools by the time that has certainly passed. Within one run of the computer its own clock counts, which
//! cannot be set; across a restart, the time since that start has passed. The wall clock is trusted only if it says
//! that more than a day has passed, or if there is no other clock; a clock that jumped backwards cools nothing. After a
//! record of another computer, or of one that the record does not name, the shorter of both times has certainly passed.

use jiff::Timestamp;

use crate::boot::Boot;
use crate::dose_record::{BELIEVED_S, DamagedLine, id_named, id_word};

const HEADER: &str = "boot\tup_s\trise_k\tdate\tmachine\n";
/// Header in earlier versions, which did not name the computer.
const OLDER_HEADER: &str = "boot\tup_s\trise_k\tdate\n";
/// Highest temperature above the room that a record may state, K: glass softens below it.
const WARMEST_K: f64 = 500.0;

/// Recorded temperature of a plate.
#[derive(Debug, Clone, PartialEq)]
pub struct Warmth {
    /// Identifier of the computer's run; `None` if the system gives none.
    pub boot: Option<String>,
    /// Time of the record, in seconds of that run.
    pub up_s: f64,
    /// Temperature above the room, K.
    pub rise_k: f64,
    /// Time of the record by the wall clock.
    pub date: Timestamp,
    /// Identifier of the computer; `None` if the record does not name it, or the computer has no identifier.
    pub machine: Option<String>,
}

impl Warmth {
    /// Returns the least time that has certainly passed since the record, s.
    #[must_use]
    pub fn age_s(&self, boot: &Boot, now: Timestamp) -> f64 {
        let wall_s = now.duration_since(self.date).as_secs_f64();
        let certain_s = match (&self.boot, &boot.id) {
            (Some(of), Some(this)) if of == this => boot.up_s - self.up_s,
            (Some(_), Some(_)) if wall_s > BELIEVED_S => wall_s,
            (Some(_), Some(_)) if self.machine.is_some() && self.machine == boot.machine => {
                boot.up_s
            }
            (Some(_), Some(_)) => wall_s.min(boot.up_s),
            _ => wall_s,
        };
        certain_s.max(0.0)
    }
}

/// Reads a record.
///
/// # Errors
/// The first line that cannot be read: the plate's temperature is then unknown.
pub fn parse(text: &str) -> Result<Warmth, DamagedLine> {
    let (line, says_machine) = match (text.strip_prefix(HEADER), text.strip_prefix(OLDER_HEADER)) {
        (Some(line), _) => (line, true),
        (None, Some(line)) => (line, false),
        (None, None) => return Err(DamagedLine { line: 1 }),
    };
    row(line, says_machine).ok_or(DamagedLine { line: 2 })
}

fn row(line: &str, says_machine: bool) -> Option<Warmth> {
    let mut fields = line.strip_suffix('\n')?.split('\t');
    let boot = id_named(fields.next()?)?;
    let up_s: f64 = fields.next()?.parse().ok()?;
    let rise_k: f64 = fields.next()?.parse().ok()?;
    let date = fields.next()?.parse().ok()?;
    let machine = if says_machine {
        id_named(fields.next()?)?
    } else {
        None
    };
    let valid = up_s.is_finite() && up_s >= 0.0 && (0.0..=WARMEST_K).contains(&rise_k);
    (fields.next().is_none() && valid).then_some(Warmth {
        boot,
        up_s,
        rise_k,
        date,
        machine,
    })
}

/// Returns the text of a record.
#[must_use]
pub fn to_text(warmth: &Warmth) -> String {
    let Warmth {
        boot,
        up_s,
        rise_k,
        date,
        machine,
    } = warmth;
    let rise_k = rise_k.clamp(0.0, WARMEST_K);
    format!(
        "{HEADER}{}\t{up_s:.3}\t{rise_k:.3}\t{date}\t{}\n",
        id_word(boot.as_deref()),
        id_word(machine.as_deref())
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const NOON: &str = "2026-05-04T12:00:00Z";

    fn timestamp(text: &str) -> Timestamp {
        text.parse().unwrap()
    }

    fn warmth(boot: Option<&str>) -> Warmth {
        Warmth {
            boot: boot.map(str::to_owned),
            up_s: 1000.0,
            rise_k: 12.5,
            date: timestamp(NOON),
            machine: Some("1".to_owned()),
        }
    }

    fn run(id: Option<&str>, up_s: f64) -> Boot {
        Boot {
            id: id.map(str::to_owned),
            up_s,
            machine: Some("1".to_owned()),
        }
    }

    /// Fault 39.
    #[test]
    fn on_the_same_run_the_wall_clock_is_not_asked() {
        for now in [
            NOON,
            "1999-01-01T00:00:00Z",
            "2026-05-04T23:00:00Z",
            "2030-01-01T00:00:00Z",
        ] {
            let age_s = warmth(Some("a")).age_s(&run(Some("a"), 1060.0), timestamp(now));
            assert_eq!(age_s, 60.0, "{now}");
        }
    }

    /// Fault 39.
    #[test]
    fn over_a_restart_the_time_since_then_has_passed_and_days_of_the_wall_clock() {
        for (now, age_s) in [
            ("2026-05-04T12:00:50Z", 30.0),
            ("2026-05-05T11:00:00Z", 30.0),
            ("1999-01-01T00:00:00Z", 30.0),
            ("2026-05-06T12:00:00Z", 172_800.0),
        ] {
            let elapsed_s = warmth(Some("a")).age_s(&run(Some("b"), 30.0), timestamp(now));
            assert_eq!(elapsed_s, age_s, "{now}");
        }
    }

    /// A bench is moved to a computer that has been on for five hours.
    /// Fault 42.
    /// Hazard 4.
    #[test]
    fn another_computers_run_cools_no_plate() {
        let next_minute = timestamp("2026-05-04T12:01:00Z");
        for machine in [Some("2".to_owned()), None] {
            let other_record = Warmth {
                machine,
                ..warmth(Some("a"))
            };
            assert_eq!(
                other_record.age_s(&run(Some("b"), 18_000.0), next_minute),
                60.0
            );
            assert_eq!(other_record.age_s(&run(Some("b"), 30.0), next_minute), 30.0);
            assert_eq!(
                other_record.age_s(&run(Some("b"), 30.0), timestamp("1999-01-01T00:00:00Z")),
                0.0
            );
        }
        let older = to_text(&warmth(Some("a")))
            .replace("\tmachine", "")
            .replace("\t1\n", "\n");
        assert_eq!(parse(&older).unwrap().machine, None);
    }

    /// Fault 39.
    #[test]
    fn no_clock_that_jumped_backwards_cools_a_plate() {
        let early = timestamp("2026-05-04T11:00:00Z");
        for (recorded, present) in [(None, None), (None, Some("a")), (Some("a"), None)] {
            assert_eq!(warmth(recorded).age_s(&run(present, 0.0), early), 0.0);
            assert_eq!(
                warmth(recorded).age_s(&run(present, 5.0), timestamp("2026-05-04T12:01:00Z")),
                60.0
            );
        }
        // Record of a longer run with the same identifier.
        assert_eq!(
            warmth(Some("a")).age_s(&run(Some("a"), 10.0), timestamp(NOON)),
            0.0
        );
    }

    #[test]
    fn a_damaged_line_is_named() {
        let valid = to_text(&warmth(Some("a")));
        assert_eq!(parse(&valid), Ok(warmth(Some("a"))));
        for (text, line) in [
            (String::new(), 1),
            ("boot\n".to_owned(), 1),
            (HEADER.to_owned(), 2),
            (valid.trim_end().to_owned(), 2),
            (format!("{valid}{valid}"), 2),
            (format!("{HEADER}a\t1\t-0.1\t{NOON}\t1\n"), 2),
            (format!("{HEADER}a\t1\tNaN\t{NOON}\t1\n"), 2),
            (format!("{HEADER}a\t1\t501\t{NOON}\t1\n"), 2),
            (format!("{HEADER}a\tinf\t1\t{NOON}\t1\n"), 2),
            (format!("{HEADER}a b\t1\t1\t{NOON}\t1\n"), 2),
            (format!("{HEADER}a\t1\t1\tyesterday\t1\n"), 2),
            (format!("{HEADER}a\t1\t1\t{NOON}\n"), 2),
        ] {
            assert_eq!(parse(&text), Err(DamagedLine { line }), "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn a_record_reads_as_it_was_written(
            boot in prop::option::of("[0-9a-f]{1,36}"), up in 0u32..1_000_000, rise in 0u32..4_000, date in 0i64..2_000_000_000,
        ) {
            let warmth = Warmth {
                boot,
                up_s: f64::from(up) / 8.0,
                rise_k: f64::from(rise) / 8.0,
                date: Timestamp::from_second(date).unwrap(),
                machine: Some("2".to_owned()),
            };
            prop_assert_eq!(parse(&to_text(&warmth)).unwrap(), warmth);
        }

        /// The age is a number and not negative, for all clocks and records.
        #[test]
        fn no_clock_makes_a_plate_younger_than_now(
            boots in prop::collection::vec(prop::option::of("[ab]"), 2), up_s in 0.0..1e9, wall_s in -2_000_000_000i64..2_000_000_000,
        ) {
            let now = Timestamp::from_second(wall_s).unwrap();
            let age_s = warmth(boots[0].as_deref()).age_s(&run(boots[1].as_deref(), up_s), now);
            prop_assert!(age_s >= 0.0);
        }
    }
}
