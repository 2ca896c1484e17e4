//! `run`: a participant's session, from the files to the last line of the summary.

mod announcement;
mod composition;
mod concerns;
mod edited_protocol;
mod files;
mod lost_recordings;
mod opening;
mod participant_session;
mod plan;

use std::io::Write;
use std::path::Path;

use devices::Life;
use escaping::quoted;
use operator_ui::console::{Dashboard, DashboardThread, Front, Headless, LineQueue, StopKeys};
use protocols::ParticipantId;

use crate::apparatus::BenchHardware;
use crate::session::{KeptUp, SessionReport, summary_lines};
use composition::{ComposedSession, Surroundings};
use files::EarlierPart;
use participant_session::ParticipantSession;

pub use concerns::ConcernKind;
pub use files::require_session;
pub use plan::{ProtocolFile, SessionPlan};

/// Runs the session to its end. `open_front` opens the operator's screen; quitting that screen ends the bench.
///
/// # Errors
/// When a part of the bench is missing or fails; a session that ends early for other reasons is a [`SessionReport`].
pub fn run(
    plan: SessionPlan,
    apparatus: BenchHardware,
    open_front: impl FnOnce(&SessionPlan, &Life) -> anyhow::Result<SessionFront>,
) -> anyhow::Result<(SessionReport, KeptUp)> {
    let BenchHardware {
        hardware,
        watchers,
        displays,
        ..
    } = apparatus;
    let (simulated, clock) = (hardware.simulated, hardware.clock.clone());
    let config = plan.bench.config();
    let facts = operator_ui::bench_page::facts(config, plan.bench.file(), &hardware);
    // Before the sound card waits to be read.
    let earlier = EarlierPart::read(&plan)?;
    let (mut bench, ledger) = opening::open(&plan, hardware)?;
    let mut session = ParticipantSession::open(&plan, &earlier, clock)?;
    let trials = session.machine.trials_left();
    let left = opening::charge(&plan, &mut bench, ledger, trials)?;
    let protocol_file = session.start(&plan, &bench.life, simulated)?;

    let (mut front, dashboard) = open_front(&plan, &bench.life)?;
    let screen = front.as_mut();
    let on_bench = (&bench, facts, simulated);
    announcement::show_bench(screen, &plan, &session, on_bench, (earlier, left));
    let sound = announcement::open_sound(screen, &bench.life, config);
    announcement::show_participant(screen, &plan, &session);

    let surroundings = Surroundings {
        front,
        watchers,
        displays,
        sound,
    };
    let composed = ComposedSession::new(&plan, session, protocol_file, bench, surroundings)?;
    composed.run(dashboard)
}

/// The operator's front end of a session, and the thread of its screen if there is one.
pub type SessionFront = (Box<dyn Front>, Option<DashboardThread>);

/// Returns the dashboard on this process's terminal; a headless session writes lines to `out` instead.
pub fn terminal_front(
    out: impl Write + Send + 'static,
) -> impl FnOnce(&SessionPlan, &Life) -> anyhow::Result<SessionFront> {
    move |plan, life| {
        if plan.headless {
            return Ok((Box::new(Headless::new(LineQueue::start(out)?)), None));
        }
        let stop = life.stop().clone();
        let keys = StopKeys::new(life.drive_stop().clone()).with_end(stop.clone());
        let (dashboard, thread) = Dashboard::open(stop, keys)?;
        Ok((Box::new(dashboard), Some(thread)))
    }
}

/// Returns the lines printed at the end.
pub fn report_lines(
    report: &SessionReport,
    kept_up: &KeptUp,
    study: &Path,
    participant: &ParticipantId,
) -> Vec<String> {
    let mut lines = summary_lines(&report.summary, &report.account);
    lines.push(kept_up.line());
    lines.extend(kept_up.clock_lines());
    let folder = study.join(participant.as_str());
    lines.push(format!("recordings        {}", folder.display()));
    match &report.reason {
        Some(reason) => {
            lines.push(format!("ended early       {reason}"));
            lines.push("to resume         the same command with --resume".to_owned());
        }
        None => lines.push(format!(
            "to results        friction-bench analyze {} --table --figures figures",
            quoted(&folder)
        )),
    }
    lines
}
