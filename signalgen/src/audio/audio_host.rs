//! Audio hosts: the platform's default, JACK, or a supplied one.

use cpal::{Host, HostId};

use super::{audio_error::AudioError, quiet};

/// The host to open.
pub enum HostChoice {
    /// The platform's default: ALSA on Linux.
    Default,
    /// ALSA.
    Alsa,
    /// A running JACK server (the one that `JACK_DEFAULT_SERVER` names). Needs the feature `jack`.
    Jack,
    /// A host from elsewhere, such as the simulated apparatus.
    Supplied(Host),
}

/// Opens a host. Does not panic on a machine without sound.
///
/// # Errors
/// If the host does not exist or does not answer: no ALSA configuration, no JACK server.
pub fn open_host(choice: HostChoice) -> Result<Host, AudioError> {
    quiet::silence_alsa();
    match choice {
        HostChoice::Supplied(host) => Ok(host),
        HostChoice::Alsa => host_by_name("alsa"),
        HostChoice::Jack => jack(),
        HostChoice::Default => {
            if cfg!(target_os = "linux") {
                return host_by_name("alsa");
            }
            // `default_host()` would panic if there is no host.
            cpal::available_hosts()
                .into_iter()
                .find(|id| !["jack", "custom"].contains(&id.to_string().as_str()))
                .ok_or_else(|| unavailable("default", "this system has none"))
                .and_then(host_by_id)
        }
    }
}

#[cfg(feature = "jack")]
fn jack() -> Result<Host, AudioError> {
    use cpal::traits::HostTrait;

    quiet::silence_jack();
    let host = host_by_name("jack")?;
    let has_devices = host
        .devices()
        .is_ok_and(|mut devices| devices.next().is_some());
    if has_devices {
        Ok(host)
    } else {
        Err(unavailable(
            "jack",
            "no JACK server answers; start jackd, or name it in JACK_DEFAULT_SERVER",
        ))
    }
}

#[cfg(not(feature = "jack"))]
fn jack() -> Result<Host, AudioError> {
    Err(unavailable(
        "jack",
        "this program was built without JACK; build it with `cargo build --release -p friction-bench --features jack`, or set \
         host = \"native\" in [audio]",
    ))
}

fn unavailable(host: &str, reason: &str) -> AudioError {
    AudioError::HostUnavailable {
        host: host.to_owned(),
        reason: reason.to_owned(),
    }
}

fn host_by_name(name: &str) -> Result<Host, AudioError> {
    let id: HostId = name
        .parse()
        .map_err(|error: cpal::Error| unavailable(name, &error.to_string()))?;
    host_by_id(id)
}

fn host_by_id(id: HostId) -> Result<Host, AudioError> {
    cpal::host_from_id(id).map_err(|error| unavailable(&id.to_string(), &error.to_string()))
}
