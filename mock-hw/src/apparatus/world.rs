//! One period of the simulation, from percept to pins.

use std::path::PathBuf;
use std::sync::Arc;

use rand::RngExt;

use super::apparatus_error::ApparatusError;
use super::fault_panel::FaultPanel;
use super::force_side::ForceSide;
use super::mass_set::MassSet;
use super::patchbay::Patchbay;
use super::rehearsal_hand::{RehearsalHand, Timetable};
use super::senses::Senses;
use super::settings::ApparatusConfig;
use crate::host::SoundCards;
use crate::oscilloscope::Oscilloscope;
use crate::pins::PinBoard;
use crate::sound_layer::SoundLayer;
use crate::vibrometer::Vibrometer;
use crate::voltmeter::Voltmeter;
use crate::world_clock::{BASE_RATE_HZ, WorldClock};
use mock_world::fingertip::Fingertip;
use mock_world::person::VirtualPerson;
use mock_world::plant::Plant;
use mock_world::run_truth::TruthWriter;
use mock_world::scenario::{PlateTable, SoundLayerTable};
use mock_world::seed;

/// Highest sampling rate of any converter, Hz.
const HIGHEST_RATE_HZ: u32 = 250_000;

/// The simulated world, and its shared interfaces to the bench.
pub(super) struct World {
    clock: Arc<WorldClock>,
    cards: Arc<SoundCards>,
    board: Arc<PinBoard>,
    force: ForceSide,
    senses: Senses,
    masses: MassSet,
    timetable: Timetable,
    person: VirtualPerson,
    plant: Plant,
    patchbay: Patchbay,
    layer: SoundLayer,
    layer_table: SoundLayerTable,
    rate_hz: u32,
    /// Delay of each channel in the scenario, samples.
    skew_samples: Vec<f64>,
    /// Time from one input's sample to the next input's, s.
    stagger_s: f64,
    step: u64,
    truth_path: Option<PathBuf>,
    truth: Option<TruthWriter>,
    drive: Vec<f32>,
    inputs: Vec<f32>,
    vibrometer: Vibrometer,
    voltmeter: Voltmeter,
    oscilloscope: Option<Oscilloscope>,
    plate: PlateTable,
    /// Fraction of the spread of the sound layer's delay for this opening.
    delay_share: f64,
}

impl World {
    pub(super) fn new(
        config: &ApparatusConfig,
        clock: &Arc<WorldClock>,
        cards: &Arc<SoundCards>,
        board: &Arc<PinBoard>,
        force: &ForceSide,
        senses: &Senses,
        (vibrometer, voltmeter, oscilloscope): (Vibrometer, Voltmeter, Option<Oscilloscope>),
    ) -> Self {
        let opening_seed = config.seed.wrapping_add(config.opening.rotate_left(32));
        let delay_share =
            seed::stream(opening_seed, seed::RandomStream::SoundLayer).random::<f64>();
        let participant_seed = config.participant_seed.unwrap_or(config.seed);
        let scenario = &config.scenario;
        let skin = Fingertip::draw(scenario, participant_seed);
        let rate_hz = f64::from(BASE_RATE_HZ);
        let most_frames = clock.period_frames_at(HIGHEST_RATE_HZ);
        let masses = MassSet::default();
        let panel = FaultPanel::new(cards, board, force);
        Self {
            timetable: Timetable::new(&config.faults, panel, masses.clone()),
            clock: Arc::clone(clock),
            cards: Arc::clone(cards),
            board: Arc::clone(board),
            force: force.clone(),
            senses: senses.clone(),
            masses,
            person: VirtualPerson::draw(&scenario.participant, participant_seed),
            plant: Plant::with_fingertip(scenario, skin, config.seed, rate_hz),
            patchbay: Patchbay::default(),
            layer: SoundLayer::new(
                &scenario.sound_layer,
                scenario.converter.channels,
                rate_hz,
                delay_share,
            ),
            layer_table: scenario.sound_layer.clone(),
            rate_hz: BASE_RATE_HZ,
            skew_samples: (0..scenario.converter.channels)
                .map(|channel| scenario.converter.skew(channel))
                .collect(),
            stagger_s: 0.0,
            step: 0,
            truth_path: config.truth_path.clone(),
            truth: None,
            drive: vec![0.0; most_frames],
            inputs: vec![0.0; most_frames * scenario.converter.channels],
            vibrometer,
            voltmeter,
            oscilloscope,
            plate: scenario.plate.clone(),
            delay_share,
        }
    }

    /// Returns a handle that connects the inputs' cables.
    pub(super) fn patchbay(&self) -> Patchbay {
        self.patchbay.clone()
    }

    /// Returns a handle that places known masses.
    pub(super) fn masses(&self) -> MassSet {
        self.masses.clone()
    }

    /// Returns a handle that injects faults by name.
    pub(super) fn rehearsal(&self) -> RehearsalHand {
        self.timetable.hand()
    }

    /// Simulates one period.
    pub(super) fn step(&mut self) -> Result<(), ApparatusError> {
        let start_ns = self.clock.ns_of(self.step);
        self.follow_rate();
        self.begin_truth()?;
        self.timetable.carry_out(start_ns, self.cards.is_running());
        if let Some(estop) = self
            .oscilloscope
            .as_mut()
            .and_then(Oscilloscope::estop_change)
        {
            self.board.press_estop(estop);
        }
        let frames = self.clock.period_frames_at(self.rate_hz);
        let drive = &mut self.drive[..frames];
        let inputs = &mut self.inputs[..frames * self.plant.channels()];

        let act = self.person.step(
            1e-9 * start_ns as f64,
            self.clock.period_s(),
            &self.senses.perceive(),
        );
        self.cards.play(start_ns, self.rate_hz, drive);
        self.layer.play(drive);
        self.plant.wire(self.patchbay.wiring());
        self.force.guard(self.clock.now_ns())?;
        let gate = self.board.amplifier_on(start_ns);
        self.plant.set_amplifier_gain(self.board.amplifier_gain());
        self.masses.carry_out(&mut self.plant);
        self.plant.step(drive, gate, &act.finger, inputs);
        if let Some(oscilloscope) = &mut self.oscilloscope {
            let volts = self.plant.volts();
            let rms_v = (volts.sum_v2 / f64::from(volts.frames.max(1))).sqrt();
            oscilloscope.look(drive, rms_v, self.board.amplifier_lines(gate));
        }
        self.force.lay(inputs, self.plant.channels());
        self.layer.record(inputs);
        self.cards.record(start_ns, self.rate_hz, inputs);
        self.cards.play_speakers(start_ns);
        self.step += 1;
        let now_s = 1e-9 * self.clock.ns_of(self.step) as f64;
        self.vibrometer
            .watch(self.plant.truth(), &self.plate, now_s)
            .map_err(ApparatusError::Serial)?;
        self.voltmeter
            .watch(self.plant.volts(), now_s)
            .map_err(ApparatusError::Serial)?;
        if let Some(truth) = &mut self.truth {
            truth
                .record(self.plant.truth())
                .map_err(ApparatusError::Truth)?;
        }
        self.board.update(act.finger.position_m, act.button_pressed);
        self.force.send(self.plant.forces(), now_s)?;
        self.clock.advance();
        Ok(())
    }

    /// Completes the truth files; further calls do nothing.
    pub(super) fn finish(&mut self) -> Result<(), ApparatusError> {
        match self.truth.take() {
            Some(truth) => truth.finish().map_err(ApparatusError::Truth),
            None => Ok(()),
        }
    }

    /// Adapts the plant's rate if a stream was opened at another rate.
    fn follow_rate(&mut self) {
        let (rate_hz, stagger_s) = (self.cards.rate_hz(), self.cards.stagger_s());
        if rate_hz != self.rate_hz || stagger_s != self.stagger_s {
            (self.rate_hz, self.stagger_s) = (rate_hz, stagger_s);
            let step = stagger_s * f64::from(rate_hz);
            let channel_skews = self.skew_samples.iter().enumerate();
            let skew = channel_skews.map(|(channel, skew)| skew + channel as f64 * step);
            self.plant.set_rate(f64::from(rate_hz), skew.collect());
            let channels = self.plant.channels();
            let (table, share) = (&self.layer_table, self.delay_share);
            self.layer = SoundLayer::new(table, channels, f64::from(rate_hz), share);
        }
    }

    /// Creates the truth files once a stream of the bench's converter is open.
    fn begin_truth(&mut self) -> Result<(), ApparatusError> {
        if let Some(folder) = self.truth_path.take_if(|_| self.cards.is_open()) {
            let truth = TruthWriter::create(&folder, &self.plant.constants())
                .map_err(ApparatusError::Truth)?;
            self.truth = Some(truth);
        }
        Ok(())
    }
}
