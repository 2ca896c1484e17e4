//! Rates of streams.

use super::Draft;
use crate::map_text::{Reason, check, number, quoted, sure};
use crate::names::RateWord;
use crate::nature::grouped;
use crate::portrait::{RateOrigin, VectorPortrait};

impl Draft<'_> {
    pub(super) fn rate(&mut self, vector: &VectorPortrait) {
        let Some(rate) = &vector.rate else {
            self.map.key(
                "rate_hz",
                "1000.0",
                check("no file states it: write the rate of the samples"),
            );
            return;
        };
        let hz = grouped(rate.hz).replace('\u{a0}', " ");
        match &rate.origin {
            RateOrigin::File => self.map.key(
                "rate_hz",
                "\"file\"",
                sure(format!("the file states {hz} Hz")),
            ),
            RateOrigin::Scalar(name, RateWord::Rate) => {
                self.map.key(
                    "rate_hz",
                    &quoted(name),
                    sure(format!("the scalar `{name}` is {hz}")),
                );
            }
            RateOrigin::Scalar(name, RateWord::Interval) => {
                self.map.key(
                    "rate_hz",
                    &number(rate.hz),
                    check(format!(
                        "the scalar `{name}` states the interval, by its name"
                    )),
                );
            }
            RateOrigin::Times(times) => {
                self.map.key(
                    "time",
                    &quoted(&times.name),
                    sure(format!("an array of times of the same length, {hz} Hz")),
                );
                let seconds = times.factor * times.unit.unit.seconds().unwrap_or(1.0);
                if seconds != 1.0 || !times.unit.is_sure {
                    let reason = Reason {
                        text: match times.factor == 1.0 {
                            true => times.unit.reason.clone(),
                            false => format!("{}, times the scale of the array", times.unit.reason),
                        },
                        is_sure: times.unit.is_sure,
                    };
                    self.map.key("seconds_per_unit", &number(seconds), reason);
                }
            }
            RateOrigin::Duration => {
                let text = "no file states it: with this rate it lasts as long as the other arrays";
                self.map.key("rate_hz", &number(rate.hz), check(text));
            }
        }
    }
}
