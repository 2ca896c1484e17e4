#![doc = include_str!("../README.md")]

mod disk;
mod obstacles;
mod outlook;
mod room;

pub use disk::session_bytes;
pub use obstacles::{
    FutileDemand, FutileKind, SeveralObstacles, futile_demands, obstacles, require_drivable,
    require_possible,
};
pub use outlook::{bench_outlook, session_outlook};
pub use room::unusual_pressure;
