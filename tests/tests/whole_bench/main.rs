//! The whole bench on simulated hardware that runs free: one program of tests, so that they share the cores.

mod blinding;
mod calibrated_session;
mod calibration;
mod calibration_channels;
mod calibration_force;
mod disk;
mod first_hour;
mod forget;
mod hostile;
mod impedance_live;
mod in_process;
mod kills;
mod long;
mod opens_in_python;
mod people;
mod person;
mod population;
mod private;
mod refusals;
mod rehearsal;
mod second_instance;
mod session;
mod stops;
mod verify;
mod wall_clock;
mod wrong_bench;
