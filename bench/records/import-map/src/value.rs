//! Values of a map that are a number or a word.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

/// Word that may stand in place of a number.
pub(crate) trait Word: Sized + Copy {
    /// The words.
    const WORDS: &'static [&'static str];

    /// Returns the meaning of a word.
    fn from_word(word: &str) -> Option<Self>;
}

/// Declares an enumeration of words.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($variant:ident = $word:literal),+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum $name { $($variant),+ }

        impl Word for $name {
            const WORDS: &'static [&'static str] = &[$($word),+];

            fn from_word(word: &str) -> Option<Self> {
                match word { $($word => Some(Self::$variant),)+ _ => None }
            }
        }
    };
}

words!(
    /// The value is found in the data.
    FoundWord { Found = "found" }
);
words!(
    /// Carrier that no number states.
    CarrierWord { Found = "found", Follows = "follows" }
);
words!(
    /// Scale of a pickup that no number states.
    ScaleWord { FromModalMass = "from modal mass" }
);
words!(
    /// Tare of the normal force that no number states.
    NormalTareWord { NoContact = "no contact", None = "none" }
);
words!(
    /// Tare of the lateral force that no number states.
    LateralTareWord { NoContact = "no contact", SymmetricStrokes = "symmetric strokes", None = "none" }
);
words!(
    /// Centre of the plate that no number states.
    CentreWord { MiddleOfTravel = "middle of travel" }
);

/// A number or a word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum NumberOr<W> {
    /// The number.
    Number(f64),
    /// The word.
    Word(W),
}

impl<'de, W: Word> Deserialize<'de> for NumberOr<W> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<W>(PhantomData<W>);

        impl<W: Word> Visitor<'_> for Reader<W> {
            type Value = NumberOr<W>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number")?;
                W::WORDS
                    .iter()
                    .try_for_each(|word| write!(f, " or \"{word}\""))
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Self::Value, E> {
                Ok(NumberOr::Number(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Self::Value, E> {
                Ok(NumberOr::Number(value as f64))
            }

            fn visit_str<E: de::Error>(self, word: &str) -> Result<Self::Value, E> {
                W::from_word(word)
                    .map(NumberOr::Word)
                    .ok_or_else(|| E::unknown_variant(word, W::WORDS))
            }
        }
        deserializer.deserialize_any(Reader(PhantomData))
    }
}

/// A number or the name of an array.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NumberOrName {
    /// The number.
    Number(f64),
    /// The name.
    Name(String),
}

impl<'de> Deserialize<'de> for NumberOrName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;

        impl Visitor<'_> for Reader {
            type Value = NumberOrName;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a name in quotation marks")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Self::Value, E> {
                Ok(NumberOrName::Number(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Self::Value, E> {
                Ok(NumberOrName::Number(value as f64))
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(NumberOrName::Name(name.to_owned()))
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

/// Name of an array: a text, or the number of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ArrayName(pub(crate) String);

impl<'de> Deserialize<'de> for ArrayName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;

        impl Visitor<'_> for Reader {
            type Value = ArrayName;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a name in quotation marks or the number of a column")
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Self::Value, E> {
                match value >= 0 {
                    true => Ok(ArrayName(value.to_string())),
                    false => Err(E::invalid_value(de::Unexpected::Signed(value), &self)),
                }
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(ArrayName(name.to_owned()))
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

/// Complex values: one complex array, real and imaginary part, or amplitude and phase.
#[derive(Debug, Clone, PartialEq)]
pub enum ComplexArrays {
    /// One complex array.
    Complex(String),
    /// Real and imaginary part.
    Parts {
        /// Array of the real part.
        real: String,
        /// Array of the imaginary part.
        imaginary: String,
    },
    /// Amplitude and phase.
    Polar {
        /// Array of the amplitude.
        amplitude: String,
        /// Array of the phase.
        phase: String,
        /// Unit of the phase, rad.
        rad_per_unit: f64,
    },
}

impl<'de> Deserialize<'de> for ComplexArrays {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;

        impl<'de> Visitor<'de> for Reader {
            type Value = ComplexArrays;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "[\"real\", \"imaginary\"], the name of a complex array, or { amplitude = \"R\", phase_rad = \"theta\" } (phase_deg for degrees)",
                )
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(ComplexArrays::Complex(name.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut names: A) -> Result<Self::Value, A::Error> {
                let mut parts = Vec::new();
                while let Some(ArrayName(name)) = names.next_element()? {
                    parts.push(name);
                }
                match <[String; 2]>::try_from(parts) {
                    Ok([real, imaginary]) => Ok(ComplexArrays::Parts { real, imaginary }),
                    Err(parts) => Err(de::Error::invalid_length(parts.len(), &self)),
                }
            }

            fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Self::Value, A::Error> {
                const KEYS: &[&str] = &["amplitude", "phase_rad", "phase_deg"];
                let (mut amplitude, mut phase) = (None, None);
                while let Some(key) = table.next_key::<String>()? {
                    let ArrayName(name) = table.next_value()?;
                    match key.as_str() {
                        "amplitude" => amplitude = Some(name),
                        "phase_rad" | "phase_deg" if phase.is_some() => {
                            return Err(de::Error::custom(
                                "has phase_rad and phase_deg: write the one in which the array is",
                            ));
                        }
                        "phase_rad" => phase = Some((name, 1.0)),
                        "phase_deg" => phase = Some((name, 1f64.to_radians())),
                        key => return Err(de::Error::unknown_field(key, KEYS)),
                    }
                }
                let (phase, rad_per_unit) =
                    phase.ok_or_else(|| de::Error::missing_field("phase_rad"))?;
                Ok(ComplexArrays::Polar {
                    amplitude: amplitude.ok_or_else(|| de::Error::missing_field("amplitude"))?,
                    phase,
                    rad_per_unit,
                })
            }
        }
        deserializer.deserialize_any(Reader)
    }
}
