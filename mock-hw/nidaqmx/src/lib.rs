#![doc = include_str!("../README.md")]
#![expect(
    unsafe_code,
    reason = "C functions with the names and prototypes of NI's header"
)]
#![expect(
    clippy::missing_safety_doc,
    reason = "as the functions of NI's header: pointers are null or of the lengths that are named"
)]
#![expect(clippy::too_many_arguments, reason = "as the functions of NI's header")]

mod analog;
mod cards;
mod digital;
mod exchange;
mod own_apparatus;
mod status;
mod tasks;
mod timing;
mod twin;
