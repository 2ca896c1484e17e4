//! Table of the faults that can be rehearsed.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::table::{Amount, FaultRow, Lasts, Needs, RealAction, Remedy, Required, Within};

/// Time within which an e-stop, a stop line or the read-back stops the drive, s (FAULTS.md, row 16).
const AT_ONCE: Required = Required::Stop(Within::Seconds(0.05));
/// Time within which a changed gain is detected, s: it shows at crests of the published modulation, one every 167 ms.
const AT_A_CREST: Required = Required::Stop(Within::Seconds(0.25));
/// Time added to the longest silence, s: one burst of the sensor, a few checks by the watch, and the ramp.
const AFTER_SILENCE: Required = Required::Stop(Within::SilenceAnd(0.05));
/// Time within which a force over its limit stops the drive, s; weights and fingers load the plate gradually.
const FORCE_STOP: Required = Required::Stop(Within::Seconds(0.1));

/// Declares the faults with their rows, so that each is named once.
macro_rules! faults {
    ($($kind:ident = $row:expr;)+) => {
        /// A fault that can be rehearsed; [`FaultKind::row`] describes it.
        ///
        /// ```
        /// use faults::FaultKind;
        ///
        /// assert_eq!("estop".parse(), Ok(FaultKind::Estop));
        /// let unknown = "e-stop".parse::<FaultKind>().unwrap_err();
        /// assert_eq!(unknown.nearest.as_deref(), Some("estop"));
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Deserialize, Serialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum FaultKind {
            $(#[doc = "See [`FaultKind::row`]."] $kind,)+
        }

        impl FaultKind {
            /// All faults, in the order of the table.
            pub const ALL: &'static [Self] = &[$(Self::$kind),+];

            /// Returns the fault's row of the table.
            #[must_use]
            pub const fn row(self) -> FaultRow {
                match self {
                    $(Self::$kind => $row,)+
                }
            }
        }
    };
}

/// Returns the row of a fault that stops the drive, lasts until its end and is re-armed after `removed`.
const fn stop(
    name: &'static str,
    words: &'static str,
    row: u8,
    required: Required,
    removed: &'static str,
) -> FaultRow {
    FaultRow {
        name,
        words,
        row: Some(row),
        amount: None,
        lasts: Lasts::Until,
        required,
        remedy: Remedy::Rearm(removed),
        real: None,
    }
}

/// Returns the row of a fault that stops the drive for good; after `mended`, the program must be restarted.
const fn lost(
    name: &'static str,
    words: &'static str,
    row: u8,
    required: Required,
    mended: &'static str,
) -> FaultRow {
    FaultRow {
        lasts: Lasts::ForGood,
        remedy: Remedy::Restart(mended),
        ..stop(name, words, row, required, mended)
    }
}

/// Returns the row of a fault that the recording marks; its argument `what` is a number of frames.
const fn flag(
    name: &'static str,
    words: &'static str,
    row: u8,
    what: &'static str,
    (high, default): (f64, f64),
) -> FaultRow {
    FaultRow {
        amount: Some(Amount {
            name: what,
            unit: "frames",
            low: 1.0,
            high,
            default,
            whole: true,
        }),
        lasts: Lasts::Moment,
        required: Required::Flag,
        remedy: Remedy::Repeat,
        ..stop(name, words, row, Required::Flag, "")
    }
}

/// Returns the row of a force exerted by a person or a weight.
const fn push(name: &'static str, words: &'static str) -> FaultRow {
    FaultRow {
        amount: Some(Amount {
            name: "force",
            unit: "N",
            low: 0.1,
            high: 20.0,
            default: 4.0,
            whole: false,
        }),
        ..stop(name, words, 23, FORCE_STOP, "Take the load off the plate.")
    }
}

const fn by_hand(row: FaultRow, needs: Needs, words: &'static str) -> FaultRow {
    FaultRow {
        real: Some(RealAction { words, needs }),
        ..row
    }
}

faults! {
    Estop = by_hand(
        stop("estop", "the e-stop is pressed", 17, AT_ONCE, "Release the e-stop."),
        Needs::Estop,
        "Press the e-stop now.",
    );
    EstopCut = by_hand(
        stop("estop-cut", "the e-stop's wire is cut", 17, AT_ONCE, "Mend the e-stop's wire."),
        Needs::Estop,
        "Unplug the e-stop's cable at the computer now.",
    );
    EstopBounce = FaultRow {
        amount: Some(Amount { name: "time", unit: "ms", low: 1.0, high: 500.0, default: 20.0, whole: false }),
        ..stop("estop-bounce", "the e-stop is pressed, and its contact bounces", 17, AT_ONCE, "Release the e-stop.")
    };
    AmplifierOff = by_hand(
        stop("amplifier-off", "the amplifier is switched off", 16, AT_ONCE, "Switch the amplifier on."),
        Needs::Amplifier,
        "Switch the amplifier off now.",
    );
    AmplifierGain = FaultRow {
        amount: Some(Amount { name: "gain left", unit: "%", low: 1.0, high: 50.0, default: 50.0, whole: false }),
        ..stop("amplifier-gain", "the amplifier's gain falls", 16, AT_A_CREST, "Set the amplifier's gain back.")
    };
    RelayWelded = FaultRow {
        required: Required::Refuse,
        ..stop("relay-welded", "the amplifier's relay is welded", 19, Required::Refuse, "Replace the relay.")
    };
    GpioRemoved = stop("gpio-removed", "the GPIO chip is removed", 18, AT_ONCE, "Plug the GPIO chip in again.");
    CardLostInput = lost("card-lost-input", "the sound card's input is lost", 5, AT_ONCE, "Plug the sound card in again.");
    CardLostOutput = lost("card-lost-output", "the sound card's output is lost", 5, AT_ONCE, "Plug the sound card in again.");
    InputStops = stop("input-stops", "the input's callbacks stop", 5, AFTER_SILENCE, "Let the sound card run on.");
    OutputStops = stop("output-stops", "the output's callbacks stop", 5, AFTER_SILENCE, "Let the sound card run on.");
    Xrun = flag("xrun", "the input loses frames", 6, "lost", (4_800.0, 192.0));
    XrunOutput = flag("xrun-output", "the output plays silence in the place of frames", 6, "lost", (960.0, 192.0));
    Nan = flag("nan", "input frames are not a number", 9, "spoilt", (4_800.0, 192.0));
    ForceUnplugged = by_hand(
        lost("force-unplugged", "the force sensor is unplugged", 21, AFTER_SILENCE, "Plug the force sensor in again."),
        Needs::ForceSensor,
        "Unplug the force sensor now.",
    );
    ForceSilent = stop("force-silent", "the force sensor sends nothing", 21, AFTER_SILENCE, "Let the force sensor send again.");
    ForceOtherDevice = stop(
        "force-other-device",
        "another device is on the force sensor's port",
        21,
        AFTER_SILENCE,
        "Plug the force sensor into its port.",
    );
    ForceSaturated = stop("force-saturated", "the force sensor's normal axis is at its end", 23, FORCE_STOP, "Take the load off the plate.");
    ForceDropped = flag("force-dropped", "force frames are not sent", 22, "dropped", (300.0, 10.0));
    ForceCorrupted = flag("force-corrupted", "force frames have a wrong bit", 22, "corrupted", (300.0, 10.0));
    ForceRepeated = flag("force-repeated", "force frames are sent twice", 22, "repeated", (300.0, 10.0));
    Press = by_hand(
        push("press", "something presses on the plate"),
        Needs::ForceSensor,
        "Press on the plate with a tool, harder and harder, until the drive stops.",
    );
    Drag = push("drag", "something pulls along the plate");
    ButtonHeld = FaultRow {
        row: None,
        remedy: Remedy::Rearm("Let go of the button."),
        ..stop("button-held", "the participant's button is held down", 0, Required::GoOn, "Let go of the button.")
    };
}

impl FaultKind {
    /// Returns the name in `--fault`, in scenario files and in the drill.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns whether the fault can be given an end.
    #[must_use]
    pub fn ends(self) -> bool {
        self.row().lasts == Lasts::Until
    }

    /// Returns whether a drill includes it: the bench stops, or marks the recording, while it drives.
    #[must_use]
    pub fn is_drilled(self) -> bool {
        matches!(self.row().required, Required::Stop(_) | Required::Flag)
    }

    /// Returns whether the fault affects a force sensor's frames, which a sensor on inputs of the sound card does not send.
    #[must_use]
    pub fn is_of_frames(self) -> bool {
        matches!(
            self,
            Self::ForceDropped
                | Self::ForceCorrupted
                | Self::ForceRepeated
                | Self::ForceOtherDevice
        )
    }

    /// Returns the name with placeholders for times and argument, as in `estop@12s-14s`.
    #[must_use]
    pub fn form(self) -> String {
        let row = self.row();
        let until = if self.ends() { "[-UNTIL]" } else { "" };
        let amount = row
            .amount
            .map(|amount| format!("[:{}]", amount.unit.to_uppercase()))
            .unwrap_or_default();
        format!("{}@TIME{until}{amount}", row.name)
    }

    /// Returns the fault's help text: description, argument, row of FAULTS.md.
    #[must_use]
    pub fn help(self) -> String {
        let row = self.row();
        let amount = row.amount.map(|amount| {
            let Amount {
                name,
                unit,
                low,
                high,
                default,
                ..
            } = amount;
            format!("; {name}: {low} to {high} {unit}, {default} if not given")
        });
        let number = row.row.map(|row| format!(" (row {row})"));
        format!(
            "{}{}{}",
            row.words,
            amount.unwrap_or_default(),
            number.unwrap_or_default()
        )
    }
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Error of a name that matches no fault.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no fault is called `{name}`{}; the faults are: {}", did_you_mean(.nearest), names().join(", "))]
pub struct UnknownFault {
    /// The name.
    pub name: String,
    /// Fault with the most similar name, if any is similar.
    pub nearest: Option<String>,
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map(|name| format!(" (did you mean `{name}`?)"))
        .unwrap_or_default()
}

fn names() -> Vec<&'static str> {
    FaultKind::ALL.iter().map(|kind| kind.name()).collect()
}

impl FromStr for FaultKind {
    type Err = UnknownFault;

    fn from_str(name: &str) -> Result<Self, UnknownFault> {
        let kind = Self::ALL.iter().find(|kind| kind.name() == name);
        kind.copied().ok_or_else(|| UnknownFault {
            name: name.to_owned(),
            nearest: strict_toml::nearest(name, &names()),
        })
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for FaultKind {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "FaultKind".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let variant = |kind: &Self| schemars::json_schema!({ "const": kind.name(), "description": kind.help() });
        let variants: Vec<schemars::Schema> = Self::ALL.iter().map(variant).collect();
        schemars::json_schema!({ "description": "A fault that can be rehearsed.", "oneOf": variants })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_scenario_files_and_each_is_its_own() {
        for (index, kind) in FaultKind::ALL.iter().enumerate() {
            assert_eq!(kind.name().parse(), Ok(*kind));
            let quoted = format!("fault = \"{kind}\"");
            #[derive(Deserialize)]
            struct Table {
                fault: FaultKind,
            }
            let read: Table = strict_toml::parse(&quoted, "test").unwrap();
            assert_eq!(read.fault, *kind, "serde has another name for {kind}");
            assert!(!names()[..index].contains(&kind.name()), "{kind} twice");
        }
    }

    #[test]
    fn rows_are_whole() {
        for kind in FaultKind::ALL {
            let row = kind.row();
            assert!(row.row.is_none_or(|row| (1..=45).contains(&row)), "{kind}");
            if let Some(amount) = row.amount {
                let range = amount.low..=amount.high;
                assert!(range.contains(&amount.default), "{kind}");
            }
            let stops = matches!(row.required, Required::Stop(_));
            assert!(row.real.is_none() || stops, "{kind}: nobody would see it");
            match row.remedy {
                Remedy::Repeat => assert_eq!(row.required, Required::Flag, "{kind}"),
                Remedy::Restart(_) => assert_eq!(row.lasts, Lasts::ForGood, "{kind}"),
                Remedy::Rearm(_) => assert_eq!(row.lasts, Lasts::Until, "{kind}"),
            }
        }
    }

    #[test]
    fn help_states_the_argument_of_a_fault() {
        assert_eq!(FaultKind::Estop.form(), "estop@TIME[-UNTIL]");
        assert_eq!(FaultKind::Xrun.form(), "xrun@TIME[:FRAMES]");
        assert_eq!(
            FaultKind::Xrun.help(),
            "the input loses frames; lost: 1 to 4800 frames, 192 if not given (row 6)"
        );
    }
}
