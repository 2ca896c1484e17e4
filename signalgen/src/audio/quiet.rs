//! Suppresses messages of the audio libraries on the operator's terminal.

/// Redirects this thread's ALSA messages from stderr to a buffer; errors are still returned. Each call empties the buffer.
#[cfg(target_os = "linux")]
pub(super) fn silence_alsa() {
    // Without the buffer the messages stay on stderr, which does no harm.
    let _ = alsa::Output::local_error_handler();
}

/// Does nothing: ALSA's messages are redirected on Linux only.
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
