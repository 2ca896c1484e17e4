//! TDMS written byte by byte from National Instruments' note.

/// Type of samples or of a property.
#[derive(Clone, Copy)]
pub struct Type(pub u32);

pub const I16: Type = Type(2);
pub const I32: Type = Type(3);
pub const U8: Type = Type(5);
pub const U32: Type = Type(7);
pub const F32: Type = Type(9);
pub const F64: Type = Type(10);
pub const TEXT: Type = Type(0x20);
pub const TIME: Type = Type(0x44);
pub const COMPLEX64: Type = Type(0x0008_000c);
pub const COMPLEX128: Type = Type(0x0010_000d);
pub const DAQMX: Type = Type(0xffff_ffff);

/// Bits of a segment's mask.
pub const METADATA: u32 = 1 << 1;
pub const NEW_LIST: u32 = 1 << 2;
pub const RAW: u32 = 1 << 3;
pub const INTERLEAVED: u32 = 1 << 5;
pub const BIG_ENDIAN: u32 = 1 << 6;
pub const DAQMX_RAW: u32 = 1 << 7;

/// Bytes in one order.
#[derive(Clone)]
pub struct Bytes {
    pub bytes: Vec<u8>,
    is_big_endian: bool,
}

impl Bytes {
    pub fn new(is_big_endian: bool) -> Self {
        let bytes = Vec::new();
        Self {
            bytes,
            is_big_endian,
        }
    }

    /// Adds a number whose bytes are given from the least significant.
    pub fn add(mut self, little: &[u8]) -> Self {
        let mut bytes = little.to_vec();
        if self.is_big_endian {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
        self
    }

    pub fn u32(self, value: u32) -> Self {
        self.add(&value.to_le_bytes())
    }

    pub fn u64(self, value: u64) -> Self {
        self.add(&value.to_le_bytes())
    }

    pub fn text(self, text: &str) -> Self {
        let mut bytes = self.u32(text.len() as u32);
        bytes.bytes.extend(text.as_bytes());
        bytes
    }

    pub fn i16s(self, values: impl IntoIterator<Item = i16>) -> Self {
        let mut values = values.into_iter();
        values
            .by_ref()
            .fold(self, |bytes, value| bytes.add(&value.to_le_bytes()))
    }

    pub fn f64s(self, values: impl IntoIterator<Item = f64>) -> Self {
        let mut values = values.into_iter();
        values
            .by_ref()
            .fold(self, |bytes, value| bytes.add(&value.to_le_bytes()))
    }

    pub fn f32s(self, values: impl IntoIterator<Item = f32>) -> Self {
        let mut values = values.into_iter();
        values
            .by_ref()
            .fold(self, |bytes, value| bytes.add(&value.to_le_bytes()))
    }
}

/// A property.
#[derive(Clone)]
pub enum Property {
    F64(&'static str, f64),
    U32(&'static str, u32),
    Text(&'static str, &'static str),
    Time(&'static str, i64, u64),
}

/// Samples of an object in the metadata.
#[derive(Clone)]
pub enum Index {
    None,
    AsBefore,
    Plain(Type, u64),
    Text {
        values: u64,
        bytes: u64,
    },
    Daqmx {
        mark: u32,
        values: u64,
        scalers: Vec<Scaler>,
        widths: Vec<u32>,
    },
}

/// A scaler of DAQmx: type, buffer, offset (bytes, or bits of a line), number.
#[derive(Clone, Copy)]
pub struct Scaler(pub u32, pub u32, pub u32, pub u32);

/// Metadata of one object.
pub fn object(bytes: Bytes, path: &str, index: &Index, properties: &[Property]) -> Bytes {
    let bytes = bytes.text(path);
    let bytes = match index {
        Index::None => bytes.u32(0xffff_ffff),
        Index::AsBefore => bytes.u32(0),
        Index::Plain(kind, values) => bytes.u32(20).u32(kind.0).u32(1).u64(*values),
        Index::Text {
            values,
            bytes: size,
        } => bytes.u32(28).u32(TEXT.0).u32(1).u64(*values).u64(*size),
        Index::Daqmx {
            mark,
            values,
            scalers,
            widths,
        } => {
            let bytes = bytes.u32(*mark).u32(DAQMX.0).u32(1).u64(*values);
            let bytes = scalers
                .iter()
                .fold(bytes.u32(scalers.len() as u32), |bytes, scaler| {
                    let bytes = bytes.u32(scaler.0).u32(scaler.1).u32(scaler.2);
                    let bytes = if *mark == 0x1269 {
                        bytes.u32(0)
                    } else {
                        bytes.add(&[0])
                    };
                    bytes.u32(scaler.3)
                });
            let bytes = bytes.u32(widths.len() as u32);
            widths.iter().fold(bytes, |bytes, width| bytes.u32(*width))
        }
    };
    properties.iter().fold(
        bytes.u32(properties.len() as u32),
        |bytes, property| match property {
            Property::F64(name, value) => bytes.text(name).u32(F64.0).add(&value.to_le_bytes()),
            Property::U32(name, value) => bytes.text(name).u32(U32.0).u32(*value),
            Property::Text(name, text) => bytes.text(name).u32(TEXT.0).text(text),
            Property::Time(name, seconds, fraction) => {
                let mut time = fraction.to_le_bytes().to_vec();
                time.extend(seconds.to_le_bytes());
                bytes.text(name).u32(TIME.0).add(&time)
            }
        },
    )
}

/// A segment: its mask without the byte order, its metadata if it has any, its samples.
pub struct Segment {
    pub mask: u32,
    pub is_big_endian: bool,
    pub objects: Vec<(&'static str, Index, Vec<Property>)>,
    pub samples: Vec<u8>,
}

impl Segment {
    pub fn bytes(&self) -> Vec<u8> {
        self.with_length(None)
    }

    /// Returns the segment as a writer leaves it that was killed.
    pub fn unfinished(&self) -> Vec<u8> {
        self.with_length(Some(u64::MAX))
    }

    fn with_length(&self, stated: Option<u64>) -> Vec<u8> {
        let order = self.is_big_endian;
        let metadata = if self.mask & METADATA != 0 {
            let count = Bytes::new(order).u32(self.objects.len() as u32);
            let objects = self.objects.iter();
            objects.fold(count, |bytes, (path, index, properties)| {
                object(bytes, path, index, properties)
            })
        } else {
            Bytes::new(order)
        };
        let metadata = metadata.bytes;
        let length = (metadata.len() + self.samples.len()) as u64;
        let mask = self.mask | if order { BIG_ENDIAN } else { 0 };
        let mut bytes = b"TDSm".to_vec();
        bytes.extend(mask.to_le_bytes());
        let rest = Bytes::new(order)
            .u32(4713)
            .u64(stated.unwrap_or(length))
            .u64(metadata.len() as u64);
        bytes.extend(rest.bytes);
        bytes.extend(metadata);
        bytes.extend(&self.samples);
        bytes
    }
}
