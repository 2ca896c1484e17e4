//! Text about a session before it is run: its course, and its demands on a bench.

use std::fmt::Write;

use config::Effective;
use devices::drive_control::carrier_hz;
use devices::{driving_time, unloaded_amplitude_m};
use protocols::{LIFT_S, Order, PLACE_S, Protocol, StepKind};

use crate::disk::session_bytes;

/// Returns the course of a session of `protocol`, in lines.
///
/// ```
/// let text = protocols::built_in("demo").expect("a built-in protocol");
/// let demo = protocols::Protocol::parse(text, "demo.toml")?;
/// let outlook = protocol_check::session_outlook(&demo);
/// assert!(outlook.contains("0:01:09  rest of 2 s or more"), "{outlook}");
/// # Ok::<(), protocols::ProtocolError>(())
/// ```
#[must_use]
pub fn session_outlook(protocol: &Protocol) -> String {
    let driving = protocol.driving_time();
    let course = protocol.course();
    let trials = protocol.trials;
    let conditions = protocol.conditions.len();
    let repetitions = protocol.most_repetitions();
    let order = match trials.order {
        Order::Fixed => "in the order listed",
        Order::Randomised => "in random order, in blocks of all conditions",
        Order::Counterbalanced => "in counterbalanced order, by the participant's number",
    };
    let mut text = format!(
        "protocol {}\n\
         trials       {} of practice, then {}: {} of each condition ({conditions}), {order}\n\
         a trial      {:.1} s with the drive on, {} exploration{}; {PLACE_S} s to place and {LIFT_S} s to lift the finger are \
         assumed\n\
         a session    {} without repetitions; {} of a trial at most, {} in all, which take {} more\n\
         \n  h:mm:ss\n",
        protocol.name,
        trials.practice,
        driving.trials - trials.practice,
        trials.per_condition,
        driving.trial_s,
        protocol.exploration.directions.len(),
        if protocol.exploration.directions.len() == 1 {
            ""
        } else {
            "s"
        },
        clock(course.end_s),
        protocol.redo.max_per_trial.min(repetitions),
        repetitions,
        clock(f64::from(repetitions) * (driving.trial_s + protocol.timing.verdict_s)),
    );
    for step in &course.steps {
        let kind = match step.kind {
            StepKind::Practice(first, last) => numbered("practice trial", first, last),
            StepKind::Trials(first, last) => numbered("trial", first, last),
            StepKind::Rest(s) => format!("rest of {s} s or more"),
        };
        let _ = writeln!(text, "  {}  {kind}", clock(step.start_s));
    }
    let _ = writeln!(text, "  {}  end", clock(course.end_s));
    text
}

/// Returns the demands of a session of `protocol` on `bench`, in lines.
#[must_use]
pub fn bench_outlook(protocol: &Protocol, bench: &Effective) -> String {
    let config = bench.config();
    let mut text = format!(
        "\n{:<16}  {:>10}  {:>18}  {:>12}  unloaded plate, mean and crest\n",
        "condition", "carrier", "volts, mean, crest", "modulation"
    );
    for condition in &protocol.conditions {
        let drive = condition.drive;
        let hz = carrier_hz(drive.carrier, config);
        let amplitude_um =
            |volts: f64| unloaded_amplitude_m(bench, hz, volts).map(|metres| 1e6 * metres);
        let (mean_v, crest_v) = (drive.mean_amplitude_v, drive.peak_amplitude_v());
        let amplitude = match (amplitude_um(mean_v), amplitude_um(crest_v)) {
            (Some(mean_um), Some(crest_um)) => format!("{mean_um:.2} µm  {crest_um:.2} µm"),
            _ => "not known before `calibrate plate`".to_owned(),
        };
        let _ = writeln!(
            text,
            "{:<16}  {hz:>7.0} Hz  {mean_v:>8.1} {crest_v:>7.1} V  {:>9} Hz  {amplitude}",
            condition.name, drive.modulation_hz,
        );
    }
    let driving = protocol.driving_time();
    let _ = write!(
        text,
        "limits       {} V at the actuators, {} µm of the unloaded plate\n\
         driving      {:.0} s within an hour, of {:.0} s allowed to a participant\n\
         disk         up to {:.2} GB a participant: every trial half as often again, with margins\n",
        config.limits.drive_v,
        config.limits.amplitude_um,
        driving.hour_s,
        driving_time::limit_s(config, &driving),
        session_bytes(config, protocol) as f64 / 1e9,
    );
    text
}

fn numbered(name: &str, first: u32, last: u32) -> String {
    if first == last {
        format!("{name} {first}")
    } else {
        format!("{name}s {first} to {last}")
    }
}

/// Returns a time as hours, minutes and seconds.
fn clock(s: f64) -> String {
    let s = s.round() as u64;
    format!("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_course_has_all_trials_and_rests_in_time() {
        let protocol = Protocol::parse(protocols::TEMPLATE, "template.toml").unwrap();
        let text = session_outlook(&protocol);
        let steps: Vec<&str> = text
            .lines()
            .skip_while(|line| !line.contains("h:mm:ss"))
            .skip(1)
            .map(|line| line.split_once("  ").map_or("", |(_, rest)| rest.trim()))
            .collect();
        let names: Vec<&str> = steps
            .iter()
            .map(|step| step.split_once("  ").map_or(*step, |(_, name)| name))
            .collect();
        assert_eq!(
            names,
            [
                "practice trials 1 to 2",
                "trials 1 to 5",
                "rest of 60 s or more",
                "trials 6 to 10",
                "end"
            ]
        );
    }

    /// Regression test: two trials that can be repeated three times each were said to allow ten repetitions.
    #[test]
    fn a_short_protocol_cannot_use_all_repetitions_of_a_session() {
        let mut protocol = Protocol::parse(protocols::TEMPLATE, "template.toml").unwrap();
        let repetitions = |protocol: &Protocol| {
            let text = session_outlook(protocol);
            text.contains("3 of a trial at most, 6 in all, which take")
        };
        assert!(!repetitions(&protocol));
        protocol.trials.per_condition = 1;
        assert_eq!(
            (protocol.conditions.len(), protocol.redo.max_per_trial),
            (2, 3)
        );
        assert!(repetitions(&protocol));
    }

    #[test]
    fn an_uncalibrated_bench_states_volts_and_no_micrometres() {
        let config = config::Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap();
        let protocol = Protocol::parse(protocols::TEMPLATE, "template.toml").unwrap();
        let text = bench_outlook(&protocol, &Effective::uncalibrated(config));
        let slow = text.lines().find(|line| line.starts_with("slow")).unwrap();
        assert!(slow.contains("24.0    46.8 V"), "{slow}");
        assert!(
            slow.ends_with("not known before `calibrate plate`"),
            "{slow}"
        );
    }
}
