//! Account of the driving time of a person or a bench, kept from one program to the next: a small file that is replaced
//! as a whole while the plate is driven, always ahead of the drive, so that a crash counts too much and never too
//! little.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use crossbeam_channel::Receiver;
use jiff::{SignedDuration, Timestamp};
use recording::DiskError;
use recording::disk::replace_file;
use safety::{Allowance, DrivenSpan, SlidingHour};
use tasks::{Clock, Task};

use crate::boot::Boot;
use crate::dose_record::{self, AccountOwner, DamagedLine, Driven};

/// Lead of the file over the drive, s.
const AHEAD_S: f64 = 5.0;
/// Silence after which a span is over, s; the watch counts shorter pauses.
const OVER_S: f64 = 2.0;
/// Longest time from the last report to the end of the program that counts as driven, ns.
const LATE_NS: i64 = 1_000_000_000;

/// An account that cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum DoseError {
    /// The file is damaged, so the driving time is unknown.
    #[error(
        "{} cannot be used, so nobody can tell how long the plate was driven within the last hour: put it back from a copy, or \
         move it away once nobody has been at the driven plate for an hour",
        path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The line.
        source: DamagedLine,
    },
    /// The file cannot be read.
    #[error("cannot read {}, which says how long the plate was driven within the last hour", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
}

/// A record of driving times on the disk.
#[derive(Debug)]
struct Book {
    path: PathBuf,
    spans: Vec<Driven>,
    to_text: fn(&[Driven]) -> String,
}

impl Book {
    fn open(path: PathBuf, to_text: fn(&[Driven]) -> String) -> Result<Self, DoseError> {
        Ok(Self {
            spans: read(&path)?,
            path,
            to_text,
        })
    }
}

/// An account of driving time.
#[derive(Debug)]
pub struct DoseAccount {
    limit_s: f64,
    need_s: f64,
    /// Person at the plate.
    owner: AccountOwner,
    /// Records to which each span of driving is written; empty for an account that ends with the program.
    books: Vec<Book>,
}

/// Files of the accounts that a drive counts on.
#[derive(Debug)]
pub struct AccountPaths {
    /// Account of the named participant; `None` if no participant is named.
    pub participant: Option<PathBuf>,
    /// Account of the bench.
    pub bench: PathBuf,
}

/// Returns the path of a bench's account, in the folder of its calibration.
#[must_use]
pub fn bench_path(calibration: &Path) -> PathBuf {
    let stem = calibration.file_stem().unwrap_or_default();
    calibration.with_file_name(format!("{}-driving.tsv", stem.to_string_lossy()))
}

/// Returns the path of a participant's account in their folder of the study.
#[must_use]
pub fn participant_path(folder: &Path) -> PathBuf {
    folder.join("driving.tsv")
}

impl DoseAccount {
    /// Opens the account for `owner`; its files are created with the first drive. Without `paths`, as for a simulated
    /// bench, the account ends with the program. `limit_s` is allowed within an hour, and `need_s` of it must be left
    /// to arm.
    ///
    /// # Errors
    /// [`DoseError`] if the earlier driving time is unknown.
    pub fn open(
        paths: Option<AccountPaths>,
        owner: AccountOwner,
        limit_s: f64,
        need_s: f64,
    ) -> Result<Self, DoseError> {
        let mut books = Vec::new();
        if let Some(AccountPaths { participant, bench }) = paths {
            if let Some(participant) = participant {
                books.push(Book::open(participant, dose_record::to_text)?);
            }
            books.push(Book::open(bench, dose_record::to_bench_text)?);
        }
        Ok(Self {
            limit_s,
            need_s,
            owner,
            books,
        })
    }

    /// Returns the driving of the last hour, on a clock with its origin `origin_s` after the computer's start: all
    /// spans of a participant's own account, and the spans of the bench's account that count for them.
    fn earlier_driving(&self, boot: &Boot, origin_s: f64, now: Timestamp) -> SlidingHour {
        let mut hour = SlidingHour::default();
        for book in &self.books {
            let counts = |span: &&Driven| self.owner.counts(span.owner);
            let spans: Vec<Driven> = book.spans.iter().filter(counts).cloned().collect();
            for (start_s, end_s) in dose_record::on_this_run(&spans, boot, now) {
                let ns = |up_s: f64| ((up_s - origin_s) * 1e9) as i64;
                hour.add(DrivenSpan {
                    start_ns: ns(start_s),
                    end_ns: ns(end_s),
                });
            }
        }
        hour
    }

    /// Returns the time until `need_s` are free, s; 0 if they are free now.
    #[must_use]
    pub fn wait_s(&self, need_s: f64, boot: &Boot, now: Timestamp) -> f64 {
        let ns = |seconds: f64| (seconds * 1e9) as i64;
        let hour = self.earlier_driving(boot, boot.up_s, now);
        hour.wait_ns(0, ns(need_s), ns(self.limit_s)) as f64 * 1e-9
    }

    /// Returns the driving time allowed within an hour, s.
    #[must_use]
    pub fn limit_s(&self) -> f64 {
        self.limit_s
    }

    /// Returns the driving time that must be left to arm, s.
    #[must_use]
    pub fn need_s(&self) -> f64 {
        self.need_s
    }

    /// Returns the driving time left, s.
    #[must_use]
    pub fn remaining_s(&self, boot: &Boot, now: Timestamp) -> f64 {
        let used_s = self.earlier_driving(boot, boot.up_s, now).used_ns(0) as f64 * 1e-9;
        (self.limit_s - used_s).max(0.0)
    }

    /// Starts to count on the clock of a bench. Returns the allowance for its watch and, for an account on the disk,
    /// the task that writes it.
    pub(crate) fn begin(
        self,
        clock: &Arc<dyn Clock>,
        boot: Boot,
    ) -> (Allowance, Option<Box<dyn Task>>) {
        let now = clock.utc();
        let origin_s = boot.up_s - clock.since_origin_s();
        let earlier_driving = self.earlier_driving(&boot, origin_s, now);
        let (sender, spans) = safety::span_reports();
        let mut books = self.books;
        for book in &mut books {
            book.spans = dose_record::recent_spans(&book.spans, &boot, now);
        }
        let task = (!books.is_empty()).then(|| -> Box<dyn Task> {
            Box::new(DoseKeeper {
                books,
                owner: self.owner,
                clock: Arc::clone(clock),
                boot,
                origin_s,
                spans,
                open: None,
                written_s: 0.0,
            })
        });
        let allowance = Allowance {
            limit_s: self.limit_s,
            need_s: self.need_s,
            earlier_driving,
            spans: task.is_some().then_some(sender),
        };
        (allowance, task)
    }
}

fn read(path: &Path) -> Result<Vec<Driven>, DoseError> {
    match bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES) {
        Ok(text) => dose_record::parse(&text).map_err(|source| DoseError::Damaged {
            path: path.to_owned(),
            source,
        }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(source) => Err(DoseError::Unreadable {
            path: path.to_owned(),
            source,
        }),
    }
}

/// Task that writes an account to the disk.
struct DoseKeeper {
    /// Records, each with its finished spans.
    books: Vec<Book>,
    owner: AccountOwner,
    clock: Arc<dyn Clock>,
    boot: Boot,
    /// Origin of the bench's clock, in seconds of this run of the computer, suspensions included.
    origin_s: f64,
    spans: Receiver<DrivenSpan>,
    open: Option<DrivenSpan>,
    /// Length of the open span on the disk, s.
    written_s: f64,
}

fn length_s(span: DrivenSpan) -> f64 {
    (span.end_ns - span.start_ns) as f64 * 1e-9
}

impl DoseKeeper {
    fn take(&mut self, span: DrivenSpan) -> Result<(), DiskError> {
        if self.open.is_some_and(|open| open.start_ns != span.start_ns) {
            self.end()?;
        }
        let begins = self.open.replace(span).is_none();
        if begins || length_s(span) + 0.5 * AHEAD_S > self.written_s {
            self.write(length_s(span) + AHEAD_S)?;
        }
        Ok(())
    }

    /// Returns `span` as a record. A suspension of the computer during or after the span places it later by the same
    /// time: the age of a span counts from its end.
    fn driven_span(&self, span: DrivenSpan, driven_s: f64) -> Driven {
        let start_s = span.start_ns as f64 * 1e-9;
        let ago_s = self.clock.now_ns() as f64 * 1e-9 - start_s;
        let elapsed = SignedDuration::try_from_secs_f64(ago_s).unwrap_or_default();
        let now = self.clock.utc();
        Driven {
            boot: self.boot.id.clone(),
            up_s: (self.origin_s + self.clock.since_origin_s() - ago_s).max(0.0),
            driven_s,
            date: now.saturating_sub(elapsed).unwrap_or(now),
            owner: self.owner,
            machine: self.boot.machine.clone(),
        }
    }

    /// Writes the records with the open span at a length of `driven_s`.
    fn write(&mut self, driven_s: f64) -> Result<(), DiskError> {
        let open = self.open.map(|span| self.driven_span(span, driven_s));
        for book in &self.books {
            let spans: Vec<Driven> = book.spans.iter().cloned().chain(open.clone()).collect();
            replace_file(&book.path, (book.to_text)(&spans).as_bytes())?;
        }
        self.written_s = driven_s;
        Ok(())
    }

    /// Ends the open span and writes its final length.
    fn end(&mut self) -> Result<(), DiskError> {
        if let Some(span) = self.open {
            self.write(length_s(span))?;
            let last_span = self.driven_span(span, length_s(span));
            for book in &mut self.books {
                book.spans.push(last_span.clone());
            }
            self.open = None;
        }
        Ok(())
    }

    fn keep(&mut self) -> anyhow::Result<()> {
        while let Ok(span) = self.spans.try_recv() {
            self.take(span)?;
        }
        Ok(())
    }
}

impl Task for DoseKeeper {
    fn name(&self) -> &'static str {
        "driving time"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(20)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        self.keep()?;
        let over_ns = now_ns as i64 - (OVER_S * 1e9) as i64;
        if self.open.is_some_and(|span| span.end_ns < over_ns) {
            self.end()?;
        }
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.keep()?;
        let now_ns = self.clock.now_ns() as i64;
        if let Some(open) = &mut self.open
            && now_ns - open.end_ns < LATE_NS
        {
            // The watch may have ended before its last report.
            open.end_ns = now_ns;
        }
        Ok(self.end()?)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use crossbeam_channel::Sender;

    use super::*;
    use crate::testing::{Hands, boot};

    fn span(start_s: f64, end_s: f64) -> DrivenSpan {
        DrivenSpan {
            start_ns: (start_s * 1e9) as i64,
            end_ns: (end_s * 1e9) as i64,
        }
    }

    struct Rig {
        folder: tempfile::TempDir,
        clock: Arc<Hands>,
        task: Box<dyn Task>,
        spans: Sender<DrivenSpan>,
    }

    impl Rig {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let account = Self::account_in(folder.path());
            let clock = Arc::new(Hands::default());
            let shared: Arc<dyn Clock> = clock.clone();
            let (allowance, task) = account.begin(&shared, boot(1000.0));
            Self {
                folder,
                clock,
                task: task.unwrap(),
                spans: allowance.spans.unwrap(),
            }
        }

        fn account_in(folder: &Path) -> DoseAccount {
            Self::account_with(folder, AccountOwner::Named)
        }

        /// Returns the account of a drive on the bench that has its files in `folder`, as has its only participant.
        fn account_with(folder: &Path, owner: AccountOwner) -> DoseAccount {
            let paths = AccountPaths {
                participant: (owner == AccountOwner::Named).then(|| participant_path(folder)),
                bench: bench_path(&folder.join("calibration.toml")),
            };
            DoseAccount::open(Some(paths), owner, 600.0, 10.0).unwrap()
        }

        fn drive(&mut self, start_s: f64, end_s: f64) {
            self.spans.send(span(start_s, end_s)).unwrap();
            self.advance(end_s);
        }

        fn advance(&mut self, now_s: f64) {
            let now_ns = (now_s * 1e9) as u64;
            self.clock.0.store(now_ns, Ordering::Relaxed);
            self.task.poll(now_ns).unwrap();
        }

        /// Returns the driving time that another program finds left when this one has been on for `now_s`, s.
        fn remaining_s(&self, now_s: f64) -> f64 {
            let account = Self::account_in(self.folder.path());
            account.remaining_s(&boot(1000.0 + now_s), self.clock.utc())
        }
    }

    /// Fault 42.
    #[test]
    fn a_program_that_is_killed_while_it_drives_has_counted_more_than_it_drove() {
        let mut rig = Rig::new();
        rig.drive(10.0, 10.0);
        for step in 0..=4000 {
            let now_s = 10.0 + 0.01 * f64::from(step);
            if step % 25 == 0 {
                rig.drive(10.0, now_s);
                let counted_s = 600.0 - rig.remaining_s(now_s);
                let driven_s = now_s - 10.0;
                assert!(
                    counted_s > driven_s && counted_s <= driven_s + AHEAD_S,
                    "{counted_s}"
                );
            }
        }
        rig.advance(60.0);
        assert!(
            (rig.remaining_s(60.0) - 560.0).abs() < 1e-3,
            "corrected at the end"
        );
    }

    #[test]
    fn the_end_of_the_program_writes_the_driving_time() {
        let mut rig = Rig::new();
        rig.drive(1.0, 8.0);
        rig.drive(20.0, 23.0);
        rig.task.finish().unwrap();
        assert!((rig.remaining_s(24.0) - 590.0).abs() < 1e-3);
        assert!((rig.remaining_s(24.0 + 3600.0) - 600.0).abs() < 1e-3);
        let account = Rig::account_in(rig.folder.path());
        let now = rig.clock.utc();
        assert_eq!(account.wait_s(590.0, &boot(1024.0), now), 0.0);
        // All of it is free again an hour after the end of the second drive.
        let wait_s = account.wait_s(600.0, &boot(1024.0), now);
        assert!((wait_s - 3599.0).abs() < 1e-3, "{wait_s}");
    }

    /// The lid is closed over lunch, and the plate driven afterwards by the same program.
    /// Fault 42.
    /// Hazard 5.
    #[test]
    fn what_was_driven_after_a_suspension_is_not_older_for_it() {
        let mut rig = Rig::new();
        rig.drive(1.0, 2.0);
        rig.advance(10.0);
        rig.clock.1.store(3600, Ordering::Relaxed);
        rig.drive(20.0, 500.0);
        rig.task.finish().unwrap();
        let book = read(&participant_path(rig.folder.path())).unwrap();
        let last = book.last().unwrap();
        assert!((last.up_s - 4620.0).abs() < 1e-3, "{}", last.up_s);
        let since = last.date.duration_since(Timestamp::UNIX_EPOCH);
        assert!((since.as_secs_f64() - 3620.0).abs() < 1e-3);
        // The next program, directly after this one.
        let left_s = rig.remaining_s(3600.0 + 500.0);
        assert!((left_s - 120.0).abs() < 1e-3, "{left_s}");
    }

    #[test]
    fn nothing_is_written_for_a_bench_that_is_not_driven() {
        let mut rig = Rig::new();
        rig.advance(100.0);
        rig.task.finish().unwrap();
        assert!(!participant_path(rig.folder.path()).exists());
    }

    /// Hazards 4, 5, 6.
    #[test]
    fn an_unnamed_finger_may_be_anybodys_and_a_calibration_has_none() {
        let folder = tempfile::tempdir().unwrap();
        let clock = Arc::new(Hands::default());
        let shared: Arc<dyn Clock> = clock.clone();
        let left_s = |record_folder: &Path, owner| {
            let left_s =
                Rig::account_with(record_folder, owner).remaining_s(&boot(1100.0), clock.utc());
            left_s.round()
        };
        let drive = |owner, driven_s: f64, at_s: f64| {
            let (allowance, task) =
                Rig::account_with(folder.path(), owner).begin(&shared, boot(1000.0));
            let driven_span = span(at_s, at_s + driven_s);
            allowance.spans.unwrap().send(driven_span).unwrap();
            task.unwrap().finish().unwrap();
        };
        clock.0.store(100_000_000_000, Ordering::Relaxed);
        let remaining_s = || {
            [
                AccountOwner::Nobody,
                AccountOwner::Unnamed,
                AccountOwner::Named,
            ]
            .map(|owner| left_s(folder.path(), owner))
        };
        // A participant's session does not count for calibrations.
        drive(AccountOwner::Named, 10.0, 0.0);
        assert_eq!(remaining_s(), [600.0, 590.0, 590.0]);
        drive(AccountOwner::Unnamed, 5.0, 20.0);
        assert_eq!(remaining_s(), [595.0, 585.0, 585.0]);
        drive(AccountOwner::Nobody, 7.0, 30.0);
        assert_eq!(remaining_s(), [588.0, 578.0, 585.0]);
        // The first participant's driving time does not count for another participant.
        std::fs::remove_file(participant_path(folder.path())).unwrap();
        assert_eq!(remaining_s(), [588.0, 578.0, 595.0]);
        let words =
            std::fs::read_to_string(bench_path(&folder.path().join("calibration.toml"))).unwrap();
        let owner: Vec<_> = words
            .lines()
            .skip(1)
            .map(|line| line.split('\t').nth(4).unwrap())
            .collect();
        assert_eq!(owner, ["named", "unnamed", "nobody"]);
    }

    #[test]
    fn a_damaged_account_is_refused_by_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = participant_path(folder.path());
        let open = |path: &Path| {
            let paths = AccountPaths {
                participant: Some(path.to_owned()),
                bench: bench_path(&folder.path().join("calibration.toml")),
            };
            DoseAccount::open(Some(paths), AccountOwner::Named, 600.0, 10.0)
        };
        std::fs::write(&path, "boot\tup_s\tdriven_s\tdate\nabc\t1.0\t2").unwrap();
        let error = open(&path).unwrap_err();
        assert!(
            matches!(&error, DoseError::Damaged { path: damaged_path, .. } if *damaged_path == path)
        );
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        let error = open(&path).unwrap_err();
        assert!(matches!(error, DoseError::Unreadable { .. }));
    }

    #[test]
    fn a_simulated_bench_keeps_nothing() {
        let account = DoseAccount::open(None, AccountOwner::Named, 600.0, 10.0).unwrap();
        let clock: Arc<dyn Clock> = Arc::new(Hands::default());
        let (allowance, task) = account.begin(&clock, boot(5.0));
        assert!(task.is_none() && allowance.spans.is_none());
    }
}
