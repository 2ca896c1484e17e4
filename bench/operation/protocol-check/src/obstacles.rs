//! Demands of a protocol that a bench refuses, and those that it follows in vain.

use anyhow::{Context, bail};
use config::{Config, Effective};
use devices::drive_control::{carrier_hz, settings, waveform};
use devices::{driving_time, impedance_chain, require_armable, require_watched};
use jiff::Timestamp;
use protocols::Protocol;
use safety::Pace;
use signalgen::DriveSettings;

/// Obstacles of one protocol, a line each.
#[derive(Debug, thiserror::Error)]
#[error("{}", .0.join("\n"))]
pub struct SeveralObstacles(Vec<String>);

/// Returns every demand of `protocol` that `bench` refuses as of `now`.
#[must_use]
pub fn obstacles(
    protocol: &Protocol,
    bench: &Effective,
    pace: Pace,
    now: Timestamp,
) -> Vec<anyhow::Error> {
    let config = bench.config();
    let carriers = carriers(protocol, config);
    let demands = [
        require_force_band(protocol, config),
        driving_time::require_finishable(config, protocol),
        require_one_carrier(protocol, &carriers),
        impedance_chain(config, carriers[0]).map(drop),
    ];
    let mut obstacles = drive_obstacles(protocol, bench, pace, now);
    obstacles.extend(demands.into_iter().filter_map(Result::err));
    obstacles
}

/// Requires that `bench` refuses no demand of `protocol`.
///
/// # Errors
/// The obstacle, or all of them together.
pub fn require_possible(
    protocol: &Protocol,
    bench: &Effective,
    pace: Pace,
    now: Timestamp,
) -> anyhow::Result<()> {
    require_none(obstacles(protocol, bench, pace, now))
}

/// Requires that there are no `obstacles`.
///
/// # Errors
/// The obstacle, or all of them together.
fn require_none(mut obstacles: Vec<anyhow::Error>) -> anyhow::Result<()> {
    match obstacles.len() {
        0 => Ok(()),
        1 => Err(obstacles.remove(0)),
        _ => {
            let lines = obstacles.iter().map(|error| format!("{error:#}"));
            Err(SeveralObstacles(lines.collect()).into())
        }
    }
}

/// Returns what keeps `bench` from being armed, or else each condition that it cannot drive.
fn drive_obstacles(
    protocol: &Protocol,
    bench: &Effective,
    pace: Pace,
    now: Timestamp,
) -> Vec<anyhow::Error> {
    let armable = require_armable(bench.config(), pace).map_err(anyhow::Error::from);
    match armable.and_then(|()| Ok(settings(bench.config())?)) {
        Ok(settings) => condition_obstacles(protocol, bench, &settings, pace, now),
        Err(error) => vec![error],
    }
}

/// Requires that the safety watch can monitor every condition's drive on `bench`, and that the drives stay within all
/// limits.
///
/// # Errors
/// Each condition that it cannot drive, with the limit.
pub fn require_drivable(
    protocol: &Protocol,
    bench: &Effective,
    settings: &DriveSettings,
    pace: Pace,
    now: Timestamp,
) -> anyhow::Result<()> {
    require_none(condition_obstacles(protocol, bench, settings, pace, now))
}

fn condition_obstacles(
    protocol: &Protocol,
    bench: &Effective,
    settings: &DriveSettings,
    pace: Pace,
    now: Timestamp,
) -> Vec<anyhow::Error> {
    let obstacles = protocol.conditions.iter().map(|condition| {
        let waveform = waveform(&condition.drive, bench.config());
        let watched = require_watched(bench, &waveform, pace, now).map_err(anyhow::Error::from);
        watched
            .and(settings.admit(waveform).map_err(anyhow::Error::from))
            .with_context(|| format!("condition {} of protocol {}", condition.name, protocol.name))
    });
    obstacles.filter_map(Result::err).collect()
}

/// Kind of a futile demand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FutileKind {
    /// A carrier far from the plate's resonance.
    Carrier,
    /// Instances longer than the vibration grows.
    Instance,
    /// Fewer periods in a trial than it needs instances.
    Periods,
}

/// A demand that would be followed in vain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FutileDemand {
    /// Its kind.
    pub kind: FutileKind,
    /// The demand and the remedy, in words.
    pub text: String,
}

/// Returns the demands that would be followed in vain: carriers that hardly move the plate of `config`, and trials that
/// no finger can pass.
#[must_use]
pub fn futile_demands(protocol: &Protocol, config: Option<&Config>) -> Vec<FutileDemand> {
    let demand = |kind| move |text| FutileDemand { kind, text };
    let distant = config.and_then(|config| distant_carrier(protocol, config));
    let distant = distant.map(demand(FutileKind::Carrier));
    // Without a modulation no instance is asked for.
    let modulated =
        { protocol.conditions.iter() }.filter(|condition| condition.drive.modulation_index > 0.0);
    let hopeless = modulated.filter_map(|condition| {
        let (name, modulation_hz) = (&condition.name, condition.drive.modulation_hz);
        let instance =
            long_instance(protocol, name, modulation_hz).map(demand(FutileKind::Instance));
        instance.or_else(|| {
            too_few_periods(protocol, name, modulation_hz).map(demand(FutileKind::Periods))
        })
    });
    distant.into_iter().chain(hopeless).collect()
}

fn carriers(protocol: &Protocol, config: &Config) -> Vec<f64> {
    let drives = protocol.conditions.iter().map(|condition| condition.drive);
    drives
        .map(|drive| carrier_hz(drive.carrier, config))
        .collect()
}

fn require_force_band(protocol: &Protocol, config: &Config) -> anyhow::Result<()> {
    let (asked_n, limit_n) = (protocol.force.max_n, config.safety.max_normal_n);
    if asked_n >= limit_n {
        bail!(
            "protocol {} asks for up to {asked_n} N (force.max_n), and the bench stops the drive at {limit_n} N \
             (safety.max_normal_n)",
            protocol.name
        );
    }
    Ok(())
}

fn require_one_carrier(protocol: &Protocol, carriers: &[f64]) -> anyhow::Result<()> {
    if let Some(hz) = carriers.iter().find(|&&hz| hz != carriers[0]) {
        bail!(
            "protocol {} drives at {:.1} Hz and at {hz:.1} Hz: one session has one carrier",
            protocol.name,
            carriers[0]
        );
    }
    Ok(())
}

fn distant_carrier(protocol: &Protocol, config: &Config) -> Option<String> {
    let resonance_hz = config.plate.resonance_hz;
    let distant_hz = carriers(protocol, config)
        .into_iter()
        .find(|hz| plausibility::carrier(*hz, resonance_hz).is_some())?;
    Some(format!(
        "drive.carrier = {distant_hz:.0} Hz is {:.0} Hz from the plate's resonance of {resonance_hz:.0} Hz: the plate will \
         hardly move; write \"plate resonance\", or the frequency of a resonance that this bench is calibrated at",
        (distant_hz - resonance_hz).abs()
    ))
}

/// Returns the fault of a condition with instances longer than the rise of its modulation.
fn long_instance(protocol: &Protocol, name: &str, modulation_hz: f64) -> Option<String> {
    let (instance_s, rise_s) = (protocol.selection.instance_s, 0.5 / modulation_hz);
    (instance_s > rise_s).then(|| {
        format!(
            "selection.instance_s = {instance_s} s is longer than the rise of condition {name}, {rise_s:.3} s (half a period of \
             {modulation_hz} Hz): no stretch can become an instance; shorten it"
        )
    })
}

/// Returns the fault of a condition in which even a perfect finger gives fewer instances than a trial needs.
fn too_few_periods(protocol: &Protocol, name: &str, modulation_hz: f64) -> Option<String> {
    let central_s = protocol.selection.central_m / protocol.exploration.speed_m_per_s;
    let explorations = protocol.exploration.directions.len();
    // A stretch that begins with the crop counts, too.
    let most = ((central_s * modulation_hz).floor() as u64 + 1) * explorations as u64;
    let needed = u64::from(protocol.selection.min_instances);
    (most < needed).then(|| {
        format!(
            "condition {name} gives at most {most} instances a trial ({explorations} explorations of {central_s:.2} s over \
             selection.central_m, {modulation_hz} Hz), and selection.min_instances = {needed}: no trial can be accepted; \
             raise modulation_hz, slow down speed_m_per_s, or lower min_instances"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bench() -> Effective {
        let config = Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap();
        Effective::uncalibrated(config)
    }

    fn protocol(changes: &[(&str, &str)]) -> Protocol {
        let mut text = protocols::TEMPLATE.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        Protocol::parse(&text, "p.toml").unwrap()
    }

    fn refusals(changes: &[(&str, &str)]) -> Vec<String> {
        let errors = obstacles(
            &protocol(changes),
            &bench(),
            Pace::Simulated,
            Timestamp::UNIX_EPOCH,
        );
        errors.iter().map(|error| format!("{error:#}")).collect()
    }

    #[test]
    fn a_bench_refuses_each_demand_by_its_key_and_all_of_them_together() {
        assert_eq!(refusals(&[]), [""; 0]);
        let force = [("max_n = 0.8", "max_n = 15.0")];
        assert!(refusals(&force)[0].contains("safety.max_normal_n"));
        let volts = [("mean_amplitude_v = 24.0", "mean_amplitude_v = 99.0")];
        assert!(refusals(&volts)[0].contains("condition slow"));
        let both = [force[0], volts[0]];
        assert_eq!(refusals(&both).len(), 3);
        let refused = refusals(&volts);
        assert_eq!(refused.len(), 2, "{refused:?}");
        assert!(refused[1].contains("condition fast"), "{refused:?}");
        let error = require_possible(
            &protocol(&both),
            &bench(),
            Pace::Simulated,
            Timestamp::UNIX_EPOCH,
        );
        assert_eq!(error.unwrap_err().to_string().lines().count(), 3);
    }

    #[test]
    fn one_session_has_one_carrier() {
        let two = [("name = \"fast\"", "name = \"fast\"\ncarrier = 35100.0")];
        let refusals = refusals(&two);
        assert!(
            refusals[0].contains("one session has one carrier"),
            "{refusals:?}"
        );
    }

    #[test]
    fn a_carrier_far_from_the_resonance_and_a_trial_without_instances_are_futile() {
        let bench = bench();
        let futile = |changes: &[(&str, &str)]| -> Vec<String> {
            let demands = futile_demands(&protocol(changes), Some(bench.config()));
            demands.into_iter().map(|demand| demand.text).collect()
        };
        assert_eq!(futile(&[]), [""; 0]);
        let near_hz = bench.config().plate.resonance_hz + 200.0;
        let carrier = |hz: f64| format!("carrier = {hz}");
        let resonant = "carrier = \"plate resonance\"";
        assert_eq!(futile(&[(resonant, &carrier(near_hz))]), [""; 0]);
        let far = futile(&[(resonant, &carrier(near_hz - 9000.0))]);
        assert!(
            far[0].contains("8800 Hz from the plate's resonance"),
            "{far:?}"
        );
        let long = futile(&[("instance_s = 0.060", "instance_s = 0.1")]);
        // Half a period of 6 Hz; that of 3 Hz is longer.
        assert_eq!(long.len(), 1, "{long:?}");
        assert!(long[0].contains("condition fast, 0.083 s"), "{long:?}");
        // Without a modulation no instance is needed.
        let steady = [(
            "modulation_hz = 3.0",
            "modulation_hz = 0.3\nmodulation_index = 0.0",
        )];
        assert_eq!(futile(&steady), [""; 0]);
        let slow = futile(&[("modulation_hz = 3.0", "modulation_hz = 0.3")]);
        assert_eq!(slow.len(), 1, "{slow:?}");
        assert!(
            slow[0].starts_with("condition slow gives at most 2 instances"),
            "{slow:?}"
        );
    }
}
