//! Whole `bench.toml` files of the simulated rigs.

/// The published rig on simulated hardware.
pub const MOCK_BENCH: &str = include_str!("../rigs/mock-bench.toml");
/// The simulated bench with a force sensor of analogue channels.
pub const MOCK_BENCH_CHANNELS: &str = include_str!("../rigs/mock-bench-channels.toml");
/// The simulated bench with a field box.
pub const MOCK_BENCH_FIELD_BOX: &str = include_str!("../rigs/mock-bench-field-box.toml");
/// The simulated bench with a force sensor on the network.
pub const MOCK_BENCH_NETFT: &str = include_str!("../rigs/mock-bench-netft.toml");
/// Maker's file of the gauges of the simulated sensor.
pub const SIMULATED_GAUGES: &str = include_str!("../tests/data/FT09999.cal");
/// The published rig with a card of National Instruments, simulated.
pub const MOCK_BENCH_NIDAQMX: &str = include_str!("../rigs/mock-bench-nidaqmx.toml");
