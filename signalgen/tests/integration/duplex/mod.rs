//! Both directions over a stepped host: the same callbacks that a sound card calls, under an allocator that aborts the process
//! if one of them allocates.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

mod callbacks;
mod devices_refused;
mod stepped_card;
mod streams;
