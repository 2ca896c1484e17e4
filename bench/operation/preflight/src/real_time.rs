//! Scheduling priority of the time-critical threads.

use config::{AudioHost, Config};
use devices::ThreadPriorities;
use tasks::scheduling::Scheduling;

use crate::table::{RowVerdict, Table};

/// Priority in the hint for an administrator: the highest that the bench requests.
const HINTED: u8 = 20;

/// Judges the priorities of the threads. Normal priority is a warning: a busy computer then loses samples or stops the drive,
/// and neither is harmful.
pub(super) fn judge(
    table: &mut Table,
    config: &Config,
    simulated: bool,
    priorities: ThreadPriorities,
) {
    let (verdict, text) = judgement(config, simulated, priorities, &user());
    table.verdict_row("real time", verdict, text);
}

fn judgement(
    config: &Config,
    simulated: bool,
    priorities: ThreadPriorities,
    user: &str,
) -> (RowVerdict, String) {
    if simulated {
        return (
            RowVerdict::Passed,
            "simulated hardware can wait: nothing was asked of the system".to_owned(),
        );
    }
    let in_words = |thread: Option<Scheduling>| {
        thread.map_or_else(
            || "normal priority: real time is not requested, because the device is not a hw: device".to_owned(),
            |thread| thread.to_string(),
        )
    };
    let locked = if config.audio.lock_memory {
        "; memory locked"
    } else {
        ""
    };
    let summary = format!(
        "safety watch: {}; output: {}; input: {}{locked}",
        in_words(priorities.watch),
        in_words(priorities.output),
        in_words(priorities.input),
    );
    let threads = [priorities.watch, priorities.output, priorities.input];
    if threads
        .iter()
        .all(|thread| thread.is_some_and(Scheduling::is_real_time))
    {
        return (RowVerdict::Passed, summary);
    }
    let is_refused =
        |thread: &Option<Scheduling>| matches!(thread, Some(Scheduling::Refused { .. }));
    let mut text =
        format!("{summary}: other programs can delay them, which loses samples or stops the drive");
    if threads.iter().any(is_refused) {
        text += &format!(
            "; add the line `{user} - rtprio {HINTED}` to /etc/security/limits.conf and log in again (a systemd service: \
             LimitRTPRIO={HINTED}; a container: --cap-add=SYS_NICE)"
        );
    }
    let has_normal_stream =
        [priorities.output, priorities.input].contains(&Some(Scheduling::Normal));
    if config.audio.host == AudioHost::Jack && has_normal_stream {
        text += "; the JACK server gives its clients no real-time priority: start it with -R";
    }
    (RowVerdict::Warning, text)
}

/// Returns the name in the hint: the user, or for an unknown user or root, the usual group for sound.
fn user() -> String {
    let name = std::env::var("USER").unwrap_or_default();
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    let is_usable =
        !name.is_empty() && name != "root" && name.len() <= 32 && name.chars().all(plain);
    if is_usable { name } else { "@audio".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRANTED: Option<Scheduling> = Some(Scheduling::RealTime { priority: 10 });
    const REFUSED: Option<Scheduling> = Some(Scheduling::Refused { limit: 0 });
    const SERVED: Option<Scheduling> = Some(Scheduling::Found { priority: 5 });
    const NORMAL: Option<Scheduling> = Some(Scheduling::Normal);

    fn judge_on(
        host: &str,
        watch: Option<Scheduling>,
        stream: Option<Scheduling>,
    ) -> (RowVerdict, String) {
        let text = config::TEMPLATE.replace("host = \"native\"", &format!("host = \"{host}\""));
        let config = Config::parse(&text, "bench.toml").unwrap();
        let priorities = ThreadPriorities {
            watch,
            output: stream,
            input: stream,
        };
        judgement(&config, false, priorities, "alice")
    }

    #[test]
    fn a_granted_priority_is_reported_and_a_refused_one_with_the_line_to_add() {
        for stream in [GRANTED, SERVED] {
            assert_eq!(judge_on("jack", GRANTED, stream).0, RowVerdict::Passed);
        }
        let line = "`alice - rtprio 20`";
        let cases = [
            ("native", REFUSED, REFUSED, Some(line)),
            ("native", GRANTED, REFUSED, Some(line)),
            ("jack", REFUSED, SERVED, Some(line)),
            ("jack", GRANTED, NORMAL, Some("start it with -R")),
            ("native", GRANTED, None, Some("not a hw: device")),
            ("native", None, None, None),
        ];
        for (host, watch, stream, hint) in cases {
            let (verdict, text) = judge_on(host, watch, stream);
            assert_eq!(verdict, RowVerdict::Warning, "{text}");
            assert!(text.contains("can delay them"), "{text}");
            assert!(hint.is_none_or(|hint| text.contains(hint)), "{text}");
        }
    }

    #[test]
    fn simulated_hardware_demands_nothing() {
        let config = Config::parse(config::TEMPLATE, "bench.toml").unwrap();
        let (verdict, _) = judgement(&config, true, ThreadPriorities::default(), "alice");
        assert_eq!(verdict, RowVerdict::Passed);
    }
}
