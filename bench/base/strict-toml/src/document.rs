//! A parsed TOML document as serde's source of data.
//!
//! The `toml` crate's own deserialisers offer each struct five kinds of maps and sequences (tables, dates, values with their
//! places), and the compiler writes the struct's reader for each of them. Here a struct is read from a table and from nothing
//! else: the program compiles a third of the code, and an array in place of a table is an error.

use std::fmt::Display;
use std::ops::Range;

use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error, Expected, IntoDeserializer,
    MapAccess, SeqAccess, Unexpected, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use toml::Spanned;
use toml::de::{DeArray, DeFloat, DeInteger, DeString, DeTable, DeValue};

/// A value or key that the type read does not accept.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(crate) struct Mismatch {
    /// Serde's description.
    pub message: String,
    /// Keys from the top of the document to the value.
    pub keys: Vec<String>,
    /// Place in the text, bytes.
    pub span: Option<Range<usize>>,
}

impl Mismatch {
    fn at(mut self, span: &Range<usize>) -> Self {
        self.span.get_or_insert_with(|| span.clone());
        self
    }

    fn under(mut self, key: &str) -> Self {
        self.keys.insert(0, key.to_owned());
        self
    }
}

impl Error for Mismatch {
    fn custom<T: Display>(message: T) -> Self {
        Self {
            message: message.to_string(),
            keys: Vec::new(),
            span: None,
        }
    }
}

/// Reads a document into `T`.
pub(crate) fn read<T: DeserializeOwned>(document: Spanned<DeTable<'_>>) -> Result<T, Mismatch> {
    let span = document.span();
    T::deserialize(Node {
        value: DeValue::Table(document.into_inner()),
        span,
    })
}

/// A value and its place.
struct Node<'de> {
    value: DeValue<'de>,
    span: Range<usize>,
}

impl<'de> From<Spanned<DeValue<'de>>> for Node<'de> {
    fn from(value: Spanned<DeValue<'de>>) -> Self {
        let span = value.span();
        Self {
            value: value.into_inner(),
            span,
        }
    }
}

fn integer(number: &DeInteger<'_>) -> Option<i64> {
    i64::from_str_radix(number.as_str(), number.radix()).ok()
}

fn large_integer(number: &DeInteger<'_>) -> Option<u64> {
    u64::from_str_radix(number.as_str(), number.radix()).ok()
}

fn float(number: &DeFloat<'_>) -> Option<f64> {
    let text = number.as_str();
    let value: f64 = text.parse().ok()?;
    // TOML's `inf` is infinite, a number with too large an exponent is not.
    (value.is_finite() || value.is_nan() || text.contains("inf")).then_some(value)
}

impl Node<'_> {
    fn wrong_type(&self, expected: &dyn Expected) -> Mismatch {
        let date;
        let unexpected = match &self.value {
            DeValue::String(text) => Unexpected::Str(text),
            DeValue::Integer(number) => {
                integer(number).map_or(Unexpected::Other("a large integer"), Unexpected::Signed)
            }
            DeValue::Float(number) => {
                float(number).map_or(Unexpected::Other("a large number"), Unexpected::Float)
            }
            DeValue::Boolean(value) => Unexpected::Bool(*value),
            DeValue::Datetime(value) => {
                date = format!("date {value}");
                Unexpected::Other(&date)
            }
            DeValue::Array(_) => Unexpected::Seq,
            DeValue::Table(_) => Unexpected::Map,
        };
        Mismatch::invalid_type(unexpected, expected).at(&self.span)
    }
}

impl<'de> Deserializer<'de> for Node<'de> {
    type Error = Mismatch;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mismatch> {
        let span = self.span.clone();
        match self.value {
            DeValue::String(DeString::Owned(text)) => visitor.visit_string(text),
            DeValue::String(DeString::Borrowed(text)) => visitor.visit_borrowed_str(text),
            DeValue::Integer(number) => match (integer(&number), large_integer(&number)) {
                (Some(value), _) => visitor.visit_i64(value),
                (None, Some(value)) => visitor.visit_u64(value),
                (None, None) => Err(Mismatch::custom("the number is too large")),
            },
            DeValue::Float(number) => match float(&number) {
                Some(value) => visitor.visit_f64(value),
                None => Err(Mismatch::custom("the number is too large")),
            },
            DeValue::Boolean(value) => visitor.visit_bool(value),
            DeValue::Datetime(_) => return Err(self.wrong_type(&visitor)),
            DeValue::Array(entries) => visitor.visit_seq(Entries(entries.into_iter())),
            DeValue::Table(table) => visitor.visit_map(Rows::new(table)),
        }
        .map_err(|mismatch| mismatch.at(&span))
    }

    /// Reads a struct, from a table alone.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        match self.value {
            DeValue::Table(table) => visitor
                .visit_map(Rows::new(table))
                .map_err(|mismatch| mismatch.at(&self.span)),
            _ => Err(self.wrong_type(&visitor)),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mismatch> {
        let span = self.span.clone();
        visitor
            .visit_some(self)
            .map_err(|mismatch| mismatch.at(&span))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        let span = self.span.clone();
        visitor
            .visit_newtype_struct(self)
            .map_err(|mismatch| mismatch.at(&span))
    }

    /// Reads a variant: its name, or a table with its name and its value.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        let Self { value, span } = self;
        let variant = match value {
            DeValue::String(name) => Variant { name, value: None },
            DeValue::Table(table) if table.len() == 1 => {
                let entry = table.into_iter().next();
                let (name, value) = entry.ok_or_else(|| Mismatch::custom("an empty table"))?;
                Variant {
                    name: name.into_inner(),
                    value: Some(value.into()),
                }
            }
            value => return Err(Self { value, span }.wrong_type(&visitor)),
        };
        visitor
            .visit_enum(variant)
            .map_err(|mismatch| mismatch.at(&span))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier ignored_any
    }
}

impl<'de> IntoDeserializer<'de, Mismatch> for Node<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

struct Entries<'de>(<DeArray<'de> as IntoIterator>::IntoIter);

impl<'de> SeqAccess<'de> for Entries<'de> {
    type Error = Mismatch;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Mismatch> {
        let entry = self.0.next();
        entry
            .map(|entry| seed.deserialize(Node::from(entry)))
            .transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// Keys and values of a table.
struct Rows<'de> {
    rows: <DeTable<'de> as IntoIterator>::IntoIter,
    value: Option<(Spanned<DeString<'de>>, Node<'de>)>,
}

impl<'de> Rows<'de> {
    fn new(table: DeTable<'de>) -> Self {
        Self {
            rows: table.into_iter(),
            value: None,
        }
    }
}

impl<'de> MapAccess<'de> for Rows<'de> {
    type Error = Mismatch;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Mismatch> {
        let Some((key, value)) = self.rows.next() else {
            return Ok(None);
        };
        let name: StrDeserializer<'_, Mismatch> = key.get_ref().as_ref().into_deserializer();
        let found = seed
            .deserialize(name)
            .map_err(|mismatch| mismatch.at(&key.span()))?;
        self.value = Some((key, value.into()));
        Ok(Some(found))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Mismatch> {
        let Some((key, value)) = self.value.take() else {
            return Err(Mismatch::custom("a value without its key"));
        };
        let span = value.span.clone();
        seed.deserialize(value)
            .map_err(|mismatch| mismatch.at(&span).under(key.get_ref()))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rows.len())
    }
}

struct Variant<'de> {
    name: DeString<'de>,
    value: Option<Node<'de>>,
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = Mismatch;
    type Variant = Content<'de>;

    fn variant_seed<V: DeserializeSeed<'de>>(
        self,
        seed: V,
    ) -> Result<(V::Value, Content<'de>), Mismatch> {
        let name: StrDeserializer<'_, Mismatch> = self.name.as_ref().into_deserializer();
        Ok((seed.deserialize(name)?, Content(self.value)))
    }
}

/// The value of a variant, if it has one.
struct Content<'de>(Option<Node<'de>>);

impl<'de> Content<'de> {
    fn node(self, expected: &str) -> Result<Node<'de>, Mismatch> {
        self.0
            .ok_or_else(|| Mismatch::invalid_type(Unexpected::UnitVariant, &expected))
    }
}

impl<'de> VariantAccess<'de> for Content<'de> {
    type Error = Mismatch;

    fn unit_variant(self) -> Result<(), Mismatch> {
        self.0.map_or(Ok(()), |node| {
            Err(node.wrong_type(&"a variant without a value"))
        })
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Mismatch> {
        seed.deserialize(self.node("a variant with a value")?)
    }

    fn tuple_variant<V: Visitor<'de>>(
        self,
        _length: usize,
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        self.node("a variant with values")?.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mismatch> {
        let node = self.node("a variant with a table")?;
        node.deserialize_struct("", fields, visitor)
    }
}
