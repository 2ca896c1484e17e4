//! Apparatus of a library to which no program has connected one: in real time, configured by the environment.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use mock_hw::apparatus::{Apparatus, ApparatusConfig};
use mock_hw::rack::Board;
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;

/// Exists as long as the process.
static APPARATUS: Mutex<Option<Apparatus>> = Mutex::new(None);

/// Creates the apparatus; `None` if that fails, as if there were no card.
pub(crate) fn board() -> Option<Board> {
    let variable = |name: &str| std::env::var(name).ok();
    let scenario = match variable("MOCK_NIDAQMX_SCENARIO") {
        Some(path) => Scenario::parse(&std::fs::read_to_string(&path).ok()?, &path).ok()?,
        None => Scenario::default(),
    };
    let seed = variable("MOCK_NIDAQMX_SEED").and_then(|seed| seed.parse().ok());
    let config = ApparatusConfig::new(scenario, seed.unwrap_or(1), WorldPace::RealTime);
    let apparatus = Apparatus::new(config.with_acquisition_card()).ok()?;
    if let Some(target) = variable("MOCK_NIDAQMX_FORCE_LINK").map(PathBuf::from) {
        link(apparatus.force_port().ok()?, &target).ok()?;
    }
    let board = apparatus.rack().board();
    *APPARATUS
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner) = Some(apparatus);
    Some(board)
}

#[cfg(unix)]
fn link(port: &Path, target: &Path) -> std::io::Result<()> {
    if target
        .symlink_metadata()
        .is_ok_and(|metadata| metadata.is_symlink())
    {
        std::fs::remove_file(target)?;
    }
    std::os::unix::fs::symlink(port, target)
}

#[cfg(not(unix))]
fn link(_port: &Path, _target: &Path) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}
