#![doc = include_str!("../README.md")]
#![expect(
    unsafe_code,
    reason = "C functions with the names and prototypes of NI's header"
)]

mod analog;
mod cards;
mod digital;
mod exchange;
mod own_apparatus;
mod status;
mod tasks;
mod timing;
mod twin;
