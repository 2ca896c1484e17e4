//! Reasons to refuse a file.

use std::fmt;
use std::fs::FileType;
use std::io;

use crate::content_store::ContentStore;

/// Kind of a file that is not regular.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A folder.
    Folder,
    /// Named pipe, which may wait for a writer forever.
    NamedPipe,
    /// A socket.
    Socket,
    /// Device, which may be endless.
    Device,
    /// Something else.
    Special,
}

impl FileKind {
    /// Returns the kind; `None` for a regular file.
    #[must_use]
    pub fn from_type(file_type: FileType) -> Option<Self> {
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

/// Reason not to read an existing file. The message does not name the file; the caller's report does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The file is not regular.
    #[error("it is {0}, not a regular file")]
    NotRegular(FileKind),
    /// The file is a symbolic link where links are not followed.
    #[error("it is a symbolic link, which is not followed here")]
    Link,
    /// The file is longer than the limit.
    #[error("it is longer than {limit_bytes} bytes, the size limit of such a file")]
    TooLong {
        /// Limit, bytes.
        limit_bytes: u64,
    },
    /// The file is a placeholder, and its content is not on this computer.
    #[error("{0}")]
    Elsewhere(ContentStore),
    /// The text is UTF-16, as some programs of Windows save it.
    #[error("it is UTF-16 text; save it as UTF-8")]
    Utf16,
    /// A byte of the text is not UTF-8.
    #[error("line {line} has the byte {byte:#04X}, which is not UTF-8{}; save it as UTF-8", in_western(*.byte))]
    NotUtf8 {
        /// Line of the byte, from 1.
        line: usize,
        /// The byte.
        byte: u8,
    },
}

/// Returns the letter that a byte is in the older encodings of Western Europe, for a message.
fn in_western(byte: u8) -> String {
    if byte >= 0xa0 {
        format!(
            " (in Windows-1252 and Latin-1 it is `{}`)",
            char::from(byte)
        )
    } else {
        String::new()
    }
}

impl From<Refusal> for io::Error {
    fn from(refusal: Refusal) -> Self {
        let kind = match refusal {
            Refusal::NotRegular(FileKind::Folder) => io::ErrorKind::IsADirectory,
            Refusal::NotRegular(_) | Refusal::Link => io::ErrorKind::InvalidInput,
            Refusal::TooLong { .. }
            | Refusal::Utf16
            | Refusal::NotUtf8 { .. }
            | Refusal::Elsewhere(_) => io::ErrorKind::InvalidData,
        };
        Self::new(kind, refusal)
    }
}

/// Returns the refusal inside an error, if there is one.
#[must_use]
pub fn refusal(error: &io::Error) -> Option<&Refusal> {
    error.get_ref()?.downcast_ref()
}
