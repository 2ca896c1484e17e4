//! Texts of the participant's screen, and the operator's words to the participant: in English, French, German or Dutch, or in a laboratory's own words.
//!
//! A protocol names one [`Language`] and may replace any text by its own ([`OwnTexts`]); [`Texts`] combines both.
//!
//! ```
//! use participant_texts::{Language, OwnTexts, Texts};
//!
//! let own: OwnTexts = toml::from_str("wait = \"Un moment\"")?;
//! let texts = Texts::in_language(Language::Fr).replaced_by(&own);
//! assert_eq!(texts.wait, "Un moment");
//! assert_eq!(texts.follow_slider, "Suivez le curseur");
//! assert_eq!(texts.number(0.62, 2), "0,62");
//! # Ok::<(), toml::de::Error>(())
//! ```

mod instruction;
mod language;
mod table;
mod wording;

pub use instruction::{Instruction, RepeatCause};
pub use language::Language;
pub use table::{OwnTexts, Texts};
pub use wording::{LONGEST_TEXT, RefusedText};
