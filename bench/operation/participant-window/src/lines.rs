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
pub enum ConnectionEnd {
    /// The other end closed it.
    #[error("it was closed")]
    Closed,
    /// The other end no longer reads.
    #[error("it no longer reads")]
    Stuck,
    /// The other end sent an invalid message.
    #[error("it sent an invalid message: {0}")]
    Garbage(String),
    /// The socket failed.
    #[error("{}", bounded_files::cause(.0))]
    Failed(#[from] std::io::Error),
}

/// A connection.
#[derive(Debug)]
pub struct LineConnection {
    stream: UnixStream,
    input: Vec<u8>,
    output: Vec<u8>,
}

impl LineConnection {
    /// Takes over a connected socket.
    ///
    /// # Errors
    /// Returns the system's error if the socket cannot be made non-blocking.
    pub fn new(stream: UnixStream) -> std::io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self {
            stream,
            input: Vec::new(),
            output: Vec::new(),
        })
    }

    /// Sends a message, now or as soon as the other end reads.
    ///
    /// # Errors
    /// [`ConnectionEnd`].
    pub fn send(&mut self, message: &impl Serialize) -> Result<(), ConnectionEnd> {
        serde_json::to_writer(&mut self.output, message).map_err(std::io::Error::from)?;
        self.output.push(b'\n');
        self.flush()
    }

    /// Sends the bytes that still wait.
    ///
    /// # Errors
    /// [`ConnectionEnd`].
    pub fn flush(&mut self) -> Result<(), ConnectionEnd> {
        while !self.output.is_empty() {
            match self.stream.write(&self.output) {
                Ok(0) => return Err(ConnectionEnd::Closed),
                Ok(count) => drop(self.output.drain(..count)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::BrokenPipe => {
                    return Err(ConnectionEnd::Closed);
                }
                Err(error) => return Err(error.into()),
            }
        }
        if self.output.len() > MOST_WAITING_BYTES {
            return Err(ConnectionEnd::Stuck);
        }
        Ok(())
    }

    /// Returns at most `most` received messages; the others are left for the next call.
    ///
    /// # Errors
    /// [`ConnectionEnd`], once all messages received before it have been returned.
    pub fn receive<T: DeserializeOwned>(
        &mut self,
        max_messages: usize,
    ) -> Result<Vec<T>, ConnectionEnd> {
        let outcome = self.read();
        let mut messages = Vec::new();
        while messages.len() < max_messages
            && let Some(end) = self.input.iter().position(|byte| *byte == b'\n')
        {
            let line: Vec<u8> = self.input.drain(..=end).collect();
            let garbage = |error: serde_json::Error| ConnectionEnd::Garbage(error.to_string());
            messages.push(serde_json::from_slice(&line).map_err(garbage)?);
        }
        let unended = !self.input.contains(&b'\n');
        if unended && self.input.len() > LONGEST_LINE_BYTES {
            return Err(ConnectionEnd::Garbage(format!(
                "a line of more than {LONGEST_LINE_BYTES} bytes"
            )));
        }
        match outcome {
            Err(end) if messages.is_empty() => Err(end),
            _ => Ok(messages),
        }
    }

    fn read(&mut self) -> Result<(), ConnectionEnd> {
        let mut chunk = [0; 4096];
        while self.input.len() < MOST_READ_BYTES {
            match self.stream.read(&mut chunk) {
                Ok(0) => return Err(ConnectionEnd::Closed),
                Ok(count) => self.input.extend(chunk.get(..count).unwrap_or_default()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::ConnectionReset => {
                    return Err(ConnectionEnd::Closed);
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

    fn pair() -> (LineConnection, UnixStream) {
        let (near_end, peer) = UnixStream::pair().unwrap();
        (LineConnection::new(near_end).unwrap(), peer)
    }

    #[test]
    fn messages_come_whole_however_they_were_cut() {
        let (mut lines, mut peer) = pair();
        for byte in b"\"alive\"\n{\"trouble\":{\"text\":\"x\"}}\n\"al" {
            assert!(lines.receive::<FromWindow>(0).unwrap().is_empty());
            peer.write_all(&[*byte]).unwrap();
        }
        let trouble = FromWindow::Trouble {
            text: "x".to_owned(),
        };
        assert_eq!(
            lines.receive::<FromWindow>(9).unwrap(),
            [FromWindow::Alive, trouble]
        );
        peer.write_all(b"ive\"\n").unwrap();
        drop(peer);
        assert_eq!(lines.receive::<FromWindow>(9).unwrap(), [FromWindow::Alive]);
        assert!(matches!(
            lines.receive::<FromWindow>(9),
            Err(ConnectionEnd::Closed)
        ));
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
            let (mut lines, mut peer) = pair();
            peer.set_nonblocking(true).unwrap();
            let _as_much_as_fits = peer.write(garbage);
            let result = lines.receive::<FromWindow>(9);
            assert!(
                matches!(result, Err(ConnectionEnd::Garbage(_))),
                "{result:?}"
            );
        }
    }

    #[test]
    fn a_flood_is_read_a_little_at_a_time() {
        let (mut lines, mut peer) = pair();
        peer.set_nonblocking(true).unwrap();
        while peer.write(b"\"alive\"\n").is_ok() {}
        let first = lines.receive::<FromWindow>(100).unwrap();
        assert_eq!(first.len(), 100);
        assert!(lines.input.len() <= MOST_READ_BYTES + 4096);
    }

    #[test]
    fn a_reader_that_stands_still_is_given_up_and_never_waited_for() {
        let (mut lines, _peer) = pair();
        let text = "x".repeat(1000);
        let stuck = (0..10_000).find_map(|_| {
            lines
                .send(&FromWindow::Trouble { text: text.clone() })
                .err()
        });
        assert!(matches!(stuck, Some(ConnectionEnd::Stuck)), "{stuck:?}");
    }
}
