//! The whole bench on simulated hardware in real time, as a user sees it: terminals, signals, a program that was frozen.

mod every_command;
mod frozen;
mod hangs;
mod operators_keys;
mod panics;
mod participant_window;
mod signals;
mod simulated_window;
mod standing_still;
mod terminal;
