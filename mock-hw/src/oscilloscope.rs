//! Oscilloscope on the drive and on the amplifier's lines: writes its latest readings to a memory-mapped file.
//!
//! Stores into mapped memory never block, and the file keeps them when the program hangs, is killed or has ended: another
//! program can read when the plate became silent, in any state of the bench. Put the file on a memory file system (`/dev/shm`).
//! Times are on the machine's monotonic clock, ns, taken when a period is simulated: a machine that falls behind makes them
//! later, never earlier. The file also has a button: [`press_estop`] presses the e-stop from the other program.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

/// Drive across the actuators that counts as driven, V RMS over a period of the simulation.
const DRIVEN_V: f64 = 0.7;
/// Sample of the card that counts as driven, full scale 1.
const PLAYED_LEVEL: f32 = 0.012;

/// First word of the file.
const MARK: u64 = u64::from_le_bytes(*b"oscillo1");

/// Words of the file, each in native byte order.
#[derive(Clone, Copy)]
enum Word {
    Mark,
    Looked,
    Played,
    Driven,
    Lines,
    Beat,
    Opened,
    Late,
    Estop,
}

#[cfg(unix)]
const WORDS: usize = Word::Estop as usize + 1;

const ENABLE: u64 = 1;
const HEARTBEAT: u64 = 2;
const POWER: u64 = 4;

/// State of the amplifier's lines in a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AmplifierLines {
    /// Whether the bench requests power.
    pub enable: bool,
    /// Level of the heartbeat.
    pub heartbeat: bool,
    /// Whether the amplifier passes the drive.
    pub power: bool,
}

/// Readings of the oscilloscope. Times are on the machine's monotonic clock, ns; 0 stands for never.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Readings {
    /// Time of the latest period.
    pub looked_ns: u64,
    /// Latest time at which the card played a driven sample.
    pub played_ns: u64,
    /// Latest time at which a driven sample reached the plate.
    pub driven_ns: u64,
    /// Latest edge of the heartbeat.
    pub beat_ns: u64,
    /// Latest time at which the enable line fell.
    pub opened_ns: u64,
    /// Longest time between two periods, ns; short if the machine keeps up.
    pub late_ns: u64,
    /// Whether the bench requests power.
    pub enable: bool,
    /// Whether the amplifier passes the drive.
    pub power: bool,
}

impl Readings {
    /// Reads the file of an oscilloscope; `None` if it does not exist.
    ///
    /// # Errors
    /// If the file cannot be read, or is not an oscilloscope's.
    pub fn read(path: &Path) -> io::Result<Option<Self>> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
        };
        let word = |word: Word| {
            let offset = word as usize * size_of::<u64>();
            let bytes = bytes.get(offset..offset + size_of::<u64>());
            bytes.map_or(0, |bytes| {
                u64::from_ne_bytes(bytes.try_into().unwrap_or_default())
            })
        };
        match word(Word::Mark) {
            MARK => {}
            // The file is being created.
            0 => return Ok(None),
            _ => {
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    "not the file of an oscilloscope",
                ));
            }
        }
        let lines = word(Word::Lines);
        Ok(Some(Self {
            looked_ns: word(Word::Looked),
            played_ns: word(Word::Played),
            driven_ns: word(Word::Driven),
            beat_ns: word(Word::Beat),
            opened_ns: word(Word::Opened),
            late_ns: word(Word::Late),
            enable: lines & ENABLE != 0,
            power: lines & POWER != 0,
        }))
    }
}

/// Presses or releases the e-stop of the apparatus with the oscilloscope file at `path`.
///
/// # Errors
/// If the file cannot be written.
pub fn press_estop(path: &Path, pressed: bool) -> io::Result<()> {
    let mut file = std::fs::File::options().write(true).open(path)?;
    let offset = Word::Estop as usize * size_of::<u64>();
    file.seek(SeekFrom::Start(offset as u64))?;
    file.write_all(&u64::from(pressed).to_ne_bytes())
}

/// Returns the machine's monotonic time, ns: the clock of [`Readings`].
#[cfg(unix)]
#[must_use]
pub fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Oscilloscope of one process's apparatus. It continues the readings of an earlier one in the same file.
#[derive(Debug)]
pub(crate) struct Oscilloscope {
    screen: screen::Screen,
    lines: Option<AmplifierLines>,
    looked_ns: u64,
    estop: bool,
}

impl Oscilloscope {
    /// Opens or creates the file at `path`.
    ///
    /// # Errors
    /// If it cannot be created or mapped, or on an operating system without mapped files.
    pub fn open(path: &Path) -> io::Result<Self> {
        let screen = screen::Screen::open(path)?;
        screen.set(Word::Mark, MARK);
        Ok(Self {
            screen,
            lines: None,
            looked_ns: 0,
            estop: false,
        })
    }

    /// Returns the new state of the e-stop button if it has changed since the last call.
    pub fn estop_change(&mut self) -> Option<bool> {
        let estop = self.screen.get(Word::Estop) != 0;
        let previous = std::mem::replace(&mut self.estop, estop);
        (estop != previous).then_some(estop)
    }

    /// Records a period that ends now: the card's samples, the voltage across the actuators and the lines.
    pub fn look(&mut self, drive: &[f32], rms_v: f64, lines: AmplifierLines) {
        let now_ns = screen::now_ns();
        self.see(now_ns, drive, rms_v, lines);
    }

    fn see(&mut self, now_ns: u64, drive: &[f32], rms_v: f64, lines: AmplifierLines) {
        if drive.iter().any(|sample| sample.abs() > PLAYED_LEVEL) {
            self.screen.set(Word::Played, now_ns);
        }
        if rms_v > DRIVEN_V {
            self.screen.set(Word::Driven, now_ns);
        }
        if let Some(previous) = self.lines.replace(lines) {
            if previous.heartbeat != lines.heartbeat {
                self.screen.set(Word::Beat, now_ns);
            }
            if previous.enable && !lines.enable {
                self.screen.set(Word::Opened, now_ns);
            }
            self.screen
                .raise(Word::Late, now_ns.saturating_sub(self.looked_ns));
        }
        let levels = [
            (lines.enable, ENABLE),
            (lines.heartbeat, HEARTBEAT),
            (lines.power, POWER),
        ];
        let levels = levels.iter().filter(|(high, _)| *high);
        self.screen
            .set(Word::Lines, levels.map(|(_, bit)| bit).sum());
        self.looked_ns = now_ns;
        self.screen.set(Word::Looked, now_ns);
    }
}

#[cfg(unix)]
mod screen {
    #![expect(
        unsafe_code,
        reason = "no safe crate maps a file into memory and stores atomically into it"
    )]

    use std::fs::File;
    use std::io;
    use std::os::fd::AsRawFd;
    use std::path::Path;
    use std::ptr::NonNull;
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::{WORDS, Word};

    pub(super) use super::monotonic_ns as now_ns;

    /// Mapped words of the file.
    #[derive(Debug)]
    pub(super) struct Screen {
        words: NonNull<[AtomicU64; WORDS]>,
    }

    // SAFETY: the words are atomic, and stay mapped until the value is dropped.
    unsafe impl Send for Screen {}

    impl Screen {
        pub(super) fn open(path: &Path) -> io::Result<Self> {
            let mut options = File::options();
            let file = options.read(true).write(true).create(true).truncate(false);
            let file = file.open(path)?;
            let length = size_of::<[AtomicU64; WORDS]>();
            file.set_len(length as u64)?;
            // SAFETY: a new mapping of a file that is as long; the kernel chooses an address, which a page aligns.
            let mapping = unsafe {
                libc::mmap(
                    std::ptr::null_mut(),
                    length,
                    libc::PROT_READ | libc::PROT_WRITE,
                    libc::MAP_SHARED,
                    file.as_raw_fd(),
                    0,
                )
            };
            match NonNull::new(mapping) {
                Some(words) if mapping != libc::MAP_FAILED => Ok(Self {
                    words: words.cast(),
                }),
                _ => Err(io::Error::last_os_error()),
            }
        }

        fn word(&self, word: Word) -> &AtomicU64 {
            // SAFETY: mapped for as long as `self` lives; others store whole words too.
            let words = unsafe { self.words.as_ref() };
            &words[word as usize]
        }

        pub(super) fn set(&self, word: Word, value: u64) {
            self.word(word).store(value, Ordering::Release);
        }

        pub(super) fn get(&self, word: Word) -> u64 {
            self.word(word).load(Ordering::Acquire)
        }

        pub(super) fn raise(&self, word: Word, value: u64) {
            self.word(word).fetch_max(value, Ordering::AcqRel);
        }
    }

    impl Drop for Screen {
        fn drop(&mut self) {
            // SAFETY: it was mapped with this length, and nothing refers to it any more.
            unsafe { libc::munmap(self.words.as_ptr().cast(), size_of::<[AtomicU64; WORDS]>()) };
        }
    }
}

#[cfg(not(unix))]
mod screen {
    use std::io;
    use std::path::Path;

    use super::Word;

    #[derive(Debug)]
    pub(super) struct Screen(std::convert::Infallible);

    impl Screen {
        pub(super) fn open(_path: &Path) -> io::Result<Self> {
            Err(io::ErrorKind::Unsupported.into())
        }

        pub(super) fn set(&self, _word: Word, _value: u64) {
            match self.0 {}
        }

        pub(super) fn get(&self, _word: Word) -> u64 {
            match self.0 {}
        }

        pub(super) fn raise(&self, _word: Word, _value: u64) {
            match self.0 {}
        }
    }

    pub(super) fn now_ns() -> u64 {
        0
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn the_last_driven_sample_and_the_lines_outlast_the_instrument() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scope");
        assert_eq!(Readings::read(&path).unwrap(), None);
        let on_lines = AmplifierLines {
            enable: true,
            heartbeat: true,
            power: true,
        };
        let mut scope = Oscilloscope::open(&path).unwrap();
        scope.see(10, &[0.0, 0.5], 20.0, on_lines);
        scope.see(
            20,
            &[0.0, 0.5],
            20.0,
            AmplifierLines {
                heartbeat: false,
                ..on_lines
            },
        );
        let off_lines = AmplifierLines {
            enable: false,
            heartbeat: false,
            power: false,
        };
        scope.see(50, &[0.001, 0.5], 0.2, off_lines);
        scope.see(60, &[0.001, -0.001], 0.0, off_lines);
        assert_eq!(scope.estop_change(), None);
        press_estop(&path, true).unwrap();
        assert_eq!(
            (scope.estop_change(), scope.estop_change()),
            (Some(true), None)
        );
        drop(scope);
        let readings = Readings::read(&path).unwrap().unwrap();
        let expected = Readings {
            looked_ns: 60,
            played_ns: 50,
            driven_ns: 20,
            beat_ns: 20,
            opened_ns: 50,
            late_ns: 30,
            enable: false,
            power: false,
        };
        assert_eq!(readings, expected);
        let mut scope = Oscilloscope::open(&path).unwrap();
        scope.see(70, &[0.0], 0.0, on_lines);
        let readings = Readings::read(&path).unwrap().unwrap();
        assert_eq!(
            (readings.driven_ns, readings.looked_ns, readings.enable),
            (20, 70, true)
        );
    }

    #[test]
    fn another_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("letter");
        std::fs::write(&path, "Dear Sir or Madam").unwrap();
        assert!(Readings::read(&path).is_err());
    }
}
