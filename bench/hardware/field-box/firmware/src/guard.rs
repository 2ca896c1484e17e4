//! Lines of the amplifier, driven only by the guard.

use core::cell::Cell;

use embassy_futures::select::select3;
use embassy_rp::gpio::{Input, Level, Output};
use embassy_rp::watchdog::Watchdog;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant, Ticker};
use field_box_device::{Amplifier, AmplifierState};
use field_box_logic::Outputs;
use field_box_wire::Word;

/// Commands of the bench that the guard has not read yet. The guard's task interrupts the sender.
pub static WORDS: Channel<CriticalSectionRawMutex, Word, 8> = Channel::new();

/// Time between two checks.
const CHECK_PERIOD: Duration = Duration::from_millis(1);
/// Time without a check after which the chip resets itself: its pins then float, and the pull-downs disable the amplifier.
const WATCHDOG_PERIOD: Duration = Duration::from_millis(50);

/// State of the amplifier and of the e-stop loop for the reports.
#[derive(Clone, Copy)]
pub struct GuardState {
    /// Line levels and reason of a stop.
    pub amplifier: AmplifierState,
    /// Whether the e-stop loop is closed.
    pub estop_closed: bool,
}

/// Latest state, returned by [`state`].
static STATE: Mutex<CriticalSectionRawMutex, Cell<GuardState>> =
    Mutex::new(Cell::new(GuardState {
        amplifier: AmplifierState {
            outputs: Outputs {
                enable: false,
                heartbeat: false,
            },
            stop: None,
            word_number: 0,
        },
        estop_closed: false,
    }));

/// Returns the latest state published by the guard.
pub fn state() -> GuardState {
    STATE.lock(Cell::get)
}

/// Runs the guard over the amplifier.
#[embassy_executor::task]
pub async fn watch(
    mut enable: Output<'static>,
    mut heartbeat: Output<'static>,
    mut estop: Input<'static>,
    mut watchdog: Watchdog,
) {
    watchdog.start(WATCHDOG_PERIOD);
    let mut amplifier = Amplifier::default();
    let mut estop_closed = estop.is_high();
    let mut ticker = Ticker::every(CHECK_PERIOD);
    loop {
        // Waiting for a level, unlike an edge, misses no change between two checks.
        let change = async {
            if estop_closed {
                estop.wait_for_low().await;
            } else {
                estop.wait_for_high().await;
            }
        };
        let _ = select3(ticker.next(), change, WORDS.ready_to_receive()).await;
        watchdog.feed(WATCHDOG_PERIOD);
        estop_closed = estop.is_high();
        while let Ok(word) = WORDS.try_receive() {
            amplifier.hear(Instant::now().as_micros(), word, estop_closed);
        }
        amplifier.look(Instant::now().as_micros(), estop_closed);
        let amplifier_state = amplifier.state();
        enable.set_level(Level::from(amplifier_state.outputs.enable));
        heartbeat.set_level(Level::from(amplifier_state.outputs.heartbeat));
        STATE.lock(|cell| {
            cell.set(GuardState {
                amplifier: amplifier_state,
                estop_closed,
            });
        });
    }
}
