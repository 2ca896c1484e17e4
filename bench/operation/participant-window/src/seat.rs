//! The session's end of the socket: one window at a time, which never blocks the session.

use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};

use crate::lines::{ConnectionEnd, LineConnection};
use crate::message::{Beat, Content, Display, FORMAT, FrameReport, FromWindow, ToWindow};
use crate::place::{self, PlaceError};

/// Silence after which a window counts as hung, s.
const LONGEST_SILENCE_S: f64 = 2.0;
/// Maximum number of messages from a window per second; a window that sends more is dismissed.
const MOST_A_SECOND: u32 = 200;

/// Event of the window.
#[derive(Clone, Debug, PartialEq)]
pub enum SeatEvent {
    /// A window has connected.
    Arrival(Display),
    /// The window is gone.
    Departure {
        /// The reason.
        reason: String,
    },
    /// Report on the frames of an exploration.
    Explored(FrameReport),
    /// A warning for the operator.
    Trouble {
        /// The text.
        text: String,
    },
    /// Whether the participant can follow the window.
    Unfit {
        /// The reason why not; `None` when they can again.
        reason: Option<String>,
    },
}

/// The session's end of the socket.
#[derive(Debug)]
pub struct Seat {
    path: PathBuf,
    listener: UnixListener,
    window: Option<Window>,
    content: Option<Content>,
}

/// A connected window.
#[derive(Debug)]
struct Window {
    lines: LineConnection,
    ready: bool,
    heard_s: f64,
    /// Start of the current second, s, and the messages since.
    message_count: (f64, u32),
}

impl Seat {
    /// Opens the socket.
    ///
    /// # Errors
    /// [`PlaceError`].
    pub fn open(path: &Path) -> Result<Self, PlaceError> {
        Ok(Self {
            path: path.to_owned(),
            listener: place::listen(path)?,
            window: None,
            content: None,
        })
    }

    /// Returns the socket.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Sets the contents of the window.
    pub fn show(&mut self, content: Content) {
        if self.content.as_ref() != Some(&content) {
            self.send(&ToWindow::Show(Box::new(content.clone())));
            self.content = Some(content);
        }
    }

    /// Sends the bench's clock to the window.
    pub fn beat(&mut self, beat: Beat) {
        self.send(&ToWindow::Beat(beat));
    }

    fn send(&mut self, message: &ToWindow) {
        if let Some(window) = self.window.as_mut().filter(|window| window.ready) {
            // An error is seen at the next look.
            let _ = window.lines.send(message);
        }
    }

    /// Accepts a window and reads its messages; returns the events. `now_s` is on any clock that never goes back.
    pub fn look(&mut self, now_s: f64) -> Vec<SeatEvent> {
        let mut events = Vec::new();
        let end = self
            .window
            .as_mut()
            .and_then(|window| window.hear(now_s, &mut events).err());
        if let Some(end) = end {
            self.dismiss(&end.to_string(), &mut events);
        }
        if let Some(window) = self
            .window
            .as_mut()
            .filter(|window| window.ready && !window.welcomed())
        {
            window.message_count = (now_s, 0);
            self.send(&ToWindow::Welcome { format: FORMAT });
            if let Some(content) = self.content.clone() {
                self.send(&ToWindow::Show(Box::new(content)));
            }
        }
        self.accept(now_s);
        events
    }

    /// Dismisses the window and tells it why.
    fn dismiss(&mut self, reason: &str, events: &mut Vec<SeatEvent>) {
        if let Some(mut window) = self.window.take() {
            let reason = reason.to_owned();
            let _ = window.lines.send(&ToWindow::Refused {
                why: reason.clone(),
            });
            if window.ready {
                events.push(SeatEvent::Departure { reason });
            }
        }
    }

    fn accept(&mut self, now_s: f64) {
        let Ok((stream, _)) = self.listener.accept() else {
            return;
        };
        if !place::is_ours(&stream) {
            return;
        }
        let Ok(mut lines) = LineConnection::new(stream) else {
            return;
        };
        if self.window.is_some() {
            let reason = "another window is at this session: close that one first".to_owned();
            let _ = lines.send(&ToWindow::Refused { why: reason });
            return;
        }
        self.window = Some(Window {
            lines,
            ready: false,
            heard_s: now_s,
            message_count: (f64::NAN, 0),
        });
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.send(&ToWindow::Bye);
        // The socket is still this session's: nobody else could bind it.
        let _ = std::fs::remove_file(&self.path);
    }
}

impl Window {
    fn welcomed(&self) -> bool {
        !self.message_count.0.is_nan()
    }

    /// Reads the window's messages.
    fn hear(&mut self, now_s: f64, events: &mut Vec<SeatEvent>) -> Result<(), ConnectionEnd> {
        self.lines.flush()?;
        for message in self.lines.receive::<FromWindow>(16)? {
            self.heard_s = now_s;
            if self.welcomed() {
                self.count(now_s)?;
            }
            match message {
                FromWindow::Ready(display) if !self.ready => {
                    require(&display)?;
                    self.ready = true;
                    events.push(SeatEvent::Arrival(display));
                }
                FromWindow::Alive if self.ready => {}
                FromWindow::Explored(report) if self.ready => {
                    events.push(SeatEvent::Explored(report))
                }
                FromWindow::Trouble { text } if self.ready => {
                    events.push(SeatEvent::Trouble { text })
                }
                FromWindow::Unfit { why: reason } if self.ready => {
                    events.push(SeatEvent::Unfit { reason })
                }
                _ => {
                    return Err(ConnectionEnd::Garbage(
                        "unexpected at this point".to_owned(),
                    ));
                }
            }
        }
        if now_s - self.heard_s > LONGEST_SILENCE_S {
            return Err(ConnectionEnd::Stuck);
        }
        Ok(())
    }

    fn count(&mut self, now_s: f64) -> Result<(), ConnectionEnd> {
        if now_s - self.message_count.0 > 1.0 {
            self.message_count = (now_s, 0);
        }
        self.message_count.1 += 1;
        if self.message_count.1 > MOST_A_SECOND {
            return Err(ConnectionEnd::Garbage(format!(
                "more than {MOST_A_SECOND} messages a second"
            )));
        }
        Ok(())
    }
}

/// Requires plausible properties of a display.
fn require(display: &Display) -> Result<(), ConnectionEnd> {
    let can_be = display.format == FORMAT
        && display.width_px > 0
        && display.height_px > 0
        && (1e-5..=2e-3).contains(&display.pixel_m)
        && (1e-3..=1.0).contains(&display.refresh_s)
        && display.monitor.chars().count() <= 200;
    if can_be {
        return Ok(());
    }
    let format = display.format;
    Err(ConnectionEnd::Garbage(format!(
        "not a display that this program knows (format {format}, here {FORMAT}): use the same version for both"
    )))
}

#[cfg(test)]
mod tests {
    use std::fs::{Permissions, set_permissions};
    use std::io::Write;
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::net::UnixStream;

    use super::*;

    struct Rig {
        _folder: tempfile::TempDir,
        seat: Seat,
        now_s: f64,
    }

    impl Rig {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            set_permissions(folder.path(), Permissions::from_mode(0o700)).unwrap();
            let seat = Seat::open(&folder.path().join("s")).unwrap();
            Self {
                _folder: folder,
                seat,
                now_s: 0.0,
            }
        }

        fn connect(&mut self) -> LineConnection {
            let stream = UnixStream::connect(self.seat.path()).unwrap();
            assert!(self.look().is_empty());
            LineConnection::new(stream).unwrap()
        }

        fn look(&mut self) -> Vec<SeatEvent> {
            self.now_s += 0.01;
            self.seat.look(self.now_s)
        }

        fn seated(&mut self) -> LineConnection {
            let mut window = self.connect();
            window.send(&FromWindow::Ready(display())).unwrap();
            assert_eq!(self.look(), [SeatEvent::Arrival(display())]);
            window
        }
    }

    fn display() -> Display {
        Display {
            format: FORMAT,
            monitor: "HDMI-1".to_owned(),
            width_px: 1920,
            height_px: 1080,
            pixel_m: 2.768e-4,
            refresh_s: 1.0 / 60.0,
            virtual_display: false,
        }
    }

    fn page_content(title: &str) -> Content {
        Content {
            title: title.to_owned(),
            ..Content::default()
        }
    }

    #[test]
    fn a_late_or_returning_window_gets_the_current_content() {
        let mut rig = Rig::new();
        rig.seat.show(page_content("Please wait"));
        for _ in 0..2 {
            let mut window = rig.seated();
            let messages: Vec<ToWindow> = window.receive(9).unwrap();
            let show = ToWindow::Show(Box::new(page_content("Please wait")));
            assert_eq!(messages, [ToWindow::Welcome { format: FORMAT }, show]);
            drop(window);
            let reason = "it was closed".to_owned();
            assert_eq!(rig.look(), [SeatEvent::Departure { reason }]);
        }
    }

    #[test]
    fn a_second_window_is_refused_because_of_the_first() {
        let mut rig = Rig::new();
        let _first = rig.seated();
        let mut second = rig.connect();
        let messages: Vec<ToWindow> = second.receive(9).unwrap();
        assert!(
            matches!(&messages[..], [ToWindow::Refused { why }] if why.contains("another window"))
        );
    }

    #[test]
    fn a_window_that_hangs_floods_or_sends_nonsense_is_dismissed() {
        let mut rig = Rig::new();
        let hanging = rig.seated();
        rig.now_s += LONGEST_SILENCE_S;
        assert!(matches!(&rig.look()[..], [SeatEvent::Departure { .. }]));
        drop(hanging);
        let mut flood = rig.seated();
        for _ in 0..1000 {
            let _ = flood.send(&FromWindow::Alive);
        }
        let events: Vec<SeatEvent> = (0..30).flat_map(|_| rig.look()).collect();
        assert!(
            matches!(&events[..], [SeatEvent::Departure { reason }] if reason.contains("messages a second"))
        );
        let mut nonsense = rig.seated();
        nonsense.send(&FromWindow::Ready(display())).unwrap();
        assert!(matches!(&rig.look()[..], [SeatEvent::Departure { .. }]));
        let _fine = rig.seated();
    }

    #[test]
    fn a_foreign_client_is_dropped_without_a_message_to_the_operator() {
        let mut rig = Rig::new();
        for bytes in [
            b"\xff\xff\n".as_slice(),
            b"\"alive\"\n",
            b"{\"ready\":{}}\n",
            b"\n",
        ] {
            let mut stream = UnixStream::connect(rig.seat.path()).unwrap();
            stream.write_all(bytes).unwrap();
            assert!(rig.look().is_empty() && rig.look().is_empty());
            assert!(rig.seat.window.is_none());
        }
        for invalid in [
            Display {
                pixel_m: f64::MAX,
                ..display()
            },
            Display {
                refresh_s: 0.0,
                ..display()
            },
            Display {
                format: FORMAT + 1,
                ..display()
            },
            Display {
                width_px: 0,
                ..display()
            },
        ] {
            let mut window = rig.connect();
            window.send(&FromWindow::Ready(invalid)).unwrap();
            assert!(rig.look().is_empty() && rig.seat.window.is_none());
        }
        let _silent = rig.connect();
        rig.now_s += LONGEST_SILENCE_S;
        assert!(rig.look().is_empty() && rig.seat.window.is_none());
    }

    #[test]
    fn a_window_that_reads_nothing_never_holds_the_session_up() {
        let mut rig = Rig::new();
        let mut window = rig.seated();
        let left = (0..20_000).any(|i| {
            rig.seat.beat(Beat {
                audio_s: f64::from(i),
                shared_s: f64::from(i),
                finger_m: None,
            });
            if i % 100 == 0 {
                let _ = window.send(&FromWindow::Alive);
            }
            !rig.look().is_empty()
        });
        assert!(left);
    }

    #[test]
    fn the_socket_goes_with_the_session() {
        let rig = Rig::new();
        let path = rig.seat.path().to_owned();
        assert!(path.exists());
        drop(rig.seat);
        assert!(!path.exists());
    }
}
