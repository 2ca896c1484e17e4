//! The window's end of the socket: it connects when a session is there, and reconnects after a loss.

use std::path::PathBuf;

use participant_window::LineConnection;
use participant_window::message::{Display, FromWindow, ToWindow};
use participant_window::place;

/// Time between attempts to connect, s.
const TRY_S: f64 = 0.5;
/// Time between signs of life, s.
const ALIVE_S: f64 = 0.4;

/// The window's end of the socket.
pub struct Link {
    socket: PathBuf,
    lines: Option<LineConnection>,
    last_try_s: f64,
    last_message_s: f64,
}

/// Result of a look at the socket.
#[derive(Default)]
pub struct Heard {
    /// Messages of the session.
    pub messages: Vec<ToWindow>,
    /// Why the session is not there, if known.
    pub lost: Option<String>,
}

impl Link {
    pub fn new(socket: PathBuf) -> Self {
        Self {
            socket,
            lines: None,
            last_try_s: f64::NEG_INFINITY,
            last_message_s: f64::NEG_INFINITY,
        }
    }

    /// Connects if necessary and reads the session's messages. `display` describes this window to the session.
    pub fn look(&mut self, now_s: f64, display: &Display) -> Heard {
        let mut news = Heard::default();
        let Some(lines) = &mut self.lines else {
            if now_s - self.last_try_s >= TRY_S {
                self.last_try_s = now_s;
                match self.meet(display) {
                    Ok(()) => self.last_message_s = now_s,
                    Err(reason) => news.lost = reason,
                }
            }
            return news;
        };
        let outcome = lines.flush().and_then(|()| lines.receive(256));
        match outcome {
            Ok(messages) => news.messages = messages,
            Err(end) => {
                self.lines = None;
                news.lost = Some(format!("the session is gone: {end}"));
            }
        }
        if now_s - self.last_message_s >= ALIVE_S {
            self.last_message_s = now_s;
            self.say(&FromWindow::Alive);
        }
        news
    }

    /// Connects to the session, if there is one.
    fn meet(&mut self, display: &Display) -> Result<(), Option<String>> {
        let in_words = |error: String| Some(error);
        let stream = place::connect(&self.socket).map_err(|error| in_words(error.to_string()))?;
        let stream = stream.ok_or(None)?;
        let mut lines = LineConnection::new(stream).map_err(|error| in_words(error.to_string()))?;
        let ready = FromWindow::Ready(display.clone());
        lines
            .send(&ready)
            .map_err(|error| in_words(error.to_string()))?;
        self.lines = Some(lines);
        Ok(())
    }

    /// Sends a message to the session, if it is connected.
    pub fn say(&mut self, message: &FromWindow) {
        if let Some(lines) = &mut self.lines {
            // An error is seen at the next look.
            let _ = lines.send(message);
        }
    }

    /// Closes the connection.
    pub fn leave(&mut self) {
        self.lines = None;
    }
}
