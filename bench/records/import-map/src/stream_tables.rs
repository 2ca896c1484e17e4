//! Reading of the tables of forces, position and intervals.

use interval_rules::Rule;

use crate::check::{Check, RawClocking, RawTime};
use crate::map::Intervals;
use crate::raw::{RawIntervals, RawLateral, RawNormal};
use crate::streams::{
    ArraySource, Clock, Lateral, LateralTare, Normal, NormalTare, Position, TimeBase, Travel,
};
use crate::value::{LateralTareWord, NormalTareWord, NumberOr};

impl Check<'_> {
    pub fn normal(&mut self, table: RawNormal, drive_time: Option<&TimeBase>) -> Option<Normal> {
        let source = self.source("normal", table.file.as_deref(), table.from);
        let time = RawTime {
            rate_hz: table.rate_hz,
            time: table.time,
            seconds_per_unit: table.seconds_per_unit,
        };
        let clock = RawClocking {
            clock: table.clock,
            offset_s: table.offset_s,
            ppm: table.ppm,
        };
        let clock = self.clock("normal", clock, None);
        // Samples on the drive's clock are its own samples unless another rate is stated.
        let following = drive_time.filter(|_| clock.is_none_or(|clock| clock.is_drives));
        let time = self.time("normal", time, following);
        let newtons_per_unit = self.scale("normal", "newtons_per_unit", table.newtons_per_unit);
        let tare = match table.tare {
            None | Some(NumberOr::Word(NormalTareWord::None)) => Some(NormalTare::Stated(0.0)),
            Some(NumberOr::Word(NormalTareWord::NoContact)) => Some(NormalTare::NoContact),
            Some(NumberOr::Number(value)) => {
                self.finite("normal.tare", value).map(NormalTare::Stated)
            }
        };
        Some(Normal {
            source: source?,
            time: time?,
            clock: clock?,
            newtons_per_unit: newtons_per_unit?,
            tare: tare?,
        })
    }

    pub fn lateral(
        &mut self,
        table: RawLateral,
        normal: Option<&(TimeBase, Clock)>,
    ) -> Option<Lateral> {
        let source = self.source("lateral", table.file.as_deref(), table.from);
        let time = RawTime {
            rate_hz: table.rate_hz,
            time: table.time,
            seconds_per_unit: table.seconds_per_unit,
        };
        let clock = RawClocking {
            clock: table.clock,
            offset_s: table.offset_s,
            ppm: table.ppm,
        };
        let time = self.time("lateral", time, normal.map(|(time, _)| time));
        let clock = self.clock("lateral", clock, normal.map(|(_, clock)| *clock));
        let newtons_per_unit = self.scale("lateral", "newtons_per_unit", table.newtons_per_unit);
        let tare = match table.tare {
            None | Some(NumberOr::Word(LateralTareWord::None)) => Some(LateralTare::Stated(0.0)),
            Some(NumberOr::Word(LateralTareWord::NoContact)) => Some(LateralTare::NoContact),
            Some(NumberOr::Word(LateralTareWord::SymmetricStrokes)) => {
                Some(LateralTare::SymmetricStrokes)
            }
            Some(NumberOr::Number(value)) => {
                self.finite("lateral.tare", value).map(LateralTare::Stated)
            }
        };
        Some(Lateral {
            source: source?,
            time: time?,
            clock: clock?,
            newtons_per_unit: newtons_per_unit?,
            tare: tare?,
        })
    }

    pub fn place(
        &mut self,
        table: &'static str,
        (source, time, clock, travel): (Option<ArraySource>, RawTime, RawClocking, Option<Travel>),
        normal: Option<&(TimeBase, Clock)>,
    ) -> Option<Position> {
        let time = self.time(table, time, normal.map(|(time, _)| time));
        let clock = self.clock(table, clock, normal.map(|(_, clock)| *clock));
        Some(Position {
            source: source?,
            time: time?,
            clock: clock?,
            travel: travel?,
        })
    }

    pub fn intervals(&mut self, raw: Option<RawIntervals>) -> Option<Intervals> {
        let Some(raw) = raw else {
            return Some(Intervals::Rules {
                unloaded: None,
                exploration: None,
            });
        };
        if let Some(marks) = &raw.marks {
            for (key, rule) in [
                ("unloaded", &raw.unloaded),
                ("exploration", &raw.exploration),
            ] {
                if rule.is_some() {
                    self.wrong(
                        &format!("intervals.{key}"),
                        "and `marks` both state intervals: delete one",
                    );
                }
            }
            let marks = self.template("intervals.marks", Some(marks)).ok()??;
            return Some(Intervals::Marks(marks));
        }
        let rule = |check: &mut Self, key: &str, text: Option<&str>| match text.map(Rule::parse) {
            None => Some(None),
            Some(Ok(rule)) => Some(Some(rule)),
            Some(Err(error)) => {
                check.wrong(key, format!("= {error}"));
                None
            }
        };
        let unloaded = rule(self, "intervals.unloaded", raw.unloaded.as_deref());
        let exploration = rule(self, "intervals.exploration", raw.exploration.as_deref());
        Some(Intervals::Rules {
            unloaded: unloaded?,
            exploration: exploration?,
        })
    }
}
