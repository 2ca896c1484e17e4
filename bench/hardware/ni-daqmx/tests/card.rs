//! The host on the simulated library, with a loop-back in place of the apparatus, which records the output and a count
//! of the frames.
#![expect(
    unsafe_code,
    reason = "the simulated library is a C library, loaded as the real one is"
)]
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::ffi::c_void;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use config::Config;
use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{BufferSize, ErrorKind, SampleFormat, StreamConfig};
use mock_hw::rack::{Board, CONNECT, Connect, Deck, GONE, XRUN};
use sources::Lines;

const CONFIG: &str = config::rigs::MOCK_BENCH_NIDAQMX;
const RATE_HZ: u32 = 100_000;
const BLOCK: usize = 1000;
/// Frames written ahead: 30 ms.
const LEAD: u64 = 3000;
/// Longest time for which a test waits.
const PATIENCE: Duration = Duration::from_secs(120);
/// An hour.
const HOUR: u64 = 3600 * RATE_HZ as u64;

/// The library has one state for its whole process.
static ALONE: Mutex<()> = Mutex::new(());
/// Thread of the loop-back, its end, and its next fault: 1 + direction, kind.
static THREAD: Mutex<Option<JoinHandle<()>>> = Mutex::new(None);
static OPEN: AtomicBool = AtomicBool::new(false);
static FAULT: [AtomicU32; 2] = [AtomicU32::new(0), AtomicU32::new(0)];
/// The converters; the output holds its last sample.
static DECK: Mutex<Option<Deck>> = Mutex::new(None);
/// Level of the amplifier enable, and the encoder's count.
static ENABLE: AtomicBool = AtomicBool::new(false);
static COUNT: AtomicU64 = AtomicU64::new(0);

extern "C" fn open(_: *const c_void, _rate_hz: u32, _stagger_s: f64, deck: Deck) -> i32 {
    OPEN.store(true, Ordering::SeqCst);
    *DECK.lock().unwrap() = Some(deck);
    let thread = std::thread::spawn(move || {
        let (mut drive, mut inputs) = ([0.0_f32; BLOCK], [0.0_f32; 2 * BLOCK]);
        let mut frame = 0_u64;
        while OPEN.load(Ordering::SeqCst) {
            let output = FAULT[0].swap(0, Ordering::SeqCst);
            if output > 0 {
                (deck.fail)(output - 1, FAULT[1].load(Ordering::SeqCst));
            }
            (deck.play)(drive.as_mut_ptr(), BLOCK);
            for (pair, sample) in inputs.chunks_exact_mut(2).zip(&drive) {
                (pair[0], pair[1]) = (*sample, pattern(frame));
                frame += 1;
            }
            (deck.record)(inputs.as_ptr(), inputs.len());
        }
    });
    *THREAD.lock().unwrap() = Some(thread);
    0
}

extern "C" fn close(_: *const c_void) {
    OPEN.store(false, Ordering::SeqCst);
    let thread = THREAD.lock().unwrap().take();
    if let Some(thread) = thread {
        thread.join().unwrap();
    }
}

extern "C" fn level(_: *const c_void, line: u32) -> i32 {
    i32::from(line == mock_hw::rack::ESTOP)
}

extern "C" fn drive(_: *const c_void, line: u32, high: u32) -> i32 {
    if line == mock_hw::rack::ENABLE {
        ENABLE.store(high != 0, Ordering::SeqCst);
    }
    0
}

extern "C" fn count(_: *const c_void) -> i64 {
    COUNT.load(Ordering::SeqCst) as i64
}

extern "C" fn release(_: *const c_void) {}

/// A prime, so that it is not a multiple of any period.
const CYCLE: u64 = 1_000_003;

/// Returns a number that is unique to a frame within ten seconds.
fn pattern(frame: u64) -> f32 {
    (frame % CYCLE) as f32 / 1_048_576.0
}

fn library() -> PathBuf {
    mock_hw::rack::library().expect("cargo builds the simulated library for this test")
}

/// Puts the loop-back behind the library.
fn connect() {
    let board = Board {
        context: std::ptr::null(),
        stepped: 1,
        inputs: 2,
        open,
        close,
        level,
        drive,
        count,
        release,
    };
    // SAFETY: no other test of this process runs meanwhile.
    unsafe { std::env::set_var("MOCK_NIDAQMX_PRODUCT", "USB-6366") };
    // SAFETY: it is the simulated library, whose prototype this is; it stays loaded.
    unsafe {
        let library = libloading::Library::new(library()).unwrap();
        let connect: Connect = *library.get(CONNECT).unwrap();
        connect(board);
        std::mem::forget(library);
    }
}

/// Observations of a run of both streams.
#[derive(Default)]
struct Seen {
    frames: AtomicU64,
    mismatches: AtomicU64,
    errors: Mutex<Vec<(&'static str, ErrorKind)>>,
}

impl Seen {
    fn tell(&self, direction: &'static str, kind: ErrorKind) {
        self.errors.lock().unwrap().push((direction, kind));
    }
}

/// Returns the level that the card's output holds once no stream runs, relative to full scale.
fn output_level() -> f32 {
    let mut sample = [f32::NAN];
    let deck = DECK.lock().unwrap();
    (deck.as_ref().unwrap().play)(sample.as_mut_ptr(), 1);
    sample[0]
}

/// Opens the card on a sample clock.
fn card(clock: &str) -> (cpal::Host, Lines) {
    connect();
    // One input at a time needs no interpolation: the samples read must be those sent, bit for bit.
    let text = CONFIG
        .replace("convert_hz = 250000", "#")
        .replace("clock = \"start-trigger\"", &format!("clock = \"{clock}\""))
        .replace("lead_s = 0.01", "lead_s = 0.03");
    let config = Config::parse(&text, "bench.toml").unwrap();
    ni_daqmx::open(&config, Some(&library()), Lines::default()).unwrap()
}

fn stream_of(channels: u16) -> StreamConfig {
    StreamConfig {
        channels,
        sample_rate: RATE_HZ,
        buffer_size: BufferSize::Fixed(BLOCK as u32),
    }
}

/// Streams until `enough` accepts the observations, for no longer than two minutes.
fn stream(clock: &str, enough: impl Fn(&Seen) -> bool) -> Arc<Seen> {
    let observations = Arc::new(Seen::default());
    let (host, lines) = card(clock);
    assert!(lines.estop.is_some() && lines.counter.is_some());
    let device = host.devices().unwrap().next().unwrap();
    let mut frames_sent = LEAD;
    let log = Arc::clone(&observations);
    let output = device
        .build_output_stream_raw(
            stream_of(1),
            SampleFormat::F32,
            move |data: &mut cpal::Data, _: &cpal::OutputCallbackInfo| {
                for sample in data.as_slice_mut::<f32>().unwrap() {
                    *sample = pattern(frames_sent);
                    frames_sent += 1;
                }
            },
            move |error: cpal::Error| log.tell("output", error.kind()),
            None,
        )
        .unwrap();
    let mut base = None;
    let (mut frame, account, log) = (0, Arc::clone(&observations), Arc::clone(&observations));
    let input = device
        .build_input_stream_raw(
            stream_of(2),
            SampleFormat::F32,
            move |data: &cpal::Data, info: &cpal::InputCallbackInfo| {
                let at_ns = (1e9 * frame as f64 / f64::from(RATE_HZ)) as u128;
                let mut mismatches =
                    u64::from(info.timestamp().capture.as_nanos().abs_diff(at_ns) > 1);
                for pair in data.as_slice::<f32>().unwrap().chunks_exact(2) {
                    let played = if frame < LEAD { 0.0 } else { pattern(frame) };
                    // The apparatus counts from the opening of its converters.
                    let base = *base.get_or_insert((pair[1] * 1_048_576.0).round() as u64);
                    mismatches += u64::from(pair != [played, pattern(base + frame)]);
                    frame += 1;
                }
                account.mismatches.fetch_add(mismatches, Ordering::SeqCst);
                account.frames.store(frame, Ordering::SeqCst);
            },
            move |error: cpal::Error| log.tell("input", error.kind()),
            None,
        )
        .unwrap();
    output.play().unwrap();
    input.play().unwrap();
    let start = Instant::now();
    while !enough(&observations) && start.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(5));
    }
    drop((output, input));
    observations
}

fn exclusive() -> std::sync::MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Fault 47.
#[test]
fn an_hour_of_samples_comes_back_whole_and_in_order() {
    let _alone = exclusive();
    let observations = stream("ao-sample-clock", |observations| {
        observations.frames.load(Ordering::SeqCst) >= HOUR
    });
    let frames = observations.frames.load(Ordering::SeqCst);
    assert!(frames >= HOUR, "{frames} frames");
    assert_eq!(observations.mismatches.load(Ordering::SeqCst), 0);
    assert_eq!(*observations.errors.lock().unwrap(), []);
}

/// Fault 47.
#[test]
fn a_card_that_ran_over_or_dry_or_is_gone_stops_and_says_so_once() {
    let _alone = exclusive();
    let stopped = |direction| {
        [
            (direction, ErrorKind::Xrun),
            (direction, ErrorKind::StreamInvalidated),
        ]
    };
    let unavailable =
        ["output", "input"].map(|direction| (direction, ErrorKind::DeviceNotAvailable));
    for (output, kind, expected) in [
        (0, XRUN, stopped("input")),
        (1, XRUN, stopped("output")),
        (0, GONE, unavailable),
    ] {
        // On the outputs' clock, the inputs stand still with the outputs, without reporting an error.
        for clock in ["start-trigger", "ao-sample-clock"] {
            FAULT[1].store(kind, Ordering::SeqCst);
            let injected = AtomicBool::new(false);
            let observations = stream(clock, |observations| {
                let running = observations.frames.load(Ordering::SeqCst) >= 20_000;
                if running && !injected.swap(true, Ordering::SeqCst) {
                    FAULT[0].store(output + 1, Ordering::SeqCst);
                }
                observations.errors.lock().unwrap().len() >= expected.len()
            });
            assert_eq!(*observations.errors.lock().unwrap(), expected, "{clock}");
            // All samples before it arrived whole.
            assert_eq!(observations.mismatches.load(Ordering::SeqCst), 0);
        }
    }
}

/// Fault 47.
#[test]
fn a_callback_that_panics_leaves_no_voltage_on_the_output() {
    let _alone = exclusive();
    for is_output in [true, false] {
        let (host, _lines) = card("ao-sample-clock");
        let device = host.devices().unwrap().next().unwrap();
        let panicking = Arc::new(AtomicBool::new(false));
        let (dead, mut blocks) = (Arc::clone(&panicking), 0);
        let output = device.build_output_stream_raw(
            stream_of(1),
            SampleFormat::F32,
            move |data: &mut cpal::Data, _: &cpal::OutputCallbackInfo| {
                data.as_slice_mut::<f32>().unwrap().fill(0.5);
                blocks += 1;
                if is_output && blocks == 20 {
                    dead.store(true, Ordering::SeqCst);
                    panic!("in the output's callback, on purpose");
                }
            },
            |_| {},
            None,
        );
        let dead = Arc::clone(&panicking);
        let input = device.build_input_stream_raw(
            stream_of(2),
            SampleFormat::F32,
            move |data: &cpal::Data, _: &cpal::InputCallbackInfo| {
                if !is_output && data.as_slice::<f32>().unwrap()[0] == 0.5 {
                    dead.store(true, Ordering::SeqCst);
                    panic!("in the input's callback, on purpose");
                }
            },
            |_| {},
            None,
        );
        let (output, input) = (output.unwrap(), input.unwrap());
        output.play().unwrap();
        input.play().unwrap();
        let start = Instant::now();
        while !panicking.load(Ordering::SeqCst) && start.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(5));
        }
        drop((output, input));
        assert!(panicking.load(Ordering::SeqCst));
        assert_eq!(output_level(), 0.0, "of full scale");
    }
}

#[test]
fn lines_and_counter_are_those_of_the_card_and_an_output_ends_low() {
    let _alone = exclusive();
    connect();
    let config = Config::parse(CONFIG, "bench.toml").unwrap();
    let (_, mut lines) = ni_daqmx::open(&config, Some(&library()), Lines::default()).unwrap();
    assert!(lines.estop.as_mut().unwrap().is_high().unwrap());
    assert!(!lines.button.as_mut().unwrap().is_high().unwrap());
    let second = ni_daqmx::open(&config, Some(&library()), Lines::default());
    let message = second.err().unwrap().to_string();
    assert!(
        message.contains("GPIO line 0 of Dev1") && message.contains("in use"),
        "{message}"
    );
    let enable = lines.enable.as_mut().unwrap();
    enable.set(true).unwrap();
    assert!(ENABLE.load(Ordering::SeqCst));
    // The card would hold the level.
    drop(lines.enable.take());
    assert!(!ENABLE.load(Ordering::SeqCst));
    let counter = lines.counter.as_mut().unwrap();
    let mut counts = Vec::new();
    for (at_ns, count) in [(0, 0), (1_000_000, 40), (2_000_000, 15)] {
        COUNT.store(count, Ordering::SeqCst);
        counter
            .poll(at_ns, &|| 0.0, &mut |counted| counts.push(counted.count))
            .unwrap();
    }
    assert_eq!(counts, [0, 40, 15]);
}

/// Fault 47.
#[test]
fn a_library_that_is_missing_or_another_one_is_refused_with_what_to_do() {
    let _alone = exclusive();
    let config = Config::parse(CONFIG, "bench.toml").unwrap();
    let absent = std::path::Path::new("/no/libnidaqmx.so");
    let refused = ni_daqmx::open(&config, Some(absent), Lines::default());
    let refused = refused.err().unwrap().to_string();
    assert!(
        refused.contains("NI's driver") && refused.contains("nidaqmx.library in bench.toml"),
        "{refused}"
    );
}
