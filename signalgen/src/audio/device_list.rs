//! Devices of a host.

use cpal::{
    Device, DeviceDirection, Host, SupportedStreamConfigRange,
    traits::{DeviceTrait, HostTrait},
};

use super::{
    audio_error::AudioError,
    choice::choose,
    quiet,
    sound_device::{
        Capability, DeviceInfo, Offer, RateRange, is_alsa_hardware, names_an_alsa_card,
        sound_cards_first,
    },
};
use crate::stream_health::StreamDirection;

/// Returns every device of the host with its capabilities, sound cards before purely software devices.
///
/// # Errors
/// If the host no longer answers.
pub fn list_devices(host: &Host) -> Result<Vec<DeviceInfo>, AudioError> {
    let mut devices: Vec<DeviceInfo> = enumerate(host)?.into_iter().map(|(info, _)| info).collect();
    sound_cards_first(&mut devices);
    Ok(devices)
}

/// Returns the devices of the host, in the host's order.
pub(super) fn enumerate(host: &Host) -> Result<Vec<(DeviceInfo, Device)>, AudioError> {
    // Repeated here because ALSA keeps one error handler per thread.
    quiet::silence_alsa();
    let devices = host
        .devices()
        .map_err(|error| AudioError::HostUnavailable {
            host: host.id().to_string(),
            reason: error.to_string(),
        })?;
    Ok(devices
        .filter_map(|device| {
            let id = device.id().ok()?;
            let description = device.description().ok()?;
            // A JACK device lists the configurations of both directions, whichever it has.
            let is_unknown = description.direction() == DeviceDirection::Unknown;
            let has_output =
                description.supports_output() || (is_unknown && device.supports_output());
            let has_input = description.supports_input() || (is_unknown && device.supports_input());
            let is_alsa = id.host().to_string() == "alsa";
            let info = DeviceInfo {
                id: id.to_string(),
                name: description.name().to_owned(),
                is_raw: !is_alsa || is_alsa_hardware(id.id()),
                is_sound_card: !is_alsa || names_an_alsa_card(id.id()),
                output: has_output.then(|| offer(device.supported_output_configs())),
                input: has_input.then(|| offer(device.supported_input_configs())),
            };
            Some((info, device))
        })
        .collect())
}

fn offer(ranges: Result<impl Iterator<Item = SupportedStreamConfigRange>, cpal::Error>) -> Offer {
    let Ok(ranges) = ranges else {
        return Offer::Unreported;
    };
    let capabilities = ranges.map(|range| Capability {
        channels: range.channels(),
        rates: RateRange::new(range.min_sample_rate(), range.max_sample_rate()),
        format: range.sample_format().to_string(),
    });
    Offer::Listed(capabilities.collect())
}

/// Returns the output device that `name` names, for sound other than the drive's.
///
/// # Errors
/// If `name` matches no device, or several; the error lists the candidates.
pub fn output_device(host: &Host, name: &str) -> Result<Device, AudioError> {
    let (infos, mut devices): (Vec<_>, Vec<_>) = enumerate(host)?.into_iter().unzip();
    let index = choose(&infos, name, StreamDirection::Output)?;
    Ok(devices.swap_remove(index))
}
