//! The operator's dashboard on a separate thread.

use std::sync::mpsc::{Receiver, Sender, SyncSender};

use anyhow::Context;
use tasks::{RaiseOnDrop, StopFlag};
use tui::{Action, Event};

use crate::console::front::Front;
use crate::console::stop_keys::StopKeys;

/// Capacity of the queue of events while the screen is stalled; further events are dropped.
const WAITING_EVENTS: usize = 4096;

/// Handle to the operator's dashboard, which runs on a separate thread.
pub struct Dashboard {
    events: SyncSender<Event>,
    actions: Receiver<Action>,
}

/// The dashboard's thread; joining it waits until the terminal is restored.
pub struct DashboardThread(std::thread::JoinHandle<Result<(), tui::TerminalError>>);

impl Dashboard {
    /// Opens the dashboard on this process's terminal and raises `stop` when it ends, for any reason. The thread that reads the
    /// keys calls `keys` before it passes the action on.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn open(stop: StopFlag, keys: StopKeys) -> anyhow::Result<(Self, DashboardThread)> {
        let (events, event_receiver) = std::sync::mpsc::sync_channel(WAITING_EVENTS);
        let (action_sender, actions): (Sender<Action>, _) = std::sync::mpsc::channel();
        let thread = std::thread::Builder::new()
            .name("dashboard".to_owned())
            .spawn(move || {
                let _raise_on_unwind = RaiseOnDrop(stop);
                tui::shell::run_operator(&event_receiver, action_sender, move |action| {
                    keys.hear();
                    action.iter().for_each(|action| keys.act(action));
                })
            })
            .context("cannot start the dashboard's thread")?;
        Ok((Self { events, actions }, DashboardThread(thread)))
    }
}

impl DashboardThread {
    /// Waits until the terminal is restored.
    ///
    /// # Errors
    /// If the terminal failed or the dashboard panicked.
    pub fn join(self) -> anyhow::Result<()> {
        match self.0.join() {
            Ok(outcome) => outcome.context("the dashboard"),
            Err(_) => anyhow::bail!("the dashboard panicked"),
        }
    }
}

impl Front for Dashboard {
    fn show(&mut self, event: Event) {
        let _dropped_when_the_screen_stands_still = self.events.try_send(event);
    }

    fn action(&mut self) -> Option<Action> {
        self.actions.try_recv().ok()
    }
}
