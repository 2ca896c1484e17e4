//! Keeps the audio libraries from printing into the operator's terminal.

/// Sends ALSA's messages of this thread to a buffer instead of stderr; its errors still return as
/// errors. Each call empties the buffer.
#[cfg(target_os = "linux")]
pub(super) fn silence_alsa() {
    // Without the buffer the messages stay on stderr: a nuisance, no fault.
    let _ = alsa::Output::local_error_handler();
}

/// Does nothing: ALSA's messages are redirected on Linux alone.
#[cfg(not(target_os = "linux"))]
pub(super) fn silence_alsa() {}

/// Drops JACK's messages of this process.
#[cfg(feature = "jack")]
pub(super) fn silence_jack() {
    // `set_logger` would panic without the library.
    if jack::jack_sys::library().is_ok() {
        jack::set_logger(jack::LoggerType::None);
    }
}
