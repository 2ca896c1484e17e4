//! The choice of the monitor.

use winit::event_loop::ActiveEventLoop;
use winit::monitor::MonitorHandle;

use crate::error::WindowError;
use participant_window::fitness::OnMonitor;

/// Refresh rate assumed for a monitor that does not report one, Hz.
const ASSUMED_REFRESH_HZ: f64 = 60.0;

/// Returns the name of a monitor.
pub fn name(monitor: &MonitorHandle) -> String {
    monitor.name().unwrap_or_else(|| "unnamed".to_owned())
}

/// Returns a monitor's name and size.
pub fn identity(monitor: &MonitorHandle) -> OnMonitor {
    OnMonitor {
        name: name(monitor),
        size_px: monitor.size().into(),
    }
}

/// Returns the refresh period of a monitor, s.
pub fn refresh_s(monitor: &MonitorHandle) -> f64 {
    let reported_hz = monitor
        .refresh_rate_millihertz()
        .map(|mhz| 1e-3 * f64::from(mhz));
    let plausible = reported_hz.filter(|hz| (20.0..=1000.0).contains(hz));
    1.0 / plausible.unwrap_or(ASSUMED_REFRESH_HZ)
}

/// Returns whether outputs of this name have no monitor behind them, as with Xvfb, VNC servers, dummy drivers and
/// remote desktops.
pub fn is_virtual(name: &str) -> bool {
    let name = name.to_lowercase();
    name == "screen"
        || ["vnc", "dummy", "virtual", "rdp", "none"]
            .iter()
            .any(|kind| name.starts_with(kind))
}

/// Returns the monitor with this number, from 1, or this name; by default the last one.
pub fn choose(
    events: &ActiveEventLoop,
    requested: Option<&str>,
) -> Result<MonitorHandle, WindowError> {
    let monitors: Vec<MonitorHandle> = events.available_monitors().collect();
    let monitor = match requested {
        None => monitors.last(),
        Some(requested) => monitors
            .iter()
            .enumerate()
            .find(|(i, monitor)| name(monitor) == requested || (i + 1).to_string() == requested)
            .map(|(_, monitor)| monitor),
    };
    monitor.cloned().ok_or_else(|| WindowError::NoMonitor {
        name: requested.unwrap_or("at all").to_owned(),
        monitors: monitors
            .iter()
            .enumerate()
            .map(|(i, monitor)| {
                let size = monitor.size();
                format!(
                    "{} {} ({} × {})",
                    i + 1,
                    name(monitor),
                    size.width,
                    size.height
                )
            })
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displays_without_a_monitor_are_known_by_their_names() {
        for name in ["screen", "VNC-0", "DUMMY0", "Virtual-1", "rdp0"] {
            assert!(is_virtual(name), "{name}");
        }
        for name in ["HDMI-1", "DP-2", "eDP-1", "DVI-D-0", "VGA-1", "#0"] {
            assert!(!is_virtual(name), "{name}");
        }
    }
}
