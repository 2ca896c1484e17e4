//! Lines of JSON over a socket, in both directions, without blocking.

use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Longest line.
const LONGEST_LINE_BYTES: usize = 16 << 10;
/// Limit of the bytes that wait for a peer that does not read.
const MOST_WAITING_BYTES: usize = 256 << 10;
/// Limit of the bytes read at a time: the rest of a flood stays in the socket and delays only its sender.
const MOST_READ_BYTES: usize = 64 << 10;

/// Why a connection has ended.
#[derive(Debug, thiserror::Error)]
pub enum Ended {
    /// The other end closed it.
    #[error("it was closed")]
    Closed,
    /// The other end no longer reads.
    #[error("it takes nothing any more")]
    Stuck,
    /// The other end sent an invalid message.
    #[error("what it sent is no message: {0}")]
    Garbage(String),
    /// The socket failed.
    #[error("{0}")]
    Failed(#[from] std::io::Error),
}

/// A connection.
#[derive(Debug)]
pub struct Lines {
    stream: UnixStream,
    coming: Vec<u8>,
    going: Vec<u8>,
}

impl Lines {
    /// Takes over a connected socket.
    ///
    /// # Errors
    /// Returns the system's error if the socket cannot be made non-blocking.
    pub fn new(stream: UnixStream) -> std::io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self {
            stream,
            coming: Vec::new(),
            going: Vec::new(),
        })
    }

    /// Sends a message, now or as soon as the other end reads.
    ///
    /// # Errors
    /// [`Ended`].
    pub fn send(&mut self, message: &impl Serialize) -> Result<(), Ended> {
        serde_json::to_writer(&mut self.going, message).map_err(std::io::Error::from)?;
        self.going.push(b'\n');
        self.flush()
    }

    /// Sends the bytes that still wait.
    ///
    /// # Errors
    /// [`Ended`].
    pub fn flush(&mut self) -> Result<(), Ended> {
        while !self.going.is_empty() {
            match self.stream.write(&self.going) {
                Ok(0) => return Err(Ended::Closed),
                Ok(written) => drop(self.going.drain(..written)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::BrokenPipe => return Err(Ended::Closed),
                Err(error) => return Err(error.into()),
            }
        }
        if self.going.len() > MOST_WAITING_BYTES {
            return Err(Ended::Stuck);
        }
        Ok(())
    }

    /// Returns at most `most` received messages; the others are left for the next call.
    ///
    /// # Errors
    /// [`Ended`], once all messages received before it have been returned.
    pub fn receive<T: DeserializeOwned>(&mut self, most: usize) -> Result<Vec<T>, Ended> {
        let ended = self.read();
        let mut messages = Vec::new();
        while messages.len() < most
            && let Some(end) = self.coming.iter().position(|byte| *byte == b'\n')
        {
            let line: Vec<u8> = self.coming.drain(..=end).collect();
            let garbage = |error: serde_json::Error| Ended::Garbage(error.to_string());
            messages.push(serde_json::from_slice(&line).map_err(garbage)?);
        }
        let unended = !self.coming.contains(&b'\n');
        if unended && self.coming.len() > LONGEST_LINE_BYTES {
            return Err(Ended::Garbage(format!(
                "a line of more than {LONGEST_LINE_BYTES} bytes"
            )));
        }
        match ended {
            Err(ended) if messages.is_empty() => Err(ended),
            _ => Ok(messages),
        }
    }

    fn read(&mut self) -> Result<(), Ended> {
        let mut chunk = [0; 4096];
        while self.coming.len() < MOST_READ_BYTES {
            match self.stream.read(&mut chunk) {
                Ok(0) => return Err(Ended::Closed),
                Ok(read) => self.coming.extend(chunk.get(..read).unwrap_or_default()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::ConnectionReset => {
                    return Err(Ended::Closed);
                }
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// Returns the socket.
    #[must_use]
    pub fn stream(&self) -> &UnixStream {
        &self.stream
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::FromWindow;

    fn pair() -> (Lines, UnixStream) {
        let (here, there) = UnixStream::pair().unwrap();
        (Lines::new(here).unwrap(), there)
    }

    #[test]
    fn messages_come_whole_however_they_were_cut() {
        let (mut here, mut there) = pair();
        for byte in b"\"alive\"\n{\"trouble\":{\"text\":\"x\"}}\n\"al" {
            assert!(here.receive::<FromWindow>(0).unwrap().is_empty());
            there.write_all(&[*byte]).unwrap();
        }
        let trouble = FromWindow::Trouble {
            text: "x".to_owned(),
        };
        assert_eq!(
            here.receive::<FromWindow>(9).unwrap(),
            [FromWindow::Alive, trouble]
        );
        there.write_all(b"ive\"\n").unwrap();
        drop(there);
        assert_eq!(here.receive::<FromWindow>(9).unwrap(), [FromWindow::Alive]);
        assert!(matches!(here.receive::<FromWindow>(9), Err(Ended::Closed)));
    }

    #[test]
    fn garbage_and_lines_without_end_are_refused() {
        for garbage in [
            b"\n".as_slice(),
            b"GET / HTTP/1.1\n",
            b"{\"alive\":1}\n",
            b"{\"ready\":{}}\n",
            b"\xff\xfe\n",
            b"[[[[[[[[\n",
            &[b'['; 200_000],
            &[b'x'; 20_000],
        ] {
            let (mut here, mut there) = pair();
            there.set_nonblocking(true).unwrap();
            let _as_much_as_fits = there.write(garbage);
            let refused = here.receive::<FromWindow>(9);
            assert!(matches!(refused, Err(Ended::Garbage(_))), "{refused:?}");
        }
    }

    #[test]
    fn a_flood_is_read_a_little_at_a_time() {
        let (mut here, mut there) = pair();
        there.set_nonblocking(true).unwrap();
        while there.write(b"\"alive\"\n").is_ok() {}
        let first = here.receive::<FromWindow>(100).unwrap();
        assert_eq!(first.len(), 100);
        assert!(here.coming.len() <= MOST_READ_BYTES + 4096);
    }

    #[test]
    fn a_reader_that_stands_still_is_given_up_and_never_waited_for() {
        let (mut here, _there) = pair();
        let text = "x".repeat(1000);
        let stuck =
            (0..10_000).find_map(|_| here.send(&FromWindow::Trouble { text: text.clone() }).err());
        assert!(matches!(stuck, Some(Ended::Stuck)), "{stuck:?}");
    }
}
