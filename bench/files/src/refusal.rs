//! Why a file is refused.

use std::fmt;
use std::fs::FileType;
use std::io;

/// Kind of something in a folder that is no regular file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A folder.
    Folder,
    /// A named pipe, which may wait for a writer for ever.
    NamedPipe,
    /// A socket.
    Socket,
    /// A device, such as one without end.
    Device,
    /// Something else.
    Special,
}

impl FileKind {
    /// Returns the kind; `None` for a regular file.
    #[must_use]
    pub fn of(file_type: FileType) -> Option<Self> {
        if file_type.is_file() {
            None
        } else if file_type.is_dir() {
            Some(Self::Folder)
        } else {
            Some(special(file_type))
        }
    }
}

#[cfg(unix)]
fn special(file_type: FileType) -> FileKind {
    use std::os::unix::fs::FileTypeExt;
    if file_type.is_fifo() {
        FileKind::NamedPipe
    } else if file_type.is_socket() {
        FileKind::Socket
    } else if file_type.is_char_device() || file_type.is_block_device() {
        FileKind::Device
    } else {
        FileKind::Special
    }
}

#[cfg(not(unix))]
fn special(_: FileType) -> FileKind {
    FileKind::Special
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Folder => "a folder",
            Self::NamedPipe => "a named pipe",
            Self::Socket => "a socket",
            Self::Device => "a device",
            Self::Special => "a special file",
        })
    }
}

/// Why a file that exists is not read. The message does not name the file: whoever reports the error does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// It is no regular file.
    #[error("it is {0}, not a regular file")]
    NotRegular(FileKind),
    /// It is a symbolic link where one is not followed.
    #[error("it is a symbolic link, which is not followed here")]
    Link,
    /// It has more bytes than are read of such a file.
    #[error("it is longer than {limit_bytes} bytes, the most that is read of such a file")]
    TooLong {
        /// The most bytes that are read.
        limit_bytes: u64,
    },
}

impl From<Refusal> for io::Error {
    fn from(refusal: Refusal) -> Self {
        let kind = match refusal {
            Refusal::NotRegular(FileKind::Folder) => io::ErrorKind::IsADirectory,
            Refusal::NotRegular(_) | Refusal::Link => io::ErrorKind::InvalidInput,
            Refusal::TooLong { .. } => io::ErrorKind::InvalidData,
        };
        Self::new(kind, refusal)
    }
}

/// Returns the refusal that an error stands for, if it is one.
#[must_use]
pub fn refusal(error: &io::Error) -> Option<&Refusal> {
    error.get_ref()?.downcast_ref()
}
