//! The devices of a bench behind one assembly: sound card, force sensor, encoder, digital lines, loudspeaker.
//!
//! [`Bench::open`] wires [`Hardware`], found or simulated by the composition root, into tasks, and its [`Life`] runs
//! them. This package does not distinguish real from simulated hardware.

pub mod acquisition;
mod arming;
mod assembly;
mod batch_queue;
mod boot;
mod card_frames;
mod card_pace;
mod card_silence;
pub mod claim;
mod device_nodes;
pub mod dose_account;
mod dose_record;
pub mod drive_control;
mod drive_ledger;
pub mod driving_time;
pub mod encoder;
pub mod estop_press;
pub mod excerpt;
mod field_reading;
pub mod field_task;
pub mod flags;
mod gauges;
mod heat_record;
mod life;
mod lock_folder;
pub mod lost_frames;
pub mod loudspeaker;
mod machine;
mod output_gap;
pub mod plate_warmth;
mod reading_queue;
pub mod recorded_bench;
mod recorded_clocks;
pub mod room;
mod signals;
mod stream_threads;
#[cfg(test)]
mod testing;
mod thread_priority;
mod tuning;

pub use arming::{
    ArmingError, NotWired, plate_heat, require_armable, require_watched, safety_limits,
    unloaded_amplitude_m,
};
pub use assembly::{Bench, Hardware, OpenHardware};
pub use batch_queue::{BatchSender, BatchesDropped, batch_queue};
pub use boot::Boot;
pub use card_pace::CardPace;
pub use device_nodes::sound_card;
pub use dose_record::AccountOwner;
pub use drive_ledger::DriveLedger;
pub use gauges::{DeviceReadings, FieldHealth, NotableClock, SensorClocks};
pub use life::{EndedByPanic, Life};
pub use lock_folder::lock_folder;
pub use reading_queue::{ReadingSender, reading_queue};
pub use signals::{Listening, before_a_hard_end, stop_on_signals};
pub use stream_threads::StreamThreads;
pub use thread_priority::ThreadPriorities;
pub use tuning::{Tuning, impedance_chain};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
