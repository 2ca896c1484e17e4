#![no_std]
#![doc = include_str!("../README.md")]

mod ads131m02;
mod amplifier;
mod converter;
mod moments;
mod reports;

pub use ads131m02::{Ads131m02, ChannelGain, ConverterFault, OSR};
pub use amplifier::{Amplifier, AmplifierState};
pub use converter::Converter;
pub use moments::{EncoderMoment, Moments};
pub use reports::{Inputs, Reports};
