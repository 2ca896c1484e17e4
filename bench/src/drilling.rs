//! `drill`: the operator's rehearsal, from flags to the summary at the end.

use std::io::Write;

use config::{Config, Effective};
use devices::stop_on_signals;
pub use drill::WatchedHardware;
use drill::{Course, DrillRecord, Scripted};
use operator_ui::console::{Dashboard, DashboardThread, Front, LineQueue, StopKeys};
use safety::DriveStop;
use tasks::StopFlag;
use tui::Event;
use tui::event::{LogLevel, SessionHeader};

use crate::apparatus::pace;
use crate::cli;

/// Plans the drill of these options without opening or driving anything.
///
/// # Errors
/// Names the fault that cannot be drilled on this bench, or the error in its limits.
pub fn plan(bench: Effective, options: &cli::Drill) -> anyhow::Result<Course> {
    if options.speed == cli::Speed::Max && !options.headless {
        anyhow::bail!("--speed max leaves the operator no time to act: add --headless");
    }
    if options.operator.trim().is_empty() {
        anyhow::bail!("--operator is empty: name who is drilled");
    }
    let hardware = &options.hardware;
    let pace = pace(bench.config(), hardware);
    Course::new(
        bench,
        &options.only,
        hardware.mock.is_some(),
        pace,
        hardware.seed,
        &options.operator,
        options.headless,
    )
}

/// Runs the drill; returns its record and its last lines.
///
/// # Errors
/// When a part of the bench is missing or fails, or the record cannot be written.
pub fn run(
    course: &Course,
    options: &cli::Drill,
    config: &Config,
    open: impl FnMut() -> anyhow::Result<WatchedHardware>,
    out: impl Write + Send + 'static,
) -> anyhow::Result<(DrillRecord, Vec<String>)> {
    let quit = StopFlag::default();
    let _listening = stop_on_signals(&quit)?;
    let drive = DriveStop::default();
    let (mut front, dashboard): (Box<dyn Front>, Option<DashboardThread>) = if options.headless {
        (Box::new(Scripted::new(LineQueue::start(out)?)), None)
    } else {
        let (dashboard, thread) = Dashboard::open(quit.clone(), StopKeys::new(drive.clone()))?;
        (Box::new(dashboard), Some(thread))
    };
    front.show(Event::Session(SessionHeader {
        uncalibrated: options.uncalibrated,
        simulated: options.hardware.mock.is_some(),
        plate_length_m: config.plate.length_m,
        ..SessionHeader::default()
    }));
    for text in config.safety_notices(config.plate.resonance_hz, pace(config, &options.hardware)) {
        let level = LogLevel::Warning;
        front.show(Event::Log { level, text });
    }
    let result = course.run(&options.out, front, (&quit, &drive), open);
    let thread_result = dashboard.map_or(Ok(()), DashboardThread::join);
    let (record, folder) = result?;
    thread_result?;
    let mut lines = record.lines();
    lines.push(format!("times             {}", folder.file().display()));
    Ok((record, lines))
}
