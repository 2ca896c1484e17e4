//! Settings of a session that are possible and hardly ever meant: asked on a terminal, refused unattended unless accepted.

use anyhow::bail;
use clap::ValueEnum;
use config::Config;
use jiff::Timestamp;
use protocol_check::{FutileDemand, FutileKind, futile_demands, unusual_pressure};
use protocols::Protocol;

use crate::confirmation::confirmed;

/// Kind of a concern, as named by `--accept`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ConcernKind {
    /// A carrier far from the plate's resonance.
    Carrier,
    /// Instances longer than the vibration grows.
    Instance,
    /// A date before this program existed.
    Date,
    /// A pressure that is rather one in mmHg.
    Pressure,
}

/// A setting that is hardly ever meant.
#[derive(Debug, Clone, PartialEq)]
pub struct Concern {
    kind: ConcernKind,
    text: String,
}

/// Returns the concerns about a session by `protocol` on the bench of `config`, begun at `now`.
#[must_use]
pub fn concerns(config: &Config, protocol: &Protocol, now: Timestamp) -> Vec<Concern> {
    let mut concerns: Vec<Concern> = Vec::new();
    let mut add = |kind, text: String| {
        if concerns.iter().all(|concern| concern.text != text) {
            concerns.push(Concern { kind, text });
        }
    };
    if let Some(text) = calendar::complaint(now) {
        add(ConcernKind::Date, text);
    }
    if let Some(text) = unusual_pressure(config) {
        add(ConcernKind::Pressure, text);
    }
    for FutileDemand { kind, text } in futile_demands(protocol, Some(config)) {
        match kind {
            FutileKind::Carrier => add(ConcernKind::Carrier, text),
            FutileKind::Instance => add(ConcernKind::Instance, text),
            // Refused by `protocol check`; a session can still be practised.
            FutileKind::Periods => {}
        }
    }
    concerns
}

/// Requires each concern to be accepted: by its kind, or on the terminal if the session is attended. Returns those accepted, in
/// words.
///
/// # Errors
/// A concern is not accepted; names the option that accepts it.
pub fn require_accepted(
    concerns: &[Concern],
    accepted: &[ConcernKind],
    attended: bool,
) -> anyhow::Result<Vec<String>> {
    for Concern { kind, text } in concerns {
        if accepted.contains(kind) {
            continue;
        }
        if !attended {
            let name = kind.to_possible_value();
            let name = name.as_ref().map_or("", |value| value.get_name());
            bail!("{text}; if it is meant, add --accept {name}");
        }
        if !confirmed(&format!("{text}. Begin all the same? (yes/no)"))? {
            bail!("not begun: {text}");
        }
    }
    let texts = concerns.iter();
    Ok(texts
        .map(|concern| format!("accepted: {}", concern.text))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TODAY_S: i64 = 1_780_000_000;

    fn kinds(edit: (&str, &str), now_s: i64) -> Vec<Concern> {
        let config = Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap();
        let text = protocols::built_in("demo").unwrap();
        assert!(text.contains(edit.0), "{}", edit.0);
        let protocol = Protocol::parse(&text.replacen(edit.0, edit.1, 1), "own.toml").unwrap();
        concerns(&config, &protocol, Timestamp::from_second(now_s).unwrap())
    }

    #[test]
    fn a_distant_carrier_a_long_instance_and_a_wrong_year_are_concerns() {
        let unchanged = ("instance_s = 0.060", "instance_s = 0.060");
        assert_eq!(kinds(unchanged, TODAY_S), []);
        let carrier = |hz: &str| format!("carrier = {hz}");
        for (edit, kind, words) in [
            (carrier("31000.0"), ConcernKind::Carrier, "4000 Hz from"),
            (carrier("36500.0"), ConcernKind::Carrier, "1500 Hz from"),
        ] {
            let concerns = kinds(("carrier = \"plate resonance\"", &edit), TODAY_S);
            assert_eq!(concerns.len(), 1, "{concerns:?}");
            assert!(
                concerns[0].kind == kind && concerns[0].text.contains(words),
                "{concerns:?}"
            );
        }
        let near = carrier("35100.0");
        assert_eq!(kinds(("carrier = \"plate resonance\"", &near), TODAY_S), []);
        let concerns = kinds(("instance_s = 0.060", "instance_s = 0.1"), TODAY_S);
        assert_eq!(concerns[0].kind, ConcernKind::Instance);
        let concerns = kinds(unchanged, 3600);
        assert!(concerns[0].kind == ConcernKind::Date && concerns[0].text.contains("1970-01-01"));
    }

    #[test]
    fn a_pressure_in_mmhg_is_a_concern() {
        let bench = |pressure_hpa: f64| {
            let room = format!(
                "{}\n[room]\npressure_hpa = {pressure_hpa}\n",
                config::rigs::MOCK_BENCH
            );
            Config::parse(&room, "bench.toml").unwrap()
        };
        let protocol = Protocol::parse(protocols::built_in("demo").unwrap(), "demo.toml").unwrap();
        let today = Timestamp::from_second(TODAY_S).unwrap();
        for pressure_hpa in [850.0, 998.0, 1035.0] {
            assert_eq!(concerns(&bench(pressure_hpa), &protocol, today), []);
        }
        let found = concerns(&bench(752.0), &protocol, today);
        assert_eq!(found[0].kind, ConcernKind::Pressure);
        assert!(found[0].text.contains("752 mmHg are 1003 hPa"), "{found:?}");
        let error = require_accepted(&found, &[], false)
            .unwrap_err()
            .to_string();
        assert!(error.ends_with("add --accept pressure"), "{error}");
    }

    #[test]
    fn an_unattended_session_needs_each_concern_accepted_by_its_name() {
        let concerns = kinds(("instance_s = 0.060", "instance_s = 0.1"), 3600);
        let accept = |kinds: &[ConcernKind]| require_accepted(&concerns, kinds, false);
        let error = accept(&[ConcernKind::Date]).unwrap_err().to_string();
        assert!(error.ends_with("add --accept instance"), "{error}");
        let accepted = accept(&[ConcernKind::Date, ConcernKind::Instance]).unwrap();
        assert_eq!(accepted.len(), 2);
        assert_eq!(
            require_accepted(&[], &[], false).unwrap(),
            Vec::<String>::new()
        );
    }
}
