//! The sliding hour against a count of its seconds.

use proptest::prelude::*;
use safety::{DrivenSpan, SlidingHour};

const S: i64 = 1_000_000_000;
const HOUR_S: i64 = 3600;

fn spans() -> impl Strategy<Value = Vec<(i64, i64)>> {
    prop::collection::vec((-8000i64..4000, 0i64..900), 0..25)
}

fn hour(spans: &[(i64, i64)]) -> SlidingHour {
    let mut hour = SlidingHour::default();
    for &(start_s, length_s) in spans {
        hour.add(DrivenSpan {
            start_ns: start_s * S,
            end_ns: (start_s + length_s) * S,
        });
    }
    hour
}

/// Returns the seconds since an hour before `now_s` that some span covers.
fn counted_s(spans: &[(i64, i64)], now_s: i64) -> i64 {
    let is_driven = |s: i64| {
        let mut spans = spans.iter();
        spans.any(|&(start_s, length_s)| (start_s..start_s + length_s).contains(&s))
    };
    (now_s - HOUR_S..5000).filter(|&s| is_driven(s)).count() as i64
}

proptest! {
    #[test]
    fn the_sliding_hour_is_the_count_of_its_seconds(spans in spans(), now_s in -2000i64..5000) {
        prop_assert_eq!(hour(&spans).used_ns(now_s * S), counted_s(&spans, now_s) * S);
    }

    #[test]
    fn dropping_spans_older_than_an_hour_changes_nothing(spans in spans(), now_s in 4900i64..9000) {
        let full_hour = hour(&spans);
        let mut recent_hour = full_hour.clone();
        recent_hour.forget(now_s * S);
        for later_s in [0, 100, 3000] {
            let at_ns = (now_s + later_s) * S;
            prop_assert_eq!(recent_hour.used_ns(at_ns), full_hour.used_ns(at_ns));
        }
    }

    /// Fault 42.
    #[test]
    fn after_the_wait_what_is_needed_is_free_and_a_second_before_it_is_not(
        spans in spans(),
        limit_s in 1i64..2000,
        need_s in 0i64..2000,
    ) {
        let now_s = 4900;
        let hour = hour(&spans);
        let wait_ns = hour.wait_ns(now_s * S, need_s * S, limit_s * S);
        let free_s = |at_ns: i64| (limit_s * S - hour.used_ns(at_ns)) / S;
        let need_s = need_s.min(limit_s);
        prop_assert!(wait_ns >= 0);
        prop_assert!(free_s(now_s * S + wait_ns) >= need_s);
        if wait_ns >= S {
            prop_assert!(free_s(now_s * S + wait_ns - S) < need_s);
        }
    }

    /// Driving within the free time alone never exceeds the limit in any hour.
    /// Fault 42.
    #[test]
    fn no_hour_ever_holds_more_than_its_limit(
        wishes in prop::collection::vec((0i64..600, 1i64..600), 1..40),
        limit_s in 100i64..1200,
    ) {
        let mut hour = SlidingHour::default();
        let (mut now_s, mut drives) = (0i64, Vec::new());
        for (pause_s, length_s) in wishes {
            now_s += pause_s;
            let start_s = now_s;
            // One second at a time, while one is free.
            while now_s - start_s < length_s && hour.used_ns(now_s * S) <= (limit_s - 1) * S {
                hour.add(DrivenSpan { start_ns: start_s * S, end_ns: (now_s + 1) * S });
                now_s += 1;
            }
            drives.push((start_s, now_s - start_s));
            hour.forget(now_s * S);
        }
        for end_s in (0..=now_s).step_by(50) {
            let used_s: i64 = drives
                .iter()
                .map(|&(start_s, length_s)| {
                    ((start_s + length_s).min(end_s) - start_s.max(end_s - HOUR_S)).max(0)
                })
                .sum();
            prop_assert!(used_s <= limit_s, "{} s in the hour before {} s", used_s, end_s);
        }
    }
}
