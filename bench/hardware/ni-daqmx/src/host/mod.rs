//! The card as a host of streams.

mod card_host;
mod deskew;
mod duplex;
mod plan;

pub(crate) use card_host::host;
