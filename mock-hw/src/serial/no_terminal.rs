//! Serial line for operating systems without pseudo-terminals: never connected.

use std::io;
use std::path::Path;

/// A serial line without a port: discards all bytes sent.
#[derive(Debug)]
pub(crate) struct SerialLine;

impl SerialLine {
    /// Returns a line without a port.
    ///
    /// # Errors
    /// Never; the pseudo-terminal of other systems may fail here.
    pub(crate) fn open(_synchronous: bool) -> io::Result<Self> {
        Ok(Self)
    }

    /// Returns `None`: the line cannot be opened.
    pub(crate) fn path(&self) -> Option<&Path> {
        None
    }

    /// Does nothing: the line is never connected.
    pub(crate) fn unplug(&mut self) {}

    /// Discards a burst.
    ///
    /// # Errors
    /// Never; the pseudo-terminal of other systems may fail here.
    pub(crate) fn send(&mut self, _burst: &[u8], _now_s: f64) -> io::Result<()> {
        Ok(())
    }

    /// Receives no bytes.
    ///
    /// # Errors
    /// Never; the pseudo-terminal of other systems may fail here.
    pub(crate) fn receive(&mut self, _received: &mut Vec<u8>) -> io::Result<()> {
        Ok(())
    }
}
