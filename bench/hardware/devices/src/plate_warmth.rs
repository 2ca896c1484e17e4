//! Temperature of the plate, kept from one program to the next: a small file that always states a temperature at least
//! as high as the estimate, so that it is not too low after a crash or for another program.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use recording::DiskError;
use recording::disk::replace_file;
use safety::{PlateHeat, Signals};
use tasks::{Clock, Task};

use crate::boot::Boot;
use crate::dose_record::DamagedLine;
use crate::heat_record::{self, Warmth};

/// Lead of the file over the temperature of a warming plate, K.
const AHEAD_K: f64 = 0.5;
/// Rise below which a plate counts as cold, K.
const COLD_K: f64 = 0.1;

/// A record of the plate's warmth that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum WarmthError {
    /// The file is damaged.
    #[error(
        "{} cannot be used, so nobody can tell how warm the plate is: put it back from a copy, or move it away once nothing \
         has been driven for an hour",
        path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The line.
        source: DamagedLine,
    },
    /// The file cannot be read.
    #[error("cannot read {}, which says how warm the plate is", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error(
        "cannot keep how warm the plate is: name a calibration in a folder of yours with --calibration"
    )]
    Unwritable(#[source] DiskError),
}

/// Temperature of a plate as recorded by earlier programs.
#[derive(Debug)]
pub struct PlateWarmth {
    heat: PlateHeat,
    /// Path of the record; `None` for a record that ends with the program.
    path: Option<PathBuf>,
    /// Record of the last program; `None` for a plate that was never driven.
    warmth: Option<Warmth>,
}

/// Returns the path of the record of a bench's plate, in the folder of its calibration.
#[must_use]
pub fn warmth_path(calibration: &Path) -> PathBuf {
    let stem = calibration.file_stem().unwrap_or_default();
    calibration.with_file_name(format!("{}-warmth.tsv", stem.to_string_lossy()))
}

impl PlateWarmth {
    /// Opens the record at `path` for a plate with these thermal constants. Without `path`, as for a simulated plate,
    /// every program begins at the temperature of the room.
    ///
    /// # Errors
    /// [`WarmthError`] if the plate's temperature is unknown.
    pub fn open(path: Option<PathBuf>, heat: PlateHeat) -> Result<Self, WarmthError> {
        let warmth = match &path {
            Some(path) => read(path)?,
            None => None,
        };
        Ok(Self { heat, path, warmth })
    }

    /// Returns the estimated temperature above the room, K.
    #[must_use]
    pub fn rise_k(&self, boot: &Boot, now: Timestamp) -> f64 {
        self.warmth
            .as_ref()
            .map_or(0.0, |warmth| cooled_k(&self.heat, warmth, boot, now))
    }

    /// Returns the estimated temperature of the surface, °C.
    #[must_use]
    pub fn surface_c(&self, boot: &Boot, now: Timestamp) -> f64 {
        self.heat.surface_c(self.rise_k(boot, now))
    }

    /// Returns the time until the plate is cool enough to be driven, s; 0 if it is now.
    #[must_use]
    pub fn wait_s(&self, boot: &Boot, now: Timestamp) -> f64 {
        self.heat.wait_s(self.rise_k(boot, now))
    }

    /// Starts to record the temperature that a watch publishes in `signals`. Returns the present temperature above the
    /// room, K, and, for a record on the disk, the task that writes it.
    ///
    /// # Errors
    /// [`WarmthError::Unwritable`] if the record cannot be written, before anything is driven.
    pub(crate) fn begin(
        self,
        clock: &Arc<dyn Clock>,
        boot: Boot,
        signals: &Arc<Signals>,
    ) -> Result<(f64, Option<Box<dyn Task>>), WarmthError> {
        let rise_k = self.rise_k(&boot, clock.utc());
        let Some(path) = self.path else {
            return Ok((rise_k, None));
        };
        let mut keeper = WarmthKeeper {
            path,
            heat: self.heat,
            origin_s: boot.up_s - clock.since_origin_s(),
            boot,
            clock: Arc::clone(clock),
            signals: Arc::clone(signals),
            written: None,
        };
        keeper.write(rise_k).map_err(WarmthError::Unwritable)?;
        Ok((rise_k, Some(Box::new(keeper))))
    }
}

fn cooled_k(heat: &PlateHeat, warmth: &Warmth, boot: &Boot, now: Timestamp) -> f64 {
    heat.rise_after(warmth.rise_k, 0.0, warmth.age_s(boot, now))
}

fn read(path: &Path) -> Result<Option<Warmth>, WarmthError> {
    let path_of = || path.to_owned();
    match bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES) {
        Ok(text) => heat_record::parse(&text)
            .map(Some)
            .map_err(|source| WarmthError::Damaged {
                path: path_of(),
                source,
            }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(source) => Err(WarmthError::Unreadable {
            path: path_of(),
            source,
        }),
    }
}

/// Task that writes the record to the disk.
struct WarmthKeeper {
    path: PathBuf,
    heat: PlateHeat,
    /// Run of the computer in which the program began.
    boot: Boot,
    /// Origin of the bench's clock, in seconds of this run of the computer, suspensions included.
    origin_s: f64,
    clock: Arc<dyn Clock>,
    signals: Arc<Signals>,
    written: Option<Warmth>,
}

impl WarmthKeeper {
    fn boot(&self) -> Boot {
        Boot {
            up_s: (self.origin_s + self.clock.since_origin_s()).max(0.0),
            ..self.boot.clone()
        }
    }

    fn write(&mut self, rise_k: f64) -> Result<(), DiskError> {
        let Boot { id, up_s, machine } = self.boot();
        let warmth = Warmth {
            boot: id,
            up_s,
            rise_k,
            date: self.clock.utc(),
            machine,
        };
        replace_file(&self.path, heat_record::to_text(&warmth).as_bytes())?;
        self.written = Some(warmth);
        Ok(())
    }

    /// Returns the temperature above the room that a program started now would read, K.
    fn recorded_k(&self) -> f64 {
        self.written.as_ref().map_or(0.0, |written| {
            cooled_k(&self.heat, written, &self.boot(), self.clock.utc())
        })
    }
}

impl Task for WarmthKeeper {
    fn name(&self) -> &'static str {
        "plate's warmth"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(50)
    }

    fn poll(&mut self, _now_ns: u64) -> anyhow::Result<()> {
        if let Some(rise_k) = self.signals.rise_k.get()
            && rise_k > COLD_K.max(self.recorded_k())
        {
            self.write(rise_k + AHEAD_K)?;
        }
        self.signals.kept_rise_k.set(self.recorded_k());
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        if let Some(rise_k) = self.signals.rise_k.get() {
            self.write(rise_k)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use super::*;
    use crate::testing::{Hands, boot};

    const HEAT: PlateHeat = PlateHeat {
        force_factor_n_per_v: 0.13,
        omega_rad_per_s: 219_911.5,
        capacity_j_per_k: 14.0,
        loss_w_per_k: 0.1,
        room_c: 25.0,
        limit_c: 40.0,
    };

    /// Time since the computer's start when the program's clock was at zero, s.
    const UP_S: f64 = 1000.0;

    struct Rig {
        folder: tempfile::TempDir,
        clock: Arc<Hands>,
        signals: Arc<Signals>,
        task: Box<dyn Task>,
        began_k: f64,
    }

    impl Rig {
        fn new() -> Self {
            Self::restarted(tempfile::tempdir().unwrap(), UP_S)
        }

        /// Starts the next program on the bench when the computer has been on for `up_s`.
        fn restarted(folder: tempfile::TempDir, up_s: f64) -> Self {
            let clock = Arc::new(Hands::default());
            let shared: Arc<dyn Clock> = clock.clone();
            let signals = Arc::new(Signals::default());
            let warmth = Self::opened(folder.path());
            let (began_k, task) = warmth.begin(&shared, boot(up_s), &signals).unwrap();
            Self {
                folder,
                clock,
                signals,
                task: task.unwrap(),
                began_k,
            }
        }

        fn opened(folder: &Path) -> PlateWarmth {
            let path = warmth_path(&folder.join("calibration.toml"));
            PlateWarmth::open(Some(path), HEAT).unwrap()
        }

        fn advance(&mut self, now_s: f64, rise_k: f64) {
            let now_ns = (now_s * 1e9) as u64;
            self.clock.0.store(now_ns, Ordering::Relaxed);
            self.signals.rise_k.set(rise_k);
            self.task.poll(now_ns).unwrap();
        }

        /// Returns the temperature above the room that another program would find if this one were killed now, K.
        fn recorded_k(&self) -> f64 {
            let up_s = UP_S + 1e-9 * self.clock.now_ns() as f64;
            Self::opened(self.folder.path()).rise_k(&boot(up_s), self.clock.utc())
        }
    }

    /// Fault 42.
    /// Hazard 4.
    #[test]
    fn a_program_that_is_killed_leaves_the_plate_no_cooler_than_it_was() {
        let mut rig = Rig::new();
        assert_eq!((rig.began_k, rig.recorded_k()), (0.0, 0.0));
        let (mut rise_k, step_s) = (0.0, 0.05);
        for step in 0..8_000 {
            // Four minutes at 3 W, then undriven.
            let power_w = if step < 4_800 { 3.0 } else { 0.0 };
            rise_k = HEAT.rise_after(rise_k, power_w, step_s);
            rig.advance(step_s * f64::from(step + 1), rise_k);
            let recorded_k = rig.recorded_k();
            let least_k = if rise_k > COLD_K { rise_k - 2e-3 } else { 0.0 };
            assert!(
                (least_k..=rise_k + AHEAD_K + 2e-3).contains(&recorded_k),
                "{recorded_k} K of {rise_k} K at {step}"
            );
            let published_k = rig.signals.kept_rise_k.get().unwrap();
            assert!(
                (published_k - recorded_k).abs() < 2e-3,
                "{published_k} K of {recorded_k} K"
            );
        }
        rig.task.finish().unwrap();
        assert!((rig.recorded_k() - rise_k).abs() < 2e-3);
    }

    /// Fault 42.
    /// Hazard 4.
    #[test]
    fn the_next_program_begins_with_what_the_model_has_cooled() {
        let mut rig = Rig::new();
        rig.advance(10.0, 14.0);
        rig.task.finish().unwrap();
        let warmth = Rig::opened(rig.folder.path());
        let now = rig.clock.utc();
        assert!((warmth.surface_c(&boot(1010.0), now) - 39.0).abs() < 1e-2);
        assert!((warmth.wait_s(&boot(1010.0), now) - HEAT.wait_s(14.0)).abs() < 0.1);
        assert_eq!(warmth.wait_s(&boot(1030.0), now), 0.0);
        // A minute and a half later; no program ran in between.
        let mut next = Rig::restarted(rig.folder, 1100.0);
        let cooled_k = HEAT.rise_after(14.0, 0.0, 90.0);
        assert!((next.began_k - cooled_k).abs() < 1e-2, "{}", next.began_k);
        // It ends before its watch publishes anything, and the record keeps its value.
        next.task.finish().unwrap();
        let third = Rig::restarted(next.folder, 1100.0);
        assert!((third.began_k - cooled_k).abs() < 1e-2);
    }

    /// Fault 42.
    /// Hazard 4.
    #[test]
    fn a_plate_that_was_driven_after_a_suspension_is_not_cooler_for_it() {
        let mut rig = Rig::new();
        rig.advance(10.0, 1.0);
        rig.clock.1.store(3600, Ordering::Relaxed);
        rig.advance(20.0, 14.0);
        rig.task.finish().unwrap();
        let warmth = Rig::opened(rig.folder.path());
        let recorded_k = warmth.rise_k(&boot(UP_S + 3620.0), rig.clock.utc());
        assert!((recorded_k - 14.0).abs() < 2e-3, "{recorded_k}");
    }

    #[test]
    fn a_damaged_record_is_refused_by_its_name_and_an_unwritable_one_before_the_drive() {
        let folder = tempfile::tempdir().unwrap();
        let path = warmth_path(&folder.path().join("calibration.toml"));
        std::fs::write(&path, "boot\tup_s\trise_k\tdate\nabc\t1.0\t2").unwrap();
        let error = PlateWarmth::open(Some(path.clone()), HEAT).unwrap_err();
        assert!(
            matches!(&error, WarmthError::Damaged { path: damaged_path, .. } if *damaged_path == path)
        );
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        let error = PlateWarmth::open(Some(path), HEAT).unwrap_err();
        assert!(matches!(error, WarmthError::Unreadable { .. }));
        let missing_path = Some(folder.path().join("nowhere").join("warmth.tsv"));
        let clock: Arc<dyn Clock> = Arc::new(Hands::default());
        let result = PlateWarmth::open(missing_path, HEAT).unwrap().begin(
            &clock,
            boot(UP_S),
            &Arc::new(Signals::default()),
        );
        assert!(matches!(result, Err(WarmthError::Unwritable(_))));
    }

    #[test]
    fn a_simulated_plate_keeps_nothing() {
        let clock: Arc<dyn Clock> = Arc::new(Hands::default());
        let warmth = PlateWarmth::open(None, HEAT).unwrap();
        let result = warmth.begin(&clock, boot(UP_S), &Arc::new(Signals::default()));
        assert!(matches!(result, Ok((0.0, None))));
    }
}
