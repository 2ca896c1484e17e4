//! One period of the simulated world, from percept to pins.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{ApparatusConfig, ApparatusError, Masses, Patchbay, Senses};
use crate::clock::{BASE_RATE_HZ, WorldClock};
use crate::fingertip::Fingertip;
use crate::host::Audio;
use crate::person::Person;
use crate::pins::PinBoard;
use crate::plant::{ForceSample, Plant};
use crate::scenario::{ForceSensor, SoundLayer as SoundLayerSettings};
use crate::serial::{DeviceStart, ForceDevice, ForceFault, SerialLine};
use crate::sound_layer::SoundLayer;
use crate::truth::TruthWriter;
use crate::vibrometer::Vibrometer;

pub(super) struct World {
    clock: Arc<WorldClock>,
    audio: Arc<Audio>,
    board: Arc<PinBoard>,
    force: ForceSide,
    senses: Senses,
    masses: Masses,
    person: Person,
    plant: Plant,
    patchbay: Patchbay,
    layer: SoundLayer,
    layer_settings: SoundLayerSettings,
    rate_hz: u32,
    step: u64,
    truth_path: Option<PathBuf>,
    truth: Option<TruthWriter>,
    drive: Vec<f32>,
    inputs: Vec<f32>,
    vibrometer: Vibrometer,
}

impl World {
    pub(super) fn new(
        config: &ApparatusConfig,
        clock: &Arc<WorldClock>,
        audio: &Arc<Audio>,
        board: &Arc<PinBoard>,
        force: &ForceSide,
        senses: &Senses,
        vibrometer: Vibrometer,
    ) -> Self {
        let participant_seed = config.participant_seed.unwrap_or(config.seed);
        let scenario = &config.scenario;
        let skin = Fingertip::draw(&scenario.participant, participant_seed);
        let rate_hz = f64::from(BASE_RATE_HZ);
        let most_frames = clock.period_frames_at(BASE_RATE_HZ);
        Self {
            clock: Arc::clone(clock),
            audio: Arc::clone(audio),
            board: Arc::clone(board),
            force: force.clone(),
            senses: senses.clone(),
            masses: Masses::default(),
            person: Person::draw(&scenario.participant, participant_seed),
            plant: Plant::with_fingertip(scenario, skin, config.seed, rate_hz),
            patchbay: Patchbay::default(),
            layer: SoundLayer::new(&scenario.sound_layer, scenario.converter.channels, rate_hz),
            layer_settings: scenario.sound_layer.clone(),
            rate_hz: BASE_RATE_HZ,
            step: 0,
            truth_path: config.truth_path.clone(),
            truth: None,
            drive: vec![0.0; most_frames],
            inputs: vec![0.0; most_frames * scenario.converter.channels],
            vibrometer,
        }
    }

    pub(super) fn patchbay(&self) -> Patchbay {
        self.patchbay.clone()
    }

    /// Whoever has it places known masses.
    pub(super) fn masses(&self) -> Masses {
        self.masses.clone()
    }

    pub(super) fn step(&mut self) -> Result<(), ApparatusError> {
        let start_ns = self.clock.ns_of(self.step);
        self.follow_rate();
        self.begin_truth()?;
        let frames = self.clock.period_frames_at(self.rate_hz);
        let drive = &mut self.drive[..frames];
        let inputs = &mut self.inputs[..frames * self.plant.channels()];

        let act = self.person.step(
            1e-9 * start_ns as f64,
            self.clock.period_s(),
            &self.senses.perceive(),
        );
        self.audio.play(start_ns, self.rate_hz, drive);
        self.layer.play(drive);
        self.plant.wire(self.patchbay.wiring());
        let gate = self.board.amplifier_on(start_ns);
        self.masses.do_errands(&mut self.plant);
        self.plant.step(drive, gate, &act.finger, inputs);
        self.layer.record(inputs);
        self.audio.record(start_ns, self.rate_hz, inputs);
        self.audio.play_speakers(start_ns);
        self.step += 1;
        let now_s = 1e-9 * self.clock.ns_of(self.step) as f64;
        self.force.send(self.plant.forces(), now_s)?;
        self.vibrometer
            .watch(self.plant.truth(), now_s)
            .map_err(ApparatusError::Serial)?;
        if let Some(truth) = &mut self.truth {
            truth
                .record(self.plant.truth())
                .map_err(ApparatusError::Truth)?;
        }
        self.board.update(act.finger.position_m, act.button_pressed);
        self.clock.advance();
        Ok(())
    }

    /// Ends the truth files; harmless when repeated.
    pub(super) fn finish(&mut self) -> Result<(), ApparatusError> {
        match self.truth.take() {
            Some(truth) => truth.finish().map_err(ApparatusError::Truth),
            None => Ok(()),
        }
    }

    /// A stream was opened at another rate than the last one.
    fn follow_rate(&mut self) {
        let rate_hz = self.audio.rate_hz();
        if rate_hz != self.rate_hz {
            self.rate_hz = rate_hz;
            self.plant.set_rate(f64::from(rate_hz));
            let channels = self.plant.channels();
            self.layer = SoundLayer::new(&self.layer_settings, channels, f64::from(rate_hz));
        }
    }

    fn begin_truth(&mut self) -> Result<(), ApparatusError> {
        if let Some(folder) = self.truth_path.take_if(|_| self.audio.is_open()) {
            let truth = TruthWriter::create(&folder, &self.plant.constants())
                .map_err(ApparatusError::Truth)?;
            self.truth = Some(truth);
        }
        Ok(())
    }
}

/// The force sensor's device and its serial line.
#[derive(Clone)]
pub(super) struct ForceSide(Arc<Mutex<(ForceDevice, SerialLine)>>);

impl ForceSide {
    /// A `synchronous` line has every byte readable when it was sent.
    pub(super) fn open(
        sensor: &ForceSensor,
        start: DeviceStart,
        synchronous: bool,
    ) -> Result<Self, ApparatusError> {
        let device = ForceDevice::new(sensor, start);
        let line = SerialLine::open(synchronous).map_err(ApparatusError::Serial)?;
        Ok(Self(Arc::new(Mutex::new((device, line)))))
    }

    pub(super) fn send(&self, readings: &[ForceSample], now_s: f64) -> Result<(), ApparatusError> {
        let (device, line) = &mut *self.lock();
        for reading in readings {
            device.sample(reading);
        }
        if let Some(burst) = device.burst(now_s) {
            line.send(burst, now_s).map_err(ApparatusError::Serial)?;
            device.sent();
        }
        Ok(())
    }

    pub(super) fn path(&self) -> PathBuf {
        self.lock().1.path().to_owned()
    }

    pub(super) fn dropped_bytes(&self) -> u64 {
        self.lock().1.dropped_bytes()
    }

    pub(super) fn lay(&self, fault: ForceFault) {
        self.lock().0.lay(fault);
    }

    pub(super) fn unplug(&self) {
        self.lock().1.unplug();
    }

    fn lock(&self) -> MutexGuard<'_, (ForceDevice, SerialLine)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
