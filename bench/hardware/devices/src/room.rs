//! Free space on the study's disk, queried on a separate thread: a hanging disk holds up no other task.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use recording::study::free_bytes;
use tasks::{Slot, Task};

/// Time between two queries, ns.
const EVERY_NS: u64 = 500_000_000;
/// Age above which the free space counts as unknown, ns.
const STALE_NS: u64 = 3_000_000_000;

/// Free space at some time.
#[derive(Clone, Copy, Debug)]
pub struct Left {
    at_ns: u64,
    free_bytes: Option<u64>,
}

/// Latest known free space.
#[derive(Clone, Debug, Default)]
pub struct Room(Arc<Slot<Left>>);

impl Room {
    /// Returns the free space, bytes, if it was known shortly before `now_ns`.
    pub fn free_bytes(&self, now_ns: u64) -> Option<u64> {
        let reading = self.0.get()?;
        (now_ns.saturating_sub(reading.at_ns) <= STALE_NS)
            .then_some(reading.free_bytes)
            .flatten()
    }
}

/// Task that queries the disk.
pub struct RoomTask {
    folder: PathBuf,
    room: Room,
    due_ns: u64,
}

impl RoomTask {
    /// Makes the task for the disk of `folder`.
    pub fn new(folder: PathBuf) -> (Room, Self) {
        let room = Room::default();
        let task = Self {
            folder,
            room: room.clone(),
            due_ns: 0,
        };
        (room, task)
    }
}

impl Task for RoomTask {
    fn name(&self) -> &'static str {
        "room"
    }

    fn period(&self) -> Duration {
        // Shorter than the time between two queries: the end of a session waits for it.
        Duration::from_millis(20)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        if now_ns < self.due_ns {
            return Ok(());
        }
        self.due_ns = now_ns + EVERY_NS;
        self.room.0.set(Left {
            at_ns: now_ns,
            free_bytes: free_bytes(&self.folder).ok(),
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fault 27.
    #[test]
    fn nothing_is_said_of_a_disk_that_does_not_answer() {
        let folder = tempfile::tempdir().unwrap();
        let (room, mut task) = RoomTask::new(folder.path().to_owned());
        assert_eq!(room.free_bytes(0), None);
        task.poll(1_000).unwrap();
        assert!(room.free_bytes(STALE_NS).is_some());
        assert_eq!(room.free_bytes(STALE_NS + 1_001), None);
    }
}
