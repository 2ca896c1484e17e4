//! Priority of the time-critical threads: the sound card's callbacks and the safety watch.

use std::sync::Arc;

use anyhow::Context;
use config::{AudioHost, Config};
use safety::Signals;
use signalgen::StreamDirection;
use signalgen::audio::ThreadStart;
use tasks::Schedule;
use tasks::scheduling::{self, Scheduling};

use crate::gauges::DeviceReadings;

/// Real-time priority of the sound card's callbacks: above the safety watch, far under the kernel's threads for
/// interrupts (50), and no more than sound servers commonly have.
const CALLBACK_PRIORITY: u8 = 20;

/// Scheduling of the time-critical threads; `None` for a thread that has not started or was not queried.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ThreadPriorities {
    /// The safety watch's thread.
    pub watch: Option<Scheduling>,
    /// The thread of the output's callbacks.
    pub output: Option<Scheduling>,
    /// The thread of the input's callbacks.
    pub input: Option<Scheduling>,
}

impl ThreadPriorities {
    /// Returns the scheduling known now.
    #[must_use]
    pub fn now(signals: &Signals, gauges: &DeviceReadings) -> Self {
        Self {
            watch: signals.scheduling.get(),
            output: gauges.stream_threads.get(StreamDirection::Output),
            input: gauges.stream_threads.get(StreamDirection::Input),
        }
    }
}

/// Returns the first action of the streams' threads. JACK sets the priority of its clients itself, and on simulated
/// hardware the thread of the callbacks also runs the simulation.
pub(crate) fn thread_start(
    config: &Config,
    simulated: bool,
    gauges: &Arc<DeviceReadings>,
) -> Option<ThreadStart> {
    let ask: fn() -> Scheduling = match config.audio.host {
        _ if simulated => return None,
        AudioHost::Jack => scheduling::look,
        AudioHost::Native | AudioHost::Nidaqmx => || scheduling::ask(CALLBACK_PRIORITY),
    };
    let gauges = Arc::clone(gauges);
    Some(Arc::new(move |direction| {
        gauges.stream_threads.started(direction, ask());
    }))
}

/// Locks the program's memory if the configuration requires it and the bench runs in real time.
///
/// # Errors
/// If the system does not let all of it be locked; the message names the remedy.
pub(crate) fn lock_memory(config: &Config, schedule: &Schedule) -> anyhow::Result<()> {
    if !config.audio.lock_memory || matches!(schedule, Schedule::Lockstep(_)) {
        return Ok(());
    }
    scheduling::lock_memory().context(
        "audio.lock_memory = true cannot be kept: permit it (`memlock unlimited` in /etc/security/limits.conf, or \
         LimitMEMLOCK=infinity of a systemd service, and log in again), or set it to false",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(host: &str) -> Config {
        let text = config::TEMPLATE.replace("host = \"native\"", &format!("host = \"{host}\""));
        Config::parse(&text, "bench.toml").unwrap()
    }

    /// Returns the scheduling of the threads of both streams after they have started.
    fn started(host: &str, simulated: bool) -> ThreadPriorities {
        let gauges = Arc::new(DeviceReadings::default());
        let start = thread_start(&config(host), simulated, &gauges);
        for direction in [StreamDirection::Output, StreamDirection::Input] {
            let start = start.clone();
            // A priority belongs to one thread.
            let thread = std::thread::spawn(move || start.map(|start| start(direction)));
            thread.join().unwrap();
        }
        ThreadPriorities::now(&Signals::default(), &gauges)
    }

    #[test]
    fn priority_is_asked_for_on_a_card_looked_at_on_jack_and_left_alone_on_simulated_hardware() {
        assert_eq!(started("native", true), ThreadPriorities::default());
        let jack = started("jack", false);
        assert_eq!([jack.output, jack.input], [Some(Scheduling::Normal); 2]);
        let card = started("native", false);
        let has_priority = |thread: Option<Scheduling>| {
            !matches!(
                thread,
                None | Some(Scheduling::Normal | Scheduling::Found { .. })
            )
        };
        assert!(
            has_priority(card.output) && has_priority(card.input),
            "{card:?}"
        );
    }

    #[test]
    fn memory_is_not_locked_unless_it_is_asked_for() {
        let config = config("native");
        assert!(!config.audio.lock_memory);
        lock_memory(&config, &Schedule::Threads).unwrap();
    }
}
