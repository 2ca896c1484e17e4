//! Decoding of messages from a byte stream.

use core::marker::PhantomData;

use crate::frame::{LONGEST_BYTES, Refused, decode};
use crate::from_box::FromBox;
use crate::to_box::ToBox;

/// Messages sent by one end of the line.
pub trait Message: Sized {
    /// Parses a message; `None` if the kind is unknown or the fields do not fit.
    fn parse(kind: u8, fields: &[u8]) -> Option<Self>;
}

impl Message for FromBox {
    fn parse(kind: u8, fields: &[u8]) -> Option<Self> {
        Self::read(kind, fields)
    }
}

impl Message for ToBox {
    fn parse(kind: u8, fields: &[u8]) -> Option<Self> {
        Self::read(kind, fields)
    }
}

/// Decodes the messages of one end from a byte stream, and resynchronises at each zero byte.
#[derive(Debug)]
pub struct Listener<M> {
    encoded: [u8; LONGEST_BYTES],
    length: usize,
    overlong: bool,
    message: PhantomData<M>,
}

impl<M> Default for Listener<M> {
    fn default() -> Self {
        Self {
            encoded: [0; LONGEST_BYTES],
            length: 0,
            overlong: false,
            message: PhantomData,
        }
    }
}

impl<M: Message> Listener<M> {
    /// Takes a byte; returns the message that it completes, or the reason for rejecting it.
    pub fn hear(&mut self, byte: u8) -> Option<Result<M, Refused>> {
        if byte != 0 {
            match self.encoded.get_mut(self.length) {
                Some(place) => {
                    *place = byte;
                    self.length += 1;
                }
                None => self.overlong = true,
            }
            return None;
        }
        let length = core::mem::take(&mut self.length);
        if core::mem::take(&mut self.overlong) {
            return Some(Err(Refused::Torn));
        }
        // Two zeros in a row delimit no frame.
        (length > 0).then(|| {
            let (kind, fields) = decode(&mut self.encoded[..length])?;
            M::parse(kind, fields).ok_or(Refused::Unknown)
        })
    }
}
