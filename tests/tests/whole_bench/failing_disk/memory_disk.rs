//! In-memory disk with injected failures; after a power cut it keeps all synced data and an arbitrary part of the rest.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};

use rand::{Rng, RngExt};
use recording::storage::{Storage, StoredFile};

/// Bytes that a disk writes whole or not at all.
const SECTOR_BYTES: usize = 512;

/// Operation on the disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    Create,
    Write,
    /// A write within the length of the file, which needs no more space.
    Overwrite,
    SetLength,
    Sync,
    Rename,
    Remove,
    Find,
    Read,
}

/// Failure of the disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failure {
    /// Any one operation fails.
    Once,
    /// One write fails.
    Write,
    /// One sync of a file or folder fails, and the data to be written is dropped.
    Sync,
    /// One rename fails.
    Rename,
    /// One write takes half of its bytes.
    ShortWrite,
    /// One write is interrupted by a signal.
    Interrupted,
    /// From one operation on the disk is full.
    Full,
    /// From one operation on the disk is read-only.
    ReadOnly,
    /// From one operation on the disk is gone.
    PowerCut,
}

impl Failure {
    pub const ALL: [Self; 9] = [
        Self::Once,
        Self::Write,
        Self::Sync,
        Self::Rename,
        Self::ShortWrite,
        Self::Interrupted,
        Self::Full,
        Self::ReadOnly,
        Self::PowerCut,
    ];

    /// Whether the failure counts this operation, and so may hit it.
    fn concerns(self, operation: Operation) -> bool {
        let written = matches!(operation, Operation::Write | Operation::Overwrite);
        match self {
            Self::Write | Self::ShortWrite | Self::Interrupted => written,
            Self::Sync => operation == Operation::Sync,
            Self::Rename => operation == Operation::Rename,
            Self::Full => matches!(operation, Operation::Create | Operation::Write),
            Self::ReadOnly => !matches!(operation, Operation::Find | Operation::Read),
            Self::Once | Self::PowerCut => true,
        }
    }

    /// Whether the failure is permanent.
    pub fn lasts(self) -> bool {
        matches!(self, Self::Full | Self::ReadOnly | Self::PowerCut)
    }

    fn error(self) -> io::Error {
        match self {
            Self::Full => io::ErrorKind::StorageFull.into(),
            Self::ReadOnly => io::ErrorKind::ReadOnlyFilesystem.into(),
            Self::Interrupted => io::ErrorKind::Interrupted.into(),
            _ => io::Error::other("the disk failed on purpose"),
        }
    }
}

#[derive(Debug, Clone)]
enum Change {
    Write { offset: usize, bytes: Vec<u8> },
    Length(usize),
}

impl Change {
    fn apply(&self, content: &mut Vec<u8>) {
        match self {
            Self::Write { offset, bytes } => {
                let end = offset + bytes.len();
                if content.len() < end {
                    content.resize(end, 0);
                }
                content[*offset..end].copy_from_slice(bytes);
            }
            Self::Length(bytes) => content.resize(*bytes, 0),
        }
    }

    /// Applies a random part of the change: some of its sectors.
    fn apply_partly(&self, content: &mut Vec<u8>, rng: &mut impl Rng) {
        let Self::Write { offset, bytes } = self else {
            return;
        };
        let (mut start, end) = (*offset, offset + bytes.len());
        while start < end {
            let stop = end.min((start / SECTOR_BYTES + 1) * SECTOR_BYTES);
            if rng.random_bool(0.5) {
                let bytes = bytes[start - offset..stop - offset].to_vec();
                Self::Write {
                    offset: start,
                    bytes,
                }
                .apply(content);
            }
            start = stop;
        }
    }
}

#[derive(Debug, Default)]
struct Content {
    current: Vec<u8>,
    synced: Vec<u8>,
    /// Changes since the last sync.
    changes: Vec<Change>,
}

impl Content {
    fn change(&mut self, change: Change) {
        change.apply(&mut self.current);
        self.changes.push(change);
    }
}

#[derive(Debug, Clone, Copy)]
enum Node {
    Folder,
    File(usize),
}

type Names = BTreeMap<PathBuf, Node>;

/// Changes of names that take effect together.
type NameChange = Vec<(PathBuf, Option<Node>)>;

fn rename(names: &mut Names, change: &NameChange) {
    for (path, node) in change {
        match node {
            Some(node) => names.insert(path.clone(), *node),
            None => names.remove(path),
        };
    }
}

#[derive(Debug)]
struct State {
    contents: Vec<Content>,
    current: Names,
    synced: Names,
    /// Changes since the last sync of their folder.
    changes: Vec<NameChange>,
    failure: Option<Failure>,
    /// Operations left before the failure, counting only those it concerns.
    remaining: usize,
    hit: bool,
}

/// The disk.
#[derive(Debug, Clone)]
pub struct MemoryDisk(Arc<Mutex<State>>);

impl MemoryDisk {
    /// Returns a disk with one folder. Of the operations that `failure` concerns, the `n`-th, from 0, fails.
    pub fn new(folder: &Path, failure: Option<Failure>, n: usize) -> Self {
        let names: Names = [(folder.to_owned(), Node::Folder)].into();
        Self(Arc::new(Mutex::new(State {
            contents: Vec::new(),
            current: names.clone(),
            synced: names,
            changes: Vec::new(),
            failure,
            remaining: n,
            hit: false,
        })))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap()
    }

    /// Returns whether the failure has happened.
    pub fn has_failed(&self) -> bool {
        self.state().hit
    }

    /// Writes the disk's content as programs see it into `to`.
    pub fn show(&self, target: &Path) {
        let state = self.state();
        let contents: Vec<_> = state.contents.iter().map(|c| c.current.clone()).collect();
        show(&state.current, &contents, target);
    }

    /// Writes the disk's content after a power cut into `to`.
    pub fn show_after_power_cut(&self, survival: Survival, rng: &mut impl Rng, target: &Path) {
        let state = self.state();
        let mut names = state.synced.clone();
        for change in &state.changes {
            if survival.draw(rng) == Survival::All {
                rename(&mut names, change);
            }
        }
        let contents = state.contents.iter().map(|content| {
            let mut bytes = content.synced.clone();
            for change in &content.changes {
                match survival.draw(rng) {
                    Survival::All => change.apply(&mut bytes),
                    Survival::Random => change.apply_partly(&mut bytes, rng),
                    Survival::Nothing => {}
                }
            }
            bytes
        });
        let contents: Vec<_> = contents.collect();
        show(&names, &contents, target);
    }
}

/// Part of the unsynced changes that a power cut keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Survival {
    Nothing,
    All,
    /// Each change at random: whole, in part or not at all.
    Random,
}

impl Survival {
    /// Draws the fate of one change; `Random` means a part of it.
    fn draw(self, rng: &mut impl Rng) -> Self {
        match self {
            Self::Random => [Self::Nothing, Self::All, Self::Random][rng.random_range(0..3)],
            fixed => fixed,
        }
    }
}

fn show(names: &Names, contents: &[Vec<u8>], target: &Path) {
    for (path, node) in names {
        let path = target.join(path.strip_prefix("/").unwrap());
        // A folder sorts before its content; the content of a lost folder is lost.
        match node {
            Node::Folder => std::fs::create_dir_all(path).unwrap(),
            Node::File(number) if path.parent().unwrap().is_dir() => {
                std::fs::write(path, &contents[*number]).unwrap();
            }
            Node::File(_) => {}
        }
    }
}

impl State {
    /// Counts an operation; returns the failure if it hits this operation.
    fn failure_at(&mut self, operation: Operation) -> Option<Failure> {
        let failure = self.failure.filter(|failure| failure.concerns(operation))?;
        if self.hit {
            return failure.lasts().then_some(failure);
        }
        if self.remaining > 0 {
            self.remaining -= 1;
            return None;
        }
        self.hit = true;
        Some(failure)
    }

    fn ask(&mut self, operation: Operation) -> io::Result<()> {
        self.failure_at(operation)
            .map_or(Ok(()), |f| Err(f.error()))
    }

    fn file(&self, path: &Path) -> io::Result<usize> {
        match self.current.get(path) {
            Some(Node::File(number)) => Ok(*number),
            Some(Node::Folder) => Err(io::ErrorKind::IsADirectory.into()),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }

    fn change_names(&mut self, change: NameChange) {
        rename(&mut self.current, &change);
        self.changes.push(change);
    }

    fn make(&mut self, path: &Path) -> io::Result<usize> {
        if !matches!(
            path.parent().and_then(|folder| self.current.get(folder)),
            Some(Node::Folder)
        ) {
            return Err(io::ErrorKind::NotFound.into());
        }
        self.contents.push(Content::default());
        let number = self.contents.len() - 1;
        self.change_names(vec![(path.to_owned(), Some(Node::File(number)))]);
        Ok(number)
    }
}

impl Storage for MemoryDisk {
    fn create_new(&self, path: &Path) -> io::Result<Box<dyn StoredFile>> {
        let mut state = self.state();
        state.ask(Operation::Create)?;
        if state.current.contains_key(path) {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        let number = state.make(path)?;
        Ok(Box::new(MemoryFile::new(self, number, false)))
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn StoredFile>> {
        let mut state = self.state();
        state.ask(Operation::Create)?;
        let number = match state.file(path) {
            Ok(number) => {
                state.contents[number].change(Change::Length(0));
                number
            }
            Err(_) => state.make(path)?,
        };
        Ok(Box::new(MemoryFile::new(self, number, false)))
    }

    fn append(&self, path: &Path) -> io::Result<Box<dyn StoredFile>> {
        let mut state = self.state();
        state.ask(Operation::Find)?;
        let number = state.file(path)?;
        Ok(Box::new(MemoryFile::new(self, number, true)))
    }

    fn read(&self, path: &Path) -> io::Result<Box<dyn Read + Send>> {
        let mut state = self.state();
        state.ask(Operation::Read)?;
        let number = state.file(path)?;
        Ok(Box::new(Cursor::new(
            state.contents[number].current.clone(),
        )))
    }

    fn create_folder(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.ask(Operation::Create)?;
        if state.current.contains_key(path) {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        state.change_names(vec![(path.to_owned(), Some(Node::Folder))]);
        Ok(())
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.ask(Operation::Rename)?;
        let number = state.file(from)?;
        state.change_names(vec![
            (from.to_owned(), None),
            (to.to_owned(), Some(Node::File(number))),
        ]);
        Ok(())
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.ask(Operation::Remove)?;
        state.file(path)?;
        state.change_names(vec![(path.to_owned(), None)]);
        Ok(())
    }

    fn find(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        state.ask(Operation::Find)?;
        let exists = state.current.contains_key(path);
        exists.then_some(()).ok_or(io::ErrorKind::NotFound.into())
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        let mut state = self.state();
        // A failed sync leaves the changes of names pending.
        state.ask(Operation::Sync)?;
        let State {
            changes, synced, ..
        } = &mut *state;
        changes.retain(|change| {
            let is_in_folder = change[0].0.parent() == Some(path);
            if is_in_folder {
                rename(synced, change);
            }
            !is_in_folder
        });
        Ok(())
    }
}

/// A file of the disk, open for writing.
#[derive(Debug)]
struct MemoryFile {
    disk: MemoryDisk,
    number: usize,
    offset: usize,
    appends: bool,
}

impl MemoryFile {
    fn new(disk: &MemoryDisk, number: usize, appends: bool) -> Self {
        Self {
            disk: disk.clone(),
            number,
            offset: 0,
            appends,
        }
    }
}

impl Write for MemoryFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.disk.state();
        let length = state.contents[self.number].current.len();
        if self.appends {
            self.offset = length;
        }
        let operation = if self.offset + bytes.len() > length {
            Operation::Write
        } else {
            Operation::Overwrite
        };
        let length_written = match state.failure_at(operation) {
            None => bytes.len(),
            Some(Failure::ShortWrite) => bytes.len().div_ceil(2),
            Some(failure) => return Err(failure.error()),
        };
        state.contents[self.number].change(Change::Write {
            offset: self.offset,
            bytes: bytes[..length_written].to_vec(),
        });
        self.offset += length_written;
        Ok(length_written)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for MemoryFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        let length = self.disk.state().contents[self.number].current.len();
        self.offset = match position {
            SeekFrom::Start(offset) => offset as usize,
            SeekFrom::End(0) => length,
            other => panic!("{other:?} is not needed"),
        };
        Ok(self.offset as u64)
    }
}

impl StoredFile for MemoryFile {
    fn set_len(&mut self, bytes: u64) -> io::Result<()> {
        let mut state = self.disk.state();
        state.ask(Operation::SetLength)?;
        state.contents[self.number].change(Change::Length(bytes as usize));
        Ok(())
    }

    fn sync_data(&mut self) -> io::Result<()> {
        let mut state = self.disk.state();
        let failure = state.failure_at(Operation::Sync);
        let Content {
            synced, changes, ..
        } = &mut state.contents[self.number];
        match failure {
            None => {
                for change in changes.drain(..) {
                    change.apply(synced);
                }
                Ok(())
            }
            Some(failure) => {
                if !failure.lasts() {
                    // Linux marks the pages as clean, so a later sync does not write them.
                    changes.clear();
                }
                Err(failure.error())
            }
        }
    }
}
