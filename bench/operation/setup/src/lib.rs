#![doc = include_str!("../README.md")]

mod ask;
mod card;
mod device_name;
mod force_sensor;
pub mod inventory;
mod ni_card;
mod options;
mod rig;
mod sheet;
mod steps;
mod twin;
mod write;

pub use ask::{Ask, NoOperator, Terminal};
pub use options::{ForceLine, InitOptions};
pub use rig::Rig;
pub use write::{Written, write};
