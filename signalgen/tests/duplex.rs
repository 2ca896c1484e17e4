//! Both directions over a stepped host: the very callbacks that a sound card calls, under an
//! allocator that aborts the process if one of them allocates.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]
#![expect(
    unsafe_code,
    reason = "cpal hands raw buffers between a host and its streams; this is the host"
)]

use std::{
    hash::{Hash, Hasher},
    process,
    sync::{Arc, Mutex},
    time::Duration,
};

use assert_no_alloc::assert_no_alloc;
use cpal::{
    BufferSize, Data, DeviceDescription, DeviceDescriptionBuilder, DeviceDirection, DeviceId,
    Error, ErrorKind, FrameCount, HostId, InputCallbackInfo, InputStreamTimestamp,
    OutputCallbackInfo, OutputStreamTimestamp, SampleFormat as CpalFormat, StreamConfig,
    StreamInstant, SupportedBufferSize, SupportedStreamConfig, SupportedStreamConfigRange,
    traits::{DeviceTrait, HostTrait, StreamTrait},
};
use signalgen::{
    BlockHeader, Command, ConverterSample, Direction, DriveConfig, DrivePhase, DriveSettings,
    Generator, Program, SampleFormat, SendError, StreamFault, SweepLaw, ToneList, Waveform,
    audio::{
        AudioError, Duplex, DuplexConfig, Host, HostChoice, StreamChoice, list_devices,
        open_duplex, open_host, output_device,
    },
};

#[cfg(debug_assertions)]
#[global_allocator]
static ALLOCATOR: assert_no_alloc::AllocDisabler = assert_no_alloc::AllocDisabler;

const RATE_HZ: u32 = 192_000;
const FULL_SCALE_V: f64 = 100.0;
const BLOCK: usize = 512;
/// More than one chunk of the output callback, and no multiple of it.
const ODD_BLOCK: usize = 700;
const INPUT_CHANNELS: usize = 2;
const OUTPUT_CHANNELS: usize = 3;
const DRIVE_CHANNEL: usize = 1;

type OutputBody = Box<dyn FnMut(&mut Data, &OutputCallbackInfo) + Send>;
type InputBody = Box<dyn FnMut(&Data, &InputCallbackInfo) + Send>;
type ErrorBody = Box<dyn FnMut(Error) + Send>;

struct Open<B> {
    body: B,
    error: ErrorBody,
    format: CpalFormat,
    playing: bool,
}

/// One device whose every input channel is wired to the drive's output channel, moved on by the
/// test.
#[derive(Default)]
struct Card {
    output: Option<Open<OutputBody>>,
    input: Option<Open<InputBody>>,
    frames: u64,
}

impl Card {
    /// One period: output callback, then input callback, neither allowed to allocate. Returns what
    /// came out, interleaved, in units of full scale.
    fn period(&mut self, frames: usize) -> Vec<f32> {
        let at = |frame: u64| StreamInstant::from_nanos(frame * 1_000_000_000 / u64::from(RATE_HZ));
        let (begin, end) = (at(self.frames), at(self.frames + frames as u64));
        self.frames += frames as u64;
        let mut rendered = vec![0.0; frames * OUTPUT_CHANNELS];
        if let Some(output) = self.output.as_mut().filter(|o| o.playing) {
            let info = OutputCallbackInfo::new(OutputStreamTimestamp {
                callback: begin,
                playback: end,
            });
            match output.format {
                CpalFormat::F32 => render::<f32>(output, &info, &mut rendered),
                CpalFormat::I32 => render::<i32>(output, &info, &mut rendered),
                CpalFormat::I16 => render::<i16>(output, &info, &mut rendered),
                other => panic!("{other} was never offered"),
            }
        }
        if let Some(input) = self.input.as_mut().filter(|i| i.playing) {
            let drive = rendered.chunks_exact(OUTPUT_CHANNELS);
            let looped: Vec<f32> = drive
                .flat_map(|frame| [frame[DRIVE_CHANNEL]; INPUT_CHANNELS])
                .collect();
            let info = InputCallbackInfo::new(InputStreamTimestamp {
                callback: end,
                capture: begin,
            });
            match input.format {
                CpalFormat::F32 => take::<f32>(input, &info, &looped),
                CpalFormat::I32 => take::<i32>(input, &info, &looped),
                CpalFormat::I16 => take::<i16>(input, &info, &looped),
                other => panic!("{other} was never offered"),
            }
        }
        rendered
    }

    fn report(&mut self, direction: Direction, kind: ErrorKind) {
        let error = match direction {
            Direction::Output => self.output.as_mut().map(|o| &mut o.error),
            Direction::Input => self.input.as_mut().map(|i| &mut i.error),
        };
        assert_no_alloc(|| error.expect("an open stream")(Error::new(kind)));
    }
}

fn render<T: ConverterSample>(
    output: &mut Open<OutputBody>,
    info: &OutputCallbackInfo,
    rendered: &mut [f32],
) {
    // Not silence: the callback must write every sample itself.
    let mut raw = vec![T::from_unit(0.5); rendered.len()];
    // SAFETY: the pointer and length are those of `raw`, whose type the format names.
    let mut data = unsafe { Data::from_parts(raw.as_mut_ptr().cast(), raw.len(), output.format) };
    assert_no_alloc(|| (output.body)(&mut data, info));
    for (sample, raw) in rendered.iter_mut().zip(raw) {
        *sample = raw.to_unit();
    }
}

fn take<T: ConverterSample>(
    input: &mut Open<InputBody>,
    info: &InputCallbackInfo,
    samples: &[f32],
) {
    let mut raw: Vec<T> = samples.iter().map(|&s| T::from_unit(s)).collect();
    // SAFETY: as above.
    let data = unsafe { Data::from_parts(raw.as_mut_ptr().cast(), raw.len(), input.format) };
    assert_no_alloc(|| (input.body)(&data, info));
}

#[derive(Clone, Default)]
struct Bench(Arc<Mutex<Card>>);

impl Bench {
    fn card(&self) -> std::sync::MutexGuard<'_, Card> {
        self.0.lock().unwrap()
    }

    fn host(&self) -> Host {
        let custom = cpal::platform::CustomHost::from_host(self.clone());
        open_host(HostChoice::Supplied(Host::from(custom))).unwrap()
    }

    fn open(&self, config: &DuplexConfig) -> Duplex {
        let duplex = open_duplex(&self.host(), config, Generator::new(settings())).unwrap();
        duplex.streams.play().unwrap();
        duplex
    }

    fn periods(&self, count: usize) {
        for _ in 0..count {
            self.card().period(BLOCK);
        }
    }
}

type Ranges = std::vec::IntoIter<SupportedStreamConfigRange>;

impl Bench {
    fn ranges(channels: usize) -> Ranges {
        [CpalFormat::F32, CpalFormat::I32, CpalFormat::I16]
            .map(|format| {
                let any = SupportedBufferSize::Unknown;
                SupportedStreamConfigRange::new(channels as u16, RATE_HZ, RATE_HZ, any, format)
            })
            .to_vec()
            .into_iter()
    }

    fn check(config: &StreamConfig) -> Result<(), Error> {
        match config.buffer_size {
            BufferSize::Default => Ok(()),
            BufferSize::Fixed(_) => Err(ErrorKind::UnsupportedConfig.into()),
        }
    }
}

impl HostTrait for Bench {
    type Devices = std::iter::Once<Self>;
    type Device = Self;
    fn is_available() -> bool {
        true
    }
    fn devices(&self) -> Result<Self::Devices, Error> {
        Ok(std::iter::once(self.clone()))
    }
    fn default_input_device(&self) -> Option<Self> {
        Some(self.clone())
    }
    fn default_output_device(&self) -> Option<Self> {
        Some(self.clone())
    }
}

impl PartialEq for Bench {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
impl Eq for Bench {}
impl Hash for Bench {
    fn hash<H: Hasher>(&self, state: &mut H) {
        Arc::as_ptr(&self.0).hash(state);
    }
}
impl std::fmt::Debug for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("stepped card")
    }
}
impl std::fmt::Display for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("stepped card")
    }
}

impl DeviceTrait for Bench {
    type SupportedInputConfigs = Ranges;
    type SupportedOutputConfigs = Ranges;
    type Stream = CardStream;
    fn description(&self) -> Result<DeviceDescription, Error> {
        Ok(DeviceDescriptionBuilder::new("stepped card")
            .direction(DeviceDirection::Duplex)
            .build())
    }
    fn id(&self) -> Result<DeviceId, Error> {
        Ok(DeviceId::new(HostId::Custom, "stepped"))
    }
    fn supported_input_configs(&self) -> Result<Ranges, Error> {
        Ok(Self::ranges(INPUT_CHANNELS))
    }
    fn supported_output_configs(&self) -> Result<Ranges, Error> {
        Ok(Self::ranges(OUTPUT_CHANNELS))
    }
    fn default_input_config(&self) -> Result<SupportedStreamConfig, Error> {
        Err(ErrorKind::UnsupportedOperation.into())
    }
    fn default_output_config(&self) -> Result<SupportedStreamConfig, Error> {
        Err(ErrorKind::UnsupportedOperation.into())
    }
    fn build_input_stream_raw<D, E>(
        &self,
        config: StreamConfig,
        format: CpalFormat,
        data: D,
        error: E,
        _timeout: Option<Duration>,
    ) -> Result<CardStream, Error>
    where
        D: FnMut(&Data, &InputCallbackInfo) + Send + 'static,
        E: FnMut(Error) + Send + 'static,
    {
        Self::check(&config)?;
        let mut card = self.card();
        if card.input.is_some() {
            return Err(ErrorKind::DeviceBusy.into());
        }
        card.input = Some(Open {
            body: Box::new(data),
            error: Box::new(error),
            format,
            playing: false,
        });
        Ok(CardStream(self.clone(), Direction::Input))
    }
    fn build_output_stream_raw<D, E>(
        &self,
        config: StreamConfig,
        format: CpalFormat,
        data: D,
        error: E,
        _timeout: Option<Duration>,
    ) -> Result<CardStream, Error>
    where
        D: FnMut(&mut Data, &OutputCallbackInfo) + Send + 'static,
        E: FnMut(Error) + Send + 'static,
    {
        Self::check(&config)?;
        let mut card = self.card();
        if card.output.is_some() {
            return Err(ErrorKind::DeviceBusy.into());
        }
        card.output = Some(Open {
            body: Box::new(data),
            error: Box::new(error),
            format,
            playing: false,
        });
        Ok(CardStream(self.clone(), Direction::Output))
    }
}

struct CardStream(Bench, Direction);

impl CardStream {
    fn set_playing(&self, playing: bool) {
        let mut card = self.0.card();
        match self.1 {
            Direction::Output => card.output.iter_mut().for_each(|o| o.playing = playing),
            Direction::Input => card.input.iter_mut().for_each(|i| i.playing = playing),
        }
    }
}

impl StreamTrait for CardStream {
    fn play(&self) -> Result<(), Error> {
        self.set_playing(true);
        Ok(())
    }
    fn pause(&self) -> Result<(), Error> {
        self.set_playing(false);
        Ok(())
    }
    fn now(&self) -> StreamInstant {
        StreamInstant::ZERO
    }
    fn buffer_size(&self) -> Result<FrameCount, Error> {
        Ok(BLOCK as FrameCount)
    }
}

impl Drop for CardStream {
    fn drop(&mut self) {
        let mut card = self.0.card();
        match self.1 {
            Direction::Output => card.output = None,
            Direction::Input => card.input = None,
        }
    }
}

fn settings() -> DriveSettings {
    DriveSettings::new(DriveConfig {
        sample_rate_hz: RATE_HZ,
        volts_per_unit: FULL_SCALE_V,
        limit_v: 100.0,
        ramp_s: 0.005,
    })
    .unwrap()
}

fn config(format: SampleFormat) -> DuplexConfig {
    DuplexConfig {
        sample_rate_hz: RATE_HZ,
        output: StreamChoice {
            device: "stepped card".to_owned(),
            channels: OUTPUT_CHANNELS as u16,
            format,
        },
        drive_channel: DRIVE_CHANNEL as u16,
        input: StreamChoice {
            device: "stepped".to_owned(),
            channels: INPUT_CHANNELS as u16,
            format,
        },
        buffer_frames: None,
        ring_s: 1.0,
    }
}

fn modulated() -> Program {
    let waveform = Waveform::Modulated {
        carrier_hz: 35_000.0,
        mean_amplitude_v: 50.0,
        modulation_hz: 6.0,
        modulation_index: 0.95,
        start_phase_rad: 0.0,
    };
    settings().admit(waveform).unwrap()
}

fn every_command() -> Vec<Command> {
    let admit = |waveform| settings().admit(waveform).unwrap();
    let foreign = DriveSettings::new(DriveConfig {
        sample_rate_hz: RATE_HZ,
        volts_per_unit: FULL_SCALE_V,
        limit_v: 50.0,
        ramp_s: 0.005,
    })
    .unwrap();
    vec![
        Command::Start(modulated()),
        Command::Adjust(modulated()),
        Command::Start(admit(Waveform::Silence)),
        Command::Start(admit(Waveform::Tone {
            carrier_hz: 30_000.0,
            amplitude_v: 20.0,
        })),
        Command::Start(admit(Waveform::Sweep {
            from_hz: 30_000.0,
            to_hz: 40_000.0,
            duration_s: 0.002,
            law: SweepLaw::Logarithmic,
            amplitude_v: 20.0,
        })),
        Command::Start(admit(Waveform::SteppedTones {
            tones: ToneList::new(&[30_000.0, 31_000.0]).unwrap(),
            dwell_s: 0.001,
            amplitude_v: 20.0,
        })),
        Command::Stop,
        Command::Start(modulated()),
        Command::EmergencyStop,
        Command::Rearm,
        Command::Start(foreign.admit(Waveform::Silence).unwrap()),
        Command::Start(modulated()),
        Command::Rearm,
    ]
}

/// Neither callback allocates, whatever happens; the mutex in between is the
/// test's own card.
#[test]
fn callbacks_do_not_allocate() {
    for format in [SampleFormat::F32, SampleFormat::I32, SampleFormat::I16] {
        let bench = Bench::default();
        let mut duplex = bench.open(&config(format));
        for command in every_command() {
            duplex.drive.send(command).unwrap();
            for _ in 0..3 {
                bench.card().period(ODD_BLOCK);
            }
        }
        duplex.drive.kill_switch().kill();
        for direction in [Direction::Output, Direction::Input] {
            bench.card().report(direction, ErrorKind::Xrun);
            bench
                .card()
                .report(direction, ErrorKind::DeviceNotAvailable);
        }
        // Runs the input ring full, and the drive without its handle.
        let input = duplex.input;
        drop(duplex.drive);
        bench.periods(RATE_HZ as usize / BLOCK + 2);
        assert!(input.ring_fill() > 0.9);
        drop(input);
        bench.periods(2);
    }
}

/// What makes the test above able to fail.
#[test]
#[cfg(debug_assertions)]
fn an_allocation_in_a_callback_would_abort() {
    const CHILD: &str = "SIGNALGEN_TEST_ALLOCATE";
    if std::env::var_os(CHILD).is_some() {
        assert_no_alloc(|| drop(std::hint::black_box(vec![0_u8; 16])));
        return;
    }
    let child = process::Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "an_allocation_in_a_callback_would_abort",
            "--nocapture",
        ])
        .env(CHILD, "1")
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&child.stderr);
    assert!(!child.status.success());
    assert!(
        stderr.contains("memory allocation of 16 bytes failed"),
        "{stderr}"
    );
}

#[test]
fn drive_goes_to_its_channel_alone_and_comes_back_exactly() {
    for (format, rounding) in [
        (SampleFormat::F32, 0.0),
        (SampleFormat::I32, 1e-7),
        (SampleFormat::I16, 2.0_f32.powi(-16)),
    ] {
        let bench = Bench::default();
        let mut duplex = bench.open(&config(format));
        duplex.drive.send(Command::Start(modulated())).unwrap();
        let mut reference = Generator::new(settings());
        reference.apply(Command::Start(modulated()));
        let mut expected = [0.0_f32; ODD_BLOCK];
        let mut samples = Vec::new();
        for _ in 0..20 {
            let rendered = bench.card().period(ODD_BLOCK);
            reference.fill(&mut expected);
            let header = duplex.input.pop_block(&mut samples).unwrap();
            assert_eq!(header.frames as usize, ODD_BLOCK);
            assert_eq!(header.drive, reference.state());
            assert_eq!(duplex.drive.published(), reference.state());
            for (n, frame) in rendered.chunks_exact(OUTPUT_CHANNELS).enumerate() {
                assert_eq!([frame[0], frame[2]], [0.0, 0.0]);
                assert!((frame[DRIVE_CHANNEL] - expected[n]).abs() <= rounding);
                assert_eq!(samples[n * INPUT_CHANNELS], frame[DRIVE_CHANNEL]);
                assert_eq!(samples[n * INPUT_CHANNELS + 1], frame[DRIVE_CHANNEL]);
            }
        }
    }
}

fn drain(duplex: &mut Duplex) -> Vec<BlockHeader> {
    let mut samples = Vec::new();
    let mut headers = Vec::new();
    while let Some(header) = duplex.input.pop_block(&mut samples) {
        assert_eq!(samples.len(), header.frames as usize * INPUT_CHANNELS);
        headers.push(header);
    }
    headers
}

#[test]
fn every_frame_is_accounted_for_when_the_ring_is_full() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(SampleFormat::F32));
    let capacity_blocks = RATE_HZ as usize / BLOCK;
    bench.periods(capacity_blocks + 10);
    let kept = drain(&mut duplex);
    assert_eq!(kept.len(), capacity_blocks);
    for (n, header) in (0_u64..).zip(&kept) {
        assert_eq!(header.first_frame, n * BLOCK as u64);
        assert_eq!(header.dropped_frames, 0);
    }
    bench.periods(1);
    let after = drain(&mut duplex)[0];
    let last = kept[capacity_blocks - 1];
    let gap = after.first_frame - (last.first_frame + u64::from(last.frames));
    assert_eq!(gap, 10 * BLOCK as u64);
    assert_eq!(after.dropped_frames, gap);
    assert_eq!(duplex.input.ring_fill(), 0.0);
}

#[test]
fn headers_carry_the_stream_clock() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(SampleFormat::F32));
    bench.periods(3);
    let headers = drain(&mut duplex);
    for (n, header) in (0_u64..).zip(&headers) {
        let at = |blocks: u64| blocks * BLOCK as u64 * 1_000_000_000 / u64::from(RATE_HZ);
        assert_eq!(header.time.capture_ns, at(n));
        assert_eq!(header.time.callback_ns, at(n + 1));
    }
    assert!(headers.is_sorted_by_key(|header| header.arrived_ns));
    assert!(headers[2].arrived_ns <= duplex.health.now_ns());
}

#[test]
fn xruns_and_losses_are_counted_per_direction() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(SampleFormat::F32));
    assert_eq!(duplex.health.read(Direction::Input).callback_age, None);
    bench.card().report(Direction::Output, ErrorKind::Xrun);
    bench.card().report(Direction::Output, ErrorKind::Xrun);
    bench.card().report(Direction::Input, ErrorKind::Xrun);
    bench.periods(1);
    let header = drain(&mut duplex)[0];
    assert_eq!((header.output_xruns, header.input_xruns), (2, 1));
    bench
        .card()
        .report(Direction::Input, ErrorKind::DeviceNotAvailable);
    let output = duplex.health.read(Direction::Output);
    let input = duplex.health.read(Direction::Input);
    assert_eq!((output.xruns, input.xruns), (2, 1));
    assert_eq!((output.callbacks, input.callbacks), (1, 1));
    assert!(output.callback_age.is_some());
    assert_eq!(output.last_fault, Some(StreamFault::Xrun));
    assert_eq!(input.last_fault, Some(StreamFault::DeviceLost));
    assert_eq!((output.device_lost, input.device_lost), (false, true));
}

#[test]
fn a_kill_stops_within_the_emergency_ramp_and_no_earlier_rearm_undoes_it() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(SampleFormat::F32));
    let kill_switch = duplex.drive.kill_switch();
    duplex.drive.send(Command::Start(modulated())).unwrap();
    bench.periods(10);
    assert_eq!(duplex.drive.published().phase, DrivePhase::Steady);

    kill_switch.kill();
    bench.periods(1);
    assert_eq!(duplex.drive.published().phase, DrivePhase::EmergencyStopped);

    // A kill after the operator's decision, seen by the same callback.
    duplex.drive.rearm().unwrap();
    kill_switch.kill();
    bench.periods(1);
    assert_eq!(duplex.drive.published().phase, DrivePhase::EmergencyStopped);

    duplex.drive.send(Command::Start(modulated())).unwrap();
    bench.periods(10);
    assert_eq!(duplex.drive.published().phase, DrivePhase::EmergencyStopped);

    duplex.drive.rearm().unwrap();
    duplex.drive.send(Command::Start(modulated())).unwrap();
    bench.periods(10);
    assert_eq!(duplex.drive.published().phase, DrivePhase::Steady);
}

#[test]
fn a_kill_before_the_first_callback_is_not_lost() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(SampleFormat::F32));
    duplex.drive.kill_switch().kill();
    duplex.drive.send(Command::Start(modulated())).unwrap();
    bench.periods(10);
    assert_eq!(duplex.drive.published().phase, DrivePhase::EmergencyStopped);
    assert_eq!(duplex.drive.published().programs, 0);
}

#[test]
fn the_drive_stops_when_nobody_commands_it_any_more() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(SampleFormat::F32));
    duplex.drive.send(Command::Start(modulated())).unwrap();
    bench.periods(10);
    let monitor = duplex.drive.monitor();
    drop(duplex.drive);
    bench.periods(1);
    assert_eq!(monitor.published().phase, DrivePhase::EmergencyStopped);
}

#[test]
fn commands_to_a_stream_that_does_not_run_are_refused() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(SampleFormat::F32));
    duplex.streams.pause().unwrap();
    let full = (0..1_000).find_map(|_| duplex.drive.send(Command::Stop).err());
    assert_eq!(full, Some(SendError::RingFull));
    drop(duplex.streams);
    assert_eq!(duplex.drive.send(Command::Stop), Err(SendError::Closed));
    assert!(duplex.input.is_closed());
    assert!(bench.card().output.is_none() && bench.card().input.is_none());
}

/// Each end goes to a thread of its own; the safety thread shares the switches.
#[test]
fn ends_can_live_on_threads_of_their_own() {
    fn is_send<T: Send>() {}
    fn is_shared<T: Clone + Send + Sync>() {}
    is_send::<Duplex>();
    is_shared::<signalgen::KillSwitch>();
    is_shared::<signalgen::DriveMonitor>();
    is_shared::<signalgen::Health>();
}

fn refused(bench: &Bench, config: &DuplexConfig) -> AudioError {
    open_duplex(&bench.host(), config, Generator::new(settings())).unwrap_err()
}

#[test]
fn what_the_device_lacks_is_answered_with_what_it_has() {
    let bench = Bench::default();
    let mut wanted = config(SampleFormat::I32);
    wanted.input.channels = 4;
    let message = refused(&bench, &wanted).to_string();
    for part in [
        "input device custom:stepped (stepped card)",
        "4 channels of i32 at 192000 Hz",
        "2 ch f32 192000 Hz; 2 ch i16 192000 Hz; 2 ch i32 192000 Hz",
    ] {
        assert!(message.contains(part), "{message}");
    }
    let mut wanted = config(SampleFormat::I32);
    wanted.buffer_frames = Some(100);
    let message = refused(&bench, &wanted).to_string();
    assert!(message.contains("100 frames per buffer"), "{message}");
}

#[test]
fn contradictions_are_refused_by_name() {
    let bench = Bench::default();
    let good = config(SampleFormat::F32);
    let refused = |change: fn(&mut DuplexConfig)| {
        let mut bad = good.clone();
        change(&mut bad);
        refused(&bench, &bad).to_string()
    };
    for (name, message) in [
        ("sample_rate_hz", refused(|c| c.sample_rate_hz = 48_000)),
        ("drive_channel", refused(|c| c.drive_channel = 3)),
        ("output.channels", refused(|c| c.output.channels = 0)),
        ("input.channels", refused(|c| c.input.channels = 0)),
        ("ring_s", refused(|c| c.ring_s = 0.0)),
        ("ring_s", refused(|c| c.ring_s = f64::NAN)),
        (
            "no input device",
            refused(|c| c.input.device = "Babyface".to_owned()),
        ),
    ] {
        assert!(message.starts_with(name), "{message}");
    }
}

#[test]
fn a_device_in_use_is_busy() {
    let bench = Bench::default();
    let _held = bench.open(&config(SampleFormat::F32));
    let error = refused(&bench, &config(SampleFormat::F32));
    assert!(matches!(error, AudioError::Busy { .. }), "{error}");
}

#[test]
fn an_output_for_other_sound_is_chosen_as_the_drives_is() {
    let host = Bench::default().host();
    let device = output_device(&host, "STEPPED").unwrap();
    assert_eq!(device.id().unwrap().to_string(), "custom:stepped");
    let error = output_device(&host, "headphones").err().unwrap();
    assert!(error.to_string().contains("custom:stepped"), "{error}");
}

/// A buffer so small that the headers run out before the samples do.
#[test]
fn tiny_blocks_are_accounted_for_too() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(SampleFormat::F32));
    let blocks = 4_000;
    for _ in 0..blocks {
        bench.card().period(1);
    }
    let kept = drain(&mut duplex);
    bench.card().period(1);
    let after = drain(&mut duplex)[0];
    assert!(kept.len() < blocks);
    assert_eq!(after.first_frame, blocks as u64);
    assert_eq!(after.dropped_frames as usize, blocks - kept.len());
}

#[test]
fn devices_are_listed_with_what_they_offer() {
    let devices = list_devices(&Bench::default().host()).unwrap();
    assert_eq!(devices.len(), 1);
    assert_eq!(devices[0].id, "custom:stepped");
    assert_eq!(devices[0].name, "stepped card");
    assert!(devices[0].is_raw);
    let input = devices[0].capabilities(Direction::Input).unwrap();
    let formats: Vec<&str> = input.iter().map(|c| c.format.as_str()).collect();
    assert_eq!(formats, ["f32", "i32", "i16"]);
}

/// FAULTS 4: a machine without sound is an error, in words and on nobody's terminal.
#[test]
fn a_machine_without_sound_is_refused_without_a_panic_or_a_print() {
    const CHILD: &str = "SIGNALGEN_TEST_NO_SOUND";
    if let Some(host) = std::env::var_os(CHILD) {
        let choice = match host.to_str() {
            Some("jack") => HostChoice::Jack,
            Some("alsa") => HostChoice::Alsa,
            _ => HostChoice::Default,
        };
        // ALSA may open without a configuration; then it has no such device.
        let opened = open_host(choice).and_then(|host| {
            open_duplex(
                &host,
                &config(SampleFormat::F32),
                Generator::new(settings()),
            )
        });
        let message = opened.unwrap_err().to_string();
        assert!(
            message.starts_with("audio host") || message.starts_with("no output device"),
            "{message}"
        );
        return;
    }
    for host in ["default", "alsa", "jack"] {
        let child = process::Command::new(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "a_machine_without_sound_is_refused_without_a_panic_or_a_print",
                "--nocapture",
            ])
            .env(CHILD, host)
            .env("ALSA_CONFIG_PATH", "/nonexistent/alsa.conf")
            .env("JACK_DEFAULT_SERVER", "signalgen-test-no-such-server")
            .env("JACK_NO_START_SERVER", "1")
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&child.stderr);
        let stdout = String::from_utf8_lossy(&child.stdout);
        assert!(child.status.success(), "{host}: {stdout}{stderr}");
        assert!(stdout.contains("1 passed"), "{host}: {stdout}");
        assert_eq!(stderr, "", "{host}");
    }
}
