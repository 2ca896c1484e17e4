//! Calibrations and a session on a simulated bench, for the pictures of the operator's screen; in lock step, so that the
//! screens are reproducible.

use std::path::Path;
use std::sync::{Arc, Mutex};

use bench_tests::in_process::{Setup, apparatus, apparatus_with_faults, config, options};
use bench_tests::session::require_consistent;
use calibration::masses::{Accuracy, ForceProcedure, ForceSetup, from_g};
use calibration::pickup::{PickupProcedure, PickupSetup};
use calibration::plate_procedure::{PlateProcedure, PlateSetup};
use calibration_rig::clear::ClearPlate;
use calibration_rig::guided::Guided;
use calibration_rig::instrument_line::LineUnit;
use calibration_rig::judged::Calibrates;
use calibration_rig::known::{Instrument, Known};
use calibration_rig::operator::ForceAxis;
use calibration_rig::rig;
use config::{CalibrationFile, Effective, Identity};
use devices::driving_time;
use friction_bench::cli;
use friction_bench::run::{SessionPlan, run};
use mock_world::scenario::{Scenario, built_in};
use operator_ui::console::Front;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use tui::calibration_page::{Question, Reply};
use tui::event::{BenchFacts, SessionHeader, SystemHealth};
use tui::{Action, Event, State, Theme, view};

/// Seed of the person, and of the bench with constants that the program does not know.
const SEED: u64 = 7;
/// Number of readings for which the simulated operator waits before answering: one second.
const PATIENCE: u32 = 20;

/// A screen to capture, and its condition.
pub struct Shot {
    pub name: &'static str,
    pub condition: fn(&State) -> bool,
    /// Number of readings after the condition for which the screen settles.
    pub settling: u32,
    /// The operator's next action.
    pub deed: Option<Deed>,
}

/// Action of an operator after a capture.
#[derive(Clone, Copy)]
pub enum Deed {
    PressEstop,
    Leave,
}

/// Captured states of the screen, by name.
pub type Captures = Arc<Mutex<Vec<(&'static str, State)>>>;

/// Simulated operator, who captures the screen and answers the questions of a calibration.
struct Operator {
    state: State,
    shots: Vec<Shot>,
    captures: Captures,
    deed: Box<dyn FnMut(Deed) -> Option<Action> + Send>,
    /// Number of readings since the question.
    reading_count: u32,
    actions: Vec<Action>,
}

impl Operator {
    fn new(
        shots: Vec<Shot>,
        captures: &Captures,
        deed: impl FnMut(Deed) -> Option<Action> + Send + 'static,
    ) -> Self {
        let mut state = State::new(Theme::Colour);
        state.apply(&Event::Tick { now_s: 0.0 });
        Self {
            state,
            shots,
            captures: captures.clone(),
            deed: Box::new(deed),
            reading_count: 0,
            actions: Vec::new(),
        }
    }

    fn answer(&self) -> Option<Reply> {
        let page = self.state.calibration.as_ref()?;
        if self.reading_count < PATIENCE {
            return None;
        }
        Some(match page.asked.as_ref()? {
            Question::Done | Question::Review => Reply::Ready,
            // Read off the instrument's display, with its four decimals.
            Question::Number { .. } => {
                let shown_um = self.state.readings.and_then(|readings| readings.known_m)? * 1e6;
                Reply::Number((shown_um * 1e4).round() * 1e-4)
            }
        })
    }
}

/// Returns the event without the disk, folder and speed of this computer.
fn strip_computer(event: Event) -> Event {
    match event {
        Event::Session(header) => Event::Session(SessionHeader {
            study: header.study.map(|_| "my-study".to_owned()),
            ..header
        }),
        Event::Health(health) => Event::Health(SystemHealth {
            ring_fill: 0.0,
            recorder_lag_s: 0.0,
            speed: 1.0,
            disk_free_bytes: None,
            disk_sessions: Some(400),
            cores: None,
            ..health
        }),
        event => event,
    }
}

impl Front for Operator {
    fn show(&mut self, event: Event) {
        let event = strip_computer(event);
        match &event {
            Event::Live(live) => self.state.apply(&Event::Tick { now_s: live.t_s }),
            Event::CalibrationReadings(_) => self.reading_count += 1,
            Event::Calibration(_) => self.reading_count = 0,
            _ => {}
        }
        self.state.apply(&event);
        if !matches!(event, Event::Live(_) | Event::CalibrationReadings(_)) {
            return;
        }
        let is_due = |shot: &mut Shot| {
            let is_met = (shot.condition)(&self.state);
            shot.settling = shot.settling.saturating_sub(is_met.into());
            is_met && shot.settling == 0
        };
        if let Some(index) = self.shots.iter_mut().position(is_due) {
            let shot = self.shots.remove(index);
            let capture = (shot.name, self.state.clone());
            self.captures.lock().unwrap().push(capture);
            self.actions
                .extend(shot.deed.and_then(|deed| (self.deed)(deed)));
        }
    }

    fn action(&mut self) -> Option<Action> {
        if let Some(reply) = self.answer() {
            self.reading_count = 0;
            return Some(Action::Answer(reply));
        }
        self.actions.pop()
    }
}

/// Returns a bench with constants other than in its configuration, and a person who follows the slider badly at first.
fn scenario() -> Scenario {
    let behaviour = built_in("participant-late").unwrap().participant.behaviour;
    let mut scenario = built_in("bench-unknown").unwrap().draw(SEED);
    scenario.participant.behaviour = behaviour;
    scenario
}

fn setup() -> Setup {
    Setup {
        scenario: scenario(),
        button: true,
        ..Setup::default()
    }
}

/// Measures by `procedure` and adds the result to `calibration`.
fn calibrate<C: Calibrates>(
    calibration: &mut CalibrationFile,
    (bench, folder): (&Effective, &Path),
    shots: Vec<Shot>,
    captures: &Captures,
    procedure: C,
) {
    let bench = bench.clone();
    let apparatus = apparatus(setup());
    let hardware = apparatus.hardware;
    let instrument = (C::NAME == "pickup").then(|| {
        let port = apparatus.vibrometer_port.unwrap();
        Instrument::open(&port, 115_200, LineUnit::micrometres()).unwrap()
    });
    let ledger = driving_time::clear_plate_account(folder, bench.config(), &hardware).unwrap();
    let operator = Operator::new(shots, captures, |_| None);
    let title = format!("calibrate {}", C::NAME);
    let outcome = rig::run(
        &bench,
        hardware,
        ledger,
        apparatus.hands,
        instrument,
        |_| {
            let front = Guided::new(operator, title, true, BenchFacts::default(), &[]);
            Ok((Box::new(front), None))
        },
        procedure,
    )
    .unwrap();
    let judgement = outcome.procedure.judge(outcome.date, "A. Tester").unwrap();
    assert!(judgement.faults.is_empty(), "{:?}", judgement.faults);
    if calibration.identity.input_device.is_empty() {
        calibration.identity = outcome.identity;
    }
    judgement.part.put_into(calibration);
}

/// Calibrates pickup, plate and force sensor with guidance for the operator, captures a shot of each, and writes the
/// calibration to `path`.
pub fn calibrate_bench(path: &Path, [pickup, plate, force]: [Shot; 3], captures: &Captures) {
    let bench_config = config(&[]);
    let identity = Identity::from_config(&bench_config, String::new(), String::new());
    let mut calibration = CalibrationFile::new(identity);
    let bench_under = |calibration: &CalibrationFile| {
        Effective::under_calibration(bench_config.clone(), calibration)
    };

    let bench = bench_under(&calibration);
    let setup = PickupSetup::new(
        bench.config(),
        &calibration,
        Vec::new(),
        Known::Typed,
        None,
        0.001,
    );
    let procedure = PickupProcedure::new(setup.unwrap());
    let procedure = ClearPlate::new(procedure, bench.config(), true);
    calibrate(
        &mut calibration,
        (&bench, path),
        vec![pickup],
        captures,
        procedure,
    );

    let bench = bench_under(&calibration);
    let setup = PlateSetup::new(bench.config(), &calibration, 20.0).unwrap();
    let procedure = ClearPlate::new(PlateProcedure::new(setup), bench.config(), true);
    calibrate(
        &mut calibration,
        (&bench, path),
        vec![plate],
        captures,
        procedure,
    );

    let bench = bench_under(&calibration).with_raw_forces();
    let masses = [
        from_g(ForceAxis::Normal, &[20.0, 50.0, 100.0, 200.0]),
        from_g(ForceAxis::Lateral, &[20.0, 50.0, 100.0]),
    ];
    let accuracy = Accuracy {
        masses: 1e-3,
        pulley: 1e-2,
    };
    let setup = ForceSetup::new(bench.config(), masses.concat(), accuracy, None).unwrap();
    let procedure = ForceProcedure::new(setup, true);
    calibrate(
        &mut calibration,
        (&bench, path),
        vec![force],
        captures,
        procedure,
    );
    std::fs::write(path, calibration.to_text().unwrap()).unwrap();
}

/// Runs the protocol `demo` in `folder` on the calibrated bench until the operator leaves.
pub fn session(folder: &Path, calibration: &Path, shots: Vec<Shot>, captures: &Captures) {
    let mut options = options(&folder.join("my-study"));
    options.protocol = "demo".to_owned();
    options.headless = false;
    options.hardware.calibration = Some(calibration.to_owned());
    options.hardware.mock = Some("bench-unknown".to_owned());
    options.uncalibrated = false;
    options.speed = cli::Speed::Max;
    let bench = Effective::calibrated(config(&[]), calibration).unwrap();
    let plan = SessionPlan::new(bench, &options).unwrap();
    let (apparatus, faults) = apparatus_with_faults(setup());
    let operator = Operator::new(shots, captures, move |deed| match deed {
        Deed::PressEstop => {
            faults.press_estop(true);
            None
        }
        Deed::Leave => Some(Action::Interrupt),
    });
    run(plan, apparatus, |_, _| Ok((Box::new(operator), None))).unwrap();
    require_consistent(&folder.join("my-study"));
}

/// Draws the dashboard.
pub fn draw(state: &State, (columns, rows): (u16, u16)) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
    terminal.draw(|frame| view(state, frame)).unwrap();
    terminal.backend().buffer().clone()
}
