//! The whole bench on simulated hardware in real time, as a person meets it: terminals, signals, a program that was
//! frozen.

mod frozen;
mod panics;
mod signals;
mod terminal;
